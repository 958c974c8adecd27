//! [`RayMaker`]: makes the rays of a pixel, and pixels of what rays see.

use super::pixel::{DepthRange, Pixel, filtered, finite, shown_normal};
use super::samples::SamplePattern;
use crate::camera::{PixelGrid, Place};
use crate::options::{Options, SamplerKind};
use crate::simd::{InstructionSet, Simd, vectorize, with_simd};
use crate::trace::Seen;
use vecmath::{Real, Vector3};

/// Makes the rays of pixels.
pub struct RayMaker {
    /// The grid that is traced: three times as fine with `-filter`.
    pub grid: PixelGrid,
    /// Pixels of that grid along the side of a pixel of the picture.
    finer: u32,
    /// `None` without a picture of depths.
    depth_range: Option<DepthRange>,
    shows_normals: bool,
    /// For each pixel of the traced grid. `None`: one sample in the corner of the pixel.
    pattern: Option<SamplePattern>,
    samples: u32,
    seed: u64,
    simd: InstructionSet,
}

/// Some samples of a set.
pub struct SetPart {
    /// Of the picture.
    pub pixel: (u32, u32),
    pub pattern: SamplePattern,
    /// Number of the set.
    pub set: u32,
    /// Number of the first sample.
    pub first: u32,
    pub count: u32,
}

impl RayMaker {
    pub fn new(args: &Options) -> Self {
        let finer = if args.filter { 3 } else { 1 };
        let samples = args.samples();
        Self {
            grid: PixelGrid { width: finer * args.width, height: finer * args.height },
            finer,
            depth_range: args.depth.as_ref().map(|depth| DepthRange::new(depth.min as Real, depth.max as Real)),
            shows_normals: args.normals.is_some(),
            pattern: args.jitter.then(|| SamplePattern::new(args.measure.sampler, samples)),
            samples,
            seed: args.seed,
            simd: args.simd,
        }
    }

    /// Replaces `places` by those of the samples of pixels of the picture: for each pixel of the traced grid its set.
    pub fn set_places(&self, pixels: &[(u32, u32)], places: &mut Vec<Place>) {
        let Some(pattern) = &self.pattern else {
            places.clear();
            let corner = |pixel| self.grid.place(pixel, (0.0, 0.0));
            return match self.finer {
                1 => places.extend(pixels.iter().copied().map(corner)),
                _ => self.for_each_grid_pixel(pixels, |pixel| places.push(corner(pixel))),
            };
        };
        let mut listed = Vec::new();
        let pixels = match self.finer {
            1 => pixels,
            _ => {
                self.for_each_grid_pixel(pixels, |pixel| listed.push(pixel));
                &listed
            }
        };
        let (samples, grid, seed) = (self.samples, self.grid, self.seed);
        places.resize(pixels.len() * samples as usize, (0.0, 0.0));
        let places = places.as_mut_slice();
        // One call for all pixels, because a call costs some 80 instructions.
        with_simd!(self.simd, simd => vectorize!(simd, {
            pattern.write_sets(pixels, samples, seed, places);
            for (&pixel, places) in pixels.iter().zip(places.chunks_exact_mut(samples as usize)) {
                for place in places {
                    *place = grid.place(pixel, *place);
                }
            }
        }));
    }

    /// Replaces `places` by those of the first two Sobol samples of pixels of the picture.
    pub fn set_pairs(&self, pixels: &[(u32, u32)], places: &mut Vec<Place>) {
        let pattern = SamplePattern::new(SamplerKind::Sobol, 2);
        places.resize(2 * pixels.len(), (0.0, 0.0));
        let places = places.as_mut_slice();
        with_simd!(self.simd, simd => vectorize!(simd, {
            pattern.write_sets(pixels, 2, self.seed, places);
            let pairs = pixels.iter().zip(places.as_chunks_mut::<2>().0);
            // One branch for all, because loops without them are several places an instruction.
            if self.finer == 1 {
                let grid = self.grid;
                pairs.for_each(|(&pixel, pair)| *pair = pair.map(|place| grid.place(pixel, place)));
            } else {
                pairs.for_each(|(&pixel, pair)| *pair = pair.map(|place| self.place_of_offset(pixel, place)));
            }
        }));
    }

    /// Replaces `places` by those of parts of sets: for each part the pixel of the picture, the pattern and number of the
    /// set, and its samples from which on and how many.
    pub fn set_places_of(&self, parts: &[SetPart], places: &mut Vec<Place>) {
        places.resize(parts.iter().map(|part| part.count as usize).sum(), (0.0, 0.0));
        let mut rest = places.as_mut_slice();
        with_simd!(self.simd, simd => vectorize!(simd, {
            for part in parts {
                let (places, later) = std::mem::take(&mut rest).split_at_mut(part.count as usize);
                part.pattern.set(part.pixel, part.set, self.seed).write_offsets(part.first, places);
                for place in places {
                    *place = self.place_of_offset(part.pixel, *place);
                }
                rest = later;
            }
        }));
    }

    /// Returns the place of the top left corner of a pixel of the picture. One beyond the last pixel of a row or a
    /// column it is the corner on the other side; further beyond it is outside the picture.
    pub fn corner(&self, (x, row): (u32, u32)) -> Place {
        ((self.finer * x) as Real, self.grid.height as Real - (self.finer * row) as Real)
    }

    /// Calls `f` with the pixels of the traced grid that pixels of the picture consist of.
    fn for_each_grid_pixel(&self, pixels: &[(u32, u32)], mut f: impl FnMut((u32, u32))) {
        let finer = self.finer;
        for &(x, row) in pixels {
            for line in 0..finer {
                for column in 0..finer {
                    f((finer * x + column, finer * row + line));
                }
            }
        }
    }

    /// Returns the place at an offset from a pixel of the picture. With `-filter` such a pixel is a block of the traced
    /// grid. A sample falls into a pixel of the block with a probability equal to the filter's weight there. So the
    /// mean of any number of samples is an estimate of the filtered block.
    #[inline(always)]
    fn place_of_offset(&self, (x, row): (u32, u32), offset: (Real, Real)) -> Place {
        if self.finer == 1 {
            return self.grid.place((x, row), offset);
        }
        let ((column, offset_x), (line, offset_y)) = (weighted_third(offset.0), weighted_third(offset.1));
        self.grid.place((3 * x + column, 3 * row + line), (offset_x, offset_y))
    }

    /// Returns what all rays of a pixel of the picture saw together: with `-jitter` the mean of the samples of each pixel
    /// of the traced grid, with `-filter` the filtered block of these.
    pub fn mean(&self, seen: &[Seen]) -> Pixel {
        let mut grid_pixels = seen.chunks(self.samples as usize).map(|seen| self.mean_of_samples(seen));
        if self.finer > 1 { filtered(grid_pixels) } else { grid_pixels.next().unwrap_or_default() }
    }

    /// Computes only what pictures show.
    fn mean_of_samples(&self, seen: &[Seen]) -> Pixel {
        let share = 1.0 / self.samples as Real;
        let mut mean = Pixel { color: mean_color(seen, share), ..Pixel::default() };
        if let Some(range) = self.depth_range {
            seen.iter().for_each(|seen| mean.depth += range.shown(seen.depth) * share);
        }
        if self.shows_normals {
            seen.iter().for_each(|seen| mean.normal += shown_normal(seen.normal) * share);
        }
        mean
    }

    /// Returns the pixel of the picture that shows what all its rays saw: their mean, or what the only one saw.
    pub fn shown(&self, seen: &[Seen]) -> Pixel {
        match (seen, &self.pattern) {
            ([seen], None) => self.displayed(seen),
            _ => self.mean(seen),
        }
    }

    /// Returns where in the picture a place of the traced grid lies: in pixels from the upper left corner.
    pub fn in_picture(&self, (x, y): Place) -> (Real, Real) {
        let side = self.finer as Real;
        (x / side, (self.grid.height as Real - y) / side)
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

/// Adds up colours times `share`, made [`finite`].
fn mean_color(seen: &[Seen], share: Real) -> Vector3 {
    let (mut sum, mut sizes) = (Vector3::ZERO, Vector3::ZERO);
    for Seen { color, .. } in seen {
        sum += *color * share;
        sizes += color.map(Real::abs);
    }
    // The usual case: all are finite as they are.
    if finite(sizes) == sizes {
        return sum;
    }
    seen.iter().fold(Vector3::ZERO, |sum, seen| sum + finite(seen.color) * share)
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
    fn corners_go_on_beyond_the_picture() {
        for finer in [1, 3] {
            let maker = RayMaker {
                grid: PixelGrid { width: 4 * finer, height: 2 * finer },
                finer,
                depth_range: None,
                shows_normals: false,
                pattern: None,
                samples: 1,
                seed: 0,
                simd: InstructionSet::baseline(),
            };
            let side = finer as Real;
            assert_eq!(maker.corner((0, 0)), (0.0, 2.0 * side));
            assert_eq!(maker.corner((4, 2)), (4.0 * side, 0.0));
            assert_eq!(maker.corner((5, 3)), (5.0 * side, -side));
        }
    }

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
