//! [`Triangle`], and the one test that decides whether a ray hits a triangle: of a scene or of a mesh.

use super::ray::{Shear, ShearAxes};
use super::run::{Numbers, PreparedRun, RUN, RayRun, around};
use super::{Aabb, PreparedRay};
use crate::render::robust::ROUNDING;
use vecmath::{Real, Vector3, greater, lesser, swapped_if};

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
    let axes = ShearAxes::of(ray.ray.direction);
    let line = [ray.ray.origin, ray.ray.direction, ray.inverse_direction].map(|vector| axes.order(vector));
    let crossing = Crossing::of(line, corners.map(|corner| axes.order(corner)));
    // NaN is not inside.
    if !crossing.is_inside {
        return None;
    }
    let (near, far) = box_interval(ray, corners, 0.0);
    let hit = crossing.hit(near, far);
    ((near <= far || grazes_box(ray, corners)) && hit.t > 0.0).then_some(hit)
}

/// The line of a ray, and a triangle. Without branches, for many rays at once.
struct Crossing {
    is_inside: bool,
    /// Of the three corners.
    edge_functions: [Real; 3],
    depths: [Real; 3],
}

impl Crossing {
    /// Everything in the order of the ray's [`ShearAxes`].
    #[inline(always)]
    fn of([origin, direction, inverse_direction]: [Vector3; 3], [a, b, c]: [Vector3; 3]) -> Self {
        let shear = Shear::new(direction, inverse_direction);
        let (a, b, c) = (shear.apply(a - origin), shear.apply(b - origin), shear.apply(c - origin));
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let same_side = ((u >= 0.0) & (v >= 0.0) & (w >= 0.0)) | ((u <= 0.0) & (v <= 0.0) & (w <= 0.0));
        Self { is_inside: same_side & (u + v + w != 0.0), edge_functions: [u, v, w], depths: [a.z, b.z, c.z] }
    }

    /// The hit, if it is one, between the places where the line enters and leaves the triangle's box.
    #[inline(always)]
    fn hit(&self, near: Real, far: Real) -> TriangleHit {
        let ([u, v, w], [a, b, c]) = (self.edge_functions, self.depths);
        let determinant = u + v + w;
        let barycentric = [u / determinant, v / determinant, w / determinant];
        let t = barycentric[0] * a + barycentric[1] * b + barycentric[2] * c;
        TriangleHit { t: greater(near, lesser(far, t)), barycentric }
    }
}

/// Of the coordinates: moving a corner to the ray's origin and shearing it has 6 u of either.
const BOX_ROUNDINGS: Real = 32.0;

/// Where the line of the ray enters and leaves the box of three points, grown by `margin`. Near an edge of the box it
/// may leave, by rounding, before it enters.
#[inline(always)]
fn box_interval(ray: &PreparedRay, [a, b, c]: [Vector3; 3], margin: Real) -> (Real, Real) {
    let (mut near, mut far) = (Real::NEG_INFINITY, Real::INFINITY);
    for axis in 0..3 {
        let inverse = ray.inverse_direction[axis];
        let min = lesser(lesser(a[axis], b[axis]), c[axis]);
        let max = greater(greater(a[axis], b[axis]), c[axis]);
        let low = (min - ray.ray.origin[axis] - margin) * inverse;
        let high = (max - ray.ray.origin[axis] + margin) * inverse;
        let (enter, leave) = swapped_if(inverse < 0.0, low, high);
        // NaN is passed over: a ray in the plane of a face.
        near = greater(near, enter);
        far = lesser(far, leave);
    }
    (near, far)
}

/// Whether the line of the ray meets the box of three points when rounding is allowed for.
#[cold]
fn grazes_box(ray: &PreparedRay, corners: [Vector3; 3]) -> bool {
    let reach = corners.iter().fold(ray.ray.origin.max_abs(), |reach, corner| reach.max(corner.max_abs()));
    let (near, far) = box_interval(ray, corners, BOX_ROUNDINGS * ROUNDING * reach);
    near <= far
}

/// What many rays hit of one triangle.
pub struct TriangleHits {
    pub t: Numbers,
    pub barycentric: [Numbers; 3],
    /// 1: a hit, 0: none, -1: to be asked by itself.
    pub verdict: Numbers,
}

impl TriangleHits {
    pub const NONE: Self = Self { t: [0.0; RUN], barycentric: [[0.0; RUN]; 3], verdict: [0.0; RUN] };

    /// [`triangle_hit`] of the rays of a mask, which have these axes.
    #[inline(always)]
    pub fn find(&mut self, axes: &ShearAxes, rays: &PreparedRun, mask: u64, corners: [Vector3; 3]) {
        let ordered = corners.map(|corner| axes.order(corner));
        let PreparedRun { rays: RayRun { origin, direction }, inverse_direction } = *rays;
        for number in around(mask) {
            let line = [origin, direction, inverse_direction];
            let line = [axes.pick(line[0], number), axes.pick(line[1], number), axes.pick(line[2], number)];
            let crossing = Crossing::of(line, ordered);
            let (near, far) = box_interval(&rays.get(number), corners, 0.0);
            let hit = crossing.hit(near, far);
            self.t[number] = hit.t;
            for corner in 0..3 {
                self.barycentric[corner][number] = hit.barycentric[corner];
            }
            let verdict = if hit.t > 0.0 { 1.0 } else { 0.0 };
            let verdict = if near <= far { verdict } else { -1.0 };
            self.verdict[number] = if crossing.is_inside { verdict } else { 0.0 };
        }
    }
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
