//! [`TrueError`]: the error of a picture against a reference picture that counts as true.
//!
//! If the reference is of numbers (PFM, EXR), the picture's colours are compared before truncation. In *levels*, both
//! are clamped to \[0, 1\] and multiplied by 255. If the reference is of bytes (PNG), the picture's bytes are
//! compared, because the reference has lost its fractions.

use super::compare::read_rgb;
use super::ssim::ssim;
use crate::error::Error;
use crate::film::{Film, NumberPicture, read_numbers, to_byte};
use crate::options::{Options, has_extension};
use std::fmt;
use std::path::Path;
use vecmath::Real;

/// Added to the squared reference in the relative error, so that dark pixels do not dominate.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// The picture that counts as true.
#[derive(Debug)]
pub struct Reference {
    picture: NumberPicture,
    is_bytes: bool,
}

/// Differences from the [`Reference`], over all pixels and channels.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueError {
    pub rmse_levels: f64,
    /// Of colours as traced; of bytes/255 against a reference of bytes.
    pub rmse_linear: f64,
    /// Mean of (x - r)^2 / (r^2 + epsilon), of the same colours.
    pub relative_mse: f64,
    pub worst_levels: f64,
    /// Column and row of the pixel with the worst channel.
    pub worst_pixel: (u32, u32),
    /// Share of pixels with a channel that is wrong by more than one level.
    pub share_over_one_level: f64,
    /// Structural similarity of the bytes of both pictures (see [`ssim`](super::ssim)): 1 for equal pictures.
    pub ssim: f64,
}

impl Reference {
    /// Reads the reference of `options`, if there is one.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn wanted_by(options: &Options) -> Result<Option<Self>, Error> {
        let path = options.measure.reference.as_ref();
        path.map(|path| Self::read(path, options.width, options.height)).transpose()
    }

    /// Reads a reference for a picture of this size.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read or has another size.
    fn read(path: &Path, width: u32, height: u32) -> Result<Self, Error> {
        let is_bytes = has_extension(path, "png");
        let picture = if is_bytes {
            let picture = read_rgb(path)?;
            let numbers = picture.iter().map(|&byte| f32::from(byte) / 255.0).collect();
            NumberPicture { width: picture.width(), height: picture.height(), numbers }
        } else {
            read_numbers(path)?
        };
        if (picture.width, picture.height) != (width, height) {
            let sizes =
                format!("is {} x {} pixels, the picture {width} x {height}", picture.width, picture.height);
            return Err(Error::file(path, sizes));
        }
        Ok(Self { picture, is_bytes })
    }

    /// Returns the error of a film's colours; `None` if the film has no plane of linear colours.
    pub fn error_of(&self, film: &Film) -> Option<TrueError> {
        let (bytes, linear) = (film.color.as_ref()?, film.linear.as_ref()?);
        let from_bytes: Vec<f32>;
        let numbers = if self.is_bytes {
            from_bytes = bytes.iter().map(|&byte| f32::from(byte) / 255.0).collect();
            &from_bytes
        } else {
            linear
        };
        Some(TrueError {
            ssim: ssim(&self.bytes(), bytes, self.picture.width as usize),
            ..self.differences(numbers)
        })
    }

    fn differences(&self, numbers: &[f32]) -> TrueError {
        let (mut levels_squared, mut linear_squared, mut relative) = (0.0, 0.0, 0.0);
        let (mut worst, mut worst_index, mut over) = (0.0, 0, 0_u64);
        for (index, (x, r)) in numbers.chunks_exact(3).zip(self.picture.numbers.chunks_exact(3)).enumerate() {
            let mut worst_here: f64 = 0.0;
            for (&x, &r) in x.iter().zip(r) {
                let (x, r) = (f64::from(x), f64::from(r));
                let levels = 255.0 * (shown(x) - shown(r));
                levels_squared += levels * levels;
                linear_squared += (x - r).powi(2);
                relative += (x - r).powi(2) / (r * r + RELATIVE_EPSILON);
                worst_here = worst_here.max(levels.abs());
            }
            // A difference of one level must not count as more because 1/255 is rounded.
            over += u64::from(worst_here > 1.0 + 1e-4);
            if worst_here > worst {
                (worst, worst_index) = (worst_here, index as u32);
            }
        }
        let pixels = numbers.len() as f64 / 3.0;
        let values = numbers.len() as f64;
        TrueError {
            rmse_levels: (levels_squared / values).sqrt(),
            rmse_linear: (linear_squared / values).sqrt(),
            relative_mse: relative / values,
            worst_levels: worst,
            worst_pixel: (worst_index % self.picture.width, worst_index / self.picture.width),
            share_over_one_level: over as f64 / pixels,
            ssim: 0.0,
        }
    }

    /// Returns the reference as bytes.
    fn bytes(&self) -> Vec<u8> {
        let numbers = self.picture.numbers.iter();
        if self.is_bytes {
            numbers.map(|&number| (number * 255.0).round() as u8).collect()
        } else {
            numbers.map(|&number| to_byte(Real::from(number))).collect()
        }
    }
}

/// Returns a value as a picture shows it: clamped, and 0 for NaN.
fn shown(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

impl TrueError {
    /// Returns the peak signal-to-noise ratio in decibels; infinite for equal pictures.
    pub fn psnr(&self) -> f64 {
        20.0 * (255.0 / self.rmse_levels).log10()
    }
}

impl fmt::Display for TrueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (x, row) = self.worst_pixel;
        writeln!(f, "true error   RMSE {:.4} levels (linear {:.3e})", self.rmse_levels, self.rmse_linear)?;
        writeln!(f, "             relMSE {:.3e} (epsilon {RELATIVE_EPSILON})", self.relative_mse)?;
        writeln!(f, "             PSNR {:.2} dB, SSIM {:.6}", self.psnr(), self.ssim)?;
        writeln!(f, "             worst {:.2} levels at column {x}, row {row}", self.worst_levels)?;
        writeln!(f, "             over 1 level: {:.4}% of the pixels", 100.0 * self.share_over_one_level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(numbers: &[f32]) -> Film {
        Film {
            width: 2,
            height: 1,
            color: Some(numbers.iter().map(|&number| to_byte(Real::from(number))).collect()),
            depth: None,
            normals: None,
            linear: Some(numbers.to_vec()),
            variances: None,
        }
    }

    fn reference(numbers: &[f32], is_bytes: bool) -> Reference {
        Reference { picture: NumberPicture { width: 2, height: 1, numbers: numbers.to_vec() }, is_bytes }
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let numbers = [0.1, 0.5, 1.5, 0.0, -1.0, 0.9];
        let error = reference(&numbers, false).error_of(&film(&numbers)).unwrap();
        assert_eq!((error.rmse_levels, error.rmse_linear, error.relative_mse, error.ssim), (0.0, 0.0, 0.0, 1.0));
        assert_eq!((error.psnr(), error.share_over_one_level), (f64::INFINITY, 0.0));
    }

    #[test]
    fn levels_are_clamped_and_linear_values_are_not() {
        let error =
            reference(&[2.0, 0.0, 0.0, 0.5, 0.5, 0.5], false).error_of(&film(&[1.0, 0.0, 0.0, 0.5, 0.5, 0.7]));
        let error = error.unwrap();
        assert!((error.rmse_levels - 255.0 * 0.2 / 6.0_f64.sqrt()).abs() < 1e-4, "{error:?}");
        assert!((error.rmse_linear - (1.04 / 6.0_f64).sqrt()).abs() < 1e-6);
        assert_eq!((error.worst_pixel, error.share_over_one_level), ((1, 0), 0.5));
        assert!((error.worst_levels - 51.0).abs() < 1e-4);
        assert!((error.relative_mse - (1.0 / 4.01 + 0.04 / 0.26) / 6.0).abs() < 1e-6);
        assert!(error.ssim < 1.0);
    }

    #[test]
    fn bytes_are_compared_with_bytes() {
        let stored = [10, 20, 30, 40, 50, 60].map(|byte| byte as f32 / 255.0);
        let numbers = stored.map(|number| number + 0.7 / 255.0);
        assert_eq!(reference(&stored, true).error_of(&film(&numbers)).unwrap().rmse_levels, 0.0);
    }
}
