//! What is asked for a run of rays at once has the bits that each ray has by itself, at every processor level, whichever
//! of the rays are asked about.

use a2::accel::simd::{Lanes, Level, Task};
use a2::camera::{Camera, CameraRays, PixelGrid, Places};
use a2::cube_map::CubeMap;
use a2::objects::run::{RUN, RayRun, Rays, Vectors, numbers_in};
use a2::objects::{HitRun, Mesh, Object, ObjectHit, Placement, Plane, Ray, Shape, Sphere, Triangle};
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

fn levels() -> impl Iterator<Item = Level> {
    Level::NAMES.into_iter().filter_map(Level::named)
}

/// NaN is NaN, whatever its sign.
fn bits(vector: Vector3) -> [u64; 3] {
    vector.to_array().map(|c| if c.is_nan() { u64::MAX } else { u64::from(c.to_bits()) })
}

struct Normalize<'a>(&'a mut Vectors, u64);

impl Task for Normalize<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        self.0.normalize(self.1);
    }
}

#[test]
fn unit_vectors() {
    let mut numbers = Numbers(1);
    for level in levels() {
        for mask in MASKS.into_iter().cycle().take(200) {
            let mut vectors = Vectors::ZERO;
            (0..RUN).for_each(|number| vectors.set(number, numbers.odd_vector()));
            let before = vectors;
            level.run(Normalize(&mut vectors, mask));
            for number in numbers_in(mask) {
                let vector = before.get(number);
                assert_eq!(bits(vectors.get(number)), bits(vector.normalized()), "{level}: {vector:?}");
            }
        }
    }
}

#[test]
fn camera_rays() {
    let up = Vector3::new(0.1, 1.0, 0.0);
    let camera = Camera::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(-1.0, -2.0, -3.5), up, 0.7).unwrap();
    let mut numbers = Numbers(2);
    for (width, height, count) in [(100, 80, 200), (1, 7, 3), (5000, 1, 65)] {
        let grid = PixelGrid { width, height };
        let wanted: Vec<(Real, Real)> =
            (0..count).map(|_| (numbers.next() * 50.0, numbers.next() * 40.0)).collect();
        for level in levels() {
            let (mut places, mut rays) = (Places::default(), Rays::default());
            wanted.iter().for_each(|&place| places.push(place));
            level.run(CameraRays { camera: &camera, grid, places: &places, rays: &mut rays });
            assert_eq!(rays.len(), count);
            let found = rays.runs().flat_map(|(run, mask)| numbers_in(mask).map(|number| run.get(number)));
            for (found, &place) in found.zip(&wanted) {
                assert_eq!(found, camera.ray(grid.ndc(place)), "{level}: {place:?}");
            }
        }
    }
}

#[test]
fn colors_of_the_cube_map() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tex/courtyard");
    let cube_map = CubeMap::open(&folder).unwrap();
    let mut numbers = Numbers(3);
    for level in levels() {
        for mask in MASKS {
            let (mut directions, mut colors) = (Vectors::ZERO, Vectors::ZERO);
            (0..RUN).for_each(|number| directions.set(number, numbers.vector()));
            // Corners and edges of the cube.
            directions.set(0, Vector3::splat(-1.0));
            directions.set(37, Vector3::new(0.0, 2.0, -2.0));
            cube_map.colors(level, &directions, mask, &mut colors);
            for number in numbers_in(mask) {
                let direction = directions.get(number);
                assert_eq!(colors.get(number), cube_map.color(direction), "{level}: {direction:?}");
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
fn normals() {
    let meshes = [folded()];
    let placement =
        Matrix4::rotation(Vector3::new(0.6, 0.0, 0.8), 0.7) * Matrix4::scaling(Vector3::new(2.0, -0.5, 1.0));
    let corners = [Vector3::ZERO, Vector3::new(1.0, 0.0, 0.2), Vector3::new(0.0, 1.0, 0.0)];
    let shapes = [
        Shape::Sphere(Sphere { center: Vector3::new(0.1, 0.2, 0.3), radius: 0.5 }),
        Shape::Plane(Plane::new(Vector3::new(0.0, 2.0, 1.0), 0.3)),
        Shape::Triangle(Triangle::new(corners)),
        Shape::Mesh(0),
    ];
    let mut numbers = Numbers(4);
    for (shape, is_placed) in shapes.iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        let placement = is_placed.then(|| Box::new(Placement::new(&placement).unwrap()));
        let object = Object::new(shape.clone(), placement, 0, None);
        for (level, mask) in levels().flat_map(|level| MASKS.map(|mask| (level, mask))) {
            let (mut rays, mut hits, mut found) = (RayRun::NONE, HitRun::NONE.at, Vectors::ZERO);
            for number in 0..RUN {
                rays.set(number, Ray { origin: numbers.vector(), direction: numbers.vector() });
                let [a, b] = [numbers.next().abs() / 2.0, numbers.next().abs() / 2.0];
                let triangle = number as u32 % 3;
                hits.set(number, ObjectHit { t: numbers.odd().abs(), triangle, barycentric: [a, b, 1.0 - a - b] });
            }
            object.normals(&meshes, level, &rays, mask, &hits, &mut found);
            for number in numbers_in(mask) {
                let expected = object.normal(&meshes, &rays.get(number), &hits.get(number));
                assert_eq!(bits(found.get(number)), bits(expected), "{level}: {shape:?} {:?}", hits.get(number));
            }
        }
    }
}
