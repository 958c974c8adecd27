//! The contract of the trees: every query has the result of a loop over all triangles or all objects, to the last
//! bit, with every instruction set, for one ray and for a packet.

use super::query_cases::{aimed_rays, any_ray, geometry, scene, soup};
use super::query_loops::{Bits, any_by_loop, any_of_object, bits, closest_of_object, count_hits};
use a2::objects::{Hit, Mesh, PreparedRay, Ray, T_MAX};
use a2::scene::{Geometry, build_mesh_tree};
use a2::simd::packet::{PACKET, RayPacket, first_lanes, has_lane, lanes_in};
use a2::simd::{InstructionSet, with_simd};
use a2::wide::{HitPacket, Scratch};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use vecmath::{Real, Vector3};

/// Returns all instruction sets that this machine has.
fn instruction_sets() -> Vec<InstructionSet> {
    let here: Vec<_> = InstructionSet::available().collect();
    if here.len() < InstructionSet::NAMES.len() {
        eprintln!("skipped: this processor does not have every instruction set, only {here:?}");
    }
    here
}

/// Checks the structure of a mesh's tree, and that every triangle is in it once. A mesh with a coordinate that is not
/// finite has no tree.
fn validate(mesh: &Mesh) -> Result<(), String> {
    let Some(tree) = build_mesh_tree(mesh) else {
        let is_ordinary = mesh.bounds().max_abs() < 1e30;
        return if is_ordinary { Err("there is no tree".into()) } else { Ok(()) };
    };
    let corners =
        |triangles: &[u32]| triangles.iter().flat_map(|&triangle| mesh.corners(triangle)).collect::<Vec<_>>();
    tree.validate(|block| tree.space.planes(&a2::objects::Aabb::of_points(corners(block.indices()))))?;
    let mut triangles: Vec<u32> = tree.leaves.iter().flat_map(|block| block.indices().to_vec()).collect();
    triangles.sort_unstable();
    let all: Vec<u32> = (0..mesh.triangle_count() as u32).collect();
    if triangles == all { Ok(()) } else { Err("not every triangle is in one leaf".into()) }
}

/// Runs a property test with the same cases at every run.
fn check<S: Strategy>(cases: u32, strategy: S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, rng).run(&strategy, test).unwrap();
}

/// Compares single rays and packets, with every instruction set, with the loop. The rule that a hit lies in the
/// object's bounds applies to both.
fn mesh_agrees(geometry: &Geometry, rays: &[Ray]) -> Result<(), TestCaseError> {
    let rays: Vec<PreparedRay> = rays.iter().map(|ray| PreparedRay::new(*ray)).collect();
    let (object, meshes) = (&geometry.objects[0], &geometry.meshes);
    let expected: Vec<_> = rays.iter().map(|ray| closest_of_object(object, meshes, ray, T_MAX)).collect();
    // A limit equal to the t of the hit shows whether the limit is inclusive.
    let limits: Vec<Real> = expected.iter().map(|hit| hit.map_or(5.0, |hit| hit.t)).collect();
    let within = |ray: &PreparedRay, limit: Real| {
        let nearer = closest_of_object(object, meshes, ray, limit);
        (limit, bits(&nearer), any_of_object(object, meshes, ray, limit))
    };
    let expected_within: Vec<_> = rays
        .iter()
        .zip(&limits)
        .map(|(ray, &limit)| [limit, limit.next_down(), 1.0].map(|limit| within(ray, limit)))
        .collect();
    let mut scratch = Scratch::EMPTY;
    for set in instruction_sets() {
        for (number, ray) in rays.iter().enumerate() {
            let closest =
                |t_max| with_simd!(set, simd => geometry.closest_hit_of_object(simd, 0, ray, t_max, &()));
            let any = |t_max| with_simd!(set, simd => geometry.any_hit_of_object(simd, 0, ray, t_max, &()));
            prop_assert_eq!(bits(&closest(T_MAX)), bits(&expected[number]), "{} {:?}", set, ray);
            for (limit, nearer, is_hit) in expected_within[number] {
                prop_assert_eq!(bits(&closest(limit)), nearer, "{} {}", set, limit);
                prop_assert_eq!(any(limit), is_hit, "{} {}", set, limit);
            }
        }
        for (first, rays) in (0..).step_by(PACKET).zip(rays.chunks(PACKET)) {
            let active = first_lanes(rays.len()) & 0xffff_ffff_ffff_fff7;
            let mut packet: RayPacket = rays.iter().map(|ray| ray.ray).collect();
            let mut hits = HitPacket::NONE;
            with_simd!(set, simd => geometry.closest_hits(simd, &mut packet, active, &mut scratch, &mut hits));
            let mut t_max = [5.0; PACKET];
            t_max[..rays.len()].copy_from_slice(&limits[first..first + rays.len()]);
            let found =
                with_simd!(set, simd => geometry.any_hits(simd, &mut packet, active, &mut scratch, &t_max));
            for lane in lanes_in(active) {
                let (ray, number) = (&rays[lane], first + lane);
                let closest = hits.get(lane, &geometry.objects).map(|hit| hit.surface);
                prop_assert_eq!(bits(&closest), bits(&expected[number]), "{} {:?}", set, ray);
                let [(_, _, is_hit), ..] = expected_within[number];
                prop_assert_eq!(has_lane(found, lane), is_hit, "{} {:?}", set, ray);
            }
        }
    }
    Ok(())
}

#[test]
fn queries_of_a_mesh_agree_with_the_loop() {
    let cases = (soup(), prop::collection::vec(any_ray(), 1..80));
    check(150, cases, |((positions, triangles), rays)| {
        let geometry = geometry(positions, triangles);
        prop_assert_eq!(validate(&geometry.meshes[0]), Ok(()));
        mesh_agrees(&geometry, &rays)
    });
}

#[test]
fn queries_at_edges_and_corners_agree_with_the_loop() {
    check(80, (soup(), any_ray()), |((positions, triangles), ray)| {
        let geometry = geometry(positions, triangles);
        let rays = aimed_rays(&geometry.meshes[0], ray.origin, ray.direction);
        mesh_agrees(&geometry, &rays)
    });
}

/// A wavy square of 2 `side`^2 triangles is seen at every scale and distance by rays that lie side by side.
#[test]
fn queries_of_coherent_rays_agree_with_the_loop() {
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
        let geometry = geometry(positions, triangles);
        let eye = Vector3::new(0.1, -0.2, distance) * Real::from(scale);
        let ray = |i: u32| {
            let (x, y) = (Real::from(i % 8) / 7.0 - 0.5, Real::from(i / 8) / 31.0 - 0.5);
            let target = Vector3::new(x * 1.2, y * 1.2, 0.0) * Real::from(scale);
            Ray { origin: eye, direction: target - eye }
        };
        let parallel = |i: u32| Ray { direction: -eye, origin: eye + ray(i).direction * 0.01 };
        let rays: Vec<Ray> = (0..256).map(ray).chain((0..256).map(parallel)).collect();
        let met = count_hits(&geometry, &rays);
        assert!(met > 100, "{met} rays meet the square at scale {scale}");
        mesh_agrees(&geometry, &rays).unwrap();
    }
}

fn hit_bits(hit: &Option<Hit>) -> Option<(u32, Bits)> {
    hit.and_then(|hit| Some((hit.object, bits(&Some(hit.surface))?)))
}

/// Runs both queries for a packet. A mask with only a part of the lanes must change nothing for these lanes.
fn packet_queries(
    geometry: &Geometry,
    rays: &[Ray],
    limits: &[Real],
    scratch: &mut Scratch,
) -> Result<Vec<(Option<Hit>, bool)>, TestCaseError> {
    let (mut packet, mut hits): (RayPacket, _) = (rays.iter().copied().collect(), HitPacket::NONE);
    let mut t_max = [0.0; PACKET];
    t_max[..limits.len()].copy_from_slice(limits);
    let all = first_lanes(rays.len());
    let parts = [all, all & 0xffff_f7ff_0ff0_ff5d, all & !0xffff_f7ff_0ff0_ff5d];
    let mut answers = [(); 3].map(|()| Vec::new());
    for (mask, answers) in parts.into_iter().zip(&mut answers) {
        let any = with_simd!(geometry.instruction_set, simd => {
            geometry.closest_hits(simd, &mut packet, mask, scratch, &mut hits);
            geometry.any_hits(simd, &mut packet, mask, scratch, &t_max)
        });
        prop_assert_eq!(any & !mask, 0);
        let answer = |lane: usize| (hits.get(lane, &geometry.objects), has_lane(any, lane));
        answers.extend(lanes_in(mask).map(|lane| (lane, answer(lane))));
    }
    let [whole, one, other] = answers;
    let mut parts: Vec<_> = one.into_iter().chain(other).collect();
    parts.sort_by_key(|part| part.0);
    for (whole, part) in whole.iter().zip(&parts) {
        prop_assert_eq!(hit_bits(&whole.1.0), hit_bits(&part.1.0), "{}", geometry.instruction_set);
        prop_assert_eq!((whole.0, whole.1.1), (part.0, part.1.1), "{}", geometry.instruction_set);
    }
    Ok(whole.into_iter().map(|whole| whole.1).collect())
}

#[test]
fn queries_of_a_scene_agree_with_the_loop() {
    check(150, (scene(), prop::collection::vec(any_ray(), 1..90)), |((objects, meshes), rays)| {
        let by_loop = |ray: &Ray| {
            let ray = PreparedRay::new(*ray);
            let mut closest: Option<Hit> = None;
            for (index, object) in objects.iter().enumerate() {
                let t_max = closest.map_or(T_MAX, |closest| closest.surface.t);
                if let Some(surface) = closest_of_object(object, &meshes, &ray, t_max) {
                    closest = Some(Hit { object: index as u32, surface });
                }
            }
            closest
        };
        let blocked_by_loop = |ray: &Ray, t_max: Real| {
            let ray = PreparedRay::new(*ray);
            objects.iter().any(|object| any_of_object(object, &meshes, &ray, t_max))
        };
        let expected: Vec<_> = rays.iter().map(by_loop).collect();
        let limits: Vec<Real> =
            expected.iter().map(|hit| hit.map_or(Real::INFINITY, |hit| hit.surface.t)).collect();
        let blocked: Vec<bool> =
            rays.iter().zip(&limits).map(|(ray, limit)| blocked_by_loop(ray, *limit)).collect();
        let (mut geometry, mut scratch) =
            (Geometry::new(objects.clone(), meshes, InstructionSet::detected()), Scratch::EMPTY);
        for set in instruction_sets() {
            geometry.instruction_set = set;
            let mut answers = Vec::new();
            for (rays, limits) in rays.chunks(PACKET).zip(limits.chunks(PACKET)) {
                answers.extend(packet_queries(&geometry, rays, limits, &mut scratch)?);
            }
            for (number, ray) in rays.iter().enumerate() {
                let single = geometry.closest_hit(ray);
                prop_assert_eq!(hit_bits(&single), hit_bits(&expected[number]), "{} {:?}", set, ray);
                prop_assert_eq!(hit_bits(&answers[number].0), hit_bits(&expected[number]), "{} {:?}", set, ray);
                let any = geometry.any_hit(ray, limits[number]);
                prop_assert_eq!((any, answers[number].1), (blocked[number], blocked[number]), "{} {:?}", set, ray);
            }
        }
        Ok(())
    });
}

/// The directions are so short that the reciprocal of a component is infinite although the component is not zero.
#[test]
fn queries_with_very_short_directions_agree_with_the_loop() {
    let length = Real::MIN_POSITIVE * 1.3e8;
    for turn in 0..3 {
        let turned = |mut p: [Real; 3]| {
            p.rotate_right(turn);
            p
        };
        let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let positions = corners.map(|corner| turned(corner).map(|c| c as f32)).to_vec();
        let geometry = geometry(positions, vec![[0, 1, 2], [0, 2, 3]]);
        let ray = |i: u32| {
            let share = Real::from(i as f32 - 40.0) * 0.1e-9;
            // The distance to the mesh is as short, so that t is an ordinary number.
            let origin = turned([0.2, 0.1, 3.0 * length]).into();
            Ray { origin, direction: turned([share * length, 0.25 * share * length, -length]).into() }
        };
        let rays: Vec<Ray> = (0..80).map(ray).collect();
        let met = count_hits(&geometry, &rays);
        assert!(met > 60, "{met}");
        mesh_agrees(&geometry, &rays).unwrap();
    }
}

/// The tree is deep, because every triangle is half as large as the triangle before.
#[test]
fn queries_of_deep_trees_agree_with_the_loop() {
    let mut positions = Vec::new();
    for i in 0..120 {
        let size = (0.5f32).powi(i);
        positions.extend([[size, 0.0, 0.0], [size, size, 0.0], [size, 0.0, size]]);
    }
    let triangles = (0..120).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let geometry = geometry(positions, triangles);
    assert_eq!(validate(&geometry.meshes[0]), Ok(()));
    let rays = aimed_rays(&geometry.meshes[0], Vector3::new(3.0, 0.4, 0.3), Vector3::new(-1.0, 1e-3, 1e-3));
    mesh_agrees(&geometry, &rays).unwrap();
}

/// The rays come from more than 2^26 times the size of the mesh, so that rounding in `f32` moves them sideways by
/// more than its size.
#[test]
fn queries_from_very_far_agree_with_the_loop() {
    let size = 1e-31f32;
    let positions = (0..60).flat_map(|i: u32| {
        let at = |k: u32| [(i * 7 + k * 3) % 5, (i * 3 + k) % 7, (i + k * 5) % 4].map(|c| c as f32 * size);
        [at(0), at(1), at(2)]
    });
    let geometry = geometry(positions.collect(), (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let ray = |i: u32| {
        let (x, z) = (Real::from(i % 23) * -1.3e-16, Real::from(i / 23) * -1.1e-16);
        Ray { origin: Vector3::new(9.8e-25, 1.0, 7.1e-25), direction: Vector3::new(x, -1.0, z) }
    };
    let rays: Vec<Ray> = (0..320).map(ray).collect();
    let beside = rays.iter().filter(|ray| {
        let ray = PreparedRay::new(**ray);
        any_by_loop(&geometry.meshes[0], &ray, T_MAX)
            && geometry.meshes[0].bounds().entry(&ray, 1e-25, T_MAX).is_none()
    });
    let beside = beside.count();
    assert!(beside > 5, "{beside}");
    mesh_agrees(&geometry, &rays).unwrap();
}

/// The directions are so long that the t of a hit has only a few digits.
#[test]
fn queries_with_very_long_directions_agree_with_the_loop() {
    let position = |i: u32| [(i * 7 % 11) as f32, (i * 5 % 13) as f32, (i * 3 % 7) as f32].map(|c| c * 1e-16);
    let positions = (0..90).map(position).collect();
    let geometry = geometry(positions, (0..30).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let ray = |i: u32| {
        let target = Vector3::from(position(i).map(Real::from));
        let origin = Vector3::new(3e-15, -2e-15, 4e-15) * Real::from(1 + i % 3);
        Ray { origin, direction: (target - origin) * 1e307 * 1e15 }
    };
    let rays: Vec<Ray> = (0..64).map(ray).collect();
    mesh_agrees(&geometry, &rays).unwrap();
}

/// Rays along a column of slices meet every box of the tree, so that stacks overflow.
#[test]
fn queries_that_meet_every_box_agree_with_the_loop() {
    let slices = 40_000;
    let slice = |i: u32| {
        let z = i as f32 / slices as f32;
        [[-1.0, -1.0, z], [2.0, -1.0, z], [-1.0, 2.0, z]]
    };
    let positions = (0..slices).flat_map(slice).collect();
    let triangles = (0..slices).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let geometry = geometry(positions, triangles);
    let ray = |i: u32| {
        let (x, up) = (Real::from(i) * 0.01, if i.is_multiple_of(2) { 1.0 } else { -1.0 });
        Ray { origin: Vector3::new(x, 0.1, 0.5 - up), direction: Vector3::new(0.01, x, up) }
    };
    mesh_agrees(&geometry, &(0..12).map(ray).collect::<Vec<_>>()).unwrap();
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let random = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    let positions: Vec<[f32; 3]> =
        (0..80_000).map(|i| [random(3 * i), random(3 * i + 1), random(3 * i + 2)]).collect();
    let triangles: Vec<[u32; 3]> = (0..80_000).map(|i| [i, (i * 7 + 1) % 80_000, (i + 1) % 80_000]).collect();
    let built = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mesh = Mesh::new(positions.clone(), triangles.clone());
            assert_eq!(validate(&mesh), Ok(()));
            format!("{:?}", build_mesh_tree(&mesh))
        })
    };
    assert!(built(1) == built(4));
}
