//! Up to 64 rays that lie side by side, through a [`Tree`] together.
//!
//! A node's boxes are first tested against a shaft around all rays, eight boxes at once; what the shaft meets is
//! tested against the rays, eight rays at once. Where few rays are left, each goes on alone. How rays share their work
//! depends on their order, which boxes they are asked about does not matter: the contract is that of
//! [`Walk`](super::walk::Walk).

use super::frame::CullRay;
use super::simd::{Eight, Lanes, Task, WIDTH};
use super::tree::{Child, Node, Tree};
use super::walk::{DONE, Visit, Walk};
use vecmath::Real;

/// Rays in a beam, at most: one for each bit of a mask.
pub const BEAM_RAYS: usize = 64;
/// Registers of rays in a beam.
pub const GROUPS: usize = BEAM_RAYS / WIDTH;
/// So few rays walk alone.
const FEW: u32 = 4;
/// Boxes that may be pending; from there on rays walk alone.
const STACK: usize = 96;
/// What a shaft is widened by: its corners are computed from rays within 6 of the middle, in four roundings.
const SHAFT_MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// Rays as lanes. A lane without a ray, or whose search is over, has the limit [`DONE`].
pub struct Beam {
    rays: [CullRay; BEAM_RAYS],
    inverse: [[Eight; GROUPS]; 3],
    origin_times_inverse: [[Eight; GROUPS]; 3],
    limit: [Eight; GROUPS],
    /// What a walk still has to look at.
    pending: [Pending; STACK],
}

/// What is to be done with rays that reach a leaf.
pub trait Leaves {
    /// Looks at a leaf for the rays of a mask, and lowers their limits.
    fn visit<L: Lanes>(&mut self, lanes: L, leaf: usize, rays: u64, beam: &mut Beam);
}

/// The rays of a mask, by number.
pub fn numbers_in(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let number = mask.trailing_zeros() as usize;
        let some = mask != 0;
        mask &= mask.wrapping_sub(1);
        some.then_some(number % BEAM_RAYS)
    })
}

impl Beam {
    /// A beam without rays.
    pub const EMPTY: Self = Self {
        rays: [CullRay::NONE; BEAM_RAYS],
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        limit: [[DONE; WIDTH]; GROUPS],
        pending: [(0, 0, 0, 0.0); STACK],
    };

    /// Takes all rays away. What is left of them has no limit to be met within, and is in no mask.
    pub fn clear(&mut self) {
        self.limit = Self::EMPTY.limit;
    }

    /// Adds a ray.
    #[inline]
    pub fn set(&mut self, number: usize, ray: CullRay, t_max: Real) {
        let (group, lane) = (number / WIDTH % GROUPS, number % WIDTH);
        let product = ray.origin_times_inverse();
        for (axis, product) in product.into_iter().enumerate() {
            self.inverse[axis][group][lane] = ray.inverse[axis];
            self.origin_times_inverse[axis][group][lane] = product;
        }
        self.limit[group][lane] = ray.limit(t_max);
        self.rays[number % BEAM_RAYS] = ray;
    }

    #[inline(always)]
    pub fn ray(&self, number: usize) -> &CullRay {
        &self.rays[number]
    }

    #[inline(always)]
    pub fn limit(&self, number: usize) -> f32 {
        self.limit[number / WIDTH][number % WIDTH]
    }

    /// Lowers a ray's limit to a t of its own; minus infinity ends its search.
    #[inline(always)]
    pub fn set_t_max(&mut self, number: usize, t_max: Real) {
        self.limit[number / WIDTH][number % WIDTH] = self.rays[number].limit(t_max);
    }

    #[inline(always)]
    fn largest_limit<L: Lanes>(&self, l: L) -> f32 {
        let mut largest = l.load(&self.limit[0]);
        for limit in &self.limit[1..] {
            largest = l.max(largest, l.load(limit));
        }
        let mut lanes = [0.0; WIDTH];
        l.store(largest, &mut lanes);
        lanes.into_iter().fold(DONE, f32::max)
    }

    /// Which rays of a mask meet a box of a node.
    #[inline(always)]
    fn meeting<L: Lanes>(&self, l: L, node: &Node, place: usize, mask: u64) -> u64 {
        let plane = node.planes_of(place);
        let mut met = 0;
        for group in 0..GROUPS {
            let here = mask >> (WIDTH * group) & 0xff;
            if here == 0 {
                continue;
            }
            let (mut near, mut far) = (l.splat(0.0), l.load(&self.limit[group]));
            for axis in 0..3 {
                let inverse = l.load(&self.inverse[axis][group]);
                let product = l.load(&self.origin_times_inverse[axis][group]);
                let lower = l.mul_sub(l.splat(plane[axis]), inverse, product);
                let upper = l.mul_sub(l.splat(plane[axis + 3]), inverse, product);
                near = l.max(near, l.min(lower, upper));
                far = l.min(far, l.max(lower, upper));
            }
            met |= (here & u64::from(l.bits(l.le(near, far)))) << (WIDTH * group);
        }
        met
    }
}

/// What encloses a beam: along one axis, which all rays run along in the same sense, the range of the other two.
struct Shaft {
    axis: usize,
    /// -1 where the rays run towards smaller coordinates.
    sign: f32,
    /// Signed coordinates along the axis at which the first ray starts, and the last.
    first: f32,
    last: f32,
    /// For the other two axes, in cyclic order: the range at `first`, and that of the change for each unit of way.
    at_first: [(f32, f32); 2],
    slope: [(f32, f32); 2],
}

impl Shaft {
    /// `None` for rays that have no direction in common.
    #[inline(always)]
    fn around(beam: &Beam, mask: u64) -> Option<Self> {
        let some = beam.rays[mask.trailing_zeros() as usize % BEAM_RAYS].direction;
        let axis = (0..3).find(|&axis| some[axis].abs() >= 0.99)?;
        let sign = 1f32.copysign(some[axis]);
        let (mut first, mut last) = (f32::INFINITY, f32::NEG_INFINITY);
        for number in numbers_in(mask) {
            let ray = &beam.rays[number];
            if ray.direction[axis] * sign < 0.25 {
                return None;
            }
            first = first.min(ray.origin[axis] * sign);
            last = last.max(ray.origin[axis] * sign);
        }
        let nothing = (f32::INFINITY, f32::NEG_INFINITY);
        let mut shaft = Self { axis, sign, first, last, at_first: [nothing; 2], slope: [nothing; 2] };
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        for number in numbers_in(mask) {
            let ray = &beam.rays[number];
            let way = first - ray.origin[axis] * sign;
            let per_way = ray.inverse[axis] * sign;
            for (side, &other) in others.iter().enumerate() {
                let slope = ray.direction[other] * per_way;
                let at_first = ray.origin[other] + way * slope;
                let wider = |range: &mut (f32, f32), value: f32, margin: f32| {
                    *range = (range.0.min(value - margin), range.1.max(value + margin));
                };
                wider(&mut shaft.at_first[side], at_first, SHAFT_MARGIN);
                wider(&mut shaft.slope[side], slope, 0.0);
            }
        }
        Some(shaft)
    }

    /// Which of a node's boxes the shaft meets before the signed coordinate `end`, and how far along.
    #[inline(always)]
    fn boxes<L: Lanes>(&self, l: L, node: &Node, end: f32) -> (u32, L::F) {
        let zero = l.splat(0.0);
        let sign = l.splat(self.sign);
        let (near, far) = if self.sign < 0.0 { (self.axis + 3, self.axis) } else { (self.axis, self.axis + 3) };
        let first = l.splat(self.first);
        let enter = l.max(l.mul_sub(l.load(&node.planes[near]), sign, first), zero);
        let leave = l.mul_sub(l.load(&node.planes[far]), sign, first);
        let mut met = l.and(l.le(zero, leave), l.le(enter, l.splat(end - self.first)));
        for side in 0..2 {
            let other = (self.axis + 1 + side) % 3;
            let (low_slope, high_slope) = (l.splat(self.slope[side].0), l.splat(self.slope[side].1));
            let low = l.min(l.mul(enter, low_slope), l.mul(leave, low_slope));
            let high = l.max(l.mul(enter, high_slope), l.mul(leave, high_slope));
            let low = l.add(l.splat(self.at_first[side].0), low);
            let high = l.add(l.splat(self.at_first[side].1), high);
            let box_low = l.load(&node.planes[other]);
            let box_high = l.load(&node.planes[other + 3]);
            met = l.and(met, l.and(l.le(low, box_high), l.le(box_low, high)));
        }
        (l.bits(met), enter)
    }
}

/// Calls [`Leaves::visit`] for every leaf whose box any ray of `mask` may meet at a t up to its limit.
pub struct BeamWalk<'a, V> {
    pub tree: &'a Tree,
    pub beam: &'a mut Beam,
    pub mask: u64,
    pub leaves: V,
}

/// A box to be looked at: its node and place, the rays that met the node, and how far along it is.
type Pending = (u32, u32, u64, f32);

impl<V: Leaves> Task for BeamWalk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        if self.mask == 0 || self.tree.nodes.is_empty() {
            return;
        }
        let shaft = Shaft::around(self.beam, self.mask);
        let mut height = 0;
        let mut current = Some((Child::node(0), self.mask));
        loop {
            if let Some((child, mask)) = current.take() {
                if child.is_leaf() {
                    self.leaves.visit(l, child.index(), mask, self.beam);
                } else if mask.count_ones() <= FEW || shaft.is_none() || height + WIDTH > STACK {
                    self.walk_alone(l, child, mask);
                } else if let Some(shaft) = &shaft {
                    let node = &self.tree.nodes[child.index()];
                    let end = shaft.last + self.beam.largest_limit(l) + SHAFT_MARGIN;
                    let (met, enter) = shaft.boxes(l, node, end);
                    let mut distances = [0.0; WIDTH];
                    l.store(enter, &mut distances);
                    push(&mut self.beam.pending, &mut height, child.index() as u32, met, mask, &distances);
                }
            }
            if height == 0 {
                return;
            }
            height -= 1;
            let (node, place, mask, _) = self.beam.pending[height];
            let (node, place) = (&self.tree.nodes[node as usize], place as usize % WIDTH);
            let mask = self.beam.meeting(l, node, place, mask);
            if mask != 0 {
                current = Some((node.children[place], mask));
            }
        }
    }
}

#[inline(always)]
fn push(
    stack: &mut [Pending; STACK],
    height: &mut usize,
    node: u32,
    mut met: u32,
    mask: u64,
    distances: &[f32; WIDTH],
) {
    let bottom = *height;
    while met != 0 {
        let place = met.trailing_zeros();
        met &= met - 1;
        let next = (node, place, mask, distances[place as usize % WIDTH]);
        let mut at = *height;
        *height += 1;
        while at > bottom && stack[at - 1].3 < next.3 {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = next;
    }
}

impl<V: Leaves> BeamWalk<'_, V> {
    #[inline(always)]
    fn walk_alone<L: Lanes>(&mut self, l: L, start: Child, mask: u64) {
        for number in numbers_in(mask) {
            let ray = self.beam.rays[number];
            let limit = self.beam.limit(number);
            let mut visit = OneOfMany { number, leaves: &mut self.leaves, beam: &mut *self.beam };
            let _ = l.enter(Walk { tree: self.tree, start, ray: &ray, limit, visit: &mut visit });
        }
    }
}

/// A ray of a beam that walks alone.
struct OneOfMany<'a, V> {
    number: usize,
    leaves: &'a mut V,
    beam: &'a mut Beam,
}

impl<V: Leaves> Visit for OneOfMany<'_, V> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, l: L, leaf: usize) -> f32 {
        self.leaves.visit(l, leaf, 1 << self.number, self.beam);
        self.beam.limit(self.number)
    }
}
