//! `-cost`: what each pixel of the colour picture costs. Rays, boxes and triangles are counted as one ray after the other
//! is traced, which is what `-plain` does. The usual renderer shares much of this work between rays.
//!
//! Every query is made twice: once by [`trace_ray`], and once more by the same code with a counter.

mod picture;

use crate::objects::{Hit, Ray};
use crate::options::Options;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::render::RayMaker;
use crate::scene::{Geometry, Scene, TestCounts};
use crate::timing::Deadline;
use crate::trace::{LightTerm, Observer, RayKind, Shadow, Surface, trace_ray};
use rayon::prelude::*;
use std::cell::RefCell;
use vecmath::Vector3;

/// What the pixels of a picture cost.
#[derive(Debug)]
pub struct Cost {
    pub width: u32,
    pub height: u32,
    /// For each pixel rays, boxes and triangles, rows from the top.
    pub pixels: Vec<[u32; 3]>,
    pub rays: RayCounts,
    pub tests: TestCounts,
}

/// What is counted for each pixel.
pub const COUNTED: [&str; 3] = ["rays", "boxes", "triangles"];

impl Cost {
    /// Traces the picture and counts.
    pub fn of(scene: &Scene, plan: &Plan, options: &Options) -> Self {
        let maker = RayMaker::new(options);
        let row_of = |row| cost_of_row(row, scene, plan, options, &maker);
        let rows: Vec<_> = (0..options.height).into_par_iter().map(row_of).collect();
        let mut cost = Self {
            width: options.width,
            height: options.height,
            pixels: Vec::with_capacity(options.width as usize * options.height as usize),
            rays: RayCounts::default(),
            tests: TestCounts::default(),
        };
        for (pixels, rays, tests) in rows {
            cost.pixels.extend(pixels);
            cost.rays += rays;
            cost.tests += tests;
        }
        cost
    }

    /// Returns the mean and the largest count of a pixel, in the order of [`COUNTED`].
    pub fn mean_and_most(&self) -> [(f64, u32); 3] {
        [0, 1, 2].map(|kind| self.mean_and_most_of(kind))
    }

    fn mean_and_most_of(&self, kind: usize) -> (f64, u32) {
        let counts = || self.pixels.iter().map(|pixel| pixel[kind]);
        let sum: u64 = counts().map(u64::from).sum();
        (sum as f64 / self.pixels.len().max(1) as f64, counts().max().unwrap_or(0))
    }
}

fn cost_of_row(
    row: u32,
    scene: &Scene,
    plan: &Plan,
    options: &Options,
    maker: &RayMaker,
) -> (Vec<[u32; 3]>, RayCounts, TestCounts) {
    let mut counter = Counter { geometry: &scene.geometry, rays: RayCounts::default(), tests: RefCell::default() };
    let (mut places, mut before) = (Vec::new(), [0; 3]);
    let pixels = (0..options.width).map(|x| {
        maker.set_places(&[(x, row)], &mut places);
        for &place in &places {
            trace_ray(scene, plan, scene.camera.ray(maker.grid.ndc(place)), Deadline::NEVER, &mut counter);
        }
        let after = counter.totals();
        let added = [0, 1, 2].map(|kind| u32::try_from(after[kind] - before[kind]).unwrap_or(u32::MAX));
        before = after;
        added
    });
    let pixels = pixels.collect();
    (pixels, counter.rays, counter.tests.into_inner())
}

/// Counts rays, and what their queries test.
struct Counter<'a> {
    geometry: &'a Geometry,
    rays: RayCounts,
    tests: RefCell<TestCounts>,
}

impl Counter<'_> {
    /// Returns the counts in the order of [`COUNTED`].
    fn totals(&self) -> [u64; 3] {
        let tests = self.tests.borrow();
        [self.rays.total(), tests.boxes, tests.triangles]
    }
}

impl Observer for Counter<'_> {
    fn ray(&mut self, kind: RayKind, ray: &Ray, throughput: Vector3, hit: Option<&Hit>) {
        self.rays.ray(kind, ray, throughput, hit);
        self.geometry.count_closest_hit(ray, &self.tests);
    }

    fn light(&mut self, surface: &Surface, term: &LightTerm) {
        self.rays.light(surface, term);
        if let Shadow::Traced { ray, t_max, .. } = &term.shadow {
            self.geometry.count_any_hit(ray, *t_max, &self.tests);
        }
    }
}
