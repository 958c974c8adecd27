//! [`Bands`]: a picture on its way from the threads that render it to its writers.
//!
//! A band is a row of tiles. Each thread takes the next tile, or in a large picture the next run of some, and hands its
//! pixels on; none waits for another to do so. The thread that finishes the last run of a band joins them, and then writes
//! what is due: each writer takes the bands from the top, from one thread at a time, while the others render. A thread that
//! is too far below the first unwritten band helps with writing, or waits. So some bands are in memory ([`InFlight`]),
//! however high the picture is.

use super::in_flight::{Band, Due, InFlight, Run, locked, most_in_flight};
use super::tile_cost::{TileCost, Totals};

use super::tiles::{Progress, Tile, Tiles};
use crate::error::Error;
use crate::film::{BandWriter, Columns, Film, Planes};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

/// Renders tiles; each thread has its own.
pub type RenderTile<'a> = Box<dyn FnMut(&Tile, &mut Columns) -> TileCost + 'a>;

/// The bands of a picture.
pub struct Bands<'a> {
    tiles: Tiles,
    planes: Planes,
    next_run: AtomicUsize,
    finished_tiles: AtomicUsize,
    /// Whether a writer had an error, or a thread has panicked.
    is_stopped: AtomicBool,
    in_flight: Mutex<InFlight<'a>>,
    /// Notified when a band was finished or written.
    has_moved: Condvar,
}

impl<'a> Bands<'a> {
    /// There must be a writer.
    pub fn new(tiles: Tiles, planes: Planes, writers: Vec<&'a mut dyn BandWriter>) -> Self {
        Self {
            tiles,
            planes,
            next_run: AtomicUsize::new(0),
            finished_tiles: AtomicUsize::new(0),
            is_stopped: AtomicBool::new(false),
            in_flight: Mutex::new(InFlight::new(writers)),
            has_moved: Condvar::new(),
        }
    }

    /// Renders and writes all bands, on all threads. Each thread calls `renderer` before its first tile.
    ///
    /// # Errors
    /// The first error of a writer.
    pub fn render<'r>(
        self,
        progress: &dyn Progress,
        renderer: &(dyn Fn() -> RenderTile<'r> + Sync),
    ) -> Result<Totals, Error> {
        let threads = rayon::current_num_threads().min(self.tiles.count());
        rayon::scope(|scope| {
            (1..threads).for_each(|_| scope.spawn(|_| self.work(progress, renderer)));
            self.work(progress, renderer);
        });
        self.in_flight.into_inner().unwrap_or_else(PoisonError::into_inner).into_totals()
    }

    /// Takes tile after tile. Nothing in here may wait for other work of the thread pool: a thread that waits takes up
    /// other work, and the band of its own tile would not be finished before that.
    fn work<'r>(&self, progress: &dyn Progress, renderer: &dyn Fn() -> RenderTile<'r>) {
        let _guard = StopInPanic(self);
        let (mut render, mut band) = (None, None::<Arc<Band>>);
        let (runs, count) = (self.tiles.runs(), self.tiles.count());
        while !self.is_stopped.load(Ordering::Relaxed) {
            let number = self.next_run.fetch_add(1, Ordering::Relaxed);
            let (row, run) = (number / runs, number % runs);
            if row * self.tiles.columns() >= count {
                break;
            }
            if band.as_ref().is_none_or(|band| band.number != row) {
                // Dropped before waiting, because it may be written, and large.
                drop(band.take());
                band = self.entered(row);
            }
            let Some(band) = &band else { break };
            let tiles = self.tiles.of_run(row, run);
            let rendered = self.rendered(tiles.clone(), render.get_or_insert_with(renderer));
            progress.add_rays(rendered.costs.iter().map(|cost| cost.counts.total()).sum());
            *locked(&band.runs[run]) = Some(rendered);
            let finished = self.finished_tiles.fetch_add(tiles.len(), Ordering::Relaxed) + tiles.len();
            progress.advance(finished, count);
            if band.unfinished.fetch_sub(1, Ordering::AcqRel) == 1 {
                self.finish(band);
                self.write_what_is_due();
            }
        }
        self.write_what_is_due();
    }

    /// Renders neighbouring tiles of a band, by their numbers.
    fn rendered(&self, tiles: Range<usize>, render: &mut RenderTile) -> Run {
        let tiles = tiles.map(|number| self.tiles.tile(number));
        let (width, height) = tiles.clone().fold((0, 0), |(width, _), tile| (width + tile.width, tile.height));
        let (mut film, mut x) = (Film::new(width, height, self.planes), 0);
        let rendered = |tile: Tile| {
            let cost = render(&tile, &mut film.columns(x, tile.width));
            x += tile.width;
            cost
        };
        let costs = tiles.map(rendered).collect();
        Run { film, costs }
    }

    /// Returns a band whose tiles are to be rendered, once it may be in flight. `None` if rendering is stopped.
    fn entered(&self, number: usize) -> Option<Arc<Band>> {
        let most = most_in_flight(self.tiles, self.planes);
        let mut in_flight = locked(&self.in_flight);
        while !in_flight.has_room_for(number, most) && !self.is_stopped.load(Ordering::Relaxed) {
            in_flight = match in_flight.take_due() {
                Some(due) => {
                    drop(in_flight);
                    self.write(due);
                    locked(&self.in_flight)
                }
                None => self.has_moved.wait(in_flight).unwrap_or_else(PoisonError::into_inner),
            };
        }
        let is_stopped = self.is_stopped.load(Ordering::Relaxed);
        (!is_stopped).then(|| in_flight.band(number, self.tiles.runs()))
    }

    /// Joins the tiles of a band, all of which are finished.
    fn finish(&self, band: &Band) {
        let first = self.tiles.tile(band.number * self.tiles.columns());
        let spare = locked(&self.in_flight).take_spare(first.height);
        let mut film = spare.unwrap_or_else(|| Film::new(self.tiles.region.width, first.height, self.planes));
        let costs = band.join(&mut film);
        locked(&self.in_flight).finish(band.number, film, costs);
        self.has_moved.notify_all();
    }

    fn write_what_is_due(&self) {
        // The lock must not be held while a band is written.
        let take_due = || locked(&self.in_flight).take_due();
        while let (Some(due), false) = (take_due(), self.is_stopped.load(Ordering::Relaxed)) {
            self.write(due);
        }
    }

    fn write(&self, due: Due<'a>) {
        let Due { index, writer, film } = due;
        let start = Instant::now();
        let written = writer.write(&film);
        drop(film);
        if written.is_err() {
            self.is_stopped.store(true, Ordering::Relaxed);
        }
        locked(&self.in_flight).give_back(index, writer, written, start.elapsed());
        self.has_moved.notify_all();
    }
}

/// Stops all threads when one panics, which would else wait for its band for ever.
struct StopInPanic<'a, 'b>(&'b Bands<'a>);

impl Drop for StopInPanic<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let _in_flight = locked(&self.0.in_flight);
            self.0.is_stopped.store(true, Ordering::Relaxed);
            self.0.has_moved.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::error_sums::ErrorSums;
    use super::super::frame::SampleCounts;
    use super::super::tiles::Silent;
    use super::*;
    use crate::options::Region;
    use crate::ray_counts::RayCounts;
    use std::path::Path;
    use std::time::Duration;
    use vecmath::Real;

    const PLANES: Planes = Planes { color: false, depth: true, normals: false, linear: false, error_map: false };

    /// Keeps all rows, and fails at a row.
    struct Rows {
        bytes: Vec<u8>,
        height: u32,
        fails_at: u32,
    }

    impl BandWriter for Rows {
        fn write(&mut self, band: &Film) -> Result<(), Error> {
            if self.height >= self.fails_at {
                return Err(Error::file(Path::new("picture"), format!("row {}", self.height)));
            }
            // Slower than rendering, so that threads must wait.
            std::thread::sleep(Duration::from_micros(50));
            self.bytes.extend(band.depth.as_ref().unwrap());
            self.height += band.height;
            Ok(())
        }
    }

    fn tiles(width: u32, height: u32) -> Tiles {
        Tiles { region: Region::whole(width, height) }
    }

    /// A pixel is the sum of its column and its row.
    fn render(tile: &Tile, film: &mut Columns) -> TileCost {
        let pixels: Vec<_> = tile.pixels().collect();
        film.set_depths(&pixels, |(x, row)| Real::from((x + row) as u8) / 255.0);
        let (counts, errors) = (RayCounts::default(), ErrorSums::default());
        let pixels = u64::from(tile.width * tile.height);
        TileCost { samples: SampleCounts::of_pixels(pixels, 1), counts, errors, filter: Duration::ZERO }
    }

    fn run(tiles: Tiles, writers: &mut [Rows]) -> Result<Totals, Error> {
        let writers = writers.iter_mut().map(|rows| rows as &mut dyn BandWriter).collect();
        let bands = Bands::new(tiles, PLANES, writers);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        pool.install(|| bands.render(&Silent, &|| Box::new(render)))
    }

    fn rows(fails_at: u32) -> Rows {
        Rows { bytes: Vec::new(), height: 0, fails_at }
    }

    #[test]
    fn every_writer_gets_all_rows_in_their_order() {
        // The first is so wide that two bands are in flight at most.
        for (width, height) in [(1 << 18, 71), (40, 4000), (1, 1), (17, 33)] {
            let mut writers = [rows(u32::MAX), rows(u32::MAX), rows(u32::MAX)];
            let totals = run(tiles(width, height), &mut writers).unwrap();
            assert_eq!(totals.samples.total, u64::from(width * height));
            let expected = (0..height).flat_map(|row| (0..width).map(move |x| (x + row) as u8));
            assert!(expected.eq(writers[0].bytes.iter().copied()), "{width} x {height}");
            assert!(writers.iter().all(|writer| writer.bytes == writers[0].bytes), "{width} x {height}");
        }
    }

    #[test]
    fn an_error_of_a_writer_ends_rendering() {
        let mut writers = [rows(u32::MAX), rows(64)];
        let error = run(tiles(1 << 18, 16 * 300), &mut writers).map(|_| ()).unwrap_err();
        assert_eq!(error.to_string(), "picture: row 64");
        assert!(writers[0].height < 200, "{}", writers[0].height);
    }

    #[test]
    #[should_panic(expected = "a mistake")]
    fn a_panic_ends_rendering() {
        let mut writer = rows(u32::MAX);
        let bands = Bands::new(tiles(1 << 18, 320), PLANES, vec![&mut writer]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let render = |tile: &Tile, film: &mut Columns| {
            if tile.row == 32 { panic!("a mistake") } else { render(tile, film) }
        };
        let _ = pool.install(|| bands.render(&Silent, &|| Box::new(render)));
    }
}
