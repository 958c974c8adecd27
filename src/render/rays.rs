//! [`RayMaker`]: makes the rays of a pixel, and pixels of what rays see.

use super::pixel::Pixel;
use super::samples::{SamplePattern, SampleSet};
use crate::camera::{PixelGrid, Place};
use crate::options::Options;
use crate::trace::Seen;
use vecmath::Real;

/// Makes the rays of pixels.
pub struct RayMaker {
    /// The grid that is traced: three times as fine with `-filter`.
    pub grid: PixelGrid,
    is_filtered: bool,
    /// `None` without a picture of depths.
    depth_range: Option<(Real, Real)>,
    shows_normals: bool,
    /// For each pixel of the traced grid. `None`: one sample in the corner of the pixel.
    pattern: Option<SamplePattern>,
    samples: u32,
    seed: u64,
}

impl RayMaker {
    pub fn new(args: &Options) -> Self {
        let finer = if args.filter { 3 } else { 1 };
        let samples = args.samples();
        Self {
            grid: PixelGrid { width: finer * args.width, height: finer * args.height },
            is_filtered: args.filter,
            depth_range: args.depth.as_ref().map(|depth| (depth.min as Real, depth.max as Real)),
            shows_normals: args.normals.is_some(),
            pattern: args.jitter.then(|| SamplePattern::new(args.measure.sampler, samples)),
            samples,
            seed: args.seed,
        }
    }

    /// Adds the places of the samples of a pixel of the traced grid.
    pub fn add_places(&self, pixel: (u32, u32), places: &mut Vec<Place>) {
        let Some(pattern) = &self.pattern else {
            return places.push(self.grid.place(pixel, (0.0, 0.0)));
        };
        let set = pattern.set(pixel, 0, self.seed);
        set.for_each_offset(self.samples, |offset| places.push(self.grid.place(pixel, offset)));
    }

    /// Returns the place of the top left corner of a pixel of the picture. One beyond the last pixel of a row or a
    /// column it is the corner on the other side.
    pub fn corner(&self, (x, row): (u32, u32)) -> Place {
        let finer = if self.is_filtered { 3 } else { 1 };
        ((finer * x) as Real, (self.grid.height - finer * row) as Real)
    }

    /// Returns the place of a sample of a pixel of the picture. With `-filter` such a pixel is a block of the traced
    /// grid. A sample falls into a pixel of the block with a probability equal to the filter's weight there. So the
    /// mean of any number of samples is an estimate of the filtered block.
    pub fn place_of_sample(&self, (x, row): (u32, u32), set: &SampleSet, sample: u32) -> Place {
        let offset = set.offset(sample);
        if !self.is_filtered {
            return self.grid.place((x, row), offset);
        }
        let ((column, offset_x), (line, offset_y)) = (weighted_third(offset.0), weighted_third(offset.1));
        self.grid.place((3 * x + column, 3 * row + line), (offset_x, offset_y))
    }

    /// Returns the pixel that shows what a ray saw.
    pub fn displayed(&self, seen: &Seen) -> Pixel {
        let mut pixel = Pixel::default();
        self.display(seen, &mut pixel);
        pixel
    }

    /// Does the same in place; `pixel` must be the default pixel.
    #[inline]
    pub fn display(&self, seen: &Seen, pixel: &mut Pixel) {
        pixel.show(seen, self.depth_range, self.shows_normals);
    }
}

/// Divides the interval from 0 to 1 in the ratio 1 : 2 : 1, and returns the part in which a place lies and the place
/// in that part.
fn weighted_third(place: Real) -> (u32, Real) {
    if place < 0.25 {
        (0, 4.0 * place)
    } else if place < 0.75 {
        (1, 2.0 * place - 0.5)
    } else {
        (2, 4.0 * place - 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_fall_into_thirds_by_their_weights() {
        let mut counts = [0; 3];
        for step in 0..400 {
            let (third, place) = weighted_third((step as Real + 0.5) / 400.0);
            assert!((0.0..1.0).contains(&place));
            counts[third as usize] += 1;
        }
        assert_eq!(counts, [100, 200, 100]);
    }
}
