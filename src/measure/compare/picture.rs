//! [`Picture`]: a picture to compare, of bytes or of numbers, and its [`Differences`] from another one.

use crate::error::Error;
use crate::film::{NumberPicture, read_numbers, to_byte};
use crate::options::{format_of_numbers, has_extension};
use crate::picture_file::PictureFile;
use image::{DynamicImage, RgbImage};
use std::fs::Metadata;
use std::path::Path;
use vecmath::Real;

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

/// Estimates the memory for reading a picture, in bytes, by what its file claims. What cannot be looked at twice, or is no
/// picture, counts as nothing.
pub fn bytes_needed(path: &Path) -> u64 {
    let Some(file) = path.metadata().ok().filter(Metadata::is_file) else { return 0 };
    if has_extension(path, "pfm") {
        return 2 * file.len();
    }
    PictureFile::open(path).map_or(0, |picture| picture.decoded_bytes())
}

/// A picture to compare; rows from the top.
pub struct Picture {
    /// Width and height.
    pub size: (u32, u32),
    channels: Channels,
    /// None if it is 255 everywhere.
    alpha: Option<Vec<u8>>,
}

/// Three for each pixel.
enum Channels {
    Bytes(Vec<u8>),
    Numbers(Vec<f32>),
}

/// The differences of two pictures of the same size, in levels of 1/255.
pub struct Differences {
    /// For each pixel the difference of its worst channel: not clamped, rounded up, and 255 for all that is larger.
    pub levels: Vec<u8>,
    /// Sum of the squares over all channels of all pixels.
    pub squares: f64,
    /// Index of the first pixel with the largest difference; none if the pictures are equal.
    pub worst: Option<usize>,
}

impl Picture {
    /// Reads a picture: `.pfm` and `.exr` as numbers, otherwise as bytes.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        if format_of_numbers(path).is_some() {
            let NumberPicture { width, height, numbers } = read_numbers(path)?;
            return Ok(Self { size: (width, height), channels: Channels::Numbers(numbers), alpha: None });
        }
        let picture = decoded(path)?;
        let alpha =
            picture.color().has_alpha().then(|| picture.to_rgba8().pixels().map(|pixel| pixel[3]).collect());
        Ok(Self { alpha, ..Self::of_bytes(picture.into_rgb8()) })
    }

    pub fn of_bytes(picture: RgbImage) -> Self {
        Self { size: picture.dimensions(), channels: Channels::Bytes(picture.into_raw()), alpha: None }
    }

    /// Returns the differences from a picture of the same size.
    pub fn differences(&self, other: &Self) -> Differences {
        let pixels = self.size.0 as usize * self.size.1 as usize;
        let mut found = Differences { levels: Vec::with_capacity(pixels), squares: 0.0, worst: None };
        let mut largest = 0.0;
        for pixel in 0..pixels {
            let [r, g, b] = [0, 1, 2].map(|channel| self.difference(other, 3 * pixel + channel));
            found.squares += r * r + g * g + b * b;
            let here = r.max(g).max(b);
            found.levels.push(here.ceil() as u8);
            if here > largest {
                (largest, found.worst) = (here, Some(pixel));
            }
        }
        found
    }

    /// Returns the difference of a channel in levels.
    fn difference(&self, other: &Self, index: usize) -> f64 {
        if let (Channels::Bytes(a), Channels::Bytes(b)) = (&self.channels, &other.channels) {
            return f64::from(a[index].abs_diff(b[index]));
        }
        let (a, b) = (self.number(index), other.number(index));
        let levels = 255.0 * (a - b).abs();
        if a == b || (a.is_nan() && b.is_nan()) {
            0.0
        } else if levels.is_nan() {
            f64::INFINITY
        } else {
            levels
        }
    }

    /// Returns the number of pixels whose alpha differs.
    pub fn differing_alpha(&self, other: &Self) -> u64 {
        if self.alpha.is_none() && other.alpha.is_none() {
            return 0;
        }
        let at = |picture: &Self, pixel: usize| picture.alpha.as_ref().map_or(255, |alpha| alpha[pixel]);
        let pixels = self.size.0 as usize * self.size.1 as usize;
        (0..pixels).filter(|&pixel| at(self, pixel) != at(other, pixel)).count() as u64
    }

    pub fn is_of_numbers(&self) -> bool {
        matches!(self.channels, Channels::Numbers(_))
    }

    /// Returns the colour of a pixel as it is shown on a screen.
    pub fn bytes(&self, pixel: usize) -> [u8; 3] {
        [0, 1, 2].map(|channel| match &self.channels {
            Channels::Bytes(bytes) => bytes[3 * pixel + channel],
            Channels::Numbers(numbers) => to_byte(Real::from(numbers[3 * pixel + channel])),
        })
    }

    /// Returns the colour of a pixel as numbers: 1 for the byte 255.
    pub fn numbers(&self, pixel: usize) -> [f64; 3] {
        [0, 1, 2].map(|channel| self.number(3 * pixel + channel))
    }

    fn number(&self, index: usize) -> f64 {
        match &self.channels {
            Channels::Bytes(bytes) => f64::from(bytes[index]) / 255.0,
            Channels::Numbers(numbers) => f64::from(numbers[index]),
        }
    }
}
