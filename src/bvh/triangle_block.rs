//! [`TriangleBlock`]: eight triangles that are culled at once in `f32`. The exact test in `Real` decides for the
//! rest.
//!
//! # The error bounds
//!
//! Let o + t d be a ray and a, a + e1, a + e2 a triangle, with C = a - o, N = e1 x e2 and R = C x d. The ray meets
//! the triangle's plane in a + (U e1 + V e2)/D at t = T/D with (Moeller, Trumbore: Fast, Minimum Storage Ray/Triangle
//! Intersection, 1997)
//!
//! ```text
//! D = d.N    U = e2.R    V = -e1.R    W = D - U - V    T = C.N
//! ```
//!
//! and that point lies in the triangle if U, V and W have one sign. In [`CullingSpace`], let e = 2^-24 and let h be
//! the largest component of e1 and e2, which are differences of exact numbers (error e h). With |C| <= 2 + 2^-15 on
//! each axis, the errors add up as follows; the errors of the exact test, bounded by e in each coordinate, are
//! included.
//!
//! - C: 1 e for a, 3 e for o, 2 e for the difference: 6 e;
//! - R: 2 (6 e |d| + 2 e |C|) + 3 roundings of at most 4: below 32 e;
//! - U, V: 3 h (32 e + |R| e with |R| <= 4) + 3 roundings of at most 12 h: below 144 e h;
//! - N: 2 (2 e h^2) + 3 roundings of 2 h^2: below 10 e h^2; D: 3 (10 + 2) e h^2 + 3 roundings of 6 h^2: below
//!   54 e h^2 <= 108 e h, because h <= 2;
//! - W: 144 + 144 + 108 and two roundings of 30 h: below 460 e h;
//! - T: 3 (6 e 2 h^2 + 2 * 10 e h^2) + 3 roundings of 12 h^2: below 132 e h^2. The comparison with t D, t <= 4, adds
//!   350 e h^2. If |D| is within its error, its sign means nothing: then a true hit has
//!   |T| <= 4 * 54 e h^2 + 132 e h^2.
//!
//! [`SIDE_MARGIN`] is 1024 e, [`DISTANCE_MARGIN`] 1024 e. The t of the exact test is clamped to the triangle's box,
//! which moves it towards the true t and not beyond.

use super::build::{self, Item};
use super::node::Bvh;
use super::prefetch::prefetch_lines;
use super::space::{BOX_MARGIN, CullingSpace};
use crate::objects::Aabb;
use crate::simd::{Eight, Simd, WIDTH, bits_of, f32x8, flip_sign, load, load3, splat, splat3};
use fearless_simd::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use vecmath::Vector3;

/// Share of h by which U, V and W may lie on the wrong side.
const SIDE_MARGIN: f32 = 1.0 / (1 << 14) as f32;
/// Share of h^2 by which T may lie outside the range.
const DISTANCE_MARGIN: f32 = 1.0 / (1 << 14) as f32;

/// Up to eight triangles, in 352 bytes:
///
/// | bytes | what |
/// |---|---|
/// | 0..96 | x of the eight first corners, then y, z: scaled as in culling space, but not translated |
/// | 96..192 | the second corners |
/// | 192..288 | the third corners |
/// | 288..320 | the triangles' indices in the mesh |
/// | 320..328 | h times [`SIDE_MARGIN`], h^2 times [`DISTANCE_MARGIN`] for the largest h of the block |
/// | 328..333 | the number of triangles, and whether scaling has kept their corners exact |
/// | 333..352 | unused |
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    corners: [[Eight; 3]; 3],
    indices: [u32; WIDTH],
    side_margin: f32,
    distance_margin: f32,
    count: u32,
    is_exact: bool,
}

/// Builds a tree over triangles 0 to `count`, which lie in `bounds`. The coordinates of their corners must be numbers
/// of `f32`. Returns `None` if there are no triangles or a coordinate is not finite: then every triangle must be
/// tested.
pub fn build_triangle_bvh(
    bounds: &Aabb,
    count: usize,
    corners: impl Fn(u32) -> [Vector3; 3] + Sync,
) -> Option<Bvh<TriangleBlock>> {
    let space = CullingSpace::of_positions(*bounds).filter(|_| count > 0)?;
    let all_finite = AtomicBool::new(true);
    let item = |index| {
        let corners = corners(index);
        if !corners.iter().all(|corner| corner.is_finite()) {
            all_finite.store(false, Ordering::Relaxed);
        }
        Item::new(index, &space.planes(&Aabb::of_points(corners)))
    };
    let items: Vec<Item> = (0..count as u32).into_par_iter().map(item).collect();
    if !all_finite.into_inner() {
        return None;
    }
    let block = |indices: &[u32]| TriangleBlock::new(&space, indices, &corners);
    Some(build::build::<WIDTH, _>(space.clone(), items, block))
}

impl TriangleBlock {
    /// Returns the number of triangles.
    pub fn count(&self) -> u32 {
        self.count
    }

    fn new(space: &CullingSpace, indices: &[u32], corners: &impl Fn(u32) -> [Vector3; 3]) -> Self {
        let mut block = Self {
            corners: [[[0.0; WIDTH]; 3]; 3],
            indices: [0; WIDTH],
            side_margin: 0.0,
            distance_margin: 0.0,
            count: 0,
            is_exact: true,
        };
        let mut longest = 0.0f32;
        for (place, &index) in indices.iter().take(WIDTH).enumerate() {
            let exact = corners(index);
            let scaled = exact.map(|corner| space.scaled(corner));
            block.is_exact &= scaled.map(|corner| space.unscaled(corner)) == exact;
            for (lanes, corner) in block.corners.iter_mut().zip(scaled) {
                for axis in 0..3 {
                    lanes[axis][place] = corner[axis];
                    longest = longest.max((corner[axis] - scaled[0][axis]).abs());
                }
            }
            block.indices[place] = index;
            block.count += 1;
        }
        // Products below the range of `f32` would become zero, and the margins with them.
        let longest = longest.max(1e-15);
        block.side_margin = longest * SIDE_MARGIN;
        block.distance_margin = longest * longest * DISTANCE_MARGIN;
        block
    }

    /// Returns the triangles' indices in the mesh.
    pub fn indices(&self) -> &[u32] {
        &self.indices[..self.count as usize]
    }

    /// Returns a triangle's index in the mesh.
    #[inline(always)]
    pub fn index(&self, place: u32) -> u32 {
        self.indices[place as usize % WIDTH]
    }

    /// Returns a triangle's exact corners; `None` if the block has rounded them.
    #[inline(always)]
    pub fn exact_corners(&self, space: &CullingSpace, place: u32) -> Option<[Vector3; 3]> {
        let place = place as usize % WIDTH;
        let [a, b, c] = &self.corners;
        let corner = |corner: &[Eight; 3]| space.unscaled([corner[0][place], corner[1][place], corner[2][place]]);
        self.is_exact.then(|| [corner(a), corner(b), corner(c)])
    }

    /// Culls all triangles for one ray (origin and direction in all lanes). Bit i of the result is 0 only if the ray
    /// certainly does not hit triangle i at a t from 0 to `limit`. `center` is [`CullingSpace::scaled_center`].
    #[inline(always)]
    pub fn candidates<S: Simd>(&self, simd: S, center: [f32; 3], ray: [[f32x8<S>; 3]; 2], limit: f32) -> u32 {
        let [a, b, c] = &self.corners;
        let triangles = corner_and_edges(simd, center, [load3(simd, a), load3(simd, b), load3(simd, c)]);
        self.may_hit(simd, triangles, ray, splat(simd, limit)) & self.all()
    }

    /// Copies one corner and two edges of a triangle into all lanes, for [`may_hit`](Self::may_hit).
    #[inline(always)]
    pub fn splat_triangle<S: Simd>(&self, simd: S, center: [f32; 3], place: u32) -> [[f32x8<S>; 3]; 3] {
        let place = place as usize % WIDTH;
        let [a, b, c] = &self.corners;
        let corner = |corner: &[Eight; 3]| splat3(simd, [corner[0][place], corner[1][place], corner[2][place]]);
        corner_and_edges(simd, center, [corner(a), corner(b), corner(c)])
    }

    /// Culls one triangle (corner and edges) for one ray (origin and direction) and its limit in each lane.
    #[inline(always)]
    pub fn may_hit<S: Simd>(
        &self,
        simd: S,
        [a, e1, e2]: [[f32x8<S>; 3]; 3],
        [o, d]: [[f32x8<S>; 3]; 2],
        limit: f32x8<S>,
    ) -> u32 {
        let c = difference(a, o);
        let r = cross(c, d);
        let n = cross(e1, e2);
        let (det, u, minus_v, t) = (dot(d, n), dot(e2, r), dot(e1, r), dot(c, n));
        let w = det - u + minus_v;
        let v = -minus_v;
        let margin = splat(simd, self.side_margin);
        let one_side = (-margin).simd_le(u.min(v).min(w)) | u.max(v).max(w).simd_le(margin);
        let t = flip_sign(simd, t, det);
        let margin = splat(simd, self.distance_margin);
        let farthest = det.abs().mul_add(limit, margin);
        let in_range = (-margin).simd_le(t) & t.simd_le(farthest);
        bits_of(one_side & in_range)
    }

    /// Returns the boxes around the triangles, three lower and three upper planes, margin included.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S, center: [f32; 3]) -> [f32x8<S>; 6] {
        let mut planes = [splat(simd, 0.0); 6];
        for axis in 0..3 {
            let [a, b, c] = &self.corners;
            let (a, b, c) = (load(simd, &a[axis]), load(simd, &b[axis]), load(simd, &c[axis]));
            planes[axis] = a.min(b).min(c) - center[axis] - BOX_MARGIN;
            planes[axis + 3] = a.max(b).max(c) - center[axis] + BOX_MARGIN;
        }
        planes
    }

    /// Prefetches the block.
    #[inline(always)]
    pub fn prefetch(&self) {
        prefetch_lines(self.corners.as_flattened());
        prefetch_lines(&self.indices);
    }

    /// Returns a mask of all triangles.
    #[inline(always)]
    pub fn all(&self) -> u32 {
        (1 << self.count) - 1
    }
}

/// Translates triangles to culling space, and returns one corner and two edges of each.
#[inline(always)]
fn corner_and_edges<S: Simd>(simd: S, center: [f32; 3], [a, b, c]: [[f32x8<S>; 3]; 3]) -> [[f32x8<S>; 3]; 3] {
    [difference(a, splat3(simd, center)), difference(b, a), difference(c, a)]
}

#[inline(always)]
fn difference<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
fn cross<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}
