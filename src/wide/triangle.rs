//! [`TriangleHits`]: the exact test of one triangle for the rays of a packet.

use crate::objects::{Crossing, ShearAxes, box_interval};
use crate::simd::packet::{PACKET, RayPacket, Scalars, Vectors, span};
use vecmath::{Real, Vector3, chosen_if};

/// What [`intersect`](Self::intersect) found, lane by lane.
pub struct TriangleHits {
    pub t: Scalars,
    pub barycentric: [Scalars; 3],
    /// [`HIT`](Self::HIT), [`MISS`](Self::MISS) or [`UNDECIDED`](Self::UNDECIDED).
    pub verdict: Scalars,
}

impl TriangleHits {
    pub const NONE: Self = Self { t: [0.0; PACKET], barycentric: [[0.0; PACKET]; 3], verdict: [0.0; PACKET] };

    pub const HIT: Real = 1.0;
    pub const MISS: Real = 0.0;
    /// The ray grazes the triangle's box: [`intersect_triangle`](crate::objects::intersect_triangle) must decide.
    pub const UNDECIDED: Real = -1.0;

    /// Does what [`intersect_triangle`](crate::objects::intersect_triangle) does for the active lanes, whose rays must
    /// have these axes.
    #[inline(always)]
    pub fn intersect(&mut self, axes: &ShearAxes, rays: &RayPacket, active: u64, corners: [Vector3; 3]) {
        let ordered = corners.map(|corner| axes.order(corner));
        for lane in span(active) {
            let in_order = |vectors: &Vectors| {
                let [x, y, z] = [&vectors.0[axes.x], &vectors.0[axes.y], &vectors.0[axes.z]];
                Vector3::new(x[lane], y[lane], z[lane])
            };
            let line = [in_order(&rays.origin), in_order(&rays.direction), in_order(&rays.inverse_direction)];
            let crossing = Crossing::of(line, ordered);
            let (near, far) = box_interval(&rays.get_prepared(lane), corners, 0.0, chosen_if);
            let hit = crossing.hit(near, far);
            self.t[lane] = hit.t;
            for corner in 0..3 {
                self.barycentric[corner][lane] = hit.barycentric[corner];
            }
            let verdict = if hit.t > 0.0 { Self::HIT } else { Self::MISS };
            let verdict = if near <= far { verdict } else { Self::UNDECIDED };
            self.verdict[lane] = if crossing.is_inside { verdict } else { Self::MISS };
        }
    }
}
