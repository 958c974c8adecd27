//! [`Tracer`]: traces the samples of pixels, in packets or, with `-plain`, one by one.

use crate::camera::{PixelGrid, Place};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use crate::simd::{Simd, with_simd};
use crate::trace::{Seen, trace_ray};
use crate::wide::PacketTracer;

/// Traces what the camera sees. Each thread has its own tracer.
pub trait Tracer {
    /// Replaces `seen` by what the camera sees through each place. It is fastest if places lie side by side.
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>);

    /// Returns the counts of rays traced since the last call.
    fn take_counts(&mut self) -> RayCounts;
}

/// Makes the tracer of a plan. The instruction set is chosen here, once.
pub fn tracer<'a>(scene: &'a Scene, plan: &'a Plan) -> Box<dyn Tracer + 'a> {
    if plan.plain {
        return Box::new(PlainTracer { scene, plan, counts: RayCounts::default() });
    }
    with_simd!(plan.simd, simd => Box::new(PacketTracer::new(simd, scene, plan)))
}

/// Traces by the definition.
struct PlainTracer<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    counts: RayCounts,
}

impl Tracer for PlainTracer<'_> {
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) {
        seen.clear();
        let rays = places.iter().map(|&place| self.scene.camera.ray(grid.ndc(place)));
        seen.extend(rays.map(|ray| trace_ray(self.scene, self.plan, ray, &mut self.counts)));
    }

    fn take_counts(&mut self) -> RayCounts {
        std::mem::take(&mut self.counts)
    }
}

impl<S: Simd> Tracer for PacketTracer<'_, S> {
    fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) {
        Self::trace(self, grid, places, seen);
    }

    fn take_counts(&mut self) -> RayCounts {
        std::mem::take(&mut self.counts)
    }
}
