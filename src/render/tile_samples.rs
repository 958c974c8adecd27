//! [`TileSamples`]: the samples of a tile in adaptive sampling.

use super::error_estimate::ErrorSums;
use super::pixel::Pixel;
use super::tiles::Tile;
use crate::film::Planes;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::trace::Seen;
use std::ops::Range;
use vecmath::{Real, Vector3};

/// Sums over the samples of each pixel of a tile, in two independent halves.
pub struct TileSamples {
    pub tile: Tile,
    /// Number of samples in each half, for each pixel.
    pub samples: Vec<u32>,
    /// Sums of colours in each half, for each pixel; empty without a colour picture.
    colors: Vec<[Vector3; 2]>,
    /// Sums of depths and normals over both halves, for each pixel; empty without pictures of them.
    others: Vec<Pixel>,
    pub counts: RayCounts,
}

/// Samples that a pixel needs.
pub struct Wanted {
    /// Index of the pixel in the tile.
    pub index: usize,
    /// Column and row in the picture.
    pub pixel: (u32, u32),
    /// Numbers of the samples, in each half.
    pub samples: Range<u32>,
}

impl TileSamples {
    /// Returns the bytes for each pixel, with the numbers that the allocation of samples keeps.
    pub fn bytes_per_pixel(planes: Planes) -> usize {
        let colors = if planes.color { size_of::<[Vector3; 2]>() } else { 0 };
        let others = if planes.depth || planes.normals { size_of::<Pixel>() } else { 0 };
        size_of::<u32>() + colors + others + 2 * size_of::<f32>()
    }

    pub fn new(tile: Tile, plan: &Plan) -> Self {
        let pixels = (tile.width * tile.height) as usize;
        let with_others = plan.depth || plan.normals;
        Self {
            tile,
            samples: vec![0; pixels],
            colors: vec![[Vector3::ZERO; 2]; if plan.color { pixels } else { 0 }],
            others: vec![Pixel::default(); if with_others { pixels } else { 0 }],
            counts: RayCounts::default(),
        }
    }

    /// Returns the pixels that have fewer samples in each half than `goal` says.
    pub fn pixels_below(&self, goal: impl Fn((u32, u32)) -> u32) -> Vec<Wanted> {
        let wanted =
            |(index, pixel): (usize, _)| Wanted { index, pixel, samples: self.samples[index]..goal(pixel) };
        self.tile.pixels().enumerate().map(wanted).filter(|wanted| !wanted.samples.is_empty()).collect()
    }

    /// Adds samples to both halves of a pixel.
    pub fn add(&mut self, index: usize, halves: [&[Seen]; 2], displayed: impl Fn(&Seen) -> Pixel) {
        self.samples[index] += halves[0].len() as u32;
        for (half, seen) in halves.into_iter().enumerate() {
            for pixel in seen.iter().map(&displayed) {
                if let Some(colors) = self.colors.get_mut(index) {
                    colors[half] += pixel.color;
                }
                if let Some(others) = self.others.get_mut(index) {
                    others.depth += pixel.depth;
                    others.normal += pixel.normal;
                }
            }
        }
    }

    /// Returns the mean of all samples of a pixel.
    pub fn mean(&self, index: usize) -> Pixel {
        let mut mean = Pixel::default();
        let samples = 2.0 * self.samples[index] as Real;
        if let Some(others) = self.others.get(index) {
            mean = Pixel { depth: others.depth / samples, normal: others.normal / samples, ..mean };
        }
        if !self.colors.is_empty() {
            let [first, second] = self.halves(index);
            mean.color = (first + second) * 0.5;
        }
        mean
    }

    /// Returns the mean colours of both halves.
    fn halves(&self, index: usize) -> [Vector3; 2] {
        self.colors[index].map(|sum| sum / self.samples[index] as Real)
    }

    /// Returns the errors of the pixels that have samples.
    pub fn errors(&self) -> ErrorSums {
        let mut sums = ErrorSums::default();
        for index in (0..self.colors.len()).filter(|&index| self.samples[index] > 0) {
            sums.add_halves(self.halves(index));
        }
        sums
    }

    /// Returns the standard errors of all pixels in levels, the largest level where there are no samples.
    pub fn pixel_errors(&self) -> impl Iterator<Item = f64> {
        (0..self.samples.len()).map(|index| match self.samples[index] {
            0 => 255.0,
            _ => ErrorSums::default().add_halves(self.halves(index)),
        })
    }
}
