//! [`Preview`]: a coarse picture for pixels that get no sample before the time limit.

use super::pixel::Pixel;
use super::rays::{RayMaker, SetPart};
use super::samples::SamplePattern;
use super::tracer::{Tracer, tracer};
use super::unseen::Unseen;
use crate::options::{Options, SamplerKind};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::timing::Deadline;
use rayon::prelude::*;

/// Largest number of mirrors that the preview follows: between two mirrors, paths of 100,000 would take seconds.
pub const MIRRORS: u32 = 16;

/// One traced pixel for each square of pixels.
pub struct Preview {
    /// Side of a square in pixels.
    step: u32,
    rows: Vec<Vec<Pixel>>,
    pub counts: RayCounts,
}

impl Preview {
    /// Takes one sample of sample set number `set` in each square of pixels.
    pub fn render(scene: &Scene, plan: &Plan, options: &Options, maker: &RayMaker, set: u32) -> Self {
        // There must be a preview even if the time is over.
        let plan = Plan { bounces: plan.bounces.min(MIRRORS), ..plan.clone() };
        let step = step(options.width, options.height);
        let columns = options.width.div_ceil(step);
        let pattern = SamplePattern::new(SamplerKind::Independent, 1);
        let middle = |start: u32, end: u32| (start + step / 2).min(end - 1);
        let row = |tracer: &mut Box<dyn Tracer>, row: u32| {
            let part = |column| {
                let pixel = (middle(column * step, options.width), middle(row * step, options.height));
                SetPart { pixel, pattern, set, first: 0, count: 1 }
            };
            let (mut places, mut seen) = (Vec::new(), Vec::new());
            maker.set_places_of(&(0..columns).map(part).collect::<Vec<_>>(), &mut places);
            let is_whole = tracer.trace(maker.grid, &places, &mut seen);
            debug_assert!(is_whole, "there is no deadline");
            let pixels: Vec<Pixel> = seen.iter().map(|seen| maker.displayed(seen).sanitized()).collect();
            (pixels, tracer.take_counts())
        };
        let rows = (0..options.height.div_ceil(step)).into_par_iter();
        let rows: Vec<_> = rows.map_init(|| tracer(scene, &plan, Deadline::NEVER), row).collect();
        let mut counts = RayCounts::default();
        rows.iter().for_each(|row| counts += row.1);
        Self { step, rows: rows.into_iter().map(|row| row.0).collect(), counts }
    }

    /// Returns the root mean square error of the squares' pixels in levels, by the differences between neighbouring
    /// squares. At edges the mean squared difference grows with the distance, and pixels lie on average 0.38 sides
    /// from the one that was traced in their square. What no sample has met is expected to add something.
    pub fn error(&self) -> f64 {
        const DISTANCE: f64 = 0.38;
        let beside = self.rows.iter().flat_map(|row| row.windows(2).map(|pair| (&pair[0], &pair[1])));
        let below = self.rows.windows(2).flat_map(|rows| rows[0].iter().zip(&rows[1]));
        let squares = beside.chain(below).map(|(a, b)| a.squared_levels(b));
        let (sum, count) = squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
        let squares = self.rows.iter().map(Vec::len).sum::<usize>() as u64;
        let unseen = Unseen { samples: 1, pixels: squares }.expected();
        (DISTANCE * sum / f64::from(count.max(1)) + unseen).sqrt()
    }

    /// Returns the traced pixel of the square that a pixel lies in.
    pub fn pixel(&self, (x, row): (u32, u32)) -> Pixel {
        self.rows[(row / self.step) as usize][(x / self.step) as usize]
    }
}

/// Returns the side of the squares: so large that the preview takes almost no time, whatever the picture's size.
fn step(width: u32, height: u32) -> u32 {
    const MOST_PIXELS: u64 = 4096;
    let pixels = u64::from(width) * u64::from(height);
    (pixels.div_ceil(MOST_PIXELS).isqrt() as u32 + 1).max(4)
}
