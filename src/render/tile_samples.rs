//! [`TileSamples`]: the samples of a tile in adaptive sampling.

use super::error_estimate::ErrorSums;
use super::pixel::Pixel;
use super::spread::{SetKind, USUAL_RATIO};
use super::tiles::Tile;
use crate::film::Planes;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::trace::Seen;
use std::ops::Range;
use vecmath::{Real, Vector3};

/// Sums over the samples of each pixel of a tile, in two halves, which are compared.
pub struct TileSamples {
    pub tile: Tile,
    /// Whether nothing but a background of one colour is seen through it.
    pub is_empty: bool,
    /// Number of samples of each pixel, both halves together. It is even, or 1 in an empty tile.
    pub samples: Vec<u32>,
    halves: Halves,
    /// Sums of colours in each half, for each pixel; empty without a colour picture.
    colors: Vec<[Vector3; 2]>,
    /// Sums of depths and normals over both halves, for each pixel; empty without pictures of them.
    others: Vec<Pixel>,
    /// The errors of the pixels that have samples.
    pub errors: ErrorSums,
    /// The squared errors of all pixels in squared levels, the largest where there are no samples.
    pub variances: Vec<f32>,
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
        let colors = if planes.color { size_of::<[Vector3; 2]>() } else { 0 };
        let others = if planes.depth || planes.normals { size_of::<Pixel>() } else { 0 };
        size_of::<u32>() + colors + others + 4 * size_of::<f32>()
    }

    pub fn new(tile: Tile, plan: &Plan, halves: Halves, is_empty: bool) -> Self {
        let pixels = (tile.width * tile.height) as usize;
        let with_others = plan.depth || plan.normals;
        Self {
            tile,
            is_empty,
            samples: vec![0; pixels],
            halves,
            colors: vec![[Vector3::ZERO; 2]; if plan.color { pixels } else { 0 }],
            others: vec![Pixel::default(); if with_others { pixels } else { 0 }],
            errors: ErrorSums::default(),
            variances: vec![UNKNOWN; pixels],
            counts: RayCounts::default(),
        }
    }

    /// Returns the pixels that have fewer samples than `goal` says.
    pub fn pixels_below(&self, goal: impl Fn((u32, u32)) -> u32) -> Vec<Wanted> {
        let wanted =
            |(index, pixel): (usize, _)| Wanted { index, pixel, samples: self.samples[index]..goal(pixel) };
        self.tile.pixels().enumerate().map(wanted).filter(|wanted| !wanted.samples.is_empty()).collect()
    }

    /// Adds what the wanted samples of a pixel saw: of independent halves first those of the first one.
    pub fn add(&mut self, wanted: &Wanted, seen: &[Seen], displayed: impl Fn(&Seen) -> Pixel) {
        let (index, samples) = (wanted.index, &wanted.samples);
        let in_first = match self.halves {
            Halves::Independent => seen.len() / 2,
            Halves::OfSequence => {
                if let Some([first, second]) = self.colors.get_mut(index) {
                    *first += std::mem::take(second);
                }
                (samples.end / 2).saturating_sub(samples.start) as usize
            }
        };
        self.samples[index] = samples.end;
        for (number, pixel) in seen.iter().map(displayed).enumerate() {
            if let Some(colors) = self.colors.get_mut(index) {
                colors[usize::from(number >= in_first)] += pixel.color;
                self.errors.see(pixel.color);
            }
            if let Some(others) = self.others.get_mut(index) {
                others.depth += pixel.depth;
                others.normal += pixel.normal;
            }
        }
    }

    /// Sets what every pixel of an empty tile shows.
    pub fn fill(&mut self, pixel: &Pixel) {
        self.samples.fill(1);
        self.colors.fill([pixel.color * 0.5; 2]);
        self.others.fill(*pixel);
        self.variances.fill(0.0);
        self.errors.see(pixel.color);
        self.errors.add_exact(self.samples.len() as u64);
    }

    /// Returns the mean of all samples of a pixel.
    pub fn mean(&self, index: usize) -> Pixel {
        let mut mean = Pixel::default();
        let samples = self.samples[index] as Real;
        if let Some(others) = self.others.get(index) {
            mean = Pixel { depth: others.depth / samples, normal: others.normal / samples, ..mean };
        }
        if !self.colors.is_empty() {
            let [first, second] = self.means(index);
            mean.color = (first + second) * 0.5;
        }
        mean
    }

    /// Returns the mean colours of both halves.
    fn means(&self, index: usize) -> [Vector3; 2] {
        self.colors[index].map(|sum| sum / (0.5 * self.samples[index] as Real))
    }

    /// Estimates the errors of all pixels anew.
    pub fn update_errors(&mut self) {
        self.errors.clear();
        for index in (0..self.colors.len()).filter(|&index| self.samples[index] > 0) {
            let factor = match self.halves {
                Halves::Independent => 1.0,
                Halves::OfSequence => SetKind::Sobol(self.samples[index]).factor(USUAL_RATIO),
            };
            self.variances[index] = self.errors.add_halves(self.means(index), factor) as f32;
        }
    }
}
