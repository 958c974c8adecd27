//! [`Block`]: eight triangles that are tested at once, in `f32`, before any of them is decided in `Real`.
//!
//! # Why nothing is lost
//!
//! With a ray o + t d, a triangle a, a + e1, a + e2, C = a - o, N = e1 x e2 and R = C x d, the ray's point of the
//! triangle's plane is a + (U e1 + V e2)/D at t = T/D with (Moeller, Trumbore: Fast, Minimum Storage Ray/Triangle
//! Intersection, 1997)
//!
//! ```text
//! D = d.N    U = e2.R    V = -e1.R    W = D - U - V    T = C.N
//! ```
//!
//! and it lies in the triangle if U, V and W have one sign. In the [`Frame`](super::frame::Frame), let e = 2^-24 and
//! h the largest component of e1 and e2, differences of exact numbers (error e h). With |C| <= 2 + 2^-15 on each axis,
//! errors (also those of the definition, which the frame bounds by e) add up to
//!
//! - C: 1 e for a, 3 e for o, 2 e for the difference: 6 e;
//! - R: 2 (6 e |d| + 2 e |C|) + 3 roundings of at most 4: below 32 e;
//! - U, V: 3 h (32 e + |R| e with |R| <= 4) + 3 roundings of at most 12 h: below 144 e h;
//! - N: 2 (2 e h^2) + 3 roundings of 2 h^2: below 10 e h^2; D: 3 (10 + 2) e h^2 + 3 roundings of 6 h^2: below
//!   54 e h^2 <= 108 e h, because h <= 2;
//! - W: 144 + 144 + 108 and two roundings of 30 h: below 460 e h;
//! - T: 3 (6 e 2 h^2 + 2 * 10 e h^2) + 3 roundings of 12 h^2: below 132 e h^2; compared with t D, t <= 4: 350 e h^2
//!   more; where |D| is within its error its sign means nothing: then |T| <= 4 * 54 e h^2 + 132 e h^2 for a true hit.
//!
//! [`SIDE_MARGIN`] is 1024 e, [`DISTANCE_MARGIN`] 1024 e. The definition's t is never before the entry into the
//! triangle's box, which the exact t is not either.

use super::frame::{BOX_MARGIN, Frame};
use super::simd::{Eight, Lanes, WIDTH};
use vecmath::Vector3;

/// Share of h by which U, V and W may lie on the wrong side.
const SIDE_MARGIN: f32 = 1.0 / (1 << 14) as f32;
/// Share of h^2 by which T may lie outside the range.
const DISTANCE_MARGIN: f32 = 1.0 / (1 << 14) as f32;

/// Up to eight triangles, in 352 bytes:
///
/// | bytes | what |
/// |---|---|
/// | 0..96 | x of the eight first corners, then y, z: in the frame's scale, but from where the mesh has its origin |
/// | 96..192 | the second corners |
/// | 192..288 | the third corners |
/// | 288..320 | the triangles' numbers |
/// | 320..328 | h times [`SIDE_MARGIN`], h^2 times [`DISTANCE_MARGIN`] for the largest h of the block |
/// | 328..332 | how many triangles there are |
/// | 332..352 | unused |
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Block {
    corners: [[Eight; 3]; 3],
    numbers: [u32; WIDTH],
    side_margin: f32,
    distance_margin: f32,
    count: u32,
}

impl Block {
    /// A block of triangles, given by number and corners.
    pub fn new(frame: &Frame, triangles: impl Iterator<Item = (u32, [Vector3; 3])>) -> Self {
        let mut block = Self {
            corners: [[[0.0; WIDTH]; 3]; 3],
            numbers: [0; WIDTH],
            side_margin: 0.0,
            distance_margin: 0.0,
            count: 0,
        };
        let mut longest = 0.0f32;
        for (place, (number, corners)) in triangles.take(WIDTH).enumerate() {
            let corners = corners.map(|corner| frame.scaled(corner));
            for (lanes, corner) in block.corners.iter_mut().zip(corners) {
                for axis in 0..3 {
                    lanes[axis][place] = corner[axis];
                    longest = longest.max((corner[axis] - corners[0][axis]).abs());
                }
            }
            block.numbers[place] = number;
            block.count += 1;
        }
        // Products below the range of `f32` would become zero, and the margins with them.
        let longest = longest.max(1e-15);
        block.side_margin = longest * SIDE_MARGIN;
        block.distance_margin = longest * longest * DISTANCE_MARGIN;
        block
    }

    pub fn numbers(&self) -> &[u32] {
        &self.numbers[..self.count as usize]
    }

    /// The corners of a triangle, as exact as the frame's scale has them.
    #[inline(always)]
    pub fn corners_of(&self, frame: &Frame, place: u32) -> [Vector3; 3] {
        let place = place as usize % WIDTH;
        let [a, b, c] = &self.corners;
        [a, b, c].map(|corner| frame.unscaled([corner[0][place], corner[1][place], corner[2][place]]))
    }

    /// Bit i is set unless it is certain that the ray does not hit triangle i at a t from 0 to `limit`. `center` is the
    /// frame's, in its scale.
    #[inline(always)]
    pub fn survivors<L: Lanes>(&self, l: L, center: [f32; 3], ray: [[L::F; 3]; 2], limit: f32) -> u32 {
        let [a, b, c] = &self.corners;
        let triangles = triangle(l, center, [load(l, a), load(l, b), load(l, c)]);
        self.may_hit(l, triangles, ray, l.splat(limit)) & self.all()
    }

    /// One triangle in all lanes.
    #[inline(always)]
    pub fn in_all_lanes<L: Lanes>(&self, l: L, center: [f32; 3], place: u32) -> [[L::F; 3]; 3] {
        let place = place as usize % WIDTH;
        let [a, b, c] = &self.corners;
        triangle(l, center, [pick(l, a, place), pick(l, b, place), pick(l, c, place)])
    }

    /// In each lane a triangle (corner and edges), a ray (origin and direction) and its limit: bit i is lane i's.
    #[inline(always)]
    pub fn may_hit<L: Lanes>(
        &self,
        l: L,
        [a, e1, e2]: [[L::F; 3]; 3],
        [o, d]: [[L::F; 3]; 2],
        limit: L::F,
    ) -> u32 {
        let c = difference(l, a, o);
        let r = cross(l, c, d);
        let n = cross(l, e1, e2);
        let (det, u, minus_v, t) = (dot(l, d, n), dot(l, e2, r), dot(l, e1, r), dot(l, c, n));
        let w = l.add(l.sub(det, u), minus_v);
        let v = l.negated_by(minus_v, l.splat(-1.0));
        let margin = self.side_margin;
        let one_side =
            l.or(l.le(l.splat(-margin), l.min(l.min(u, v), w)), l.le(l.max(l.max(u, v), w), l.splat(margin)));
        let t = l.negated_by(t, det);
        let margin = self.distance_margin;
        let farthest = l.mul_add(l.abs(det), limit, l.splat(margin));
        let in_range = l.and(l.le(l.splat(-margin), t), l.le(t, farthest));
        l.bits(l.and(one_side, in_range))
    }

    /// Boxes around the triangles, three lower and three upper planes, margin included.
    #[inline(always)]
    pub fn boxes<L: Lanes>(&self, l: L, center: [f32; 3]) -> [L::F; 6] {
        let (lower, upper) = (l.splat(-BOX_MARGIN), l.splat(BOX_MARGIN));
        let mut planes = [lower; 6];
        for axis in 0..3 {
            let [a, b, c] = &self.corners;
            let (a, b, c) = (l.load(&a[axis]), l.load(&b[axis]), l.load(&c[axis]));
            let center = l.splat(center[axis]);
            planes[axis] = l.add(l.sub(l.min(l.min(a, b), c), center), lower);
            planes[axis + 3] = l.add(l.sub(l.max(l.max(a, b), c), center), upper);
        }
        planes
    }

    /// A bit for each triangle.
    #[inline(always)]
    pub fn all(&self) -> u32 {
        (1 << self.count) - 1
    }

    #[inline(always)]
    pub fn number(&self, place: u32) -> u32 {
        self.numbers[place as usize % WIDTH]
    }
}

/// Corner and edges of triangles, of which the corners are given in the frame's scale.
#[inline(always)]
fn triangle<L: Lanes>(l: L, center: [f32; 3], [a, b, c]: [[L::F; 3]; 3]) -> [[L::F; 3]; 3] {
    let center = splat(l, center);
    [difference(l, a, center), difference(l, b, a), difference(l, c, a)]
}

#[inline(always)]
fn difference<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [l.sub(a[0], b[0]), l.sub(a[1], b[1]), l.sub(a[2], b[2])]
}

#[inline(always)]
fn load<L: Lanes>(l: L, from: &[Eight; 3]) -> [L::F; 3] {
    [l.load(&from[0]), l.load(&from[1]), l.load(&from[2])]
}

#[inline(always)]
fn splat<L: Lanes>(l: L, v: [f32; 3]) -> [L::F; 3] {
    [l.splat(v[0]), l.splat(v[1]), l.splat(v[2])]
}

#[inline(always)]
fn pick<L: Lanes>(l: L, from: &[Eight; 3], place: usize) -> [L::F; 3] {
    splat(l, [from[0][place], from[1][place], from[2][place]])
}

#[inline(always)]
fn dot<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.mul_add(a[0], b[0], l.mul_add(a[1], b[1], l.mul(a[2], b[2])))
}

#[inline(always)]
fn cross<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [
        l.mul_sub(a[1], b[2], l.mul(a[2], b[1])),
        l.mul_sub(a[2], b[0], l.mul(a[0], b[2])),
        l.mul_sub(a[0], b[1], l.mul(a[1], b[0])),
    ]
}
