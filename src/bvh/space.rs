//! [`Frame`]: where culling happens. A tree's items are moved and scaled into the cube from -1 to 1, and every ray is
//! moved there in `Real` before it is rounded to `f32`, so that all rounding errors have absolute bounds.
//!
//! # Why nothing is lost
//!
//! Write e = 2^-24 for half the distance of `f32` numbers just below 1 (their relative rounding error). In the frame
//!
//! - items lie within 1 of the origin on every axis, and a ray starts where it enters the root box (or, inside it,
//!   where it starts), so |origin| <= 1 + 2^-16 too; its direction has largest component 1, so that t <= 4 inside;
//! - moving a ray there in `f64` costs at most 8 * 2^-53 times its distance, of which [`FARTHEST`] allows 2^26: 2^-24;
//!   the definition of a hit (see [`objects`](crate::objects)) makes errors of the same size, and may thus accept what
//!   lies 2^-24 beside the exact ray; the rounding of the origin to `f32` adds another e.
//!
//! **Boxes.** t of a box's plane is `plane * inverse - origin * inverse`. As an error of the plane's position: e for
//! the rounded plane, 3e for the origin, e + e for the two products, 2 e |plane - origin| <= 4.1 e for the rounded
//! inverse of the direction and 2.1 e for the difference: below 13 e. Comparing with a rounded limit of t adds 4 e,
//! because |direction| <= 1. Directions nearer to an axis plane than 2^-30 are turned away from it so far: 2^-28. All
//! together less than 18 e < 2^-19; [`BOX_MARGIN`] is twice that.
//!
//! **Triangles.** See [`triangles`](super::triangles).

use super::beam::{Beam, GROUPS};
use super::simd::{Lanes, Level, Task, WIDTH};
use super::walk::DONE;
use crate::objects::run::{Numbers, PreparedRun, RUN, around, numbers_in};
use crate::objects::{Aabb, PreparedRay, Ray};
use crate::render::robust::ROUNDING;
use vecmath::{Real, Vector3, greater, lesser};

/// Boxes grow by this on every side, in the frame.
pub const BOX_MARGIN: f32 = 1.0 / (1 << 18) as f32;
/// Rays that start farther away, in the frame, are culled by nothing but the root box, grown by what rounding does to
/// them: `f64` would not carry the bounds above.
const FARTHEST: Real = (1u32 << 26) as Real;
/// Items whose spread (see [`Frame::with_spread`]) is larger than this for a ray, in the frame, likewise. The
/// errors above leave half of [`BOX_MARGIN`]; this is an eighth of it.
const LARGEST_SPREAD: Real = BOX_MARGIN as Real / 8.0;
/// Directions are longer than this: a component that is not kept from zero has a finite inverse, for it has at least
/// 2^-30 of the length.
const SHORTEST: Real = Real::MIN_POSITIVE * (1u64 << 33) as Real;
/// Directions are so short, in the frame, that its t per t of the ray is far from the ends of the range of `f64`.
const LARGEST_RATE: Real = Real::EPSILON / 64.0 / Real::MIN_POSITIVE;
/// Twice the roundings by which the definition of a triangle's hit lets a ray pass beside its box.
const GRAZING_ROUNDINGS: Real = 64.0;
/// The centre of a frame of positions is nearer than this, in its scale, so that nothing there leaves the range of
/// `f32`.
const FARTHEST_CENTER: Real = (1u64 << 60) as Real;
/// No hit in the root box has a larger t in the frame.
const LARGEST_T: f32 = 8.0;
/// Components of directions are kept this far from zero.
const SMALLEST_COMPONENT: f32 = 1.0 / LARGEST_INVERSE;
const LARGEST_INVERSE: f32 = (1u32 << 30) as f32;
/// Scales beyond 2^(+-900) would leave the range of `f64` on the way.
const LARGEST_EXPONENT: i32 = Real::MAX_EXP - Real::MAX_EXP / 8;

/// A box's planes: three lower, then three upper ones.
pub type Planes = [f32; 6];

/// The cube from -1 to 1 around a tree's items.
#[derive(Clone, Debug)]
pub struct Frame {
    center: Vector3,
    scale: Real,
    /// 1 / scale, exactly.
    unscale: Real,
    /// Rays whose origin is farther away from the centre, in the sum of coordinates, are not culled.
    farthest: Real,
    /// Nor are rays of a longer direction, in the sum of components.
    longest: Real,
    /// Rounding may move rays sideways by this share of their origin's largest coordinate before they meet an item,
    /// beside the errors above.
    spread: Real,
    /// Around all items, grown by [`BOX_MARGIN`].
    bounds: Aabb,
}

/// A ray in the frame.
#[derive(Clone, Copy, Debug)]
pub struct CullRay {
    pub origin: [f32; 3],
    /// Largest component 1, none zero.
    pub direction: [f32; 3],
    pub inverse: [f32; 3],
    /// t of the ray where the frame's is 0.
    pub start: Real,
    /// The frame's t per t of the ray.
    pub rate: Real,
}

/// How a ray meets a frame.
#[derive(Clone, Copy, Debug)]
pub enum Entry {
    /// Not at all.
    Missed,
    Met(CullRay),
    /// Too far away or too strange to be culled: the items must be asked one by one.
    Unknown,
}

impl Frame {
    /// The frame of items in `bounds`; none for bounds that are empty or not finite.
    pub fn new(bounds: Aabb) -> Option<Self> {
        Self::around(bounds, bounds.center())
    }

    /// The frame of points in `bounds` whose coordinates are numbers of `f32`. So is its centre in the frame's scale,
    /// and differences from it are as exact there as anywhere.
    pub fn of_positions(bounds: Aabb) -> Option<Self> {
        let frame = Self::around(bounds, bounds.center().map(|c| Real::from(c as f32)))?;
        ((frame.center * frame.scale).max_abs() <= FARTHEST_CENTER).then_some(frame)
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
        Some(Self { center, scale, unscale, farthest: FARTHEST * unscale, longest, spread: 0.0, bounds })
    }

    /// The centre in the frame's scale.
    pub fn scaled_center(&self) -> [f32; 3] {
        self.scaled(self.center)
    }

    /// The vector that has these components in the frame's scale.
    #[inline(always)]
    pub fn unscaled(&self, components: [f32; 3]) -> Vector3 {
        Vector3::from(components.map(Real::from)) * self.unscale
    }

    /// The same frame for items that rays meet with this spread (see [`Object::spread`](crate::objects::Object)).
    pub fn with_spread(self, spread: Real) -> Self {
        let farthest = (LARGEST_SPREAD * self.unscale / spread - sum(self.center)).min(self.farthest);
        Self { spread, farthest, ..self }
    }

    /// Around all items, margin included.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// See [`with_spread`](Self::with_spread).
    pub fn spread(&self) -> Real {
        self.spread
    }

    /// A vector's components in the frame.
    pub fn scaled(&self, vector: Vector3) -> [f32; 3] {
        (vector * self.scale).to_array().map(|c| c as f32)
    }

    /// A point in the frame.
    pub fn point(&self, point: Vector3) -> [f32; 3] {
        self.scaled(point - self.center)
    }

    /// A box in the frame, grown by [`BOX_MARGIN`].
    pub fn planes(&self, bounds: &Aabb) -> Planes {
        let (min, max) = (self.point(bounds.min), self.point(bounds.max));
        let [lower, upper] = [min.map(|c| c - BOX_MARGIN), max.map(|c| c + BOX_MARGIN)];
        [lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]]
    }

    /// The ray in the frame, if it meets the root box at a t up to `t_max`.
    #[inline]
    pub fn enter(&self, ray: &PreparedRay, t_max: Real) -> Entry {
        if !self.bounds_errors(&ray.ray) {
            return if self.may_graze(ray, t_max) { Entry::Unknown } else { Entry::Missed };
        }
        match self.bounds.entry(ray, 0.0, t_max) {
            Some(start) => Entry::Met(self.moved(ray, start)),
            None => Entry::Missed,
        }
    }

    /// [`enter`](Self::enter) of the rays of a mask: those that have met it, which are put into the beam, and those of
    /// which this is unknown.
    pub fn enter_many(
        &self,
        level: Level,
        rays: PreparedRun,
        mask: u64,
        t_max: &Numbers,
        beam: &mut Beam,
    ) -> (u64, u64) {
        let (met, unbounded) = level.run(EnterMany { frame: self, rays, mask, t_max, beam });
        let grazing = numbers_in(unbounded).filter(|&number| self.may_graze(&rays.get(number), t_max[number]));
        (met, grazing.fold(0, |mask, number| mask | 1 << number))
    }

    /// Whether the errors of a ray have the bounds above: its direction is neither too short nor too long for them, and
    /// it does not start too far away.
    #[inline(always)]
    fn bounds_errors(&self, ray: &Ray) -> bool {
        self.has_usual_size(ray.direction) & (sum(ray.origin - self.center) <= self.farthest)
    }

    #[inline(always)]
    fn has_usual_size(&self, direction: Vector3) -> bool {
        (largest(direction) > SHORTEST) & (sum(direction) <= self.longest)
    }

    /// Whether a ray without such bounds may meet an item, by its own rounding: it starts so far away that this exceeds
    /// the margin of the root box, or has a direction of which nothing can be said.
    #[cold]
    fn may_graze(&self, ray: &PreparedRay, t_max: Real) -> bool {
        let reach = ray.ray.origin.max_abs().max(self.bounds.max_abs());
        let margin = (GRAZING_ROUNDINGS * ROUNDING + self.spread) * reach;
        // NaN meets every box.
        !self.has_usual_size(ray.ray.direction) || self.bounds.entry(ray, margin, t_max).is_some()
    }

    /// The ray in the frame, if its errors have bounds. At t = `start` it must be within 1 + 2^-16 of the middle on
    /// every axis, and not yet in the box unless `start` is 0.
    #[inline(always)]
    fn moved(&self, PreparedRay { ray, inverse_direction }: &PreparedRay, start: Real) -> CullRay {
        let from_center = ray.origin - self.center;
        let largest = largest(ray.direction);
        let origin = (from_center + ray.direction * start) * self.scale;
        // 1 / largest, without dividing once more.
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
        CullRay {
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

/// Of the components' sizes. It does not pass over NaN.
#[inline(always)]
fn sum(vector: Vector3) -> Real {
    vector.x.abs() + vector.y.abs() + vector.z.abs()
}

/// Takes the rays of a mask into a frame, and those that meet it within their `t_max` into a beam. The output are the
/// rays that have met it, and those whose errors have no bounds.
struct EnterMany<'a> {
    frame: &'a Frame,
    rays: PreparedRun<'a>,
    mask: u64,
    t_max: &'a Numbers,
    beam: &'a mut Beam,
}

impl Task for EnterMany<'_> {
    type Output = (u64, u64);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> (u64, u64) {
        let Self { frame, rays, mask, t_max, beam } = self;
        beam.clear();
        // 0: missed, 1: met, 2: unknown.
        let mut states = [[0.0f32; WIDTH]; GROUPS];
        // Apart from the beam, for the compiler does not see that they do not overlap with numbers of another size.
        let (mut start, mut rate) = ([0.0; RUN], [1.0; RUN]);
        for number in around(mask) {
            let ray = rays.get(number);
            let (meets, near) = frame.bounds.meets(&ray, 0.0, t_max[number]);
            // Rays that are not asked about would widen the search.
            let is_asked = mask >> number & 1 == 1;
            let is_sane = frame.bounds_errors(&ray.ray);
            let moved = frame.moved(&ray, near);
            let limit = moved.limit(t_max[number]);
            let state = if meets { 1.0 } else { 0.0 };
            let state = if is_sane { state } else { 2.0 };
            states.as_flattened_mut()[number] = if is_asked { state } else { 0.0 };
            (start[number], rate[number]) = (moved.start, moved.rate);
            beam.set(number, &moved, if meets & is_sane & is_asked { limit } else { DONE });
        }
        (beam.start, beam.rate) = (start, rate);
        let (mut met, mut unknown) = (0, 0);
        for (group, states) in states.iter().enumerate() {
            let states = l.load(states);
            let from_one = u64::from(l.bits(l.le(l.splat(1.0), states)));
            let from_two = u64::from(l.bits(l.le(l.splat(2.0), states)));
            met |= (from_one & !from_two) << (WIDTH * group);
            unknown |= from_two << (WIDTH * group);
        }
        (met, unknown)
    }
}

impl CullRay {
    /// The frame's t for the ray's, never too small for the ray to reach an item at that t.
    #[inline(always)]
    pub fn limit(&self, t: Real) -> f32 {
        limit(t, self.start, self.rate)
    }

    /// Origin and direction, in all lanes.
    #[inline(always)]
    pub fn in_all_lanes<L: Lanes>(&self, l: L) -> [[L::F; 3]; 2] {
        [self.origin, self.direction].map(|v| [l.splat(v[0]), l.splat(v[1]), l.splat(v[2])])
    }

    /// origin * inverse, axis by axis.
    pub fn origin_times_inverse(&self) -> [f32; 3] {
        std::array::from_fn(|axis| self.origin[axis] * self.inverse[axis])
    }
}

/// [`CullRay::limit`] of a ray with this start and rate.
#[inline(always)]
pub fn limit(t: Real, start: Real, rate: Real) -> f32 {
    // The half margin covers the rounding of t, of which the frame's t is at most 4.
    (((t - start) * rate) as f32 + 0.5 * BOX_MARGIN).min(LARGEST_T)
}
