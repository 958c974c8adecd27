//! The promise of `a2::accel`: whatever is asked, the answer is that of a loop over all triangles or all objects, to the
//! last bit, at every processor level.

use a2::accel::simd::Level;
use a2::accel::{Accelerator, Hit};
use a2::objects::HitRun;
use a2::objects::run::{Prepare, PreparedRun, RUN, RayRun, Vectors, first, numbers_in};
use a2::objects::{
    Mesh, MeshHit, Object, Placement, Plane, PreparedRay, Ray, Shape, Sphere, T_MAX, Triangle, TriangleHit,
    TriangleHits, triangle_hit,
};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use vecmath::{Matrix4, Real, Vector3};

/// All levels that this machine has.
fn levels() -> Vec<Level> {
    let here: Vec<Level> = Level::NAMES.into_iter().filter_map(Level::named).collect();
    if here.len() < Level::NAMES.len() {
        eprintln!("skipped: this processor does not have every level, only {here:?}");
    }
    here
}

fn mesh_with_tree(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let mut mesh = Mesh::new(positions, triangles);
    mesh.build_tree();
    mesh
}

/// The same cases at every run.
fn check<S: Strategy>(cases: u32, strategy: S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, rng).run(&strategy, test).unwrap();
}

/// Small whole numbers make coplanar, axis-parallel, touching and coinciding things likely; the other ones spread out.
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
fn soup() -> impl Strategy<Value = (Vec<[f32; 3]>, Vec<[u32; 3]>)> {
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

fn any_ray() -> impl Strategy<Value = Ray> {
    ([number(), number(), number()], [number(), number(), number()])
        .prop_map(|(origin, direction)| Ray { origin: origin.into(), direction: direction.into() })
}

/// A bit pattern of everything that a hit says; NaN equals NaN.
fn bits(hit: &Option<MeshHit>) -> Option<(u32, u64, [u64; 3])> {
    hit.map(|found| (found.triangle, found.hit.t.to_bits(), found.hit.barycentric.map(Real::to_bits)))
}

/// The definition: the nearest of all triangles' hits, the first one of equals.
fn closest_by_loop(mesh: &Mesh, ray: &PreparedRay, t_max: Real) -> Option<MeshHit> {
    let mut closest: Option<MeshHit> = None;
    for triangle in 0..mesh.triangle_count() as u32 {
        let Some(hit) = triangle_hit(ray, mesh.corners(triangle)) else { continue };
        if hit.t < closest.map_or(t_max, |closest| closest.hit.t) {
            closest = Some(MeshHit { triangle, hit });
        }
    }
    closest
}

fn any_by_loop(mesh: &Mesh, ray: &PreparedRay, t_max: Real) -> bool {
    let mut triangles = 0..mesh.triangle_count() as u32;
    triangles.any(|triangle| triangle_hit(ray, mesh.corners(triangle)).is_some_and(|hit| hit.t <= t_max))
}

/// Rays one by one and 64 at a time, at every level, against the loop.
fn mesh_agrees(mesh: &mut Mesh, rays: &[Ray]) -> Result<(), TestCaseError> {
    let rays: Vec<PreparedRay> = rays.iter().map(|ray| PreparedRay::new(*ray)).collect();
    let expected: Vec<_> = rays.iter().map(|ray| closest_by_loop(mesh, ray, T_MAX)).collect();
    // A limit that is met exactly shows whether it is meant inclusively.
    let limits: Vec<Real> = expected.iter().map(|hit| hit.map_or(5.0, |hit| hit.hit.t)).collect();
    for level in levels() {
        mesh.set_level(level);
        for (number, ray) in rays.iter().enumerate() {
            prop_assert_eq!(bits(&mesh.closest_hit(ray, T_MAX)), bits(&expected[number]), "{} {:?}", level, ray);
            for limit in [limits[number], limits[number].next_down(), 1.0] {
                let nearer = closest_by_loop(mesh, ray, limit);
                prop_assert_eq!(bits(&mesh.closest_hit(ray, limit)), bits(&nearer), "{} {}", level, limit);
                prop_assert_eq!(mesh.any_hit(ray, limit), any_by_loop(mesh, ray, limit), "{} {}", level, limit);
            }
        }
        let mut triangle_hits = TriangleHits::NONE;
        for (rays, expected) in rays.chunks(RUN).zip(expected.chunks(RUN)) {
            let mask = first(rays.len()) & 0xffff_ffff_ffff_fff7;
            let mut run = RayRun::NONE;
            rays.iter().enumerate().for_each(|(number, ray)| run.set(number, ray.ray));
            let mut inverse_direction = Vectors::ZERO;
            level.run(Prepare { rays: &run, mask, inverse_direction: &mut inverse_direction });
            let prepared = PreparedRun { rays: &run, inverse_direction: &inverse_direction };
            let mut hits = HitRun::NONE.at;
            hits.t = [T_MAX; RUN];
            let hit = mesh.closest_hits(prepared, mask, &mut triangle_hits, &mut hits);
            let mut limits = [5.0; RUN];
            expected.iter().zip(&mut limits).for_each(|(hit, limit)| *limit = hit.map_or(5.0, |hit| hit.hit.t));
            let found = mesh.any_hits(prepared, mask, &mut triangle_hits, &limits);
            for number in numbers_in(mask) {
                let ray = &rays[number];
                let at = hits.get(number);
                let triangle_hit = TriangleHit { t: at.t, barycentric: at.barycentric };
                let closest =
                    (hit >> number & 1 == 1).then_some(MeshHit { triangle: at.triangle, hit: triangle_hit });
                prop_assert_eq!(bits(&closest), bits(&expected[number]), "{} {:?}", level, ray);
                prop_assert_eq!(found >> number & 1 == 1, any_by_loop(mesh, ray, limits[number]), "{}", level);
            }
        }
    }
    Ok(())
}

/// Rays towards the corners, the edges and the insides of triangles, where hits are decided by the last bits.
fn aimed_rays(mesh: &Mesh, eye: Vector3, sideways: Vector3) -> Vec<Ray> {
    let count = mesh.triangle_count().min(40) as u32;
    let targets = (0..count).flat_map(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        [a, (a + b) * 0.5, a * 0.5 + b * 0.25 + c * 0.25]
    });
    let aimed = |target: Vector3| {
        let from_eye = Ray { origin: eye, direction: target - eye };
        // From the surface itself, and past it.
        let from_target = Ray { origin: target, direction: sideways };
        let axis_parallel = Ray { origin: target - sideways, direction: Vector3::new(0.0, 0.0, -1.0) };
        [from_eye, from_target, axis_parallel]
    };
    targets.flat_map(aimed).collect()
}

#[test]
fn a_mesh_answers_as_the_loop_does() {
    let cases = (soup(), prop::collection::vec(any_ray(), 1..80));
    check(150, cases, |((positions, triangles), rays)| {
        let mut mesh = mesh_with_tree(positions, triangles);
        prop_assert_eq!(mesh.tree().map(|tree| tree.validate(|triangle| mesh.corners(triangle))), Some(Ok(())));
        mesh_agrees(&mut mesh, &rays)
    });
}

#[test]
fn a_mesh_answers_as_the_loop_does_at_edges_and_corners() {
    check(80, (soup(), any_ray()), |((positions, triangles), ray)| {
        let mut mesh = mesh_with_tree(positions, triangles);
        let rays = aimed_rays(&mesh, ray.origin, ray.direction);
        mesh_agrees(&mut mesh, &rays)
    });
}

/// A wavy square of 2 `side`^2 triangles, seen at every scale and distance by rays that lie side by side.
#[test]
fn coherent_rays_answer_as_the_loop_does() {
    let side = 24u32;
    let height = |x: u32, y: u32| ((x * 7 + y * 13) % 5) as f32 * 0.01;
    for (scale, distance) in [(1.0f32, 3.0), (1.0, 0.02), (1e-9, 1.0), (1e15, 1e4), (1.0, 1e9), (1e-30, 2.0)] {
        let positions = (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y)));
        let middle = |i: u32| i as f32 / side as f32 - 0.5;
        let positions = positions.map(|(x, y)| [middle(x), middle(y), height(x, y)].map(|c| c * scale)).collect();
        let corner = |x: u32, y: u32| y * (side + 1) + x;
        let squares = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
        let triangles = squares
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
                [[a, b, c], [b, d, c]]
            })
            .collect();
        let mut mesh = mesh_with_tree(positions, triangles);
        let eye = Vector3::new(0.1, -0.2, distance) * Real::from(scale);
        let ray = |i: u32| {
            let (x, y) = (Real::from(i % 8) / 7.0 - 0.5, Real::from(i / 8) / 31.0 - 0.5);
            let target = Vector3::new(x * 1.2, y * 1.2, 0.0) * Real::from(scale);
            Ray { origin: eye, direction: target - eye }
        };
        let parallel = |i: u32| Ray { direction: -eye, origin: eye + ray(i).direction * 0.01 };
        let rays: Vec<Ray> = (0..256).map(ray).chain((0..256).map(parallel)).collect();
        let met = rays.iter().filter(|ray| any_by_loop(&mesh, &PreparedRay::new(**ray), T_MAX)).count();
        assert!(met > 100, "{met} rays meet the square at scale {scale}");
        mesh_agrees(&mut mesh, &rays).unwrap();
    }
}

fn placement() -> impl Strategy<Value = Option<Matrix4>> {
    let matrix = ([number(), number(), number()], -3.0..3.0, 0.2..2.0).prop_map(|(offset, angle, size)| {
        let offset = Vector3::from(offset.map(|c: Real| if c.abs() < 1e6 { c } else { 0.5 }));
        let axis = Vector3::new(0.3, 1.0, -0.5).normalized();
        Matrix4::translation(offset)
            * Matrix4::rotation(axis, angle)
            * Matrix4::scaling(Vector3::new(size, 1.0, -size))
    });
    prop::option::of(matrix)
}

/// Objects as `compile` would make them, of two meshes, spheres, triangles and planes, some of them twice.
fn scene() -> impl Strategy<Value = (Vec<Object>, Vec<Mesh>)> {
    let object = (0..6u8, placement(), position(), position(), 0u32..3);
    (prop::collection::vec(object, 1..40), soup(), soup()).prop_map(|(objects, one, other)| {
        let meshes = vec![mesh_with_tree(one.0, one.1), mesh_with_tree(other.0, other.1)];
        let vector = |p: [f32; 3]| Vector3::from(p.map(Real::from));
        let made = objects.into_iter().flat_map(|(kind, matrix, p, q, copies)| {
            let (shape, bounds) = match kind {
                0 => (Shape::Plane(Plane::new(vector(p) + Vector3::splat(0.1), q[0].into())), None),
                1 | 2 => {
                    let sphere = Sphere { center: vector(p), radius: Real::from(q[0].abs()) + 0.1 };
                    let bounds = sphere.bounds();
                    (Shape::Sphere(sphere), Some(bounds))
                }
                3 => {
                    let triangle = Triangle::new([vector(p), vector(q), Vector3::new(0.0, 1.0, 0.5)]);
                    let bounds = triangle.bounds();
                    (Shape::Triangle(triangle), Some(bounds))
                }
                _ => (Shape::Mesh(u32::from(kind % 2)), Some(*meshes[usize::from(kind % 2)].bounds())),
            };
            let placement = matrix.and_then(|matrix| Placement::new(&matrix).ok()).map(Box::new);
            let object = Object::new(shape, placement, 0, bounds.as_ref());
            (0..=copies / 2).map(move |_| object.clone())
        });
        (made.collect(), meshes)
    })
}

fn object_bits(hit: &Option<Hit>) -> Option<(u32, u32, u64, [u64; 3])> {
    hit.map(|hit| (hit.object, hit.at.triangle, hit.at.t.to_bits(), hit.at.barycentric.map(Real::to_bits)))
}

#[test]
fn a_scene_answers_as_the_loop_does() {
    check(150, (scene(), prop::collection::vec(any_ray(), 1..90)), |((objects, mut meshes), rays)| {
        let by_loop = |meshes: &[Mesh], ray: &Ray| {
            let ray = PreparedRay::new(*ray);
            let mut closest: Option<Hit> = None;
            for (index, object) in objects.iter().enumerate() {
                let t_max = closest.map_or(T_MAX, |closest| closest.at.t);
                if let Some(at) = object.closest_hit(meshes, &ray, t_max) {
                    closest = Some(Hit { object: index as u32, at });
                }
            }
            closest
        };
        let blocked_by_loop = |meshes: &[Mesh], ray: &Ray, t_max: Real| {
            let ray = PreparedRay::new(*ray);
            objects.iter().any(|object| object.any_hit(meshes, &ray, t_max.min(T_MAX.next_down())))
        };
        meshes.iter_mut().for_each(|mesh| mesh.set_level(Level::SCALAR));
        let expected: Vec<_> = rays.iter().map(|ray| by_loop(&meshes, ray)).collect();
        let limits: Vec<Real> = expected.iter().map(|hit| hit.map_or(Real::INFINITY, |hit| hit.at.t)).collect();
        let blocked: Vec<bool> =
            rays.iter().zip(&limits).map(|(ray, limit)| blocked_by_loop(&meshes, ray, *limit)).collect();
        for level in levels() {
            meshes.iter_mut().for_each(|mesh| mesh.set_level(level));
            let accelerator = Accelerator::with_level(&objects, level);
            let (mut hits, mut found) = (Vec::new(), Vec::new());
            for (rays, limits) in rays.chunks(RUN).zip(limits.chunks(RUN)) {
                let (mut run, mut t_max, mut nearest) = (RayRun::NONE, [0.0; RUN], HitRun::NONE);
                rays.iter().enumerate().for_each(|(number, ray)| run.set(number, *ray));
                t_max[..limits.len()].copy_from_slice(limits);
                let all = first(rays.len());
                // Whoever else is asked about changes nothing.
                let parts = [all, all & 0xffff_f7ff_0ff0_ff5d, all & !0xffff_f7ff_0ff0_ff5d];
                let mut answers = [(); 3].map(|()| Vec::new());
                for (mask, answers) in parts.into_iter().zip(&mut answers) {
                    accelerator.closest_hits(&objects, &meshes, &run, mask, &mut nearest);
                    let any = accelerator.any_hits(&objects, &meshes, &run, mask, &t_max);
                    prop_assert_eq!(any & !mask, 0);
                    let answer = |number: usize| (nearest.get(number, &objects), any >> number & 1 == 1);
                    answers.extend(numbers_in(mask).map(|number| (number, answer(number))));
                }
                let [whole, one, other] = answers;
                let mut parts: Vec<_> = one.into_iter().chain(other).collect();
                parts.sort_by_key(|part| part.0);
                for (whole, part) in whole.iter().zip(&parts) {
                    prop_assert_eq!(object_bits(&whole.1.0), object_bits(&part.1.0), "{}", level);
                    prop_assert_eq!((whole.0, whole.1.1), (part.0, part.1.1), "{}", level);
                }
                hits.extend(whole.iter().map(|whole| whole.1.0));
                found.extend(whole.iter().map(|whole| whole.1.1));
            }
            prop_assert_eq!(&found, &blocked, "{}", level);
            for (number, ray) in rays.iter().enumerate() {
                let alone = accelerator.closest_hit(&objects, &meshes, ray);
                prop_assert_eq!(object_bits(&alone), object_bits(&expected[number]), "{} {:?}", level, ray);
                prop_assert_eq!(object_bits(&hits[number]), object_bits(&expected[number]), "{} {:?}", level, ray);
                let any = accelerator.any_hit(&objects, &meshes, ray, limits[number]);
                prop_assert_eq!(any, blocked[number], "{} {:?}", level, ray);
            }
        }
        Ok(())
    });
}

/// Directions so short that the reciprocal of a component has no finite value, though its share of the whole is not
/// small.
#[test]
fn very_short_directions_answer_as_the_loop_does() {
    let length = Real::MIN_POSITIVE * 1.3e8;
    for turn in 0..3 {
        let turned = |mut p: [Real; 3]| {
            p.rotate_right(turn);
            p
        };
        let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let positions = corners.map(|corner| turned(corner).map(|c| c as f32)).to_vec();
        let mut mesh = mesh_with_tree(positions, vec![[0, 1, 2], [0, 2, 3]]);
        let ray = |i: u32| {
            let share = Real::from(i as f32 - 40.0) * 0.1e-9;
            // As short is the way to the mesh, so that t is an ordinary number.
            let origin = turned([0.2, 0.1, 3.0 * length]).into();
            Ray { origin, direction: turned([share * length, 0.25 * share * length, -length]).into() }
        };
        let rays: Vec<Ray> = (0..80).map(ray).collect();
        let met = rays.iter().filter(|ray| any_by_loop(&mesh, &PreparedRay::new(**ray), T_MAX)).count();
        assert!(met > 60, "{met}");
        mesh_agrees(&mut mesh, &rays).unwrap();
    }
}

/// A chain in which every triangle is half as large as the one before gives deep trees.
#[test]
fn deep_trees_answer_as_the_loop_does() {
    let mut positions = Vec::new();
    for i in 0..120 {
        let size = (0.5f32).powi(i);
        positions.extend([[size, 0.0, 0.0], [size, size, 0.0], [size, 0.0, size]]);
    }
    let triangles = (0..120).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut mesh = mesh_with_tree(positions, triangles);
    assert_eq!(mesh.tree().unwrap().validate(|triangle| mesh.corners(triangle)), Ok(()));
    let rays = aimed_rays(&mesh, Vector3::new(3.0, 0.4, 0.3), Vector3::new(-1.0, 1e-3, 1e-3));
    mesh_agrees(&mut mesh, &rays).unwrap();
}

/// A mesh so small that rays come from more than 2^26 times its size, where rounding moves them sideways by more than that.
#[test]
fn rays_from_very_far_answer_as_the_loop_does() {
    let size = 1e-31f32;
    let positions = (0..60).flat_map(|i: u32| {
        let at = |k: u32| [(i * 7 + k * 3) % 5, (i * 3 + k) % 7, (i + k * 5) % 4].map(|c| c as f32 * size);
        [at(0), at(1), at(2)]
    });
    let mut mesh = mesh_with_tree(positions.collect(), (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let ray = |i: u32| {
        let (x, z) = (Real::from(i % 23) * -1.3e-16, Real::from(i / 23) * -1.1e-16);
        Ray { origin: Vector3::new(9.8e-25, 1.0, 7.1e-25), direction: Vector3::new(x, -1.0, z) }
    };
    let rays: Vec<Ray> = (0..320).map(ray).collect();
    let beside = rays.iter().filter(|ray| {
        let ray = PreparedRay::new(**ray);
        any_by_loop(&mesh, &ray, T_MAX) && mesh.bounds().entry(&ray, 1e-25, T_MAX).is_none()
    });
    let beside = beside.count();
    assert!(beside > 5, "{beside}");
    mesh_agrees(&mut mesh, &rays).unwrap();
}

/// Directions so long that a hit's t has no more than a few digits.
#[test]
fn very_long_directions_answer_as_the_loop_does() {
    let position = |i: u32| [(i * 7 % 11) as f32, (i * 5 % 13) as f32, (i * 3 % 7) as f32].map(|c| c * 1e-16);
    let positions = (0..90).map(position).collect();
    let mut mesh = mesh_with_tree(positions, (0..30).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let ray = |i: u32| {
        let target = Vector3::from(position(i).map(Real::from));
        let origin = Vector3::new(3e-15, -2e-15, 4e-15) * Real::from(1 + i % 3);
        Ray { origin, direction: (target - origin) * 1e307 * 1e15 }
    };
    let rays: Vec<Ray> = (0..64).map(ray).collect();
    mesh_agrees(&mut mesh, &rays).unwrap();
}

/// Rays up and down a column of slices meet every box of the tree, so that more is pending than there is room for.
#[test]
fn rays_that_meet_everything_answer_as_the_loop_does() {
    let slices = 40_000;
    let slice = |i: u32| {
        let z = i as f32 / slices as f32;
        [[-1.0, -1.0, z], [2.0, -1.0, z], [-1.0, 2.0, z]]
    };
    let positions = (0..slices).flat_map(slice).collect();
    let triangles = (0..slices).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut mesh = mesh_with_tree(positions, triangles);
    let ray = |i: u32| {
        let (x, up) = (Real::from(i) * 0.01, if i.is_multiple_of(2) { 1.0 } else { -1.0 });
        Ray { origin: Vector3::new(x, 0.1, 0.5 - up), direction: Vector3::new(0.01, x, up) }
    };
    mesh_agrees(&mut mesh, &(0..12).map(ray).collect::<Vec<_>>()).unwrap();
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let random = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    let positions: Vec<[f32; 3]> =
        (0..60_000).map(|i| [random(3 * i), random(3 * i + 1), random(3 * i + 2)]).collect();
    let triangles: Vec<[u32; 3]> = (0..60_000).map(|i| [i, (i * 7 + 1) % 60_000, (i + 1) % 60_000]).collect();
    let built = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mesh = pool.install(|| mesh_with_tree(positions.clone(), triangles.clone()));
        assert_eq!(mesh.tree().unwrap().validate(|triangle| mesh.corners(triangle)), Ok(()));
        format!("{:?}", mesh.tree())
    };
    assert!(built(1) == built(4));
}
