//! [`Comparison`]: how much two pictures differ, of bytes or of numbers.

use crate::error::Error;
use crate::film::{NumberPicture, read_numbers, write_png};
use crate::options::{CompareOptions, has_extension};
use crate::output;
use crate::picture_file::PictureFile;
use image::{DynamicImage, RgbImage};
use std::fmt;
use std::path::Path;

/// The differences of two pictures of the same size. The difference of a pixel is that of its worst channel, in
/// levels of 1/255. Those of numbers are not clamped, and rounded up for the histogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub pixels: u64,
    pub worst: u8,
    /// Root mean square over all channels of all pixels, in levels.
    pub rmse: f64,
    /// `histogram[d]` pixels differ by d levels; the last one stands for all larger differences, too.
    pub histogram: Box<[u64; 256]>,
    /// Pixels whose alpha differs. It is not compared otherwise.
    pub alpha: u64,
}

impl Comparison {
    /// Compares two pictures of the same size.
    pub fn new(a: &RgbImage, b: &RgbImage) -> Self {
        Self::of(a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b))))
    }

    /// Sums up differences in levels, three for each pixel.
    fn of(mut differences: impl Iterator<Item = f64>) -> Self {
        let mut histogram = Box::new([0; 256]);
        let (mut pixels, mut squares) = (0, 0.0);
        while let (Some(r), Some(g), Some(b)) = (differences.next(), differences.next(), differences.next()) {
            squares += r * r + g * g + b * b;
            histogram[r.max(g).max(b).ceil().min(255.0) as usize] += 1;
            pixels += 1;
        }
        let worst = (0..=255).rev().find(|&d| histogram[usize::from(d)] > 0).unwrap_or(0);
        Self { pixels, worst, rmse: (squares / (3 * pixels) as f64).sqrt(), histogram, alpha: 0 }
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
        Ok(())
    }
}

/// Reads a picture as 8 bit RGB.
///
/// # Errors
/// [`Error::File`] when it cannot be read.
pub fn read_rgb(path: &Path) -> Result<RgbImage, Error> {
    decoded(path).map(DynamicImage::into_rgb8)
}

fn decoded(path: &Path) -> Result<DynamicImage, Error> {
    let picture = PictureFile::open(path).and_then(PictureFile::decode);
    picture.map_err(|message| Error::file(path, message))
}

/// A picture to compare.
struct Picture {
    size: (u32, u32),
    channels: Channels,
    /// None if it is 255 everywhere.
    alpha: Option<Vec<u8>>,
}

/// Three for each pixel.
enum Channels {
    Bytes(Vec<u8>),
    Numbers(Vec<f32>),
}

impl Picture {
    fn read(path: &Path) -> Result<Self, Error> {
        if ["pfm", "exr"].iter().any(|extension| has_extension(path, extension)) {
            let NumberPicture { width, height, numbers } = read_numbers(path)?;
            return Ok(Self { size: (width, height), channels: Channels::Numbers(numbers), alpha: None });
        }
        let picture = decoded(path)?;
        let alpha =
            picture.color().has_alpha().then(|| picture.to_rgba8().pixels().map(|pixel| pixel[3]).collect());
        let size = (picture.width(), picture.height());
        Ok(Self { size, channels: Channels::Bytes(picture.into_rgb8().into_raw()), alpha })
    }

    /// Returns the differences of the channels in levels.
    fn differences(&self, other: &Self) -> impl Iterator<Item = f64> + Clone {
        let count = 3 * self.size.0 as usize * self.size.1 as usize;
        (0..count).map(|index| match (&self.channels, &other.channels) {
            (Channels::Bytes(a), Channels::Bytes(b)) => f64::from(a[index].abs_diff(b[index])),
            (a, b) => {
                let (a, b) = (a.number(index), b.number(index));
                let is_same = a == b || (a.is_nan() && b.is_nan());
                let levels = 255.0 * (a - b).abs();
                if is_same {
                    0.0
                } else if levels.is_nan() {
                    f64::INFINITY
                } else {
                    levels
                }
            }
        })
    }

    fn alpha_of(&self, pixel: usize) -> u8 {
        self.alpha.as_ref().map_or(255, |alpha| alpha[pixel])
    }
}

impl Channels {
    fn number(&self, index: usize) -> f64 {
        match self {
            Self::Bytes(bytes) => f64::from(bytes[index]) / 255.0,
            Self::Numbers(numbers) => f64::from(numbers[index]),
        }
    }
}

/// Compares two picture files, and writes a picture of their differences with `-diff`. A `.pfm` or `.exr` is compared as
/// numbers.
///
/// # Errors
/// [`Error::File`] when a picture cannot be read or the sizes differ.
pub fn compare_files(options: &CompareOptions) -> Result<Comparison, Error> {
    if let Some(path) = options.diff.as_deref() {
        output::check([path].into_iter())?;
        output::check_inputs([path].into_iter(), [options.a.as_path(), &options.b])?;
    }
    let (a, b) = (Picture::read(&options.a)?, Picture::read(&options.b)?);
    if a.size != b.size {
        let size = |picture: &Picture| format!("{} x {}", picture.size.0, picture.size.1);
        return Err(Error::file(&options.b, format!("is {} pixels, the other picture {}", size(&b), size(&a))));
    }
    let differences = a.differences(&b);
    if let Some(path) = &options.diff {
        // Sixteen times as bright.
        let picture: Vec<u8> = differences.clone().map(|levels| (16.0 * levels) as u8).collect();
        write_png(path, a.size.0, a.size.1, &picture)?;
    }
    let mut comparison = Comparison::of(differences);
    if a.alpha.is_some() || b.alpha.is_some() {
        let pixels = 0..comparison.pixels as usize;
        comparison.alpha = pixels.filter(|&pixel| a.alpha_of(pixel) != b.alpha_of(pixel)).count() as u64;
    }
    Ok(comparison)
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
        assert_eq!(Comparison::new(&a, &a).psnr(), f64::INFINITY);
    }
}
