//! [`MirrorQueue`]: mirror rays that wait to be followed, with the paths that they continue.

use crate::simd::packet::{PACKET, RayPacket, Scalars, Vectors, first_lanes, has_lane, lanes_in, span};
use crate::simd::{Simd, vectorize};
use crate::trace::Seen;
use vecmath::Vector3;

/// Paths from the camera, lane by lane.
#[derive(Clone, Copy)]
pub struct PathPacket {
    /// Which camera ray the path began with.
    pub camera_ray: [u32; PACKET],
    /// The light that the path has gathered.
    pub color: Vectors,
    /// The share of further light that reaches the eye.
    pub throughput: Vectors,
}

impl PathPacket {
    pub const NONE: Self =
        Self { camera_ray: [0; PACKET], color: Vectors::ZERO, throughput: Vectors([[1.0; PACKET]; 3]) };

    /// Begins a path for each camera ray from this number on.
    pub fn start(&mut self, first: u32) {
        *self = Self::NONE;
        for (lane, camera_ray) in self.camera_ray.iter_mut().enumerate() {
            *camera_ray = first + lane as u32;
        }
    }

    /// Adds light to the paths of a mask.
    pub fn add<S: Simd>(&mut self, simd: S, mask: u64, light: impl Fn(usize) -> Vector3) {
        vectorize!(simd, {
            for lane in span(mask) {
                let before = self.color.get(lane);
                let color = before + self.throughput.get(lane).scaled_by(light(lane));
                self.color.set(lane, if has_lane(mask, lane) { color } else { before });
            }
        });
    }

    /// Ends the paths of a mask: their colours are what the camera rays see.
    pub fn end(&self, mask: u64, seen: &mut [Seen]) {
        for lane in lanes_in(mask) {
            seen[self.camera_ray[lane] as usize].color = self.color.get(lane);
        }
    }
}

/// Mirror rays that have passed equally many mirrors, in packets.
#[derive(Default)]
pub struct MirrorQueue {
    /// Those in use come first; the others are kept to spare allocations.
    packets: Vec<(RayPacket, PathPacket)>,
    count: usize,
}

impl MirrorQueue {
    pub fn clear(&mut self) {
        self.count = 0;
    }

    pub fn len(&self) -> usize {
        self.count
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds the rays of the active lanes, and the paths that they continue.
    pub fn append(&mut self, active: u64, origin: &Vectors, direction: &Vectors, paths: &PathPacket) {
        let mut rest = active;
        while rest != 0 {
            let (index, place) = (self.count / PACKET, self.count % PACKET);
            if index == self.packets.len() {
                self.packets.push((RayPacket::NONE, PathPacket::NONE));
            }
            let (rays, to) = &mut self.packets[index];
            // Lanes side by side are copied together.
            let first = rest.trailing_zeros() as usize;
            let count = ((rest >> first).trailing_ones() as usize).min(PACKET - place);
            let run = Run { first, place, count };
            run.copy_vectors(origin, &mut rays.origin);
            run.copy_vectors(direction, &mut rays.direction);
            run.copy_vectors(&paths.color, &mut to.color);
            run.copy_vectors(&paths.throughput, &mut to.throughput);
            run.copy(&paths.camera_ray, &mut to.camera_ray);
            self.count += count;
            rest &= !(first_lanes(count) << first);
        }
    }

    /// Iterates over the packets, each with its active lanes.
    pub fn packets(&mut self) -> impl Iterator<Item = (&mut RayPacket, &mut PathPacket, u64)> {
        let count = self.count;
        let packets = &mut self.packets[..count.div_ceil(PACKET)];
        packets
            .iter_mut()
            .enumerate()
            .map(move |(index, (rays, paths))| (rays, paths, first_lanes(count - index * PACKET)))
    }
}

/// Lanes side by side: the first one, the place that it is copied to, and how many there are.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    place: usize,
    count: usize,
}

impl Run {
    #[inline]
    fn copy<T: Copy>(self, from: &[T; PACKET], to: &mut [T; PACKET]) {
        let Self { first, place, count } = self;
        to[place..place + count].copy_from_slice(&from[first..first + count]);
    }

    fn copy_vectors(self, from: &Vectors, to: &mut Vectors) {
        from.0.iter().zip(&mut to.0).for_each(|(from, to): (&Scalars, _)| self.copy(from, to));
    }
}
