//! [`RayOffset`]: where shadow and mirror rays start.
//!
//! A ray that starts at a computed hit would hit the same surface again, because the point of the hit is rounded. The
//! starter's rays start 0.01 along their direction, and the course's pictures depend on it.
//! [`Epsilon::Auto`](crate::options::Epsilon::Auto) takes the smallest distance that rounding allows, which fits at
//! every scale. `docs/numerics.md` derives it at length.
//!
//! The error bounds of an object stand beside it, in units of [`UNIT_ROUNDOFF`]: of boxes in `objects/aabb.rs`, of
//! surfaces in the file of each shape, of transforms in `objects/transform.rs`.

use crate::light::{Illumination, Light};
use crate::material::mirrored;
use crate::objects::{Ray, SurfacePoint};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3};

/// Share of the distance and of the coordinates by which a shadow ray ends before the light. An object that touches
/// the light must not block it, though rounding may put the hit on either side of the light.
///
/// Distance and t are each computed from a difference, three squares and a root: 5 roundings of the distance, and one
/// of the coordinates of light and origin. The object adds at most the error bound of a surface point, about 20
/// roundings of the coordinates. 64 of both are more than enough.
const LIGHT_MARGIN: Real = 64.0 * UNIT_ROUNDOFF;

/// Returns the ray that starts `epsilon` along itself from a point: the starter's offset.
#[inline(always)]
pub fn offset_along(point: Vector3, direction: Vector3, epsilon: Real) -> Ray {
    Ray { origin: point + direction * epsilon, direction }
}

/// A point of a surface that shadow and mirror rays leave.
#[derive(Clone, Copy, Debug)]
pub enum RayOffset {
    /// Rays start this far along their direction.
    Along { point: Vector3, epsilon: Real },
    /// Rays start beside the surface, at the distance of its error bound.
    Beside(BesideSurface),
}

/// See [`RayOffset::Beside`].
#[derive(Clone, Copy, Debug)]
pub struct BesideSurface {
    surface: SurfacePoint,
    /// The surface's normal on the side that the eye sees.
    to_eye: Vector3,
    /// Direction of the ray that has hit the surface.
    incoming: Vector3,
}

impl RayOffset {
    /// Returns the point that is shaded.
    pub fn point(&self) -> Vector3 {
        match self {
            Self::Along { point, .. } => *point,
            Self::Beside(beside) => beside.surface.point,
        }
    }

    /// Returns the ray to a light as `seen` from the point, and how far it goes. As in the starter, the distance is
    /// counted from the offset origin: an object up to one offset behind the light blocks it too, except with
    /// `-robust`.
    pub fn shadow_ray(&self, light: &Light, seen: &Illumination, is_robust: bool) -> (Ray, Real) {
        match self {
            Self::Along { point, epsilon } => {
                let ray = offset_along(*point, seen.to_light, *epsilon);
                let t_max =
                    if is_robust { shadow_t_max(ray.origin, seen.distance - epsilon) } else { seen.distance };
                (ray, t_max)
            }
            Self::Beside(beside) => beside.shadow_ray(light, seen.to_light, seen.distance, is_robust),
        }
    }

    /// Returns the mirror ray in this direction.
    pub fn mirror_ray(&self, reflected: Vector3, is_robust: bool) -> Ray {
        match self {
            Self::Along { point, epsilon } => offset_along(*point, reflected, *epsilon),
            Self::Beside(beside) => beside.mirror_ray(reflected, is_robust),
        }
    }
}

impl BesideSurface {
    /// Makes the offset of rays that leave the point where `ray` has hit `surface`.
    pub fn new(ray: &Ray, surface: SurfacePoint) -> Self {
        let points_away = surface.normal.dot(ray.direction) > 0.0;
        let to_eye = if points_away { -surface.normal } else { surface.normal };
        Self { surface, to_eye, incoming: ray.direction }
    }

    /// Returns the mirror ray, which starts on the side that it goes to. With `-robust` it always goes to the side
    /// that the eye sees: where the smooth normal would lead it into the mirror, the normal of the face is used
    /// instead.
    pub fn mirror_ray(&self, reflected: Vector3, is_robust: bool) -> Ray {
        let enters = self.to_eye.dot(reflected) < 0.0;
        let direction = if is_robust && enters { mirrored(self.incoming, self.to_eye) } else { reflected };
        Ray { origin: self.surface.beside(direction), direction }
    }

    /// Returns the ray to a light, and how far it goes. With `-robust` it starts on the side that the eye sees, wherever
    /// the light is: a surface blocks a light behind it.
    pub fn shadow_ray(&self, light: &Light, to_light: Vector3, distance: Real, is_robust: bool) -> (Ray, Real) {
        if !is_robust {
            return (Ray { origin: self.surface.beside(to_light), direction: to_light }, distance);
        }
        let origin = self.surface.point + self.to_eye * self.surface.error_bound;
        let seen = light.illuminate(origin);
        (Ray { origin, direction: seen.to_light }, shadow_t_max(origin, seen.distance))
    }
}

/// Returns how far a shadow ray goes to a light at this distance from its origin: not quite so far, because the light
/// may lie on an object.
pub fn shadow_t_max(origin: Vector3, distance: Real) -> Real {
    if distance == Real::INFINITY {
        return distance;
    }
    // The light's coordinates are at most the origin's and the distance together.
    (distance - LIGHT_MARGIN * (2.0 * distance + origin.max_abs())).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const Y: Vector3 = Vector3::new(0.0, 1.0, 0.0);
    const DOWN: Ray = Ray { origin: Vector3::new(0.0, 2.0, 0.0), direction: Vector3::new(0.0, -1.0, 0.0) };

    fn surface() -> SurfacePoint {
        SurfacePoint { point: Vector3::new(0.0, 0.5, 0.0), normal: -Y, error_bound: 0.125 }
    }

    #[test]
    fn rays_start_on_the_side_they_go_to_or_on_the_eyes() {
        let beside = BesideSurface::new(&DOWN, surface());
        assert_eq!(beside.mirror_ray(Y, true).origin, Vector3::new(0.0, 0.625, 0.0));
        assert_eq!(beside.mirror_ray(-Y, false).origin, Vector3::new(0.0, 0.375, 0.0));
        let lamp = |y| Light::Point { position: Vector3::new(0.0, y, 0.0), color: Y, falloff: 1.0 };
        let shadow_origin = |y, is_robust| {
            let seen = lamp(y).illuminate(Vector3::new(0.0, 0.5, 0.0));
            beside.shadow_ray(&lamp(y), seen.to_light, seen.distance, is_robust).0.origin
        };
        for y in [3.0, -3.0] {
            assert_eq!(shadow_origin(y, true), Vector3::new(0.0, 0.625, 0.0));
        }
        assert_eq!(shadow_origin(-3.0, false), Vector3::new(0.0, 0.375, 0.0));
    }

    #[test]
    fn a_mirror_sends_no_ray_into_itself() {
        let beside = BesideSurface::new(&DOWN, surface());
        let inward = Vector3::new(0.8, -0.6, 0.0);
        assert_eq!(beside.mirror_ray(inward, false).direction, inward);
        assert_eq!(beside.mirror_ray(inward, true).direction, Y);
    }

    #[test]
    fn a_light_is_not_behind_the_object_that_it_touches() {
        let origin = Vector3::new(1e6, 0.0, 0.0);
        assert!(shadow_t_max(origin, 1.0) < 1.0);
        assert!(shadow_t_max(origin, 1.0) > 1.0 - 1e6 * 100.0 * UNIT_ROUNDOFF);
        assert_eq!(shadow_t_max(origin, Real::INFINITY), Real::INFINITY);
    }
}
