//! [`TileSamples`]: the samples of a tile in adaptive sampling.

use super::allocation::Goal;
use super::error_sums::ErrorSums;
use super::frame::SampleCounts;
use super::halves_error::HalvesError;
use super::pixel::{Pixel, fill, finite, store};
use super::preview::Preview;
use super::spread::SetKind;
use super::tiles::Tile;
use crate::film::{Columns, Film, Planes};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::simd::{InstructionSet, Simd, vectorize, with_simd};
use crate::trace::Seen;
use std::ops::Range;
use vecmath::{Real, Vector3};

/// Sums over the samples of each pixel of a tile, in two halves, which are compared. Memory is taken by the first samples,
/// so a tile that is never reached takes none, nor one that is empty.
pub struct TileSamples {
    pub tile: Tile,
    /// Whether nothing but a background of one colour is seen through it.
    pub is_empty: bool,
    /// What every pixel of an empty tile shows, once it is known.
    filled: Option<Pixel>,
    halves: Halves,
    has_colors: bool,
    has_others: bool,
    /// Number of samples of each pixel, both halves together, which is even.
    samples: Vec<u32>,
    /// Sums of the colours of all samples, for each pixel; empty without a colour picture.
    colors: Vec<Vector3>,
    /// Of these, what independent halves have in the second one; empty with other halves.
    in_second: Vec<Vector3>,
    /// What the halves say, for each pixel; empty without a colour picture.
    halves_errors: Vec<HalvesError>,
    /// Sums of depths and normals over both halves, for each pixel; empty without pictures of them.
    others: Vec<Pixel>,
    /// Whether samples were added since the variances were last copied.
    has_news: bool,
    /// The errors of the pixels that have samples.
    pub errors: ErrorSums,
    pub counts: RayCounts,
}

/// The squared error of a pixel of which nothing is known.
const UNKNOWN: f32 = 255.0 * 255.0;

/// What the halves of a pixel's samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Halves {
    /// Two sets.
    Independent,
    /// The first and the second half of one sequence, whose length is a power of two: when it doubles, both halves
    /// become the first one.
    OfSequence,
}

/// Samples that a pixel needs.
pub struct Wanted {
    /// Index of the pixel in the tile.
    pub index: usize,
    /// Column and row in the picture.
    pub pixel: (u32, u32),
    /// From the number of samples that it has to the number that it shall have.
    pub samples: Range<u32>,
}

impl TileSamples {
    /// Returns the bytes for each pixel, with the numbers that the allocation of samples keeps.
    pub fn bytes_per_pixel(planes: Planes) -> usize {
        let colors =
            if planes.color || planes.linear { 2 * size_of::<Vector3>() + size_of::<HalvesError>() } else { 0 };
        let others = if planes.depth || planes.normals { size_of::<Pixel>() } else { 0 };
        size_of::<u32>() + colors + others + 4 * size_of::<f32>()
    }

    pub fn new(tile: Tile, plan: &Plan, halves: Halves, is_empty: bool) -> Self {
        Self {
            tile,
            is_empty,
            filled: None,
            halves,
            has_colors: plan.color,
            has_others: plan.depth || plan.normals,
            samples: Vec::new(),
            colors: Vec::new(),
            in_second: Vec::new(),
            halves_errors: Vec::new(),
            others: Vec::new(),
            has_news: false,
            errors: ErrorSums::default(),
            counts: RayCounts::default(),
        }
    }

    /// Gives its memory back.
    pub fn free(&mut self) {
        self.samples = Vec::new();
        self.colors = Vec::new();
        self.in_second = Vec::new();
        self.halves_errors = Vec::new();
        self.others = Vec::new();
    }

    /// Returns the number of its pixels.
    fn pixels(&self) -> usize {
        (self.tile.width * self.tile.height) as usize
    }

    /// Returns whether memory for samples was taken.
    pub fn has_samples(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Takes the memory that samples need, if it is not there.
    pub fn make_room(&mut self) {
        if self.samples.is_empty() {
            let pixels = self.pixels();
            let only_if = |wanted: bool| if wanted { pixels } else { 0 };
            self.samples = vec![0; pixels];
            self.colors = vec![Vector3::ZERO; only_if(self.has_colors)];
            let are_independent = self.halves == Halves::Independent;
            self.in_second = vec![Vector3::ZERO; only_if(self.has_colors && are_independent)];
            self.halves_errors = vec![HalvesError::default(); only_if(self.has_colors)];
            self.others = vec![Pixel::default(); only_if(self.has_others)];
        }
    }

    /// Returns the number of samples of a pixel: 1 in an empty tile.
    pub fn samples(&self, index: usize) -> u32 {
        let own = || self.samples.get(index).copied().unwrap_or(0);
        self.filled.map_or_else(own, |_| 1)
    }

    /// Returns the smallest number of samples that a pixel has, where it is not known without them; `None` if no pixel
    /// has any.
    pub fn fewest(&self) -> Option<u32> {
        match self.least() {
            0 => self.samples.iter().copied().filter(|&samples| samples > 0).min(),
            least => Some(least),
        }
    }

    /// Counts the samples of all pixels.
    pub fn count_samples(&self) -> SampleCounts {
        match self.samples.as_slice() {
            [] => SampleCounts::of_pixels(self.pixels() as u64, self.samples(0)),
            samples => SampleCounts::of_each(samples),
        }
    }

    /// Returns the smallest number of samples of all pixels.
    fn least(&self) -> u32 {
        self.samples.iter().copied().min().unwrap_or(0)
    }

    /// Returns the squared error of a pixel in squared levels, the largest if it has no samples.
    fn variance(&self, index: usize) -> f32 {
        match (self.samples(index), self.halves_errors.get(index)) {
            (0, _) => UNKNOWN,
            (_, error) => error.map_or(0.0, |error| error.squared_levels),
        }
    }

    /// Copies the variance of a sample of each pixel in squared levels, by its own samples, to a part of the picture.
    /// `powers` has what the squared error of 1, 2, 4 ... samples is multiplied by. Does nothing if they are the same as
    /// when it was last called.
    pub fn copy_variances(&mut self, powers: &[f32; 32], part: Tile, variances: &mut [f32]) {
        if !std::mem::take(&mut self.has_news) {
            return;
        }
        let width = self.tile.width as usize;
        for row in 0..self.tile.height {
            let first = part.index_of((self.tile.x, self.tile.row + row));
            for (x, variance) in variances[first..first + width].iter_mut().enumerate() {
                let index = row as usize * width + x;
                let power = self.samples(index).checked_ilog2().unwrap_or(0) as usize;
                *variance = self.variance(index) * powers[power];
            }
        }
    }

    /// Replaces `wanted` by the pixels that have fewer samples than `goal` says.
    pub fn pixels_below(&self, goal: &Goal, wanted: &mut Vec<Wanted>) {
        wanted.clear();
        if !self.samples.is_empty() && goal.most(&self.tile) <= self.least() {
            return;
        }
        let of_pixel =
            |(index, pixel): (usize, _)| Wanted { index, pixel, samples: self.samples(index)..goal.of(pixel) };
        wanted.extend(self.tile.pixels().enumerate().map(of_pixel).filter(|wanted| !wanted.samples.is_empty()));
    }

    /// Adds the first two samples of pixels from number `first` on, of which each is a half.
    pub fn add_pairs(
        &mut self,
        simd: InstructionSet,
        first: usize,
        seen: &[Seen],
        displayed: impl Fn(&Seen) -> Pixel,
    ) {
        let pairs = seen.as_chunks::<2>().0;
        let pixels = first..first + pairs.len();
        self.samples[pixels.clone()].fill(2);
        self.has_news = true;
        if let Some(sums) = self.colors.get_mut(pixels.clone()) {
            let (mut seconds, mut brightest) = (vec![Vector3::ZERO; pairs.len()], Vector3::ZERO);
            for ((pair, sum), second) in pairs.iter().zip(&mut *sums).zip(&mut seconds) {
                let (a, b) = (finite(pair[0].color), finite(pair[1].color));
                brightest = brightest.greater(a).greater(b);
                (*sum, *second) = (a + b, b);
            }
            self.errors.see(brightest);
            let (sums, seconds, errors) = (&*sums, &*seconds, &mut self.halves_errors[pixels.clone()]);
            let factor = SetKind::usual_factor(2);
            with_simd!(simd, simd => vectorize!(simd, HalvesError::write_each(errors, sums, seconds, factor)));
        }
        if let Some(others) = self.others.get_mut(pixels) {
            for (pixel, pair) in others.iter_mut().zip(pairs) {
                add_others(pixel, pair, &displayed);
            }
        }
    }

    /// Adds what the wanted samples of a pixel saw: of independent halves first those of the first one.
    #[inline]
    pub fn add(&mut self, wanted: &Wanted, seen: &[Seen], displayed: impl Fn(&Seen) -> Pixel) {
        let (index, samples) = (wanted.index, wanted.samples.end);
        if !self.colors.is_empty() {
            let in_first = match self.halves {
                Halves::Independent => seen.len() / 2,
                Halves::OfSequence => (samples / 2).saturating_sub(wanted.samples.start) as usize,
            };
            let (first, second) = seen.split_at(in_first);
            let new = (self.sum(first), self.sum(second));
            self.add_colors(index, samples, new);
        }
        self.samples[index] = samples;
        self.has_news = true;
        if let Some(others) = self.others.get_mut(index) {
            add_others(others, seen, &displayed);
        }
    }

    /// Adds colours up, and notes how bright they are.
    #[inline]
    fn sum(&mut self, seen: &[Seen]) -> Vector3 {
        let mut sum = Vector3::ZERO;
        for seen in seen {
            let color = finite(seen.color);
            self.errors.see(color);
            sum += color;
        }
        sum
    }

    /// Adds the sums of new colours in both halves of a pixel, which has so many samples then.
    #[inline]
    fn add_colors(&mut self, index: usize, samples: u32, new: (Vector3, Vector3)) {
        let second = match self.in_second.get_mut(index) {
            Some(second) => {
                *second += new.1;
                *second
            }
            // All earlier samples are in the first half of a sequence.
            None => new.1,
        };
        let sum = self.colors[index] + new.0 + new.1;
        self.colors[index] = sum;
        let factor = match self.halves {
            Halves::Independent => 1.0,
            Halves::OfSequence => SetKind::usual_factor(samples),
        };
        let in_half = 2.0 / samples as Real;
        self.halves_errors[index] = HalvesError::new((sum - second) * in_half, second * in_half, factor);
    }

    /// Sets what every pixel of an empty tile shows.
    pub fn fill(&mut self, pixel: Pixel) {
        self.filled = Some(pixel);
        self.errors.see(pixel.color);
        self.errors.add_exact(self.pixels() as u64);
    }

    /// Returns the mean of all samples of a pixel.
    fn mean(&self, index: usize) -> Pixel {
        let mut mean = Pixel::default();
        let samples = self.samples(index) as Real;
        if let Some(others) = self.others.get(index) {
            mean = Pixel { depth: others.depth / samples, normal: others.normal / samples, ..mean };
        }
        if let Some(&sum) = self.colors.get(index) {
            mean.color = sum * (1.0 / samples);
        }
        mean
    }

    /// Turns the samples into a picture of the tile.
    pub fn film(&self, planes: Planes) -> Film {
        let mut film = Film::new(self.tile.width, self.tile.height, planes);
        self.store(None, &mut film.columns(0, self.tile.width));
        film
    }

    /// Turns the samples into the tile's part of the picture. Pixels without samples show the preview.
    pub fn store(&self, preview: Option<&Preview>, film: &mut Columns) {
        let pixel = |(index, pixel)| match preview {
            Some(preview) if self.samples(index) == 0 => preview.pixel(pixel),
            _ => self.mean(index),
        };
        match self.filled {
            Some(pixel) => fill(&pixel, film),
            // The usual case: whole pixels take three times as long.
            None if !self.has_others && self.least() > 0 => {
                let means = self.colors.iter().zip(&self.samples);
                let means: Vec<Vector3> = means.map(|(&sum, &samples)| sum * (1.0 / samples as Real)).collect();
                film.set_colors(&means, |&color| color);
            }
            None => store(&self.tile.pixels().enumerate().map(pixel).collect::<Vec<_>>(), film),
        }
        if film.have_variances() {
            film.set_variances(&(0..self.pixels()).map(|index| self.variance(index)).collect::<Vec<_>>());
        }
    }

    /// Adds the errors of all pixels up anew.
    pub fn update_errors(&mut self) {
        self.errors.clear();
        let sampled = self.halves_errors.iter().zip(&self.samples).filter(|(_, samples)| **samples > 0);
        self.errors.add_halves(sampled.map(|(error, _)| error));
    }
}

/// Adds what pictures of depths and normals show.
fn add_others(sum: &mut Pixel, seen: &[Seen], displayed: impl Fn(&Seen) -> Pixel) {
    for pixel in seen.iter().map(displayed) {
        sum.depth += pixel.depth;
        sum.normal += pixel.normal;
    }
}
