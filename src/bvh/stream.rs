//! [`StreamWalk`]: rays that have nothing in common, through a [`Tree`] step by step, all of them at each step.
//!
//! A ray that walks alone ([`Walk`](super::walk::Walk)) asks at every box what to do next, and the processor, which
//! guesses the answer, mostly guesses wrong. Here a step is done for all rays before the next one begins, and without
//! a branch that depends on what a ray meets: each ray has its pending boxes on a stack of its own, and numbers are
//! written where they may be needed and counted if they are. Which boxes a ray is asked about does not matter: the
//! contract is that of [`Walk`](super::walk::Walk).

use super::beam::{Beam, Leaves, walk_alone};
use super::kept::Kept;
use super::simd::{Lanes, Task, WIDTH, places_in};
use super::tree::{Child, Node, Tree};
use super::walk::DONE;
use crate::objects::run::{RUN, numbers_in};
use std::hint::select_unpredictable;

/// Entries of a ray's stack. Where there is no room for eight more, the ray walks a node alone.
const DEPTH: usize = 32;

/// What the rays of a run still have to look at.
struct Stream {
    /// For each ray, where it enters its pending boxes, and what is in them. The first entry stands for none.
    near: [[f32; DEPTH]; RUN],
    child: [[u32; DEPTH]; RUN],
    /// Pending boxes of each ray.
    height: [u32; RUN],
    nodes: List,
    leaves: List,
    /// Items of leaves that are to be asked: for each its place in the leaf, and the leaf's in the list.
    place: [u8; RUN * WIDTH],
    leaf: [u8; RUN * WIDTH],
}

/// Rays, each with the node or the leaf that it looks at next.
struct List {
    rays: [(u32, u32); RUN],
    count: usize,
}

thread_local! {
    static STREAM: Kept<Stream> = const { Kept::new(None) };
}

impl List {
    const EMPTY: Self = Self { rays: [(0, 0); RUN], count: 0 };

    /// Adds a ray, if so.
    #[inline(always)]
    fn add(&mut self, number: usize, child: Child, if_so: bool) {
        self.rays[self.count % RUN] = (number as u32, child.bits());
        self.count += usize::from(if_so);
    }

    #[inline(always)]
    fn get(&self, index: usize) -> (usize, Child) {
        let (ray, child) = self.rays[index % RUN];
        (ray as usize % RUN, Child::of_bits(child))
    }

    /// Empties the list. What was in it can be had until as much has been added.
    #[inline(always)]
    fn drain(&mut self) -> usize {
        std::mem::take(&mut self.count)
    }
}

impl Stream {
    const EMPTY: Self = Self {
        near: [[f32::NEG_INFINITY; DEPTH]; RUN],
        child: [[u32::MAX; DEPTH]; RUN],
        height: [0; RUN],
        nodes: List::EMPTY,
        leaves: List::EMPTY,
        place: [0; RUN * WIDTH],
        leaf: [0; RUN * WIDTH],
    };

    /// Says what a ray looks at next: `child`, entered at `near`, or what is pending if that is beyond the limit.
    #[inline(always)]
    fn next(&mut self, number: usize, mut near: f32, mut child: u32, limit: f32) {
        let mut height = self.height[number] as usize % DEPTH;
        while near > limit {
            (near, child) = (self.near[number][height], self.child[number][height]);
            height = height.saturating_sub(1);
        }
        self.height[number] = height as u32;
        let child = Child::of_bits(child);
        let (is_some, is_leaf) = (child != Child::NONE, child.is_leaf());
        self.nodes.add(number, child, is_some & !is_leaf);
        self.leaves.add(number, child, is_some & is_leaf);
    }

    /// Looks at a node for a ray; not if there is no room for what might become pending, which is the output.
    #[inline(always)]
    fn look<L: Lanes>(&mut self, l: L, node: &Node, number: usize, beam: &Beam) -> bool {
        let (is_met, near) = beam.boxes(l, node, number);
        let met = l.bits(is_met);
        let nearest = l.least(l.select(is_met, near, l.splat(f32::INFINITY)));
        let first = (met & l.bits(l.le(near, l.splat(nearest)))).trailing_zeros() as usize % WIDTH;
        let others = met & !(1 << first);

        let height = self.height[number] as usize % DEPTH;
        let pending = (self.near[number][height], self.child[number][height]);
        let room = (
            self.near[number][height + 1..].first_chunk_mut(),
            self.child[number][height + 1..].first_chunk_mut(),
        );
        let (Some(near_room), Some(child_room)) = room else { return false };
        l.compress(others, near, near_room);
        l.compress_bits(others, node.children.map(Child::bits), child_room);

        let (left, more) = (height.saturating_sub(1), height + others.count_ones() as usize);
        let is_any = met != 0;
        self.height[number] = select_unpredictable(is_any, more, left) as u32;
        let near = f32::from_bits(select_unpredictable(is_any, nearest.to_bits(), pending.0.to_bits()));
        let child = select_unpredictable(is_any, node.children[first].bits(), pending.1);
        self.next(number, near, child, beam.limit(number));
        true
    }

    /// Forgets what is pending beyond a limit, unless that is much: [`next`](Self::next) would forget it one by one.
    #[inline(always)]
    fn cull<L: Lanes>(&mut self, l: L, number: usize, limit: f32) {
        let height = self.height[number] as usize;
        let pending = (self.near[number][1..].first_chunk_mut(), self.child[number][1..].first_chunk_mut());
        if let (Some(nears), Some(children), 0..=WIDTH) = (pending.0, pending.1, height) {
            let near = l.load(nears);
            let within = l.bits(l.le(near, l.splat(limit))) & ((1 << height) - 1);
            l.compress(within, near, nears);
            l.compress_bits(within, *children, children);
            self.height[number] = within.count_ones();
        }
    }

    /// Asks the leaves of the list about their rays; the output is how many there were.
    #[inline(always)]
    fn ask<L: Lanes>(&mut self, l: L, beam: &mut Beam, leaves: &mut impl Leaves) -> usize {
        let (count, mut items) = (self.leaves.drain(), 0);
        for index in 0..count {
            let (number, child) = self.leaves.get(index);
            let survivors = leaves.survivors(l, child.index(), number, beam);
            self.place[items..items + WIDTH].copy_from_slice(&places_in(survivors));
            self.leaf[items..items + WIDTH].copy_from_slice(&[index as u8; WIDTH]);
            items += survivors.count_ones() as usize;
        }
        for item in 0..items {
            let (number, child) = self.leaves.get(self.leaf[item].into());
            if beam.limit(number) > DONE {
                leaves.ask(l, child.index(), self.place[item].into(), number, beam);
                self.cull(l, number, beam.limit(number));
            }
        }
        count
    }
}

/// Calls [`Leaves::survivors`] and [`Leaves::ask`] for every leaf below `start` whose box a ray of `mask` may meet at a t
/// up to its limit.
pub struct StreamWalk<'a, V> {
    pub tree: &'a Tree,
    pub start: Child,
    pub mask: u64,
    pub beam: &'a mut Beam,
    pub leaves: &'a mut V,
}

impl<V: Leaves> Task for StreamWalk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { tree, start, mask, beam, leaves } = self;
        let mut stream = STREAM.take().unwrap_or_else(|| Box::new(Stream::EMPTY));
        for number in numbers_in(mask) {
            stream.height[number] = 0;
            stream.next(number, 0.0, start.bits(), beam.limit(number));
        }
        while stream.nodes.count + stream.leaves.count != 0 {
            for index in 0..stream.nodes.drain() {
                let (number, node) = stream.nodes.get(index);
                if !stream.look(l, &tree.nodes[node.index()], number, beam) {
                    walk_alone(l, tree, node, 1 << number, beam, leaves);
                    stream.next(number, f32::INFINITY, 0, beam.limit(number));
                }
            }
            for index in 0..stream.ask(l, beam, leaves) {
                let (number, _) = stream.leaves.get(index);
                stream.next(number, f32::INFINITY, 0, beam.limit(number));
            }
        }
        STREAM.set(Some(stream));
    }
}
