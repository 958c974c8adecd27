//! [`Triangle`], and the exact test of a ray against a triangle, which single triangles and meshes share.

use super::surface_point::{NearestPoint, across};
use super::{Aabb, PreparedRay, SurfaceHit};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3, greater, lesser, swapped_if};

/// Intersects a ray with a triangle. Both sides can be hit; edges and corners belong to the triangle.
///
/// The test is watertight (Woop, Benthin, Wald: Watertight Ray/Triangle Intersection, JCGT 2013). It translates and
/// shears space so that the ray becomes the z axis. A corner gets the same coordinates in every triangle that has it.
/// The sign of an edge function is exact, or the function is zero, because rounding keeps the order of its two
/// products. Swapping the ends of an edge swaps the sign and changes nothing else. So a ray between two triangles
/// that share an edge hits at least one of them.
///
/// The ray must also meet the triangle's bounding box, and t is clamped to it. For a triangle seen edge-on, all three
/// edge functions are nothing but rounding, and t has no correct digit: the ray may lie in the triangle's plane and
/// pass beside it. Without this rule the hit would depend on whether a tree has tested the box before.
pub fn intersect_triangle(ray: &PreparedRay, corners: [Vector3; 3]) -> Option<SurfaceHit> {
    let axes = ShearAxes::of(ray.ray.direction);
    let line = [ray.ray.origin, ray.ray.direction, ray.inverse_direction].map(|vector| axes.order(vector));
    let crossing = Crossing::of(line, corners.map(|corner| axes.order(corner)));
    // NaN is not inside.
    if !crossing.is_inside {
        return None;
    }
    let (near, far) = box_interval(ray, corners, 0.0, swapped_if);
    let hit = crossing.hit(near, far);
    ((near <= far || grazes_box(ray, corners)) && hit.t > 0.0).then_some(hit)
}

/// The order of axes in which a ray is sheared: `z` is the axis of its largest component, x and y follow cyclically.
///
/// The paper swaps x and y for a negative direction to keep the winding. Here both sides can be hit, so there is no
/// need.
#[derive(Clone, Copy, Debug)]
pub struct ShearAxes {
    pub x: usize,
    pub y: usize,
    pub z: usize,
}

impl ShearAxes {
    #[inline(always)]
    pub fn of(direction: Vector3) -> Self {
        let [x, y, z] = direction.map(Real::abs).to_array();
        Self::along(if (x >= y) & (x >= z) {
            0
        } else if y >= z {
            1
        } else {
            2
        })
    }

    #[inline(always)]
    pub fn along(z: usize) -> Self {
        Self { x: (z + 1) % 3, y: (z + 2) % 3, z: z % 3 }
    }

    /// Returns a vector's components in the order of these axes.
    #[inline(always)]
    pub fn order(&self, vector: Vector3) -> Vector3 {
        let components = vector.to_array();
        Vector3::new(components[self.x], components[self.y], components[self.z])
    }
}

/// The edge functions of a triangle for a ray's line. They are computed without branches, so that loops over rays
/// vectorise.
pub struct Crossing {
    pub is_inside: bool,
    edge_functions: [Real; 3],
    /// t of the three corners.
    depths: [Real; 3],
}

impl Crossing {
    /// Computes the edge functions. All vectors have their components in the order of the ray's [`ShearAxes`].
    #[inline(always)]
    pub fn of([origin, direction, inverse_direction]: [Vector3; 3], [a, b, c]: [Vector3; 3]) -> Self {
        // The shear lays the ray along the z axis of its axes; z is then t.
        let factors = Vector3::new(direction.x / direction.z, direction.y / direction.z, inverse_direction.z);
        let sheared = |corner: Vector3| {
            let offset = corner - origin;
            let (f, z) = (factors, offset.z);
            Vector3::new(offset.x - f.x * z, offset.y - f.y * z, f.z * z)
        };
        let (a, b, c) = (sheared(a), sheared(b), sheared(c));
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let same_side = ((u >= 0.0) & (v >= 0.0) & (w >= 0.0)) | ((u <= 0.0) & (v <= 0.0) & (w <= 0.0));
        Self { is_inside: same_side & (u + v + w != 0.0), edge_functions: [u, v, w], depths: [a.z, b.z, c.z] }
    }

    /// Returns the hit; use it only if `is_inside`. t is clamped to `near` and `far`, where the line enters and
    /// leaves the box.
    #[inline(always)]
    pub fn hit(&self, near: Real, far: Real) -> SurfaceHit {
        let ([u, v, w], [a, b, c]) = (self.edge_functions, self.depths);
        let determinant = u + v + w;
        let barycentric = [u / determinant, v / determinant, w / determinant];
        let t = barycentric[0] * a + barycentric[1] * b + barycentric[2] * c;
        SurfaceHit { t: greater(near, lesser(far, t)), triangle: 0, barycentric }
    }
}

/// Roundings in units of the coordinates, with a wide margin: 6 u for translating a corner to the ray's origin and
/// shearing it.
const BOX_ROUNDINGS: Real = 32.0;

/// Returns the t at which the ray's line enters and leaves the box around three points, grown by `margin`. Near an edge
/// of the box, rounding may put the exit before the entry. `swapped_if` swaps two numbers if its first argument is true.
#[inline(always)]
pub fn box_interval(
    ray: &PreparedRay,
    [a, b, c]: [Vector3; 3],
    margin: Real,
    swapped_if: impl Fn(bool, Real, Real) -> (Real, Real),
) -> (Real, Real) {
    let (mut near, mut far) = (Real::NEG_INFINITY, Real::INFINITY);
    for axis in 0..3 {
        let inverse = ray.inverse_direction[axis];
        let min = lesser(lesser(a[axis], b[axis]), c[axis]);
        let max = greater(greater(a[axis], b[axis]), c[axis]);
        let low = (min - ray.ray.origin[axis] - margin) * inverse;
        let high = (max - ray.ray.origin[axis] + margin) * inverse;
        let (enter, leave) = swapped_if(inverse < 0.0, low, high);
        // NaN, of a ray in the plane of a face, changes nothing here.
        near = greater(near, enter);
        far = lesser(far, leave);
    }
    (near, far)
}

/// Returns whether the ray's line meets the box around three points, grown by an error bound.
#[cold]
fn grazes_box(ray: &PreparedRay, corners: [Vector3; 3]) -> bool {
    let reach = corners.iter().fold(ray.ray.origin.max_abs(), |reach, corner| reach.max(corner.max_abs()));
    let (near, far) = box_interval(ray, corners, BOX_ROUNDINGS * UNIT_ROUNDOFF * reach, swapped_if);
    near <= far
}

/// A triangle of the scene file, with a flat normal.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub corners: [Vector3; 3],
    /// Unit vector; zero for a triangle without area.
    pub normal: Vector3,
}

impl Triangle {
    pub fn new(corners: [Vector3; 3]) -> Self {
        Self { corners, normal: face_normal(corners) }
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<SurfaceHit> {
        intersect_triangle(ray, self.corners)
    }

    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(self.corners)
    }
}

/// Roundings in units of |n| . |corners|: the weights have sum 1 within 3 u (two sums, one division), products and
/// sums of corners have 3 u, the sum of point and offset 2 u.
const CORNER_ROUNDINGS: Real = 8.0;
/// Roundings in units of l^3 / A, with l the longest edge and A the area. A ray that starts inside the triangle has
/// corners at distances up to l. Translated to its origin and sheared they have 6 u of l. So an edge function, two
/// products of numbers up to 2 l, has 60 u of l^2. Three of them, each times a depth up to l, are divided by 2 A.
const SHAPE_ROUNDINGS: Real = 90.0;
/// Roundings of the depths, in units of l.
const DEPTH_ROUNDINGS: Real = 6.0;
/// Largest l^2 / A that counts. For slivers beyond it the error bound would exceed a hundred thousandth of their
/// length, and rays that start so far off would leak through neighbours.
const LARGEST_SHAPE: Real = (1 << 30) as Real;

/// Returns the point of a triangle with given barycentric coordinates. Their sum is 1, so the point lies in the
/// triangle's plane even where t has no correct digit, as for triangles seen edge-on.
pub(super) fn nearest_point_of_triangle(
    corners: [Vector3; 3],
    barycentric: [Real; 3],
    normal: Vector3,
) -> NearestPoint {
    let [a, b, c] = corners;
    let point = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
    let edges = [b - a, c - b, a - c];
    let longest = edges.into_iter().map(Vector3::length).fold(0.0, Real::max);
    let area = 0.5 * edges[0].cross(edges[2]).length();
    // An area of zero gives infinity or NaN; `min` replaces both.
    let shape = (longest * longest / area).min(LARGEST_SHAPE);
    let corner = a.map(Real::abs).max(b.map(Real::abs)).max(c.map(Real::abs));
    let coordinates = CORNER_ROUNDINGS * across(normal, corner);
    let error = UNIT_ROUNDOFF * (coordinates + (SHAPE_ROUNDINGS * shape + DEPTH_ROUNDINGS) * longest);
    NearestPoint { point, normal, error }
}

/// Returns cross(v1 - v0, v2 - v0) as a unit vector, or zero if that has no direction.
pub fn face_normal([v0, v1, v2]: [Vector3; 3]) -> Vector3 {
    (v1 - v0).cross(v2 - v0).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::Ray;

    const CORNERS: [Vector3; 3] =
        [Vector3::new(0.0, 0.0, 0.0), Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];

    fn hit(origin: [Real; 3], direction: [Real; 3]) -> Option<SurfaceHit> {
        let ray = Ray { origin: origin.into(), direction: direction.into() };
        intersect_triangle(&PreparedRay::new(ray), CORNERS)
    }

    #[test]
    fn both_sides_are_hit_and_weights_belong_to_corners() {
        for (z, direction) in [(2.0, -1.0), (-2.0, 1.0)] {
            let hit = hit([0.25, 0.5, z], [0.0, 0.0, direction]).unwrap();
            assert_eq!(hit.t, 2.0);
            assert_eq!(hit.barycentric, [0.25, 0.25, 0.5]);
        }
    }

    #[test]
    fn t_is_in_units_of_the_direction_s_length() {
        assert_eq!(hit([0.25, 0.5, 2.0], [0.0, 0.0, -4.0]).unwrap().t, 0.5);
    }

    #[test]
    fn rays_beside_behind_and_in_the_plane_miss() {
        assert_eq!(hit([0.75, 0.5, 2.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit([0.25, 0.5, 2.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(hit([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([Real::NAN, 0.25, 1.0], [0.0, 0.0, -1.0]), None);
    }

    #[test]
    fn edges_and_corners_belong_to_the_triangle() {
        for origin in [[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.0, 0.5, 1.0], [0.5, 0.5, 1.0], [1.0, 0.0, 1.0]] {
            assert!(hit(origin, [0.0, 0.0, -1.0]).is_some(), "{origin:?}");
        }
    }

    #[test]
    fn flat_normals_follow_the_winding() {
        assert_eq!(Triangle::new(CORNERS).normal, Vector3::new(0.0, 0.0, 1.0));
        let [a, b, c] = CORNERS;
        assert_eq!(Triangle::new([a, c, b]).normal, Vector3::new(0.0, 0.0, -1.0));
        assert_eq!(Triangle::new([a, b, b]).normal, Vector3::ZERO);
    }
}
