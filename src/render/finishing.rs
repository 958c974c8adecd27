//! [`Finishing`]: how long it takes to turn samples into a picture and to write it, for which a time limit must leave
//! time.

use super::tile_samples::TileSamples;
use crate::film::{Film, Planes, encode_numbers, encode_png};
use crate::options::Options;
use crate::timing::Times;
use std::hint::black_box;
use std::ops::Range;
use std::time::{Duration, Instant};

/// What is known of the time that it takes to finish a picture.
#[derive(Debug)]
pub struct Finishing {
    /// Seconds to get a byte of memory, to write it and to give it back.
    memory: f64,
    /// How many times longer work takes because other programs use the processors: at least 1.
    crowding: f64,
}

impl Finishing {
    /// Measures how fast memory is, if that `is_wanted`.
    pub fn new(is_wanted: bool) -> Self {
        Self { memory: if is_wanted { seconds_for_a_byte() } else { 0.0 }, crowding: 1.0 }
    }

    /// Notes the time in which all threads had work, to see how much of the processors other programs take.
    pub fn all_threads_worked(&mut self, times: Times) {
        /// More is taken for a moment's disturbance.
        const MOST: f64 = 8.0;
        let (wall, cpu) = (times.wall.as_secs_f64(), times.cpu.as_secs_f64());
        // Processor time is not known everywhere.
        if cpu > 0.0 {
            self.crowding = (threads() * wall / cpu).clamp(1.0, MOST);
        }
    }

    /// Predicts the time for a whole picture, by doing the same with some tiles, in memory. They are such a `share` of
    /// all. `finished` turns a tile into its part of the picture.
    pub fn time<T>(
        &self,
        options: &Options,
        tiles: &[T],
        share: f64,
        finished: impl Fn(&T) -> Option<Film>,
    ) -> Duration {
        // What other programs interrupt takes longer; the shorter of two tries was not interrupted.
        let part = (0..2).filter_map(|_| time_of_part(options, tiles, &finished)).min().unwrap_or(Duration::ZERO);
        part.mul_f64(self.crowding / share) + self.time_of_memory(options)
    }

    /// Returns how long it takes to get the memory of the film, if there is one, and to give back all. What is written gets memory of the
    /// system.
    fn time_of_memory(&self, options: &Options) -> Duration {
        /// The share that giving back has in the time of memory.
        const GIVING_BACK: f64 = 0.25;
        let planes = Planes::wanted_by(options);
        let tiles = TileSamples::bytes_per_pixel(planes) as f64;
        let film = if options.keeps_film() { planes.bytes_per_pixel() as f64 } else { 0.0 };
        let file = if options.color_is_numbers() { 12.0 } else { 0.0 };
        let pixels = f64::from(options.width) * f64::from(options.height);
        Duration::from_secs_f64(self.memory * pixels * (GIVING_BACK * tiles + film + file))
    }
}

/// Returns how many seconds it takes to get a byte of memory, to write it and to give it back.
fn seconds_for_a_byte() -> f64 {
    const BYTES: usize = 1 << 21;
    const TRIES: u32 = 3;
    let blocks = (0..TRIES).map(|_| {
        let start = Instant::now();
        (black_box(vec![1_u8; BYTES]), start.elapsed())
    });
    // All are kept, because a block that was given back is had again for nothing.
    let (blocks, times): (Vec<_>, Vec<_>) = blocks.unzip();
    let start = Instant::now();
    drop(blocks);
    let giving_back = start.elapsed() / TRIES;
    // The shortest try was not interrupted by other programs.
    let getting = times.into_iter().min().unwrap_or_default();
    (getting + giving_back).as_secs_f64() / BYTES as f64
}

/// Returns the tiles that stand for all: in the middle of the picture, so few that they take almost no time, and so
/// many that it is measured well enough.
pub fn tried(tiles: usize) -> Range<usize> {
    let tried = (tiles / 128).clamp(8, 128);
    let first = (tiles / 2).saturating_sub(tried / 2);
    first..(first + tried).min(tiles)
}

/// Returns how long it takes to finish and to encode some tiles, on all threads where all can work.
fn time_of_part<T>(options: &Options, tiles: &[T], finished: impl Fn(&T) -> Option<Film>) -> Option<Duration> {
    let start = Instant::now();
    let films: Vec<Film> = tiles.iter().filter_map(finished).collect();
    let finishing = start.elapsed();
    let start = Instant::now();
    let sides = || films.iter().map(|film| (film.width, film.height));
    let (width, height) = (sides().map(|side| side.0).sum(), sides().map(|side| side.1).max()?);
    let mut strip = Film::new(width, height, Planes::wanted_by(options));
    let mut x = 0;
    for film in &films {
        strip.place(x, 0, film);
        x += film.width;
    }
    let joining = start.elapsed();
    let files = times_to_encode(options, &strip);
    let (all, longest) = (files.iter().sum::<Duration>(), files.into_iter().max().unwrap_or_default());
    if options.keeps_film() {
        return Some(finishing.div_f64(threads()) + joining + all.div_f64(threads()).max(longest));
    }
    // Bands are finished while others are encoded; a file is encoded by one thread at a time.
    Some((finishing + joining + all).div_f64(threads()).max(longest))
}

/// Returns how long it takes to encode each of a film's pictures.
fn times_to_encode(options: &Options, film: &Film) -> Vec<Duration> {
    let color = film.color.as_ref().filter(|_| !options.color_is_numbers());
    let planes = [color, film.normals.as_ref(), film.depth.as_ref()].into_iter().flatten();
    let timed = |encode: &dyn Fn()| {
        let start = Instant::now();
        encode();
        start.elapsed()
    };
    // An error would come again when the picture is written, and be reported.
    let mut times: Vec<_> =
        planes.map(|plane| timed(&|| drop(encode_png(film.width, film.height, plane)))).collect();
    if let (Some(path), Some(numbers), true) = (&options.color, &film.linear, options.color_is_numbers()) {
        times.push(timed(&|| drop(encode_numbers(path, film.width, film.height, numbers))));
    }
    times
}

fn threads() -> f64 {
    rayon::current_num_threads() as f64
}
