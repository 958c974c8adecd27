//! [`CullingSpace`]: the space in which a tree culls, with constant error bounds.
//!
//! A tree's items are moved and scaled into the cube from -1 to 1. A ray is moved there in `Real` before it is rounded to
//! `f32`. So all rounding errors of culling are bounded by constants, and boxes that are grown by more than these lose no
//! hit.
//!
//! # The error bounds
//!
//! Let e = 2^-24 be the unit roundoff of `f32`. In culling space
//!
//! - items lie within 1 of the origin on every axis. A ray starts where it enters the root box, or where it starts if
//!   that is inside, so |origin| <= 1 + 2^-16 too. The largest component of its direction is 1, so t <= 4 inside;
//! - moving a ray there in `f64` costs at most 8 * 2^-53 times its distance. [`FARTHEST`] allows a distance of 2^26, so
//!   this is 2^-24. The exact tests (see [`objects`](crate::objects)) make errors of the same size and may accept what
//!   lies 2^-24 beside the ray. Rounding the origin to `f32` adds another e.
//!
//! **Boxes.** t of a box's plane is `plane * inverse - origin * inverse`. Its error, as an error of the plane's position,
//! is e for the rounded plane, 3e for the origin, e + e for the two products, 2 e |plane - origin| <= 4.1 e for the
//! rounded inverse of the direction and 2.1 e for the difference: below 13 e. Comparing it with a rounded limit of t
//! adds 4 e, because |direction| <= 1. Directions nearer than 2^-30 to an axis plane are turned away from it by that
//! much, which adds 2^-28. All together this is less than 18 e < 2^-19; [`BOX_MARGIN`] is twice that.
//!
//! **Triangles.** See [`triangle_block`](super::triangle_block).

use crate::objects::{Aabb, PreparedRay, Ray};
use crate::simd::{Simd, f32x8, splat3};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3, greater, lesser};

/// Boxes grow by this on every side, in culling space.
pub const BOX_MARGIN: f32 = 1.0 / (1 << 18) as f32;
/// Rays that start farther away than this, in culling space, are unbounded: only the root box culls them, grown by their
/// own rounding, because `f64` does not carry the error bounds above for them.
const FARTHEST: Real = (1u32 << 26) as Real;
/// So are rays that rounding moves sideways by more than this, in culling space, on their way to an item. The errors above
/// leave half of [`BOX_MARGIN`] over; this is an eighth of it.
const LARGEST_SIDEWAYS_ERROR: Real = BOX_MARGIN as Real / 8.0;
/// Bounded rays have longer directions than this, so that a component of at least 2^-30 of the length has a finite inverse.
const SHORTEST: Real = Real::MIN_POSITIVE * (1u64 << 33) as Real;
/// Bounded rays have a smaller rate than this, far from the end of the range of `f64`.
const LARGEST_RATE: Real = Real::EPSILON / 64.0 / Real::MIN_POSITIVE;
/// Twice the roundings by which the exact test of a triangle lets a ray pass beside the triangle's box.
const GRAZING_ROUNDINGS: Real = 64.0;
/// The centre of a space of `f32` positions is nearer than this in the space's scale, so that no position leaves the range
/// of `f32` there.
const FARTHEST_CENTER: Real = (1u64 << 60) as Real;
/// No hit in the root box has a larger t in culling space.
const LARGEST_T: f32 = 8.0;
/// Components of directions are kept this far from zero, so that their inverse is no larger than [`LARGEST_INVERSE`].
const SMALLEST_COMPONENT: f32 = 1.0 / LARGEST_INVERSE;
const LARGEST_INVERSE: f32 = (1u32 << 30) as f32;
/// Scales beyond 2^(+-900) would leave the range of `f64` on the way.
const LARGEST_EXPONENT: i32 = Real::MAX_EXP - Real::MAX_EXP / 8;

/// A box's planes: three lower, then three upper ones.
pub type Planes = [f32; 6];

/// The way from a tree's own space to the cube from -1 to 1 around its items.
#[derive(Clone, Debug)]
pub struct CullingSpace {
    center: Vector3,
    scale: Real,
    /// 1 / scale, exactly.
    unscale: Real,
    /// Rays whose origin is farther from the centre than this, in the sum of coordinates, are unbounded.
    farthest: Real,
    /// So are rays whose direction is longer than this, in the sum of components.
    longest: Real,
    /// See [`Object::sideways_error`](crate::objects::Object): the largest one of the items.
    sideways_error: Real,
    /// The box around all items, grown by [`BOX_MARGIN`].
    bounds: Aabb,
}

/// A ray in culling space.
#[derive(Clone, Copy, Debug)]
pub struct CullingRay {
    pub origin: [f32; 3],
    /// Largest component 1, none zero.
    pub direction: [f32; 3],
    pub inverse: [f32; 3],
    /// The ray's t at which t is 0 in culling space.
    pub start: Real,
    /// How much t grows in culling space for each unit of the ray's t.
    pub rate: Real,
}

/// How a ray enters a tree.
#[derive(Clone, Copy, Debug)]
pub enum Entry {
    /// It meets no item.
    Missed,
    Entered(CullingRay),
    /// Its errors have no bounds: every item must be tested.
    Unbounded,
}

impl CullingSpace {
    /// Makes the space of items in `bounds`; `None` for bounds that are empty or not finite.
    pub fn new(bounds: Aabb) -> Option<Self> {
        Self::around(bounds, bounds.center())
    }

    /// Makes the space of points in `bounds` whose coordinates are numbers of `f32`. Its scaled centre is a number of
    /// `f32` too, so differences from it are as exact there as they were.
    pub fn of_positions(bounds: Aabb) -> Option<Self> {
        let space = Self::around(bounds, bounds.center().map(|c| Real::from(c as f32)))?;
        ((space.center * space.scale).max_abs() <= FARTHEST_CENTER).then_some(space)
    }

    fn around(bounds: Aabb, center: Vector3) -> Option<Self> {
        let half = (bounds.max - center).max(center - bounds.min).max_abs();
        if bounds.is_empty() || !center.is_finite() || !bounds.size().is_finite() {
            return None;
        }
        let exponent = if half > 0.0 { half.log2().ceil() as i32 } else { 0 };
        if exponent.abs() > LARGEST_EXPONENT {
            return None;
        }
        // The logarithm may be rounded down past a power of two.
        let exponent = exponent + i32::from(half * (2.0 as Real).powi(-exponent) > 1.0);
        let scale = (2.0 as Real).powi(-exponent);
        let (unscale, bounds) = (1.0 / scale, bounds.grown(BOX_MARGIN as Real / scale));
        let longest = (LARGEST_RATE * unscale).min(Real::MAX);
        Some(Self { center, scale, unscale, farthest: FARTHEST * unscale, longest, sideways_error: 0.0, bounds })
    }

    /// Returns the centre, scaled.
    pub fn scaled_center(&self) -> [f32; 3] {
        self.scaled(self.center)
    }

    /// Undoes [`scaled`](Self::scaled).
    #[inline(always)]
    pub fn unscaled(&self, components: [f32; 3]) -> Vector3 {
        Vector3::from(components.map(Real::from)) * self.unscale
    }

    /// Makes the same space for items with this [`Object::sideways_error`](crate::objects::Object).
    pub fn with_sideways_error(self, sideways_error: Real) -> Self {
        let farthest =
            (LARGEST_SIDEWAYS_ERROR * self.unscale / sideways_error - sum(self.center)).min(self.farthest);
        Self { sideways_error, farthest, ..self }
    }

    /// Returns the box around all items, margin included.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// See [`with_sideways_error`](Self::with_sideways_error).
    pub fn sideways_error(&self) -> Real {
        self.sideways_error
    }

    /// Scales a vector, without moving it.
    pub fn scaled(&self, vector: Vector3) -> [f32; 3] {
        (vector * self.scale).to_array().map(|c| c as f32)
    }

    /// Takes a point to culling space.
    pub fn point(&self, point: Vector3) -> [f32; 3] {
        self.scaled(point - self.center)
    }

    /// Takes a box to culling space and grows it by [`BOX_MARGIN`].
    pub fn planes(&self, bounds: &Aabb) -> Planes {
        let (min, max) = (self.point(bounds.min), self.point(bounds.max));
        let [lower, upper] = [min.map(|c| c - BOX_MARGIN), max.map(|c| c + BOX_MARGIN)];
        [lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]]
    }

    /// Takes a ray to culling space if it meets the root box at a t up to `t_max`.
    #[inline]
    pub fn enter(&self, ray: &PreparedRay, t_max: Real) -> Entry {
        if !self.is_bounded(&ray.ray) {
            return if self.may_graze(ray, t_max) { Entry::Unbounded } else { Entry::Missed };
        }
        match self.bounds.entry(ray, 0.0, t_max) {
            Some(start) => Entry::Entered(self.moved(ray, start)),
            None => Entry::Missed,
        }
    }

    /// Returns whether the errors of a ray have the bounds above: its direction is neither too short nor too long, and it
    /// does not start too far away.
    #[inline(always)]
    pub fn is_bounded(&self, ray: &Ray) -> bool {
        self.has_usual_size(ray.direction) & (sum(ray.origin - self.center) <= self.farthest)
    }

    #[inline(always)]
    fn has_usual_size(&self, direction: Vector3) -> bool {
        (largest(direction) > SHORTEST) & (sum(direction) <= self.longest)
    }

    /// Returns whether an unbounded ray may meet an item, by its own rounding: it starts so far away that this exceeds
    /// the margin of the root box, or its direction is such that nothing can be said.
    #[cold]
    pub fn may_graze(&self, ray: &PreparedRay, t_max: Real) -> bool {
        let reach = ray.ray.origin.max_abs().max(self.bounds.max_abs());
        let margin = (GRAZING_ROUNDINGS * UNIT_ROUNDOFF + self.sideways_error) * reach;
        // NaN meets every box.
        !self.has_usual_size(ray.ray.direction) || self.bounds.entry(ray, margin, t_max).is_some()
    }

    /// Takes a bounded ray to culling space. At t = `start` it must be within 1 + 2^-16 of the middle on every axis, and
    /// not yet in the box unless `start` is 0.
    #[inline(always)]
    pub fn moved(&self, PreparedRay { ray, inverse_direction }: &PreparedRay, start: Real) -> CullingRay {
        let from_center = ray.origin - self.center;
        let largest = largest(ray.direction);
        let origin = (from_center + ray.direction * start) * self.scale;
        // This is 1 / largest without another division.
        let [x, y, z] = inverse_direction.map(Real::abs).to_array();
        let smallest = lesser(lesser(x, y), z);
        let away = |c: f32| {
            let size = if c.abs() > SMALLEST_COMPONENT { c.abs() } else { SMALLEST_COMPONENT };
            size.copysign(c)
        };
        let near = |c: f32| {
            let c = if c < LARGEST_INVERSE { c } else { LARGEST_INVERSE };
            if c > -LARGEST_INVERSE { c } else { -LARGEST_INVERSE }
        };
        CullingRay {
            origin: origin.to_array().map(|c| c as f32),
            direction: (ray.direction * smallest).to_array().map(|c| away(c as f32)),
            inverse: (*inverse_direction * largest).to_array().map(|c| near(c as f32)),
            start,
            rate: largest * self.scale,
        }
    }
}

#[inline(always)]
fn largest(vector: Vector3) -> Real {
    greater(greater(vector.x.abs(), vector.y.abs()), vector.z.abs())
}

/// Returns the sum of the components' sizes, NaN if one of them is NaN.
#[inline(always)]
fn sum(vector: Vector3) -> Real {
    vector.x.abs() + vector.y.abs() + vector.z.abs()
}

impl CullingRay {
    /// Takes a t of the ray to culling space, rounded so that an item at that t is never beyond it.
    #[inline(always)]
    pub fn limit(&self, t: Real) -> f32 {
        limit(t, self.start, self.rate)
    }

    /// Puts origin and direction into all lanes.
    #[inline(always)]
    pub fn splat<S: Simd>(&self, simd: S) -> [[f32x8<S>; 3]; 2] {
        [splat3(simd, self.origin), splat3(simd, self.direction)]
    }

    /// Returns origin * inverse, axis by axis.
    #[inline]
    pub fn origin_times_inverse(&self) -> [f32; 3] {
        std::array::from_fn(|axis| self.origin[axis] * self.inverse[axis])
    }
}

/// Returns [`CullingRay::limit`] of a ray with this start and rate.
#[inline(always)]
pub fn limit(t: Real, start: Real, rate: Real) -> f32 {
    // The half margin covers the rounding of t, which is at most 4 in culling space.
    (((t - start) * rate) as f32 + 0.5 * BOX_MARGIN).min(LARGEST_T)
}
