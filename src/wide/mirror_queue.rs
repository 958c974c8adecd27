//! [`MirrorQueue`]: mirror rays that wait to be followed, with the paths that they continue.

use crate::objects::Ray;
use crate::simd::packet::{PACKET, RayPacket, Vectors, first_lanes};
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

    /// Adds a mirror ray and the path that it continues.
    #[inline]
    pub fn push(&mut self, ray: Ray, camera_ray: u32, color: Vector3, throughput: Vector3) {
        let (index, lane) = (self.count / PACKET, self.count % PACKET);
        if index == self.packets.len() {
            self.packets.push((RayPacket::NONE, PathPacket::NONE));
        }
        self.count += 1;
        let (rays, paths) = &mut self.packets[index];
        rays.set(lane, ray);
        paths.camera_ray[lane] = camera_ray;
        paths.color.set(lane, color);
        paths.throughput.set(lane, throughput);
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
