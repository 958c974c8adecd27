//! [`HitPacket`]: the nearest hits of a packet's rays so far.

use crate::objects::{Hit, Object, Shape, SurfaceHit, T_MAX, match_surface};
use crate::simd::packet::{PACKET, RayPacket, Scalars, Vectors, has_lane, lanes_equal, span};
use crate::simd::{Simd, vectorize};
use vecmath::{Real, greater, lesser};

/// The nearest hit of each lane. A query also reads from `t` how far its rays go.
#[derive(Clone, Copy, Debug)]
pub struct HitPacket {
    /// Index of the object, [`NOTHING`](Self::NOTHING) if nothing is hit.
    pub object: [u32; PACKET],
    pub t: Scalars,
    /// Triangle and weights are set only where a triangle is hit; see [`SurfaceHit`].
    pub triangle: [u32; PACKET],
    pub barycentric: Vectors,
}

/// The largest t of a hit.
const BELOW_T_MAX: Real = T_MAX.next_down();

impl HitPacket {
    /// The index of no object.
    pub const NOTHING: u32 = u32::MAX;

    /// Nothing is hit yet.
    pub const NONE: Self = Self {
        object: [Self::NOTHING; PACKET],
        t: [BELOW_T_MAX; PACKET],
        triangle: [0; PACKET],
        barycentric: Vectors::ZERO,
    };

    pub fn clear(&mut self) {
        self.object = Self::NONE.object;
        self.t = Self::NONE.t;
    }

    /// Returns the active lanes whose nearest hit is on this object.
    pub fn lanes_of<S: Simd>(&self, simd: S, active: u64, object: u32) -> u64 {
        active & lanes_equal(simd, &self.object, object)
    }

    /// Returns the nearest hit of a lane.
    pub fn get(&self, lane: usize, objects: &[Object]) -> Option<Hit> {
        let object = self.object[lane];
        (object != Self::NOTHING).then(|| {
            let surface = match_surface!(&objects[object as usize].shape,
                _surface => SurfaceHit::at(self.t[lane]),
                Shape::Triangle(_) | Shape::Mesh(_) => self.surface(lane),
            );
            Hit { object, surface }
        })
    }

    /// Returns where a lane's ray hits a triangle.
    #[inline(always)]
    pub fn surface(&self, lane: usize) -> SurfaceHit {
        let barycentric = self.barycentric.get(lane).to_array();
        SurfaceHit { t: self.t[lane], triangle: self.triangle[lane], barycentric }
    }

    #[inline(always)]
    pub fn set_surface(&mut self, lane: usize, hit: SurfaceHit) {
        self.t[lane] = hit.t;
        self.triangle[lane] = hit.triangle;
        self.barycentric.set(lane, hit.barycentric.into());
    }

    /// Returns the t below which a hit of this object replaces a lane's hit.
    #[inline(always)]
    pub fn limit(&self, lane: usize, object: u32) -> Real {
        let bits = self.t[lane].to_bits();
        // One number further for an object that comes first, because it wins at the same t. t is above 0.
        Real::from_bits(if object < self.object[lane] { bits + 1 } else { bits })
    }

    /// Computes the [`limit`](Self::limit) of each active lane.
    pub fn limits<S: Simd>(&self, simd: S, index: u32, active: u64, limits: &mut Scalars) {
        vectorize!(simd, {
            for lane in span(active) {
                limits[lane] = self.limit(lane, index);
            }
        });
    }

    /// Sets how far the active rays go: to their `t_max`, and no farther than a hit may be.
    pub fn set_t_max<S: Simd>(&mut self, simd: S, active: u64, t_max: &Scalars) {
        vectorize!(simd, {
            for lane in span(active) {
                self.t[lane] = lesser(BELOW_T_MAX, t_max[lane]);
            }
        });
    }

    /// Returns the active lanes whose rays go at least as far as `t`.
    pub fn reached<S: Simd>(&self, simd: S, active: u64, t: &Scalars) -> u64 {
        active
            & vectorize!(simd, {
                let mut reached = 0;
                for lane in span(active) {
                    reached |= u64::from(t[lane] <= self.t[lane]) << lane;
                }
                reached
            })
    }

    /// Replaces hits of the active lanes by those at `t` that are nearer.
    pub fn take_nearer<S: Simd>(&mut self, simd: S, index: u32, active: u64, t: &Scalars) {
        vectorize!(simd, {
            for lane in span(active) {
                let (new, old, before) = (t[lane], self.t[lane], self.object[lane]);
                let takes = is_nearer(new, old, index < before) & has_lane(active, lane);
                self.t[lane] = if takes { new } else { old };
                self.object[lane] = if takes { index } else { before };
            }
        });
    }

    /// Replaces hits of the active lanes by those in a mesh that are nearer. `entry` returns for a lane and its t whether
    /// the ray enters the object's bounds before that, and where.
    pub fn take_nearer_in_mesh<S: Simd>(
        &mut self,
        simd: S,
        index: u32,
        active: u64,
        in_mesh: &Self,
        entry: impl Fn(usize, Real) -> (bool, Real),
    ) {
        vectorize!(simd, {
            for lane in span(active) {
                let (old, before) = (self.t[lane], self.object[lane]);
                let (meets, entry) = entry(lane, old);
                let new = greater(in_mesh.t[lane], entry);
                let takes = meets & is_nearer(new, old, index < before) & has_lane(active, lane);
                self.t[lane] = if takes { new } else { old };
                self.object[lane] = if takes { index } else { before };
                self.triangle[lane] = if takes { in_mesh.triangle[lane] } else { self.triangle[lane] };
                let (weights, kept) = (in_mesh.barycentric.get(lane), self.barycentric.get(lane));
                self.barycentric.set(lane, if takes { weights } else { kept });
            }
        });
    }

    /// Returns the active lanes whose rays enter an object's bounds at a t up to and including that of their hit.
    pub fn entering<S: Simd>(&self, simd: S, object: &Object, world: &RayPacket, active: u64) -> u64 {
        active
            & vectorize!(simd, {
                let mut met = 0;
                for lane in span(active) {
                    let (meets, _) = object.entry_branchless(&world.get_prepared(lane), self.t[lane]);
                    met |= u64::from(meets) << lane;
                }
                met
            })
    }
}

/// Returns whether a hit at `new` replaces one at `old`: it is nearer, or as near and first in the file. It has no
/// branches, so that loops vectorise.
#[inline(always)]
pub fn is_nearer(new: Real, old: Real, comes_first: bool) -> bool {
    (new < old) | ((new == old) & comes_first)
}
