//! Where shadow and mirror rays start, and the tolerances behind it.
//!
//! In: where a ray has met a surface. Out: a [`Departure`], from which rays leave that surface. The starter's rays
//! leave 0.01 along their own direction, and the course's pictures depend on it; [`Epsilon::Auto`](crate::options::Epsilon::Auto) takes the smallest
//! distance that rounding allows, which holds at every scale. `docs/numerics.md` has the derivations at length.
//!
//! Tolerances that belong to one object stand beside it, in units of [`ROUNDING`]: boxes in `objects/aabb.rs`,
//! surfaces in `objects/surface.rs`, placements in `objects/placement.rs`.

use crate::light::Light;
use crate::material::mirrored;
use crate::objects::{Ray, SurfacePoint};
use vecmath::{Real, Vector3};

/// The largest relative error of one rounding: u of Higham, Accuracy and Stability of Numerical Algorithms, 2002, 2.1.
pub const ROUNDING: Real = Real::EPSILON / 2.0;

/// A light stops being behind an object that it touches: rounding may put the hit on the light's side or on this one.
///
/// Distance and t each come from a difference, three squares and a root (5 roundings of the distance and one of the
/// light's and the origin's coordinates each); the object adds at most as much as a surface's own bound, some 20
/// roundings of the coordinates. 64 of either cover that with room to spare.
const LIGHT_GAP: Real = 64.0 * ROUNDING;

/// A point of a surface, ready for rays to start just off it.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    surface: SurfacePoint,
    /// The surface's normal on the side that the eye sees.
    to_eye: Vector3,
    /// Direction of the ray that has come here.
    incoming: Vector3,
}

impl Departure {
    /// Where `ray` has met `surface`.
    pub fn new(ray: &Ray, surface: SurfacePoint) -> Self {
        let away = surface.normal.dot(ray.direction) > 0.0;
        let to_eye = if away { -surface.normal } else { surface.normal };
        Self { surface, to_eye, incoming: ray.direction }
    }

    /// The mirror ray of direction `reflected`, which starts on the side of the surface that it goes to. If it may only
    /// go to the side that the eye sees, an interpolated normal that leads elsewhere gives way to the face's own.
    pub fn mirror_ray(&self, reflected: Vector3, only_to_eye: bool) -> Ray {
        let enters = self.to_eye.dot(reflected) < 0.0;
        let direction = if only_to_eye && enters { mirrored(self.incoming, self.to_eye) } else { reflected };
        Ray { origin: self.surface.beside(direction), direction }
    }

    /// The ray to a light from the side that the eye sees, wherever the light is, and how far it goes: a surface stands
    /// in the way of what is behind it.
    pub fn shadow_ray(&self, light: &Light) -> (Ray, Real) {
        let origin = self.surface.point + self.to_eye * self.surface.gap;
        let illumination = light.illuminate(origin);
        (Ray { origin, direction: illumination.to_light }, shadow_limit(origin, illumination.distance))
    }

    /// The starter's ray to a light, but for its distance from the surface.
    pub fn plain_shadow_ray(&self, to_light: Vector3, distance: Real) -> (Ray, Real) {
        (Ray { origin: self.surface.beside(to_light), direction: to_light }, distance)
    }
}

/// How far an object in front of a light may be, if `distance` lies between the light and `origin`: not quite so far,
/// for the light may lie on an object.
pub fn shadow_limit(origin: Vector3, distance: Real) -> Real {
    if distance == Real::INFINITY {
        return distance;
    }
    // The light's coordinates are at most the origin's and the distance together.
    (distance - LIGHT_GAP * (2.0 * distance + origin.max_abs())).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const Y: Vector3 = Vector3::new(0.0, 1.0, 0.0);
    const DOWN: Ray = Ray { origin: Vector3::new(0.0, 2.0, 0.0), direction: Vector3::new(0.0, -1.0, 0.0) };

    fn surface() -> SurfacePoint {
        SurfacePoint { point: Vector3::new(0.0, 0.5, 0.0), normal: -Y, gap: 0.125 }
    }

    #[test]
    fn rays_start_on_the_side_they_go_to_or_on_the_eyes() {
        let departure = Departure::new(&DOWN, surface());
        assert_eq!(departure.mirror_ray(Y, true).origin, Vector3::new(0.0, 0.625, 0.0));
        assert_eq!(departure.mirror_ray(-Y, false).origin, Vector3::new(0.0, 0.375, 0.0));
        let lamp = |y| Light::Point { position: Vector3::new(0.0, y, 0.0), color: Y, falloff: 1.0 };
        for y in [3.0, -3.0] {
            assert_eq!(departure.shadow_ray(&lamp(y)).0.origin, Vector3::new(0.0, 0.625, 0.0));
        }
        let below = lamp(-3.0).illuminate(Vector3::new(0.0, 0.5, 0.0));
        assert_eq!(
            departure.plain_shadow_ray(below.to_light, below.distance).0.origin,
            Vector3::new(0.0, 0.375, 0.0)
        );
    }

    #[test]
    fn a_mirror_sends_no_ray_into_itself() {
        let departure = Departure::new(&DOWN, surface());
        let inward = Vector3::new(0.8, -0.6, 0.0);
        assert_eq!(departure.mirror_ray(inward, false).direction, inward);
        assert_eq!(departure.mirror_ray(inward, true).direction, Y);
    }

    #[test]
    fn a_light_is_not_behind_the_object_that_it_touches() {
        let origin = Vector3::new(1e6, 0.0, 0.0);
        assert!(shadow_limit(origin, 1.0) < 1.0);
        assert!(shadow_limit(origin, 1.0) > 1.0 - 1e6 * 100.0 * ROUNDING);
        assert_eq!(shadow_limit(origin, Real::INFINITY), Real::INFINITY);
    }
}
