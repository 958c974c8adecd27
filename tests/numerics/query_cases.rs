//! Meshes, objects and rays that are hard to intersect, for [`queries`](super::queries).

use a2::objects::{Mesh, Object, Plane, Ray, Shape, Sphere, Transform, Triangle};
use a2::scene::Geometry;
use a2::simd::InstructionSet;
use proptest::prelude::*;
use vecmath::{Matrix4, Real, Vector3};

/// Makes a scene of one mesh.
pub fn geometry(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Geometry {
    let mesh = Mesh::new(positions, triangles);
    let object = Object::new(Shape::Mesh(0), None, 0, Some(mesh.bounds()));
    Geometry::new(vec![object], vec![mesh], InstructionSet::detected())
}

/// Small whole numbers, which make coplanar, axis-parallel, touching and equal triangles likely, and other numbers.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => (-3i8..=3).prop_map(f32::from),
        4 => -3f32..3.0,
        1 => -1e-6f32..1e-6,
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(1e-30), Just(1.0 + f32::EPSILON)],
    ]
}

fn position() -> impl Strategy<Value = [f32; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

/// Ordinary triangles, needles, points, and copies of one another.
pub fn soup() -> impl Strategy<Value = (Vec<[f32; 3]>, Vec<[u32; 3]>)> {
    let scale =
        prop_oneof![6 => Just(1.0f32), 1 => Just(1e-12), 1 => Just(1e12), 1 => Just(3e-38), 1 => Just(1e37)];
    let offset = prop_oneof![4 => Just([0.0f32; 3]), 1 => Just([1e4, -1e4, 7.0]), 1 => Just([0.0, 1e-3, 2e7])];
    (prop::collection::vec(position(), 3..60), scale, offset).prop_flat_map(|(positions, scale, offset)| {
        let count = positions.len() as u32;
        let corner = 0..count;
        let triangles = prop::collection::vec([corner.clone(), corner.clone(), corner], 1..200);
        let place = move |p: [f32; 3]| [0, 1, 2].map(|axis| p[axis] * scale + offset[axis] * scale);
        let positions: Vec<[f32; 3]> = positions.into_iter().map(place).collect();
        (Just(positions), triangles)
    })
}

fn number() -> impl Strategy<Value = Real> {
    prop_oneof![
        20 => coordinate().prop_map(Real::from),
        4 => -30.0..30.0,
        1 => prop_oneof![Just(1e9), Just(-1e18), Just(1e-200), Just(5e-324), Just(1e300)],
        1 => prop_oneof![Just(Real::NAN), Just(Real::INFINITY), Just(Real::NEG_INFINITY)],
    ]
}

pub fn any_ray() -> impl Strategy<Value = Ray> {
    ([number(), number(), number()], [number(), number(), number()])
        .prop_map(|(origin, direction)| Ray { origin: origin.into(), direction: direction.into() })
}

/// Makes rays towards corners, edges and insides of triangles, where the last bits decide.
pub fn aimed_rays(mesh: &Mesh, eye: Vector3, sideways: Vector3) -> Vec<Ray> {
    let count = mesh.triangle_count().min(40) as u32;
    let targets = (0..count).flat_map(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        [a, (a + b) * 0.5, a * 0.5 + b * 0.25 + c * 0.25]
    });
    let aimed = |target: Vector3| {
        let from_eye = Ray { origin: eye, direction: target - eye };
        // A ray that starts on the surface.
        let from_target = Ray { origin: target, direction: sideways };
        let axis_parallel = Ray { origin: target - sideways, direction: Vector3::new(0.0, 0.0, -1.0) };
        [from_eye, from_target, axis_parallel]
    };
    targets.flat_map(aimed).collect()
}

fn transform() -> impl Strategy<Value = Option<Matrix4>> {
    let matrix = ([number(), number(), number()], -3.0..3.0, 0.2..2.0).prop_map(|(offset, angle, size)| {
        let offset = Vector3::from(offset.map(|c: Real| if c.abs() < 1e6 { c } else { 0.5 }));
        let axis = Vector3::new(0.3, 1.0, -0.5).normalized();
        Matrix4::translation(offset)
            * Matrix4::rotation(axis, angle)
            * Matrix4::scaling(Vector3::new(size, 1.0, -size))
    });
    prop::option::of(matrix)
}

/// Objects as `compile` makes them: instances of two meshes, spheres, triangles and planes, some of them twice.
pub fn scene() -> impl Strategy<Value = (Vec<Object>, Vec<Mesh>)> {
    let object = (0..6u8, transform(), position(), position(), 0u32..3);
    (prop::collection::vec(object, 1..40), soup(), soup()).prop_map(|(objects, one, other)| {
        let meshes = vec![Mesh::new(one.0, one.1), Mesh::new(other.0, other.1)];
        let vector = |p: [f32; 3]| Vector3::from(p.map(Real::from));
        let made = objects.into_iter().flat_map(|(kind, matrix, p, q, copies)| {
            let shape = match kind {
                0 => Shape::Plane(Plane::new(vector(p) + Vector3::splat(0.1), q[0].into())),
                1 | 2 => Shape::Sphere(Sphere { center: vector(p), radius: Real::from(q[0].abs()) + 0.1 }),
                3 => Shape::Triangle(Triangle::new([vector(p), vector(q), Vector3::new(0.0, 1.0, 0.5)])),
                _ => Shape::Mesh(u32::from(kind % 2)),
            };
            let bounds = shape.bounds(&meshes);
            let transform = matrix.and_then(|matrix| Transform::new(&matrix).ok()).map(Box::new);
            let object = Object::new(shape, transform, 0, bounds.as_ref());
            (0..=copies / 2).map(move |_| object.clone())
        });
        (made.collect(), meshes)
    })
}
