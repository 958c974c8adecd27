//! [`Triangle`], and the one test that decides whether a ray hits a triangle: of a scene or of a mesh.

use super::{Aabb, PreparedRay, ShearedRay};
use crate::render::robust::ROUNDING;
use vecmath::{Real, Vector3};

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    pub t: Real,
    /// Weights of the three corners; they sum to 1.
    pub barycentric: [Real; 3],
}

/// The hit of a ray with the triangle of three corners, both sides counting, edges and corners included.
///
/// Watertight (Woop, Benthin, Wald, JCGT 2013): the ray is laid along the z axis, and a corner lands on the same point
/// for every triangle that has it. The sign of an edge function is then exact or the function is zero, because
/// rounding keeps the order of the two products; swapping an edge's ends swaps the sign and nothing else. So of two
/// triangles that share an edge at least one is hit by a ray between them.
///
/// The ray must also meet the triangle's bounding box, and t lies inside it. For a triangle seen edge-on all three
/// functions are nothing but rounding: the ray may lie in its plane and pass beside it, and the division has no
/// digits. What the box says would otherwise depend on whether a search asks for the box.
pub fn triangle_hit(ray: &PreparedRay, corners: [Vector3; 3]) -> Option<TriangleHit> {
    let sheared = ShearedRay::new(ray);
    let [a, b, c] = corners.map(|corner| sheared.apply(corner - ray.ray.origin));
    let u = c.x * b.y - c.y * b.x;
    let v = a.x * c.y - a.y * c.x;
    let w = b.x * a.y - b.y * a.x;
    let same_side = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let determinant = u + v + w;
    // NaN fails the first condition.
    if !same_side || determinant == 0.0 {
        return None;
    }
    let barycentric = [u / determinant, v / determinant, w / determinant];
    let t = barycentric[0] * a.z + barycentric[1] * b.z + barycentric[2] * c.z;
    let (near, far) = box_interval(ray, corners)?;
    let t = t.min(far).max(near);
    (t > 0.0).then_some(TriangleHit { t, barycentric })
}

/// Of the coordinates: moving a corner to the ray's origin and shearing it has 6 u of either.
const BOX_ROUNDINGS: Real = 32.0;

/// Where the line of the ray enters and leaves the box of three points, if it meets it. Near an edge of the box it may
/// leave, by rounding, before it enters.
fn box_interval(ray: &PreparedRay, corners: [Vector3; 3]) -> Option<(Real, Real)> {
    let [a, b, c] = corners;
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let interval = |margin: Real| {
        let (mut near, mut far) = (Real::NEG_INFINITY, Real::INFINITY);
        for axis in 0..3 {
            let inverse = ray.inverse_direction[axis];
            let low = (min[axis] - ray.ray.origin[axis] - margin) * inverse;
            let high = (max[axis] - ray.ray.origin[axis] + margin) * inverse;
            let (enter, leave) = if inverse >= 0.0 { (low, high) } else { (high, low) };
            // `max` and `min` pass over NaN: a ray in the plane of a face.
            near = near.max(enter);
            far = far.min(leave);
        }
        (near, far)
    };
    let (near, far) = interval(0.0);
    let meets = near <= far || {
        let (near, far) =
            interval(BOX_ROUNDINGS * ROUNDING * ray.ray.origin.max_abs().max(min.max_abs()).max(max.max_abs()));
        near <= far
    };
    meets.then_some((near, far))
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

    pub fn hit(&self, ray: &PreparedRay) -> Option<TriangleHit> {
        triangle_hit(ray, self.corners)
    }

    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(self.corners)
    }
}

/// cross(v1 - v0, v2 - v0) as a unit vector, or zero where that has no direction.
pub fn face_normal([v0, v1, v2]: [Vector3; 3]) -> Vector3 {
    (v1 - v0).cross(v2 - v0).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::Ray;

    const CORNERS: [Vector3; 3] =
        [Vector3::new(0.0, 0.0, 0.0), Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];

    fn hit(origin: [Real; 3], direction: [Real; 3]) -> Option<TriangleHit> {
        let ray = Ray { origin: origin.into(), direction: direction.into() };
        triangle_hit(&PreparedRay::new(ray), CORNERS)
    }

    #[test]
    fn both_sides_count_and_weights_belong_to_corners() {
        for (z, direction) in [(2.0, -1.0), (-2.0, 1.0)] {
            let hit = hit([0.25, 0.5, z], [0.0, 0.0, direction]).unwrap();
            assert_eq!(hit.t, 2.0);
            assert_eq!(hit.barycentric, [0.25, 0.25, 0.5]);
        }
    }

    #[test]
    fn t_counts_lengths_of_the_direction() {
        assert_eq!(hit([0.25, 0.5, 2.0], [0.0, 0.0, -4.0]).unwrap().t, 0.5);
    }

    #[test]
    fn beside_behind_and_in_the_plane_are_missed() {
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
