//! [`Mesh`]: the triangles of an OBJ file and their smooth normals.

use super::Aabb;
use super::triangle::face_normal;
use rayon::prelude::*;
use vecmath::{Real, Vector3};

/// Triangles that share corners by index.
#[derive(Debug)]
pub struct Mesh {
    /// `f32`, because OBJ files are read as `f32`.
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// For each position a unit vector, or zero where the normals of the faces around it cancel out. Empty if no picture
    /// shows them.
    vertex_normals: Vec<Vector3>,
    bounds: Aabb,
}

/// Face normals are computed and added up in batches of this size, so that few are in memory at once.
const AT_ONCE: usize = 1 << 16;
/// So many triangles are left out at once where none of them has a corner in a range of positions.
const BLOCK: usize = 1 << 8;

impl Mesh {
    /// Makes a mesh of positions and corner indices, which must be in range.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self::without_normals(positions, triangles).with_normals()
    }

    /// Makes a mesh that can be hit, and has no normals.
    pub fn without_normals(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let bounds = bounds_of(&positions);
        Self { positions, triangles, vertex_normals: Vec::new(), bounds }
    }

    /// Returns the mesh with its smooth normals.
    #[must_use]
    pub fn with_normals(mut self) -> Self {
        self.vertex_normals = self.smooth_normals();
        self
    }

    /// Returns for each position the sum of the unit normals of its faces, normalised. All faces count the same,
    /// whatever their area; a face without area does not count.
    fn smooth_normals(&self) -> Vec<Vector3> {
        let mut sums = vec![Vector3::ZERO; self.positions.len()];
        // Each thread adds up a range of positions. So every sum is made in the order of the file, on any number of
        // threads.
        let range = sums.len().div_ceil(rayon::current_num_threads()).max(1);
        let mut normals = Vec::new();
        for (chunk, triangles) in self.triangles.chunks(AT_ONCE).enumerate() {
            let first = (chunk * AT_ONCE) as u32;
            let face_normal = |index| face_normal(self.corners(first + index));
            (0..triangles.len() as u32).into_par_iter().map(face_normal).collect_into_vec(&mut normals);
            // With many threads each would read all corners, nearly all of them in vain.
            let touched: Vec<u64> = triangles.par_chunks(BLOCK).map(|block| ranges_of(block, range)).collect();
            sums.par_chunks_mut(range).enumerate().for_each(|(number, sums)| {
                let start = number * range;
                let blocks = triangles.chunks(BLOCK).zip(normals.chunks(BLOCK)).zip(&touched);
                let touching = blocks.filter(|(_, touched)| *touched >> (number % 64) & 1 == 1);
                touching.for_each(|((triangles, normals), _)| add_normals(sums, start, triangles, normals));
            });
        }
        sums.par_iter_mut().for_each(|sum| *sum = sum.normalized());
        sums
    }

    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns the mesh's bytes on the heap.
    pub fn bytes(&self) -> usize {
        size_of_val(self.positions.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.vertex_normals.as_slice())
    }

    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Returns the corners of a triangle, in object space.
    pub fn corners(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|corner| to_vector(self.positions[corner as usize]))
    }

    /// Returns the smooth unit normals at a triangle's corners; zero where the faces around a corner cancel out.
    #[inline(always)]
    pub(crate) fn corner_normals(&self, triangle: u32) -> [Vector3; 3] {
        self.triangles[triangle as usize].map(|corner| self.vertex_normals[corner as usize])
    }

    /// Returns the smooth unit normal at a hit: the corners' normals, interpolated. Where they cancel out, it is the
    /// normal of the face.
    pub fn normal(&self, triangle: u32, barycentric: [Real; 3]) -> Vector3 {
        let face = || face_normal(self.corners(triangle));
        let mut sum = Vector3::ZERO;
        for (normal, weight) in self.corner_normals(triangle).into_iter().zip(barycentric) {
            sum += weight * if normal == Vector3::ZERO { face() } else { normal };
        }
        sum.try_normalized().unwrap_or_else(face)
    }
}

/// Adds the normals of faces to the sums of their corners, as far as these lie in the range that begins at `start`.
fn add_normals(sums: &mut [Vector3], start: usize, triangles: &[[u32; 3]], normals: &[Vector3]) {
    for (corners, normal) in triangles.iter().zip(normals) {
        for corner in corners {
            if let Some(sum) = sums.get_mut((*corner as usize).wrapping_sub(start)) {
                *sum += *normal;
            }
        }
    }
}

/// Returns which ranges of so many positions the corners of triangles lie in: bit n for the ranges n, n + 64, n + 128 ...
fn ranges_of(triangles: &[[u32; 3]], range: usize) -> u64 {
    triangles.as_flattened().iter().fold(0, |bits, corner| bits | 1 << (*corner as usize / range % 64))
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

    /// Makes a roof: two faces that share an edge along z, one steep, one flat and ten times as large.
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
        let scattered = |i: u32| [corner(i), corner(3 * i), corner(7 * i + 1)];
        // Most threads find nothing in most blocks.
        let local = |i: u32| [i / 80, i / 80 + 90, 999 - i / 80];
        for triangle in [&scattered as &dyn Fn(u32) -> [u32; 3], &local] {
            let triangles = (0..AT_ONCE as u32 + 5).map(triangle).collect();
            let mesh = Mesh::without_normals(positions.clone(), triangles);
            let mut sums = vec![Vector3::ZERO; 1000];
            for (index, corners) in mesh.triangles.iter().enumerate() {
                for corner in corners {
                    sums[*corner as usize] += face_normal(mesh.corners(index as u32));
                }
            }
            let expected: Vec<Vector3> = sums.into_iter().map(|sum| sum.normalized()).collect();
            for threads in [1, 3, 70] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert!(pool.install(|| mesh.smooth_normals()) == expected, "{threads}");
            }
        }
    }

    #[test]
    fn where_smooth_normals_cancel_the_normal_is_the_face_s() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 1]]);
        assert_eq!(mesh.normal(0, [0.2, 0.3, 0.5]), Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(mesh.normal(1, [0.2, 0.3, 0.5]), Vector3::new(0.0, 0.0, -1.0));
    }
}
