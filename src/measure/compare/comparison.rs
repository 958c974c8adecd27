//! [`Comparison`]: how much two pictures differ, and where.

use super::picture::{Differences, Picture};
use super::regions::{Region, regions};
use crate::error::counted;
use image::RgbImage;
use std::fmt;

/// Number of regions that are printed and drawn.
pub const SHOWN_REGIONS: usize = 10;

/// The differences of two pictures of the same size. The difference of a pixel is that of its worst channel, in
/// levels of 1/255. Those of numbers are not clamped, and rounded up for the histogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub width: u32,
    pub height: u32,
    pub pixels: u64,
    pub worst: u8,
    /// Root mean square over all channels of all pixels, in levels.
    pub rmse: f64,
    /// `histogram[d]` pixels differ by d levels; the last one stands for all larger differences, too.
    pub histogram: Box<[u64; 256]>,
    /// Pixels whose alpha differs. It is not compared otherwise.
    pub alpha: u64,
    /// The first pixel with the largest difference; none if the pictures are equal.
    pub worst_pixel: Option<WorstPixel>,
    /// Where pixels differ by more than `levels`; those of most pixels first.
    pub regions: Vec<Region>,
    pub levels: u8,
}

/// The pixel that differs most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPixel {
    /// Column from the left.
    pub x: u32,
    /// Row from the top.
    pub y: u32,
    /// Colours: bytes from 0 to 255, or numbers if one of the pictures is of numbers.
    pub a: [f64; 3],
    pub b: [f64; 3],
    pub is_of_numbers: bool,
}

impl Comparison {
    /// Compares two pictures of the same size.
    pub fn new(a: &RgbImage, b: &RgbImage) -> Self {
        let (a, b) = (Picture::of_bytes(a.clone()), Picture::of_bytes(b.clone()));
        Self::of(&a, &b, &a.differences(&b), 0)
    }

    /// Sums up the differences of `a` and `b`. Regions are those of pixels that differ by more than `levels`.
    pub(super) fn of(a: &Picture, b: &Picture, differences: &Differences, levels: u8) -> Self {
        let (width, height) = a.size;
        let mut histogram = Box::new([0; 256]);
        differences.levels.iter().for_each(|&level| histogram[usize::from(level)] += 1);
        let pixels = differences.levels.len() as u64;
        Self {
            width,
            height,
            pixels,
            worst: (0..=255).rev().find(|&level| histogram[usize::from(level)] > 0).unwrap_or(0),
            rmse: (differences.squares / (3 * pixels) as f64).sqrt(),
            histogram,
            alpha: a.differing_alpha(b),
            worst_pixel: differences.worst.map(|pixel| WorstPixel::of(a, b, pixel)),
            regions: regions(&differences.levels, width as usize, levels),
            levels,
        }
    }

    /// Returns the number of pixels that differ by more than `levels`.
    pub fn pixels_over(&self, levels: u8) -> u64 {
        self.histogram[usize::from(levels) + 1..].iter().sum()
    }

    /// Returns the percentage of pixels that differ by more than `levels`.
    pub fn percent_over(&self, levels: u8) -> f64 {
        100.0 * self.pixels_over(levels) as f64 / self.pixels as f64
    }

    /// Returns the peak signal-to-noise ratio in decibels; infinite for equal pictures.
    pub fn psnr(&self) -> f64 {
        20.0 * (255.0 / self.rmse).log10()
    }
}

impl WorstPixel {
    fn of(a: &Picture, b: &Picture, pixel: usize) -> Self {
        let is_of_numbers = a.is_of_numbers() || b.is_of_numbers();
        let color = |picture: &Picture| {
            if is_of_numbers { picture.numbers(pixel) } else { picture.bytes(pixel).map(f64::from) }
        };
        let (pixel, width) = (pixel as u32, a.size.0);
        Self { x: pixel % width, y: pixel / width, a: color(a), b: color(b), is_of_numbers }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "worst channel  {} levels", self.worst)?;
        writeln!(f, "RMSE           {:.4} levels", self.rmse)?;
        writeln!(f, "PSNR           {:.2} dB", self.psnr())?;
        for levels in [0, 1, 8] {
            let (pixels, percent) = (self.pixels_over(levels), self.percent_over(levels));
            writeln!(f, "over {levels} levels  {pixels} pixels, {percent:.4}%")?;
        }
        if self.alpha > 0 {
            writeln!(f, "alpha          differs in {} pixels, and is not compared", self.alpha)?;
        }
        if let Some(pixel) = &self.worst_pixel {
            writeln!(f, "worst pixel    {pixel}")?;
        }
        self.write_regions(f)
    }
}

impl Comparison {
    /// Writes a line for each of the largest regions, if there are any.
    fn write_regions(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.regions.is_empty() {
            return Ok(());
        }
        let levels = counted(usize::from(self.levels), "level");
        writeln!(f, "regions        {} of pixels over {levels}:", self.regions.len())?;
        let (shown, others) = self.regions.split_at(SHOWN_REGIONS.min(self.regions.len()));
        for Region { left, top, right, bottom, pixels, worst } in shown {
            let (pixels, worst) = (counted(*pixels as usize, "pixel"), counted(usize::from(*worst), "level"));
            writeln!(f, "  x {left} to {right}, y {top} to {bottom}: {pixels}, worst {worst}")?;
        }
        if !others.is_empty() {
            let pixels: u64 = others.iter().map(|region| region.pixels).sum();
            writeln!(f, "  and {} more: {} in all", others.len(), counted(pixels as usize, "pixel"))?;
        }
        Ok(())
    }
}

impl fmt::Display for WorstPixel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let color = |[r, g, b]: [f64; 3]| {
            if self.is_of_numbers { format!("{r:.5} {g:.5} {b:.5}") } else { format!("{r} {g} {b}") }
        };
        let Self { x, y, a, b, .. } = self;
        write!(f, "x {x} from the left, y {y} from the top: A {}, B {}", color(*a), color(*b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn differences_are_counted_by_their_worst_channel() {
        let a = RgbImage::from_pixel(2, 2, Rgb([100, 100, 100]));
        let mut b = a.clone();
        b.put_pixel(0, 0, Rgb([101, 100, 100]));
        b.put_pixel(1, 1, Rgb([100, 109, 97]));
        let comparison = Comparison::new(&a, &b);
        assert_eq!((comparison.pixels, comparison.worst), (4, 9));
        assert_eq!([0, 1, 8].map(|levels| comparison.pixels_over(levels)), [2, 1, 1]);
        let squares: f64 = 1.0 + 81.0 + 9.0;
        assert!((comparison.rmse - (squares / 12.0).sqrt()).abs() < 1e-12);
        let worst = comparison.worst_pixel.unwrap();
        assert_eq!((worst.x, worst.y, worst.a, worst.b), (1, 1, [100.0; 3], [100.0, 109.0, 97.0]));
        assert_eq!(comparison.regions.iter().map(|region| region.pixels).collect::<Vec<_>>(), [2]);
        let same = Comparison::new(&a, &a);
        assert_eq!((same.psnr(), same.worst_pixel, same.regions.len()), (f64::INFINITY, None, 0));
    }
}
