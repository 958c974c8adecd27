//! What was seen, as numbers and as bytes.
//!
//! A [`Pixel`] holds displayed values: colour as it is, depth and normal already mapped to \[0, 1\]. A [`Film`] holds
//! the bytes of the pictures that are asked for, and no others.

mod encode;
mod numbers;
mod png;

pub use encode::{check_writable, write_png, write_whole};
pub use numbers::{NumberPicture, read_numbers, write_numbers};

use crate::plan::Plan;
use crate::render::trace::Seen;
use vecmath::{Real, Vector3};

/// The displayed values of a pixel or of a sample of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Not clamped.
    pub color: Vector3,
    /// 0 (nearest, or nothing seen) to 1.
    pub depth: Real,
    /// (n + 1)/2, each component from 0 to 1.
    pub normal: Vector3,
}

impl Pixel {
    /// Shows what a ray saw. Maps depths from `depth_range` to \[0, 1\]; a range without extent is black. Depth and normal
    /// stay as they are where no picture shows them.
    #[inline]
    pub fn show(&mut self, seen: &Seen, depth_range: Option<(Real, Real)>, shows_normals: bool) {
        let clamped = |value: Real| if value >= 0.0 { value.min(1.0) } else { 0.0 };
        self.color = seen.color;
        if let Some((min, max)) = depth_range {
            let depth = seen.depth.map_or(0.0, |t| (t - min) / (max - min));
            self.depth = if min == max { 0.0 } else { clamped(depth) };
        }
        if shows_normals {
            self.normal = ((seen.normal + Vector3::splat(1.0)) * 0.5).map(clamped);
        }
    }

    /// Ready to be averaged: a colour that is NaN counts as 0, an infinite one as the largest `f32`.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        const LARGEST: Real = f32::MAX as Real;
        self.color = self.color.map(|c| if c.is_nan() { 0.0 } else { c.clamp(-LARGEST, LARGEST) });
        self
    }
}

impl Pixel {
    fn add(&mut self, other: &Self, weight: Real) {
        self.color += other.color * weight;
        self.depth += other.depth * weight;
        self.normal += other.normal * weight;
    }
}

/// The mean of `count` pixels.
pub fn average(pixels: impl Iterator<Item = Pixel>, count: u32) -> Pixel {
    let mut mean = Pixel::default();
    pixels.for_each(|pixel| mean.add(&pixel, 1.0 / count as Real));
    mean
}

/// A 3 x 3 block of pixels, weighted (1 2 1; 2 4 2; 1 2 1)/16.
pub fn filtered(block: impl Iterator<Item = Pixel>) -> Pixel {
    const WEIGHTS: [Real; 9] = [1.0, 2.0, 1.0, 2.0, 4.0, 2.0, 1.0, 2.0, 1.0];
    let mut mean = Pixel::default();
    block.zip(WEIGHTS).for_each(|(pixel, weight)| mean.add(&pixel, weight / 16.0));
    mean
}

/// The bytes of the pictures that are asked for, rows from the top.
#[derive(Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Three bytes a pixel.
    pub color: Option<Vec<u8>>,
    /// One byte a pixel.
    pub depth: Option<Vec<u8>>,
    /// Three bytes a pixel.
    pub normals: Option<Vec<u8>>,
    /// Colours as traced, neither clamped nor rounded: three numbers a pixel.
    pub linear: Option<Vec<f32>>,
    /// Estimated standard errors of the colours: one byte a pixel, sixteen for a level.
    pub error_map: Option<Vec<u8>>,
}

/// Planes of a film that no scene needs and that are kept on demand.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExtraPlanes {
    pub linear: bool,
    pub error_map: bool,
}

impl Film {
    /// A black film for the pictures of `plan`.
    pub fn new(width: u32, height: u32, plan: &Plan, extra: ExtraPlanes) -> Self {
        let pixels = width as usize * height as usize;
        let plane = |wanted: bool, bytes: usize| wanted.then(|| vec![0; pixels * bytes]);
        Self {
            width,
            height,
            color: plane(plan.color, 3),
            depth: plane(plan.depth, 1),
            normals: plane(plan.normals, 3),
            linear: extra.linear.then(|| vec![0.0; 3 * pixels]),
            error_map: plane(extra.error_map, 1),
        }
    }

    /// Stores the standard errors, in levels, of the pixels of a rectangle.
    pub fn set_errors(&mut self, x: u32, row: u32, width: u32, levels: &[f64]) {
        let Some(plane) = &mut self.error_map else { return };
        for (line, levels) in levels.chunks_exact(width as usize).enumerate() {
            let start = (row as usize + line) * self.width as usize + x as usize;
            for (byte, levels) in plane[start..].iter_mut().zip(levels) {
                *byte = (16.0 * levels).round() as u8;
            }
        }
    }

    /// Stores the pixels of a rectangle `width` wide whose top left pixel is (`x`, `row`).
    pub fn set_tile(&mut self, x: u32, row: u32, width: u32, pixels: &[Pixel]) {
        for (line, pixels) in pixels.chunks_exact(width as usize).enumerate() {
            let start = (row as usize + line) * self.width as usize + x as usize;
            let places = start..start + pixels.len();
            if let Some(plane) = &mut self.color {
                set_colors(&mut plane[3 * places.start..3 * places.end], pixels, |pixel| pixel.color);
            }
            if let Some(plane) = &mut self.linear {
                for (numbers, pixel) in plane[3 * places.start..].chunks_exact_mut(3).zip(pixels) {
                    numbers.copy_from_slice(&pixel.color.to_array().map(|c| c as f32));
                }
            }
            if let Some(plane) = &mut self.normals {
                set_colors(&mut plane[3 * places.start..3 * places.end], pixels, |pixel| pixel.normal);
            }
            if let Some(plane) = &mut self.depth {
                for (byte, pixel) in plane[places].iter_mut().zip(pixels) {
                    *byte = to_byte(pixel.depth);
                }
            }
        }
    }
}

fn set_colors(bytes: &mut [u8], pixels: &[Pixel], color: impl Fn(&Pixel) -> Vector3) {
    for (bytes, pixel) in bytes.chunks_exact_mut(3).zip(pixels) {
        bytes.copy_from_slice(&color(pixel).to_array().map(to_byte));
    }
}

/// clamp(trunc(255 c), 0, 255); NaN is 0. No gamma.
pub fn to_byte(value: Real) -> u8 {
    // The cast truncates, saturates, and takes NaN to 0.
    (value * 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_truncated_and_saturate() {
        for (value, byte) in [
            (0.0, 0),
            (0.5, 127),
            (0.999, 254),
            (1.0, 255),
            (7.0, 255),
            (1e30, 255),
            (Real::INFINITY, 255),
            (-0.5, 0),
            (Real::NAN, 0),
        ] {
            assert_eq!(to_byte(value), byte, "{value}");
        }
    }

    fn depth_of(t: Option<Real>, range: (Real, Real)) -> Real {
        let mut pixel = Pixel::default();
        pixel.show(&Seen { depth: t, ..Seen::default() }, Some(range), false);
        pixel.depth
    }

    #[test]
    fn depths_map_to_their_range() {
        assert_eq!(depth_of(Some(9.0), (8.0, 12.0)), 0.25);
        assert_eq!(depth_of(Some(9.0), (12.0, 8.0)), 0.75);
        assert_eq!(depth_of(Some(20.0), (8.0, 12.0)), 1.0);
        assert_eq!(depth_of(Some(1.0), (8.0, 12.0)), 0.0);
        assert_eq!(depth_of(None, (8.0, 12.0)), 0.0);
        assert_eq!(depth_of(None, (12.0, 8.0)), 0.0);
        assert_eq!(depth_of(Some(9.0), (9.0, 9.0)), 0.0);
    }

    #[test]
    fn the_filter_weighs_the_middle_most() {
        let mut block = [Pixel::default(); 9];
        block[4].color = Vector3::splat(1.0);
        assert_eq!(filtered(block.into_iter()).color, Vector3::splat(0.25));
        let flat = [Pixel { depth: 0.5, ..Pixel::default() }; 9];
        assert_eq!(filtered(flat.into_iter()).depth, 0.5);
    }

    #[test]
    fn what_is_no_number_is_averaged_as_a_number() {
        let pixel = Pixel { color: Vector3::new(Real::NAN, Real::INFINITY, -1.0), ..Pixel::default() };
        let largest = f32::MAX as Real;
        assert_eq!(pixel.sanitized().color, Vector3::new(0.0, largest, -1.0));
    }
}
