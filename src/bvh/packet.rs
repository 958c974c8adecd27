//! Up to 64 rays that lie side by side, through a [`Tree`] together.
//!
//! A node's boxes are first tested against a shaft around all rays, eight boxes at once; what the shaft meets is
//! tested against the rays, eight rays at once. Where few rays are left, each goes on alone; rays that have no
//! direction in common part at the root and go on as [`StreamWalk`]. How rays share their work depends on their order,
//! which boxes they are asked about does not matter: the contract is that of [`Walk`].

use super::frame::{self, CullRay};
use super::shaft::Shaft;
use super::simd::{Eight, Lanes, Task, WIDTH};
use super::stream::StreamWalk;
use super::tree::{Child, Node, Tree};
use super::walk::{DONE, EMPTY_STACK, Visit, Walk};
use crate::objects::run::{Numbers, RUN, around, numbers_in};
use vecmath::Real;

/// Registers of rays in a beam.
pub const GROUPS: usize = RUN / WIDTH;
/// So few rays of a beam walk alone.
pub const FEW: u32 = 4;
/// Boxes that may be pending; from there on rays part.
const STACK: usize = 96;
/// A number for each ray.
type Rays = [Eight; GROUPS];

/// Rays in a tree's frame as lanes. A lane without a ray, or whose search is over, has the limit [`DONE`].
pub struct Beam {
    pub origin: [Rays; 3],
    pub direction: [Rays; 3],
    pub inverse: [Rays; 3],
    origin_times_inverse: [Rays; 3],
    pub limit: Rays,
    /// See [`CullRay`].
    pub start: Numbers,
    pub rate: Numbers,
    /// What a walk still has to look at.
    pending: [Pending; STACK],
}

/// What is to be done with rays that reach a leaf.
pub trait Leaves {
    /// Looks at a leaf for the rays of a mask, and lowers their limits. The shaft, if there is one, is around them all.
    fn visit<L: Lanes>(&mut self, lanes: L, leaf: usize, rays: u64, shaft: Option<&Shaft>, beam: &mut Beam);
    /// Which of the up to eight items of a leaf one ray may hit.
    fn survivors<L: Lanes>(&self, lanes: L, leaf: usize, number: usize, beam: &Beam) -> u32;
    /// Asks an item of a leaf about one ray, and lowers its limit.
    fn ask<L: Lanes>(&mut self, lanes: L, leaf: usize, place: u32, number: usize, beam: &mut Beam);

    /// Looks at a leaf for one ray, and lowers its limit.
    #[inline(always)]
    fn visit_one<L: Lanes>(&mut self, l: L, leaf: usize, number: usize, beam: &mut Beam) {
        let mut survivors = self.survivors(l, leaf, number, beam);
        while survivors != 0 && beam.limit(number) > DONE {
            self.ask(l, leaf, survivors.trailing_zeros(), number, beam);
            survivors &= survivors - 1;
        }
    }
}

impl Beam {
    /// A beam without rays.
    pub const EMPTY: Self = Self {
        origin: [[[0.0; WIDTH]; GROUPS]; 3],
        direction: [[[1.0; WIDTH]; GROUPS]; 3],
        inverse: [[[1.0; WIDTH]; GROUPS]; 3],
        origin_times_inverse: [[[0.0; WIDTH]; GROUPS]; 3],
        limit: [[DONE; WIDTH]; GROUPS],
        start: [0.0; RUN],
        rate: [1.0; RUN],
        pending: [(0, 0, 0, 0.0); STACK],
    };

    /// Takes all rays away. What is left of them has no limit to be met within, and is in no mask.
    pub fn clear(&mut self) {
        self.limit = Self::EMPTY.limit;
    }

    /// Adds a ray, but for its start and rate.
    #[inline(always)]
    pub fn set(&mut self, number: usize, ray: &CullRay, limit: f32) {
        for (axis, product) in ray.origin_times_inverse().into_iter().enumerate() {
            self.origin[axis].as_flattened_mut()[number] = ray.origin[axis];
            self.direction[axis].as_flattened_mut()[number] = ray.direction[axis];
            self.inverse[axis].as_flattened_mut()[number] = ray.inverse[axis];
            self.origin_times_inverse[axis].as_flattened_mut()[number] = product;
        }
        self.limit.as_flattened_mut()[number] = limit;
    }

    #[inline(always)]
    pub fn ray(&self, number: usize) -> CullRay {
        let of = |rays: &[Rays; 3]| [0, 1, 2].map(|axis| rays[axis].as_flattened()[number]);
        CullRay {
            origin: of(&self.origin),
            direction: of(&self.direction),
            inverse: of(&self.inverse),
            start: self.start[number],
            rate: self.rate[number],
        }
    }

    #[inline(always)]
    pub fn limit(&self, number: usize) -> f32 {
        self.limit.as_flattened()[number]
    }

    /// Lowers a ray's limit to a t of its own; minus infinity ends its search.
    #[inline(always)]
    pub fn set_t_max(&mut self, number: usize, t_max: Real) {
        self.limit.as_flattened_mut()[number] = frame::limit(t_max, self.start[number], self.rate[number]);
    }

    /// The same for the rays of a mask.
    #[inline(always)]
    pub fn set_t_maxes(&mut self, mask: u64, t_max: &Numbers) {
        for number in around(mask) {
            let limit = frame::limit(t_max[number], self.start[number], self.rate[number]);
            let before = self.limit.as_flattened()[number];
            self.limit.as_flattened_mut()[number] = if mask >> number & 1 == 1 { limit } else { before };
        }
    }

    #[inline(always)]
    pub fn largest_limit<L: Lanes>(&self, l: L) -> f32 {
        let mut largest = l.load(&self.limit[0]);
        for limit in &self.limit[1..] {
            largest = l.max(largest, l.load(limit));
        }
        l.greatest(largest)
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

    /// Which of a node's boxes a ray meets at a t up to its limit, and where.
    #[inline(always)]
    pub fn boxes<L: Lanes>(&self, l: L, node: &Node, number: usize) -> (L::M, L::F) {
        let (mut near, mut far) = (l.splat(0.0), l.splat(self.limit(number)));
        for axis in 0..3 {
            let inverse = l.splat(self.inverse[axis].as_flattened()[number]);
            let product = l.splat(self.origin_times_inverse[axis].as_flattened()[number]);
            let lower = l.mul_sub(l.load(&node.planes[axis]), inverse, product);
            let upper = l.mul_sub(l.load(&node.planes[axis + 3]), inverse, product);
            near = l.max(near, l.min(lower, upper));
            far = l.min(far, l.max(lower, upper));
        }
        (l.le(near, far), near)
    }

    /// Origin and direction of one ray, in all lanes.
    #[inline(always)]
    pub fn in_all_lanes<L: Lanes>(&self, l: L, number: usize) -> [[L::F; 3]; 2] {
        let of = |rays: &[Rays; 3], axis: usize| l.splat(rays[axis].as_flattened()[number]);
        let Self { origin: o, direction: d, .. } = self;
        [[of(o, 0), of(o, 1), of(o, 2)], [of(d, 0), of(d, 1), of(d, 2)]]
    }

    /// Origin and direction of a group of rays.
    #[inline(always)]
    pub fn group<L: Lanes>(&self, l: L, group: usize) -> [[L::F; 3]; 2] {
        let Self { origin: [x, y, z], direction: [i, j, k], .. } = self;
        let origin = [l.load(&x[group]), l.load(&y[group]), l.load(&z[group])];
        [origin, [l.load(&i[group]), l.load(&j[group]), l.load(&k[group])]]
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
        let shaft = Shaft::around(l, self.beam, self.mask);
        let mut height = 0;
        let mut current = Some((Child::node(0), self.mask));
        loop {
            if let Some((child, mask)) = current.take() {
                if child.is_leaf() {
                    self.leaves.visit(l, child.index(), mask, shaft.as_ref(), self.beam);
                } else if mask.count_ones() <= FEW {
                    walk_alone(l, self.tree, child, mask, self.beam, &mut self.leaves);
                } else if shaft.is_none() || height + WIDTH > STACK {
                    let Self { tree, beam, leaves, .. } = &mut self;
                    l.enter(StreamWalk { tree, start: child, mask, beam, leaves });
                } else if let Some(shaft) = &shaft {
                    let node = &self.tree.nodes[child.index()];
                    let [a, b, c, d, e, f] = &node.planes;
                    let planes = [l.load(a), l.load(b), l.load(c), l.load(d), l.load(e), l.load(f)];
                    let (met, enter) = shaft.boxes(l, &planes, self.beam.largest_limit(l));
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

/// Takes the rays of a mask on from a node, one after the other.
#[inline(always)]
pub fn walk_alone<L: Lanes>(
    l: L,
    tree: &Tree,
    start: Child,
    mask: u64,
    beam: &mut Beam,
    leaves: &mut impl Leaves,
) {
    let mut stack = EMPTY_STACK;
    for number in numbers_in(mask) {
        let (ray, limit) = (beam.ray(number), beam.limit(number));
        let visit = &mut OneOfMany { number, leaves: &mut *leaves, beam: &mut *beam };
        let _ = l.enter(Walk { tree, start, ray: &ray, limit, visit, stack: &mut stack });
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
        self.leaves.visit_one(l, leaf, self.number, self.beam);
        self.beam.limit(self.number)
    }
}
