//! What is computed for a packet has the bits that each lane has by itself, with every instruction set, whichever lanes
//! are active.

use super::camera::camera_rays;
use super::cube_map::{self, CubeMapScratch};
use super::hit_packet::HitPacket;
use super::normals::{NormalScratch, normals};
use crate::camera::{Camera, PixelGrid, Place};
use crate::cube_map::CubeMap;
use crate::objects::{Mesh, Object, Plane, Ray, Shape, Sphere, SurfaceHit, Transform, Triangle};
use crate::simd::packet::{PACKET, RayPacket, Vectors, lanes_in};
use crate::simd::{InstructionSet, Simd as _, with_simd};
use std::path::Path;
use vecmath::{Matrix4, Real, Vector3};

/// All rays, a few, one, and such as leave gaps.
const MASKS: [u64; 6] = [
    u64::MAX,
    0xffff_f00f_f0ff_fff7,
    0x0000_0000_0fff_0000,
    0x8000_0000_0000_0001,
    1 << 37,
    0xaaaa_aaaa_aaaa_aaaa,
];

/// Numbers that look random, the same ones at every run; a few are of the kind that goes wrong.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> Real {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as Real / (1u64 << 23) as Real - 1.0
    }

    fn odd(&mut self) -> Real {
        const ODD: [Real; 7] = [0.0, -0.0, Real::MIN_POSITIVE, 1e-30, 1e30, Real::INFINITY, Real::NAN];
        let number = self.next();
        match (number.abs() * 1000.0) as usize {
            place @ 0..7 => ODD[place],
            _ => number,
        }
    }

    fn vector(&mut self) -> Vector3 {
        Vector3::new(self.next(), self.next(), self.next())
    }

    fn odd_vector(&mut self) -> Vector3 {
        Vector3::new(self.odd(), self.odd(), self.odd())
    }
}

/// NaN is NaN, whatever its sign.
fn bits(vector: Vector3) -> [u64; 3] {
    vector.to_array().map(|c| if c.is_nan() { u64::MAX } else { u64::from(c.to_bits()) })
}

#[test]
fn unit_vectors() {
    let mut numbers = Numbers(1);
    for set in InstructionSet::available() {
        for mask in MASKS.into_iter().cycle().take(200) {
            let mut vectors = Vectors::ZERO;
            (0..PACKET).for_each(|lane| vectors.set(lane, numbers.odd_vector()));
            let before = vectors;
            with_simd!(set, simd => simd.vectorize(#[inline(always)] || vectors.normalize(mask)));
            for lane in lanes_in(mask) {
                let vector = before.get(lane);
                assert_eq!(bits(vectors.get(lane)), bits(vector.normalized()), "{set}: {vector:?}");
            }
        }
    }
}

#[test]
fn camera_rays_of_places() {
    let up = Vector3::new(0.1, 1.0, 0.0);
    let camera = Camera::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(-1.0, -2.0, -3.5), up, 0.7).unwrap();
    let mut numbers = Numbers(2);
    for (width, height, count) in [(100, 80, 200), (1, 7, 3), (5000, 1, 65)] {
        let grid = PixelGrid { width, height };
        let places: Vec<Place> = (0..count).map(|_| (numbers.next() * 50.0, numbers.next() * 40.0)).collect();
        for set in InstructionSet::available() {
            let mut rays = RayPacket::NONE;
            for places in places.chunks(PACKET) {
                let active = with_simd!(set, simd => camera_rays(simd, &camera, grid, places, &mut rays));
                assert_eq!(active.count_ones() as usize, places.len());
                for (lane, &place) in places.iter().enumerate() {
                    assert_eq!(rays.get(lane), camera.ray(grid.ndc(place)), "{set}: {place:?}");
                }
            }
        }
    }
}

#[test]
fn colors_of_the_cube_map() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tex/courtyard");
    let cube_map = CubeMap::open(&folder).unwrap();
    let (mut numbers, mut scratch) = (Numbers(3), CubeMapScratch::EMPTY);
    for set in InstructionSet::available() {
        for mask in MASKS {
            let mut directions = Vectors::ZERO;
            (0..PACKET).for_each(|lane| directions.set(lane, numbers.vector()));
            // Corners and edges of the cube.
            directions.set(0, Vector3::splat(-1.0));
            directions.set(37, Vector3::new(0.0, 2.0, -2.0));
            let colors = with_simd!(set, simd => {
                cube_map::colors(simd, &cube_map, &directions, mask, &mut scratch)
            });
            for lane in lanes_in(mask) {
                let direction = directions.get(lane);
                assert_eq!(colors.get(lane), cube_map.color(direction), "{set}: {direction:?}");
            }
        }
    }
}

/// A fold whose sides face away from each other, so that the normals on the edge cancel out, beside an ordinary face.
fn folded() -> Mesh {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.3]];
    Mesh::new(positions, vec![[0, 1, 2], [0, 2, 1], [1, 3, 2]])
}

#[test]
fn normals_of_every_shape() {
    let meshes = [folded()];
    let matrix =
        Matrix4::rotation(Vector3::new(0.6, 0.0, 0.8), 0.7) * Matrix4::scaling(Vector3::new(2.0, -0.5, 1.0));
    let corners = [Vector3::ZERO, Vector3::new(1.0, 0.0, 0.2), Vector3::new(0.0, 1.0, 0.0)];
    let shapes = [
        Shape::Sphere(Sphere { center: Vector3::new(0.1, 0.2, 0.3), radius: 0.5 }),
        Shape::Plane(Plane::new(Vector3::new(0.0, 2.0, 1.0), 0.3)),
        Shape::Triangle(Triangle::new(corners)),
        Shape::Mesh(0),
    ];
    let (mut numbers, mut scratch) = (Numbers(4), NormalScratch::EMPTY);
    for (shape, is_placed) in shapes.iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        let transform = is_placed.then(|| Box::new(Transform::new(&matrix).unwrap()));
        let object = Object::new(shape.clone(), transform, 0, None);
        // Different triangles, or one: without normals at its corners, or with.
        let triangles: [fn(usize) -> u32; 3] = [|lane| lane as u32 % 3, |_| 0, |_| 2];
        let cases = InstructionSet::available().flat_map(|set| MASKS.map(|mask| (set, mask)));
        for ((set, mask), triangle) in cases.flat_map(|case| triangles.map(|triangle| (case, triangle))) {
            let (mut rays, mut hits, mut found) = (RayPacket::NONE, HitPacket::NONE, Vectors::ZERO);
            for lane in 0..PACKET {
                rays.set(lane, Ray { origin: numbers.vector(), direction: numbers.vector() });
                let [a, b] = [numbers.next().abs() / 2.0, numbers.next().abs() / 2.0];
                let (t, barycentric) = (numbers.odd().abs(), [a, b, 1.0 - a - b]);
                hits.set_surface(lane, SurfaceHit { t, triangle: triangle(lane), barycentric });
            }
            for kept in [true, false] {
                let before = found;
                with_simd!(set, simd => {
                    normals(simd, &object, &meshes, &rays, mask, &hits, kept, &mut scratch, &mut found);
                });
                for lane in lanes_in(mask) {
                    let expected = object.normal(&meshes, &rays.get(lane), &hits.surface(lane));
                    assert_eq!(bits(found.get(lane)), bits(expected), "{set}: {shape:?} {:?}", hits.surface(lane));
                }
                let is_same = |lane| bits(found.get(lane)) == bits(before.get(lane));
                assert!(!kept || lanes_in(!mask).all(is_same), "{set}: {shape:?}");
            }
        }
    }
}
