//! [`InFlight`]: the bands of a picture that are begun and not yet written by all writers.

use super::tile_cost::{TileCost, Totals};
use super::tiles::Tiles;
use crate::error::Error;
use crate::film::{BandWriter, Film, Planes};
use std::collections::VecDeque;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Bytes of pixels in bands that are not written yet: so many that threads need not wait for one slow tile.
const IN_FLIGHT: u64 = 16 << 20;

/// The bands that are begun and not yet written by all writers.
pub struct InFlight<'a> {
    /// Number of the first one.
    first: usize,
    bands: VecDeque<Begun>,
    /// Films of bands that are written: to use one again takes less time than to get memory.
    spare: Vec<Film>,
    writers: Vec<Writer<'a>>,
    totals: Totals,
    error: Option<Error>,
}

struct Begun {
    band: Arc<Band>,
    /// Once all tiles are finished.
    film: Option<Arc<Film>>,
    costs: Vec<TileCost>,
}

/// A band that is being rendered.
pub struct Band {
    pub number: usize,
    /// Each run from when it is finished to when it is joined to the others.
    pub runs: Vec<Mutex<Option<Run>>>,
    /// Number of runs that are not finished.
    pub unfinished: AtomicUsize,
}

/// Neighbouring tiles that are rendered by one thread, and what each of them has cost.
pub struct Run {
    pub film: Film,
    pub costs: Vec<TileCost>,
}

struct Writer<'a> {
    /// `None` while a thread writes with it.
    writer: Option<&'a mut dyn BandWriter>,
    /// Number of the band that it writes next.
    next: usize,
}

/// A band that is to be written.
pub struct Due<'a> {
    /// Of the writer.
    pub index: usize,
    pub writer: &'a mut dyn BandWriter,
    pub film: Arc<Film>,
}

impl Band {
    fn new(number: usize, runs: usize) -> Self {
        let unfinished = AtomicUsize::new(runs);
        Self { number, runs: (0..runs).map(|_| Mutex::default()).collect(), unfinished }
    }

    /// Joins the runs, all of which are finished, in a film. Returns their costs.
    pub fn join(&self, film: &mut Film) -> Vec<TileCost> {
        let (mut costs, mut x) = (Vec::new(), 0);
        for run in self.runs.iter().filter_map(|run| locked(run).take()) {
            film.place(x, 0, &run.film);
            x += run.film.width;
            costs.extend(run.costs);
        }
        costs
    }
}

impl<'a> InFlight<'a> {
    /// Begins with no band. There must be a writer.
    pub fn new(writers: Vec<&'a mut dyn BandWriter>) -> Self {
        let writers = writers.into_iter().map(|writer| Writer { writer: Some(writer), next: 0 }).collect();
        let (bands, spare, totals) = (VecDeque::new(), Vec::new(), Totals::default());
        Self { first: 0, bands, spare, writers, totals, error: None }
    }

    /// Returns whether a band may be begun, if `most` may be in flight.
    pub fn has_room_for(&self, number: usize, most: usize) -> bool {
        number < self.first + most
    }

    /// Returns a band of so many runs, which is begun now unless it was before.
    pub fn band(&mut self, number: usize, runs: usize) -> Arc<Band> {
        while self.first + self.bands.len() <= number {
            let band = Arc::new(Band::new(self.first + self.bands.len(), runs));
            self.bands.push_back(Begun { band, film: None, costs: Vec::new() });
        }
        Arc::clone(&self.bands[number - self.first].band)
    }

    /// Returns a film that is no longer needed, if there is one of this height.
    pub fn take_spare(&mut self, height: u32) -> Option<Film> {
        self.spare.pop().filter(|film| film.height == height)
    }

    /// Takes the film of a band whose tiles are joined, and their costs.
    pub fn finish(&mut self, number: usize, film: Film, costs: Vec<TileCost>) {
        let begun = &mut self.bands[number - self.first];
        (begun.film, begun.costs) = (Some(Arc::new(film)), costs);
    }

    /// Takes the writer that is farthest behind, and the band that it writes next; `None` if no writer can go on.
    pub fn take_due(&mut self) -> Option<Due<'a>> {
        let (first, bands) = (self.first, &self.bands);
        let film = |writer: &Writer| bands.get(writer.next - first)?.film.as_ref();
        let is_due = |(_, writer): &(usize, &mut Writer)| writer.writer.is_some() && film(writer).is_some();
        let (index, writer) = self.writers.iter_mut().enumerate().filter(is_due).min_by_key(|(_, w)| w.next)?;
        let film = Arc::clone(film(writer)?);
        Some(Due { index, writer: writer.writer.take()?, film })
    }

    /// Takes back a writer that has written its next band in this time, or had an error.
    pub fn give_back(
        &mut self,
        index: usize,
        writer: &'a mut dyn BandWriter,
        written: Result<(), Error>,
        time: Duration,
    ) {
        self.totals.writing += time;
        self.writers[index].next += 1;
        self.writers[index].writer = Some(writer);
        match written {
            Ok(()) => self.retire_written(),
            Err(error) => _ = self.error.get_or_insert(error),
        }
    }

    /// Lets go of the bands that all writers have written.
    fn retire_written(&mut self) {
        let unwritten = self.writers.iter().map(|writer| writer.next).min().unwrap_or(self.first);
        while self.first < unwritten {
            self.first += 1;
            let Some(Begun { film, costs, .. }) = self.bands.pop_front() else { continue };
            costs.into_iter().for_each(|cost| self.totals.add(cost));
            self.spare.extend(film.and_then(Arc::into_inner));
        }
    }

    /// Returns the totals of what is written.
    ///
    /// # Errors
    /// The first error of a writer.
    pub fn into_totals(self) -> Result<Totals, Error> {
        self.error.map_or(Ok(self.totals), Err)
    }
}

/// Locks, also after another thread has panicked: that panic will be reported.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the largest number of bands in flight: with two, a band can be rendered while another is written.
pub fn most_in_flight(tiles: Tiles, planes: Planes) -> usize {
    let bytes = tiles.band_pixels() * planes.bytes_per_pixel() as u64;
    (IN_FLIGHT / bytes.max(1)).max(2) as usize
}

/// Returns the bytes of pixels in flight at most.
pub fn bytes_in_flight(tiles: Tiles, planes: Planes) -> u64 {
    let band = tiles.band_pixels() * planes.bytes_per_pixel() as u64;
    // Those of one are there twice while its tiles are joined.
    (most_in_flight(tiles, planes) as u64 + 1) * band
}
