//! [`Bands`]: a picture on its way from the threads that render it to its writers.
//!
//! A band is a row of tiles. Each thread takes the next tile and hands its pixels on; none waits for another to do so. The
//! thread that finishes the last tile of a band joins them, and then writes what is due: each writer takes the bands from
//! the top, from one thread at a time, while the others render. A thread that is too far below the first unwritten band
//! helps with writing, or waits. So some bands are in memory, however high the picture is.

use super::error_estimate::ErrorSums;
use super::frame::SampleCounts;
use super::tiles::{Progress, Tile, Tiles};
use crate::error::Error;
use crate::film::{BandWriter, Film, Planes};
use crate::ray_counts::RayCounts;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Bytes of pixels in bands that are not written yet: so many that threads need not wait for one slow tile.
const IN_FLIGHT: u64 = 16 << 20;

/// A finished tile.
pub struct RenderedTile {
    pub film: Film,
    pub cost: TileCost,
}

/// What a tile has cost, and how wrong it is.
pub struct TileCost {
    pub pixels: u64,
    /// Of each pixel.
    pub samples: u32,
    pub counts: RayCounts,
    pub errors: ErrorSums,
    /// Time spent on turning samples into pixels; zero unless it is measured.
    pub filter: Duration,
}

/// The costs and the errors of all tiles.
#[derive(Default)]
pub struct Totals {
    pub counts: RayCounts,
    pub samples: SampleCounts,
    pub errors: ErrorSums,
    pub filter: Duration,
    /// Time spent on writing, summed over all threads.
    pub writing: Duration,
}

impl Totals {
    /// Adds a tile. They are added in their order, because sums of errors are rounded.
    fn add(&mut self, tile: TileCost) {
        self.counts += tile.counts;
        self.samples.add_pixels(tile.pixels, tile.samples);
        self.errors = ErrorSums::total([self.errors, tile.errors]);
        self.filter += tile.filter;
    }
}

/// Renders tiles; each thread has its own.
pub type RenderTile<'a> = Box<dyn FnMut(&Tile) -> RenderedTile + 'a>;

/// The bands of a picture.
pub struct Bands<'a> {
    tiles: Tiles,
    planes: Planes,
    next_tile: AtomicUsize,
    finished_tiles: AtomicUsize,
    /// Whether a writer had an error, or a thread has panicked.
    is_stopped: AtomicBool,
    state: Mutex<State<'a>>,
    /// Notified when a band was finished or written.
    has_moved: Condvar,
}

/// The bands in flight: those that are begun and not yet written by all writers.
struct State<'a> {
    /// Number of the first one.
    first: usize,
    in_flight: VecDeque<InFlight>,
    /// Films of bands that are written: to use one again takes less time than to get memory.
    spare: Vec<Film>,
    writers: Vec<Writer<'a>>,
    totals: Totals,
    error: Option<Error>,
}

struct InFlight {
    band: Arc<Band>,
    /// Once all tiles are finished.
    film: Option<Arc<Film>>,
    costs: Vec<TileCost>,
}

/// A band that is being rendered.
struct Band {
    number: usize,
    /// Each tile from when it is finished to when it is joined to the others.
    tiles: Vec<Mutex<Option<RenderedTile>>>,
    /// Number of tiles that are not finished.
    unfinished: AtomicUsize,
}

struct Writer<'a> {
    /// `None` while a thread writes with it.
    writer: Option<&'a mut dyn BandWriter>,
    /// Number of the band that it writes next.
    next: usize,
}

/// A band that is to be written.
struct Due<'a> {
    index: usize,
    writer: &'a mut dyn BandWriter,
    film: Arc<Film>,
}

impl<'a> Bands<'a> {
    /// There must be a writer.
    pub fn new(tiles: Tiles, planes: Planes, writers: Vec<&'a mut dyn BandWriter>) -> Self {
        let writers = writers.into_iter().map(|writer| Writer { writer: Some(writer), next: 0 }).collect();
        let (in_flight, spare, totals) = (VecDeque::new(), Vec::new(), Totals::default());
        Self {
            tiles,
            planes,
            next_tile: AtomicUsize::new(0),
            finished_tiles: AtomicUsize::new(0),
            is_stopped: AtomicBool::new(false),
            state: Mutex::new(State { first: 0, in_flight, spare, writers, totals, error: None }),
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
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        state.error.map_or(Ok(state.totals), Err)
    }

    /// Takes tile after tile. Nothing in here may wait for other work of the thread pool: a thread that waits takes up
    /// other work, and the band of its own tile would not be finished before that.
    fn work<'r>(&self, progress: &dyn Progress, renderer: &dyn Fn() -> RenderTile<'r>) {
        let _guard = StopInPanic(self);
        let (mut render, mut band) = (None, None::<Arc<Band>>);
        while !self.is_stopped.load(Ordering::Relaxed) {
            let number = self.next_tile.fetch_add(1, Ordering::Relaxed);
            if number >= self.tiles.count() {
                break;
            }
            let (row, column) = (number / self.tiles.columns(), number % self.tiles.columns());
            if band.as_ref().is_none_or(|band| band.number != row) {
                // Dropped before waiting, because it may be written, and large.
                drop(band.take());
                band = self.entered(row);
            }
            let Some(band) = &band else { break };
            let rendered = render.get_or_insert_with(renderer)(&self.tiles.tile(number));
            progress.add_rays(rendered.cost.counts.total());
            *locked(&band.tiles[column]) = Some(rendered);
            let finished = self.finished_tiles.fetch_add(1, Ordering::Relaxed) + 1;
            progress.advance(finished, self.tiles.count());
            if band.unfinished.fetch_sub(1, Ordering::AcqRel) == 1 {
                self.finish(band);
                self.write_what_is_due();
            }
        }
        self.write_what_is_due();
    }

    /// Returns a band whose tiles are to be rendered, once it may be in flight. `None` if rendering is stopped.
    fn entered(&self, number: usize) -> Option<Arc<Band>> {
        let most = most_in_flight(self.tiles, self.planes);
        let mut state = locked(&self.state);
        while number >= state.first + most && !self.is_stopped.load(Ordering::Relaxed) {
            state = match state.take_due() {
                Some(due) => {
                    drop(state);
                    self.write(due);
                    locked(&self.state)
                }
                None => self.has_moved.wait(state).unwrap_or_else(PoisonError::into_inner),
            };
        }
        if self.is_stopped.load(Ordering::Relaxed) {
            return None;
        }
        while state.first + state.in_flight.len() <= number {
            let band = Arc::new(Band {
                number: state.first + state.in_flight.len(),
                tiles: (0..self.tiles.columns()).map(|_| Mutex::new(None)).collect(),
                unfinished: AtomicUsize::new(self.tiles.columns()),
            });
            state.in_flight.push_back(InFlight { band, film: None, costs: Vec::new() });
        }
        Some(Arc::clone(&state.in_flight[number - state.first].band))
    }

    /// Joins the tiles of a band, all of which are finished.
    fn finish(&self, band: &Band) {
        let first = self.tiles.tile(band.number * self.tiles.columns());
        let spare = locked(&self.state).spare.pop().filter(|film| film.height == first.height);
        let mut film = spare.unwrap_or_else(|| Film::new(self.tiles.region.width, first.height, self.planes));
        let (mut costs, mut x) = (Vec::with_capacity(band.tiles.len()), 0);
        for tile in band.tiles.iter().filter_map(|tile| locked(tile).take()) {
            film.place(x, 0, &tile.film);
            x += tile.film.width;
            costs.push(tile.cost);
        }
        let mut state = locked(&self.state);
        let index = band.number - state.first;
        (state.in_flight[index].film, state.in_flight[index].costs) = (Some(Arc::new(film)), costs);
        self.has_moved.notify_all();
    }

    fn write_what_is_due(&self) {
        // The lock must not be held while a band is written.
        let take_due = || locked(&self.state).take_due();
        while let (Some(due), false) = (take_due(), self.is_stopped.load(Ordering::Relaxed)) {
            self.write(due);
        }
    }

    fn write(&self, due: Due<'a>) {
        let Due { index, writer, film } = due;
        let start = Instant::now();
        let written = writer.write(&film);
        drop(film);
        let mut state = locked(&self.state);
        state.totals.writing += start.elapsed();
        state.writers[index].next += 1;
        state.writers[index].writer = Some(writer);
        match written {
            Ok(()) => state.retire_written(),
            Err(error) => {
                state.error.get_or_insert(error);
                self.is_stopped.store(true, Ordering::Relaxed);
            }
        }
        self.has_moved.notify_all();
    }
}

impl<'a> State<'a> {
    /// Takes the writer that is farthest behind, and the band that it writes next; `None` if no writer can go on.
    fn take_due(&mut self) -> Option<Due<'a>> {
        let (first, in_flight) = (self.first, &self.in_flight);
        let film = |writer: &Writer| in_flight.get(writer.next - first)?.film.as_ref();
        let is_due = |(_, writer): &(usize, &mut Writer)| writer.writer.is_some() && film(writer).is_some();
        let (index, writer) = self.writers.iter_mut().enumerate().filter(is_due).min_by_key(|(_, w)| w.next)?;
        let film = Arc::clone(film(writer)?);
        Some(Due { index, writer: writer.writer.take()?, film })
    }

    /// Lets go of the bands that all writers have written.
    fn retire_written(&mut self) {
        let unwritten = self.writers.iter().map(|writer| writer.next).min().unwrap_or(self.first);
        while self.first < unwritten {
            self.first += 1;
            let Some(InFlight { film, costs, .. }) = self.in_flight.pop_front() else { continue };
            costs.into_iter().for_each(|cost| self.totals.add(cost));
            self.spare.extend(film.and_then(Arc::into_inner));
        }
    }
}

/// Stops all threads when one panics, which would else wait for its band for ever.
struct StopInPanic<'a, 'b>(&'b Bands<'a>);

impl Drop for StopInPanic<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let _state = locked(&self.0.state);
            self.0.is_stopped.store(true, Ordering::Relaxed);
            self.0.has_moved.notify_all();
        }
    }
}

/// Locks, also after another thread has panicked: that panic will be reported.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the largest number of bands in flight: with two, a band can be rendered while another is written.
fn most_in_flight(tiles: Tiles, planes: Planes) -> usize {
    let bytes = tiles.band_pixels() * planes.bytes_per_pixel() as u64;
    (IN_FLIGHT / bytes.max(1)).max(2) as usize
}

/// Returns the bytes of pixels in flight at most.
pub fn bytes_in_flight(tiles: Tiles, planes: Planes) -> u64 {
    let band = tiles.band_pixels() * planes.bytes_per_pixel() as u64;
    // Those of one are there twice while its tiles are joined.
    (most_in_flight(tiles, planes) as u64 + 1) * band
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Region;
    use std::path::Path;

    const PLANES: Planes = Planes { color: false, depth: true, normals: false, linear: false, error_map: false };

    struct Silent;

    impl Progress for Silent {
        fn advance(&self, _: usize, _: usize) {}
    }

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
    fn render(tile: &Tile) -> RenderedTile {
        let mut film = Film::new(tile.width, tile.height, PLANES);
        film.depth = Some(tile.pixels().map(|(x, row)| (x + row) as u8).collect());
        let (counts, errors) = (RayCounts::default(), ErrorSums::default());
        let pixels = u64::from(tile.width * tile.height);
        RenderedTile { film, cost: TileCost { pixels, samples: 1, counts, errors, filter: Duration::ZERO } }
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
        let render = |tile: &Tile| if tile.row == 32 { panic!("a mistake") } else { render(tile) };
        let _ = pool.install(|| bands.render(&Silent, &|| Box::new(render)));
    }
}
