//! [`Tracer`]: traces the samples of pixels, in packets or, with `-plain`, one by one.

use crate::camera::{PixelGrid, Place};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::simd::{Simd, with_simd};
use crate::timing::Deadline;
use crate::trace::{Seen, trace_ray};
use crate::wide::PacketTracer;

/// Traces what the camera sees. Each thread has its own tracer.
pub trait Tracer {
    /// Replaces `seen` by what the camera sees through each place. It is fastest if places lie side by side. Returns
    /// false if the deadline came first: then `seen` is incomplete, and of no use.
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) -> bool;

    /// Returns the counts of rays traced since the last call.
    fn take_counts(&mut self) -> RayCounts;
}

/// Makes the tracer of a plan. It stops at the deadline, even in the middle of a path. The instruction set is chosen
/// here, once.
pub fn tracer<'a>(scene: &'a Scene, plan: &'a Plan, deadline: Deadline) -> Box<dyn Tracer + 'a> {
    if plan.plain {
        return Box::new(PlainTracer { scene, plan, deadline, counts: RayCounts::default() });
    }
    with_simd!(plan.simd, simd => Box::new(PacketTracer::new(simd, scene, plan, deadline)))
}

/// Traces by the definition.
struct PlainTracer<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    deadline: Deadline,
    counts: RayCounts,
}

impl Tracer for PlainTracer<'_> {
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) -> bool {
        seen.clear();
        let rays = places.iter().map(|&place| self.scene.camera.ray(grid.ndc(place)));
        seen.extend(rays.map_while(|ray| trace_ray(self.scene, self.plan, ray, self.deadline, &mut self.counts)));
        seen.len() == places.len()
    }

    fn take_counts(&mut self) -> RayCounts {
        std::mem::take(&mut self.counts)
    }
}

impl<S: Simd> Tracer for PacketTracer<'_, S> {
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) -> bool {
        Self::trace(self, grid, places, seen)
    }

    fn take_counts(&mut self) -> RayCounts {
        std::mem::take(&mut self.counts)
    }
}
