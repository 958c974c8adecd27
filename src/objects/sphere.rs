//! [`Sphere`].

use super::surface_point::{NearestPoint, across};
use super::{Aabb, Ray, Surface};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3, exponent, scaled};

/// The points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub center: Vector3,
    /// Above zero.
    pub radius: Real,
}

/// Roundings of a surface point, in units of the radius r. The unit vector from the centre is too long or short by at
/// most 5 u (three squares, their sum, root, division); the product with r has 1 u more. A ray that starts there
/// computes f = origin - center (1 u) and |f|^2 - r^2: the squares and their sum have 3 u of r^2, the square of r and
/// the difference 2 u more. That is 7 u of r^2 together, or 3.5 u of r in height. The discriminant, by the point
/// nearest to the centre, has the same. The sum is 5 + 1 + 1 + 3.5 + 3.5.
const SPHERE_ROUNDINGS: Real = 16.0;
/// Roundings in units of the coordinates: the sum of centre and radius, and the sum of point and offset.
const SUM_ROUNDINGS: Real = 2.0;

impl Sphere {
    /// Returns whether the sphere is so small that the rounding of its points, half a unit of the last place in the
    /// coordinates, shows in their direction from the centre: by more than half a level of a picture of normals.
    pub fn is_near_rounding(&self) -> bool {
        /// Levels of a component from -1 to 1 are 2/255 apart.
        const SHOWN: Real = 256.0;
        self.radius < SHOWN * UNIT_ROUNDOFF * self.center.max_abs()
    }
}

impl Surface for Sphere {
    const NORMALIZES: bool = true;

    /// Returns the nearest root t > 0 of |origin + t direction - center|^2 = radius^2.
    ///
    /// The discriminant is computed from the ray's point nearest to the centre, and the second root from the product
    /// of both. So no digits cancel when the sphere is small or far (Haines, Guenther, Akenine-Moeller: Precision
    /// Improvements for Ray/Sphere Intersection, Ray Tracing Gems 2019, chapter 7).
    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> Option<Real> {
        let f = ray.origin - self.center;
        let a = ray.direction.length_squared();
        let b = -f.dot(ray.direction);
        let nearest = f + ray.direction * (b / a);
        let discriminant = self.radius * self.radius - nearest.length_squared();
        // Written so that NaN is a miss.
        if !(discriminant >= 0.0) {
            return None;
        }
        let q = b + (a * discriminant).sqrt().copysign(b);
        let c = f.length_squared() - self.radius * self.radius;
        let (t0, t1) = (c / q, q / a);
        let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        if near > 0.0 {
            Some(near)
        } else if far > 0.0 {
            Some(far)
        } else {
            None
        }
    }

    /// Returns a vector that points outward.
    #[inline(always)]
    fn gradient(&self, point: Vector3) -> Vector3 {
        point - self.center
    }

    fn nearest_point(&self, near: Vector3) -> NearestPoint {
        let normal = self.normal(near);
        let point = self.center + normal * self.radius;
        let error = UNIT_ROUNDOFF * (SPHERE_ROUNDINGS * self.radius + SUM_ROUNDINGS * across(normal, point));
        NearestPoint { point, normal, error }
    }

    fn bounds(&self) -> Option<Aabb> {
        Some(Aabb { min: self.center, max: self.center }.grown(self.radius))
    }
}

/// A sphere, or a transform of one, whose size [is unusual](vecmath::is_unusual), so that products may leave the
/// range of numbers.
#[derive(Clone, Copy, Debug)]
pub struct ExtremeSphere(pub Sphere);

impl Surface for ExtremeSphere {
    const NORMALIZES: bool = true;

    /// Does what [`Sphere::intersect`] does, with radius and direction scaled to about 1 by powers of two.
    fn intersect(&self, ray: &Ray) -> Option<Real> {
        let Sphere { center, radius } = self.0;
        let (size, speed) = (exponent(radius), exponent(ray.direction.max_abs()));
        let unit = Sphere { center: Vector3::ZERO, radius: scaled(radius, -size) };
        let origin = (ray.origin - center).scaled(-size);
        let t = unit.intersect(&Ray { origin, direction: ray.direction.scaled(-speed) })?;
        Some(scaled(t, size - speed)).filter(|t| *t > 0.0)
    }

    fn gradient(&self, point: Vector3) -> Vector3 {
        self.0.gradient(point)
    }

    fn nearest_point(&self, near: Vector3) -> NearestPoint {
        self.0.nearest_point(near)
    }

    fn bounds(&self) -> Option<Aabb> {
        self.0.bounds()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Sphere = Sphere { center: Vector3::ZERO, radius: 1.0 };

    fn ray(origin: [Real; 3], direction: [Real; 3]) -> Ray {
        Ray { origin: origin.into(), direction: direction.into() }
    }

    #[test]
    fn from_outside_the_near_root_is_hit() {
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 5.0], [0.0, 0.0, -1.0])), Some(4.0));
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 5.0], [0.0, 0.0, -2.0])), Some(2.0));
    }

    #[test]
    fn from_inside_the_far_root_is_hit() {
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 0.0], [0.0, 0.5, 0.0])), Some(2.0));
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])), Some(2.0));
    }

    #[test]
    fn spheres_behind_or_beside_are_missed() {
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 5.0], [0.0, 0.0, 1.0])), None);
        assert_eq!(UNIT.intersect(&ray([0.0, 1.5, 5.0], [0.0, 0.0, -1.0])), None);
    }

    #[test]
    fn a_tangent_touches_once() {
        assert_eq!(UNIT.intersect(&ray([0.0, 1.0, 5.0], [0.0, 0.0, -1.0])), Some(5.0));
    }

    #[test]
    fn nan_is_missed() {
        assert_eq!(UNIT.intersect(&ray([Real::NAN, 0.0, 5.0], [0.0, 0.0, -1.0])), None);
    }

    #[test]
    fn normals_point_outward() {
        let sphere = Sphere { center: Vector3::new(1.0, 2.0, 3.0), radius: 2.0 };
        assert_eq!(sphere.normal(Vector3::new(1.0, 4.0, 3.0)), Vector3::new(0.0, 1.0, 0.0));
    }
}
