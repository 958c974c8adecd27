//! [`Mesh`]: the triangles of an OBJ file, smoothly shaded.

use super::triangle::face_normal;
use super::{Aabb, PreparedRay, TriangleHit, triangle_hit};
use crate::accel::TriangleTree;
use crate::accel::simd::Level;
use rayon::prelude::*;
use vecmath::{Real, Vector3};

/// Triangles that share corners by index.
#[derive(Debug)]
pub struct Mesh {
    /// As precise as the OBJ file is read.
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// One a position: unit length, or zero where the faces around it cancel out.
    vertex_normals: Vec<Vector3>,
    bounds: Aabb,
    /// `None` without triangles, and until it is built.
    tree: Option<TriangleTree>,
}

/// Where a ray meets a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    pub triangle: u32,
    pub hit: TriangleHit,
}

/// So many normals of faces are at hand while they are added up, and so many positions are looked at by one thread.
const AT_ONCE: usize = 1 << 16;

impl Mesh {
    /// A mesh of these positions and corner indices, which must be in range. It has no tree yet.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let mut mesh =
            Self { bounds: bounds_of(&positions), vertex_normals: Vec::new(), tree: None, positions, triangles };
        mesh.vertex_normals = mesh.smooth_normals();
        mesh
    }

    /// Builds the tree over the triangles, if there are any.
    pub fn build_tree(&mut self) {
        if !self.triangles.is_empty() {
            self.tree = Some(self.built_tree());
        }
    }

    /// For each position, the sum of the unit normals of its faces as a unit vector. Faces count the same whatever
    /// their area; one without area counts nothing.
    fn smooth_normals(&self) -> Vec<Vector3> {
        let mut sums = vec![Vector3::ZERO; self.positions.len()];
        // Each thread adds up a range of the positions: every sum is made in the order of the file.
        let range = sums.len().div_ceil(rayon::current_num_threads()).max(1);
        let mut normals = Vec::new();
        for (chunk, triangles) in self.triangles.chunks(AT_ONCE).enumerate() {
            let first = (chunk * AT_ONCE) as u32;
            let face_normal = |index| face_normal(self.corners(first + index));
            (0..triangles.len() as u32).into_par_iter().map(face_normal).collect_into_vec(&mut normals);
            sums.par_chunks_mut(range).enumerate().for_each(|(number, sums)| {
                let start = number * range;
                for (corners, normal) in triangles.iter().zip(&normals) {
                    for corner in corners {
                        if let Some(sum) = sums.get_mut((*corner as usize).wrapping_sub(start)) {
                            *sum += *normal;
                        }
                    }
                }
            });
        }
        sums.par_iter_mut().for_each(|sum| *sum = sum.normalized());
        sums
    }

    /// A tree over the triangles.
    pub fn built_tree(&self) -> TriangleTree {
        TriangleTree::build(self.triangles.len(), &self.bounds, |triangle| self.corners(triangle))
    }

    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    pub fn tree(&self) -> Option<&TriangleTree> {
        self.tree.as_ref()
    }

    /// Culls at this processor level from now on.
    pub fn set_level(&mut self, level: Level) {
        if let Some(tree) = &mut self.tree {
            tree.set_level(level);
        }
    }

    /// Bytes on the heap: the mesh, and its tree.
    pub fn bytes(&self) -> (usize, usize) {
        let mesh = size_of_val(self.positions.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.vertex_normals.as_slice());
        (mesh, self.tree.as_ref().map_or(0, TriangleTree::bytes))
    }

    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    pub(super) fn indices(&self) -> std::ops::Range<u32> {
        0..self.triangles.len() as u32
    }

    /// The corners of a triangle, in object space.
    pub fn corners(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|corner| to_vector(self.positions[corner as usize]))
    }

    /// The unit normals of a triangle's corners; zero where the faces around one cancel out.
    #[inline(always)]
    pub(super) fn corner_normals(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|corner| self.vertex_normals[corner as usize])
    }

    /// The unit normal at a hit: the corners' normals, weighted. Where they cancel out, the face's own.
    pub fn normal(&self, triangle: u32, barycentric: [Real; 3]) -> Vector3 {
        let face = || face_normal(self.corners(triangle));
        let mut sum = Vector3::ZERO;
        for (normal, weight) in self.corner_normals(triangle).into_iter().zip(barycentric) {
            sum += weight * if normal == Vector3::ZERO { face() } else { normal };
        }
        sum.try_normalized().unwrap_or_else(face)
    }

    /// The nearest hit with t < `t_max`; of several at the same t, the first triangle's.
    pub fn closest_hit(&self, ray: &PreparedRay, t_max: Real) -> Option<MeshHit> {
        let mut search = MeshSearch { t_max, closest: None };
        match &self.tree {
            None => self.indices().for_each(|triangle| {
                search.ask(self, ray, triangle);
            }),
            Some(tree) => tree.candidates(ray, t_max, |triangle| search.ask(self, ray, triangle)),
        }
        search.closest
    }

    /// Whether anything is hit at a t up to and including `t_max`.
    pub fn any_hit(&self, ray: &PreparedRay, t_max: Real) -> bool {
        let is_hit = |triangle: u32| triangle_hit(ray, self.corners(triangle)).is_some_and(|hit| hit.t <= t_max);
        let Some(tree) = &self.tree else {
            return self.indices().any(is_hit);
        };
        let mut found = false;
        tree.candidates(ray, t_max, |triangle| {
            found |= is_hit(triangle);
            if found { Real::NEG_INFINITY } else { t_max }
        });
        found
    }
}

/// The nearest hit of a ray with a mesh so far.
struct MeshSearch {
    /// Hits count below this t.
    t_max: Real,
    closest: Option<MeshHit>,
}

impl MeshSearch {
    /// Asks a triangle, whatever the order and even twice, and returns the new `t_max`.
    fn ask(&mut self, mesh: &Mesh, ray: &PreparedRay, triangle: u32) -> Real {
        if let Some(hit) = triangle_hit(ray, mesh.corners(triangle)) {
            let comes_first = self.closest.is_some_and(|closest| triangle < closest.triangle);
            if hit.t < self.t_max || (hit.t == self.t_max && comes_first) {
                self.t_max = hit.t;
                self.closest = Some(MeshHit { triangle, hit });
            }
        }
        self.t_max
    }
}

fn bounds_of(positions: &[[f32; 3]]) -> Aabb {
    let parts = positions.par_chunks(AT_ONCE);
    let bounds = parts.map(|part| Aabb::of_points(part.iter().map(|&position| to_vector(position))));
    bounds.reduce(|| Aabb::EMPTY, |a, b| a.union(&b))
}

fn to_vector(position: [f32; 3]) -> Vector3 {
    Vector3::from(position.map(Real::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::{Ray, T_MAX};

    /// A roof: two faces that share an edge along z, one steep, one flat and ten times as large.
    fn roof() -> Mesh {
        let positions =
            vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [10.0, 0.0, 0.0], [0.0, -1.0, 0.0], [5.0, 5.0, 5.0]];
        Mesh::new(positions, vec![[0, 1, 2], [0, 3, 1]])
    }

    #[test]
    fn faces_count_the_same_whatever_their_area() {
        let mesh = roof();
        let half = (0.5 as Real).sqrt();
        let normal = mesh.normal(0, [1.0, 0.0, 0.0]);
        assert!((normal - Vector3::new(-half, half, 0.0)).max_abs() < 4.0 * Real::EPSILON, "{normal:?}");
        assert_eq!(mesh.normal(0, [0.0, 0.0, 1.0]), Vector3::new(0.0, 1.0, 0.0));
    }

    #[test]
    fn sums_of_normals_are_made_in_the_order_of_the_file() {
        let position = |i: u32| [i * 7919 % 1000, i * 104_729 % 1000, i * 31 % 1000].map(|c| c as f32);
        let positions: Vec<_> = (0..1000).map(position).collect();
        let corner = |i: u32| i % 1009 % 1000;
        let triangles: Vec<_> =
            (0..AT_ONCE as u32 + 5).map(|i| [corner(i), corner(3 * i), corner(7 * i + 1)]).collect();
        let mesh = Mesh::new(positions, triangles);
        let mut sums = vec![Vector3::ZERO; 1000];
        for (index, corners) in mesh.triangles.iter().enumerate() {
            for corner in corners {
                sums[*corner as usize] += face_normal(mesh.corners(index as u32));
            }
        }
        assert!(mesh.vertex_normals.iter().zip(sums).all(|(normal, sum)| *normal == sum.normalized()));
    }

    #[test]
    fn where_normals_cancel_the_face_speaks() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 1]]);
        assert_eq!(mesh.normal(0, [0.2, 0.3, 0.5]), Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(mesh.normal(1, [0.2, 0.3, 0.5]), Vector3::new(0.0, 0.0, -1.0));
    }

    #[test]
    fn of_two_equal_triangles_the_first_is_hit() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut mesh = Mesh::new(positions, vec![[0, 1, 2]; 40]);
        mesh.build_tree();
        assert!(mesh.has_tree());
        let origin = Vector3::new(0.2, 0.2, 3.0);
        let ray = PreparedRay::new(Ray { origin, direction: Vector3::new(0.0, 0.0, -1.0) });
        assert_eq!(mesh.closest_hit(&ray, T_MAX).unwrap().triangle, 0);
        assert!(mesh.any_hit(&ray, 3.0));
        assert!(!mesh.any_hit(&ray, 2.9));
    }

    #[test]
    fn an_empty_mesh_is_never_hit() {
        let mesh = Mesh::new(Vec::new(), Vec::new());
        let ray = Ray { origin: Vector3::ZERO, direction: Vector3::new(0.0, 0.0, -1.0) };
        assert!(mesh.closest_hit(&PreparedRay::new(ray), T_MAX).is_none());
    }
}
