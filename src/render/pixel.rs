//! [`Pixel`]: the displayed values of what a ray saw, and their mean.

use crate::film::Columns;
use crate::trace::Seen;
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
    /// Sets the pixel to what a ray saw. Depth and normal are not changed if no picture shows them.
    #[inline]
    pub fn show(&mut self, seen: &Seen, depth_range: Option<DepthRange>, shows_normals: bool) {
        self.color = seen.color;
        if let Some(range) = depth_range {
            self.depth = range.shown(seen.depth);
        }
        if shows_normals {
            self.normal = shown_normal(seen.normal);
        }
    }

    /// Returns the pixel with finite colours, so that it can be averaged: NaN becomes 0, infinity the largest `f32`.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        self.color = finite(self.color);
        self
    }

    /// Returns the squared difference of the displayed colours in squared levels, averaged over the channels.
    pub fn squared_levels(&self, other: &Self) -> f64 {
        let shown = |pixel: &Self| pixel.color.map(|c| c.clamp(0.0, 1.0));
        let difference = shown(self) - shown(other);
        255.0 * 255.0 * difference.to_array().iter().map(|&d| (d as f64).powi(2)).sum::<f64>() / 3.0
    }

    fn add(&mut self, other: &Self, weight: Real) {
        self.color += other.color * weight;
        self.depth += other.depth * weight;
        self.normal += other.normal * weight;
    }
}

/// The distances that a picture of depths shows as black and as white.
#[derive(Clone, Copy, Debug)]
pub struct DepthRange {
    min: Real,
    max: Real,
    /// 1, or less where the difference of both ends would overflow: it is in both ends already.
    scale: Real,
}

impl DepthRange {
    pub fn new(min: Real, max: Real) -> Self {
        let scale = if (max - min).is_finite() { 1.0 } else { 0.5 };
        Self { min: min * scale, max: max * scale, scale }
    }

    /// Maps a depth to what a picture with this range shows: an empty range gives 0.
    #[inline]
    pub fn shown(&self, depth: Option<Real>) -> Real {
        let depth = depth.map_or(0.0, |t| (t * self.scale - self.min) / (self.max - self.min));
        if self.min == self.max { 0.0 } else { clamped(depth) }
    }
}

/// Maps a normal to what a picture shows.
#[inline]
pub fn shown_normal(normal: Vector3) -> Vector3 {
    ((normal + Vector3::splat(1.0)) * 0.5).map(clamped)
}

fn clamped(value: Real) -> Real {
    if value >= 0.0 { value.min(1.0) } else { 0.0 }
}

/// Returns a colour with NaN as 0, and infinity as the largest `f32`.
#[inline]
pub fn finite(color: Vector3) -> Vector3 {
    const LARGEST: Real = f32::MAX as Real;
    // Nearly all are.
    if color.x.abs() <= LARGEST && color.y.abs() <= LARGEST && color.z.abs() <= LARGEST {
        return color;
    }
    color.map(|c| if c.is_nan() { 0.0 } else { c.clamp(-LARGEST, LARGEST) })
}

/// Returns the Gaussian weight of a pixel of a 3 x 3 block: (1 2 1; 2 4 2; 1 2 1)/16.
pub fn filter_weight(index: usize) -> Real {
    const WEIGHTS: [Real; 9] = [1.0, 2.0, 1.0, 2.0, 4.0, 2.0, 1.0, 2.0, 1.0];
    WEIGHTS[index] / 16.0
}

/// Filters a 3 x 3 block of pixels.
pub fn filtered(block: impl Iterator<Item = Pixel>) -> Pixel {
    let mut mean = Pixel::default();
    block.enumerate().for_each(|(index, pixel)| mean.add(&pixel, filter_weight(index)));
    mean
}

/// Stores pixels, row by row.
pub fn store(pixels: &[Pixel], film: &mut Columns) {
    film.set_colors(pixels, |pixel| pixel.color);
    film.set_normals(pixels, |pixel| pixel.normal);
    film.set_depths(pixels, |pixel| pixel.depth);
}

/// Stores the same pixel everywhere.
pub fn fill(pixel: &Pixel, film: &mut Columns) {
    film.fill(pixel.color, pixel.normal, pixel.depth);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth_of(t: Option<Real>, (min, max): (Real, Real)) -> Real {
        let mut pixel = Pixel::default();
        pixel.show(&Seen { depth: t, ..Seen::default() }, Some(DepthRange::new(min, max)), false);
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
        let end = Real::MAX;
        assert_eq!(depth_of(Some(9.0), (-end, end)), 0.5);
        assert_eq!(depth_of(Some(9.0), (end, -end)), 0.5);
        assert_eq!(depth_of(None, (-end, end)), 0.0);
        assert_eq!(depth_of(Some(end / 2.0), (-end, end)), 0.75);
    }

    #[test]
    fn the_filter_weights_sum_to_one_and_are_largest_in_the_middle() {
        let mut block = [Pixel::default(); 9];
        block[4].color = Vector3::splat(1.0);
        assert_eq!(filtered(block.into_iter()).color, Vector3::splat(0.25));
        let flat = [Pixel { depth: 0.5, ..Pixel::default() }; 9];
        assert_eq!(filtered(flat.into_iter()).depth, 0.5);
    }

    #[test]
    fn nan_and_infinity_become_finite_before_averaging() {
        let pixel = Pixel { color: Vector3::new(Real::NAN, Real::INFINITY, -1.0), ..Pixel::default() };
        let largest = f32::MAX as Real;
        assert_eq!(pixel.sanitized().color, Vector3::new(0.0, largest, -1.0));
    }
}
