//! [`Comparison`]: how much two pictures of bytes differ.

use crate::error::Error;
use crate::film::write_png;
use crate::options::CompareOptions;
use crate::output;
use crate::picture_file::PictureFile;
use image::RgbImage;
use std::fmt;
use std::path::Path;

/// The differences of two pictures of the same size. The difference of a pixel is that of its worst channel, in
/// levels from 0 to 255.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub pixels: u64,
    pub worst: u8,
    /// Root mean square over all channels of all pixels, in levels.
    pub rmse: f64,
    /// `histogram[d]` pixels differ by d levels.
    pub histogram: Box<[u64; 256]>,
}

impl Comparison {
    /// Compares two pictures of the same size.
    pub fn new(a: &RgbImage, b: &RgbImage) -> Self {
        let mut histogram = Box::new([0; 256]);
        let mut squares = 0;
        for (a, b) in a.pixels().zip(b.pixels()) {
            let differences = [0, 1, 2].map(|channel| a[channel].abs_diff(b[channel]));
            squares += differences.iter().map(|&d| u64::from(d).pow(2)).sum::<u64>();
            histogram[usize::from(differences.into_iter().max().unwrap_or(0))] += 1;
        }
        let pixels = u64::from(a.width()) * u64::from(a.height());
        let worst = (0..=255).rev().find(|&d| histogram[usize::from(d)] > 0).unwrap_or(0);
        Self { pixels, worst, rmse: (squares as f64 / (3 * pixels) as f64).sqrt(), histogram }
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
        Ok(())
    }
}

/// Reads a picture as 8 bit RGB.
///
/// # Errors
/// [`Error::File`] when it cannot be read.
pub fn read_rgb(path: &Path) -> Result<RgbImage, Error> {
    let picture = PictureFile::open(path).and_then(PictureFile::decode);
    Ok(picture.map_err(|message| Error::file(path, message))?.into_rgb8())
}

/// Compares two picture files, and writes a picture of their differences with `-diff`.
///
/// # Errors
/// [`Error::File`] when a picture cannot be read or the sizes differ.
pub fn compare_files(options: &CompareOptions) -> Result<Comparison, Error> {
    if let Some(path) = options.diff.as_deref() {
        output::check([path].into_iter())?;
        output::check_inputs([path].into_iter(), [options.a.as_path(), &options.b])?;
    }
    let (a, b) = (read_rgb(&options.a)?, read_rgb(&options.b)?);
    if a.dimensions() != b.dimensions() {
        let size = |picture: &RgbImage| format!("{} x {}", picture.width(), picture.height());
        return Err(Error::file(&options.b, format!("is {} pixels, the other picture {}", size(&b), size(&a))));
    }
    if let Some(path) = &options.diff {
        write_png(path, a.width(), a.height(), &difference_picture(&a, &b))?;
    }
    Ok(Comparison::new(&a, &b))
}

/// Returns the absolute differences, sixteen times as bright.
fn difference_picture(a: &RgbImage, b: &RgbImage) -> Vec<u8> {
    a.iter().zip(b.iter()).map(|(a, b)| a.abs_diff(*b).saturating_mul(16)).collect()
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
