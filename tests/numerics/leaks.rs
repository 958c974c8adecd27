//! No ray gets through a closed surface: on edges, at corners, in random poses, as a mesh and as separate triangles.

use super::support::{Mode, Random, Studio, check, modes, objects, vector};
use a2::objects::Ray;
use a2::simd::InstructionSet;
use std::fmt::Write as _;
use vecmath::Vector3;

/// Returns a sphere of triangles as an OBJ file: an octahedron whose faces are split `levels` times. The corners have
/// random radii from 0.7 to 1, so that there are slivers; with seed 0 all have radius 1.
pub fn ball(levels: u32, seed: u64) -> String {
    let mut points: Vec<[f64; 3]> = vec![
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let mut faces: Vec<[usize; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = [0, 1, 2].map(|i| points[a][i] + points[b][i]);
                let length = sum.map(|x| x * x).iter().sum::<f64>().sqrt();
                points.push(sum.map(|x| x / length));
                points.len() - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut random = Random(seed);
    let mut text = String::new();
    for point in &points {
        let radius = if seed == 0 { 1.0 } else { 0.85 + 0.15 * random.signed() };
        let _ = writeln!(text, "v {} {} {}", point[0] * radius, point[1] * radius, point[2] * radius);
    }
    for [a, b, c] in faces {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// Returns corners and points on edges of an OBJ file of triangles, where leaks would be.
fn seams(obj: &str) -> Vec<Vector3> {
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect() };
    // The program reads an OBJ file's coordinates as f32.
    let points: Vec<Vector3> = obj
        .lines()
        .filter(|line| line.starts_with('v'))
        .map(|line| vector([0, 1, 2].map(|i| f64::from(numbers(line)[i] as f32))))
        .collect();
    let mut seams = points.clone();
    for line in obj.lines().filter(|line| line.starts_with('f')) {
        let corners: Vec<Vector3> = numbers(line).iter().map(|&index| points[index as usize - 1]).collect();
        for (i, share) in [(0, 0.5), (1, 0.3), (2, 0.77)] {
            seams.push(corners[i] + (corners[(i + 1) % 3] - corners[i]) * share);
        }
    }
    seams
}

/// Counts the rays that start inside a closed star-shaped mesh and hit nothing.
pub fn leaks(scene: &str, obj: &str, pose: impl Fn(Vector3) -> Vector3, mode: Mode, rays: u64, seed: u64) -> u64 {
    let studio = Studio::with_meshes(scene, &[("m.obj", obj)], mode.flags).at(mode);
    let seams = seams(obj);
    let mut random = Random(seed);
    let mut leaks = 0;
    for i in 0..rays {
        // The origin is within 0.4 of the centre, where no face is. Half of the rays aim at seams.
        let from = vector(random.unit().map(|x| 0.4 * x * (i % 3) as f64 / 2.0));
        let to = if i % 2 == 0 { seams[random.bits() as usize % seams.len()] } else { vector(random.unit()) };
        let origin = pose(from);
        let ray = Ray { origin, direction: (pose(to) - origin).normalized() };
        leaks += u64::from(studio.hit(&ray).is_none());
    }
    leaks
}

const MESH: &str = "TriangleMesh { obj_file m.obj }";

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let obj = ball(3, 1);
    for mode in modes() {
        let leaks = leaks(&objects(MESH), &obj, |p| p, mode, 250_000, 1);
        check("closed mesh of 512 faces, rays at its seams: leaks in 250,000", 0.0, leaks as f64);
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh_in_random_poses() {
    use vecmath::Matrix4;
    let obj = ball(2, 2);
    let mut random = Random(8);
    for mode in modes() {
        let mut total = 0;
        for pose in 0..40 {
            let axis = random.unit();
            let (degrees, scale) = (180.0 * random.signed(), 10_f64.powf(7.0 * random.signed()));
            let away = random.unit().map(|x| x * scale * 10_f64.powi(pose % 7));
            let steps = format!(
                "Translate {:e} {:e} {:e} Rotate {{ {:e} {:e} {:e} {degrees:e} }} Scale {scale:e} {:e} {scale:e}",
                away[0],
                away[1],
                away[2],
                axis[0],
                axis[1],
                axis[2],
                3.0 * scale
            );
            let matrix = Matrix4::translation(vector(away))
                * Matrix4::rotation(vector(axis).normalized(), (degrees.to_radians()) as vecmath::Real)
                * Matrix4::scaling(vector([scale, 3.0 * scale, scale]));
            let scene = objects(&format!("Transform {{ {steps} {MESH} }}"));
            total += leaks(&scene, &obj, |p| matrix.transform_point(p), mode, 6000, pose as u64);
        }
        check("closed mesh in 40 poses of size 1e-7 to 1e7: leaks in 240,000", 0.0, total as f64);
    }
}

#[test]
fn no_ray_gets_through_a_closed_body_of_separate_triangles() {
    // Each triangle is an object with bounds of its own. From far away rounding moves a ray across a seam, and the
    // bounds must allow for that. The rays come from outside and aim at seams on the near side.
    let obj = ball(2, 0);
    let points: Vec<[f64; 3]> = obj
        .lines()
        .filter(|line| line.starts_with('v'))
        .map(|line| {
            let n: Vec<f64> = line.split(' ').skip(1).map(|w| w.parse().unwrap()).collect();
            [n[0], n[1], n[2]]
        })
        .collect();
    let mut text = String::new();
    for line in obj.lines().filter(|line| line.starts_with('f')) {
        let corners: Vec<[f64; 3]> =
            line.split(' ').skip(1).map(|w| points[w.parse::<usize>().unwrap() - 1]).collect();
        text += "Triangle { ";
        for (i, [x, y, z]) in corners.iter().enumerate() {
            text += &format!("vertex{i} {x:e} {y:e} {z:e} ");
        }
        text += "}\n";
    }
    let flush = |a: &[f64; 3], b: &[f64; 3]| (0..3).any(|axis| a[axis] == 0.0 && b[axis] == 0.0);
    let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>() < 0.3;
    let pairs = points.iter().flat_map(|a| points.iter().map(move |b| (*a, *b)));
    let flush: Vec<_> = pairs.filter(|(a, b)| a != b && flush(a, b) && near(a, b)).collect();
    for (case, distance) in [("10", 10.0), ("1e4", 1e4), ("1e7", 1e7)] {
        for mode in modes() {
            let studio = Studio::new(&objects(&text), mode.flags).at(mode);
            let mut random = Random(6);
            let mut leaks = 0;
            for _ in 0..20_000 {
                // The target is on a seam in a coordinate plane, where both boxes end in the same plane.
                let (a, b) = flush[random.bits() as usize % flush.len()];
                let share = 0.5 + 0.45 * random.signed();
                let to = [0, 1, 2].map(|i| a[i] + share * (b[i] - a[i]));
                let aside = random.unit();
                let from = [0, 1, 2].map(|i| distance * (to[i] + 0.5 * aside[i]));
                let ray = Ray { origin: vector(from), direction: (vector(to) - vector(from)).normalized() };
                leaks += u32::from(studio.hit(&ray).is_none());
            }
            check(
                &format!("closed body of 128 separate triangles from {case} away: leaks in 20,000"),
                0.0,
                f64::from(leaks),
            );
        }
    }
}

#[test]
fn no_ray_gets_through_a_flat_wall_of_two_objects() {
    // Two triangles in one plane share an edge along an axis, and their flat bounds end in the same line. From far
    // away the rounded ray may hit one triangle, but enter only the bounds of the other.
    let wall = "Triangle { vertex0 0 -1 0 vertex1 0 1 0 vertex2 -1 0 0 } Triangle { vertex0 0 1 0 vertex1 0 -1 0 vertex2 1 0 0 }";
    let sheared = format!(
        "Transform {{ Matrix4f {{ 1 0 0 0  0 1 0 0  1000 0 1 0  0 0 0 1 }} Group {{ numObjects 2 {wall} }} }}"
    );
    for (case, text, distance) in [
        ("flat wall of two triangles from 10 away", wall, 10.0),
        ("flat wall of two triangles from 1e8 away", wall, 1e8),
        ("sheared wall of two triangles from 10 away", &sheared, 10.0),
        ("sheared wall of two triangles from 1e8 away", &sheared, 1e8),
    ] {
        for mode in modes() {
            let studio = Studio::new(&objects(text), mode.flags).at(mode);
            let mut random = Random(14);
            let mut leaks = 0;
            for _ in 0..20_000 {
                let away = random.unit();
                let from = vector(away.map(|x| x * distance));
                let to = vector([distance * 1e-13 * random.signed(), 0.5 * random.signed(), 0.0]);
                if away[2].abs() > 0.1 {
                    leaks += u32::from(
                        studio.hit(&Ray { origin: from, direction: (to - from).normalized() }).is_none(),
                    );
                }
            }
            check(&format!("{case}: leaks in 20,000"), 0.0, f64::from(leaks));
        }
    }
}

#[test]
fn no_light_gets_out_of_a_closed_body() {
    // A lamp is inside, the eyes are outside: with -shadows every point is dark. The starter lets highlights through,
    // because its shadow rays start 0.01 inside the wall; so does the default here.
    let obj = ball(3, 1);
    for (case, scale) in [("1e-6", 1e-6), ("1", 1.0), ("1e9", 1e9)] {
        let scene = format!(
            "{}Lights {{ numLights 1 PointLight {{ position 0 0 0 color 1 1 1 falloff {:e} }} }}
            Background {{ color 0 0 0 }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 1 1 1 specularColor 1 1 1 shininess 0 }} }}
            Group {{ numObjects 1 MaterialIndex 0 Transform {{ UniformScale {scale:e} {MESH} }} }}",
            super::support::CAMERA,
            0.01 / scale / scale
        );
        let lit = |flags: &str| {
            let studio = Studio::with_meshes(&scene, &[("m.obj", &obj)], &format!("-shadows {flags}"));
            let mut random = Random(12);
            (0..20_000)
                .filter(|_| {
                    let from = vector(random.unit().map(|x| 3.0 * scale * x));
                    let to = vector(random.unit().map(|x| 0.6 * scale * x));
                    studio.color(&Ray { origin: from, direction: (to - from).normalized() }) != [0.0; 3]
                })
                .count()
        };
        check(
            &format!("lamp in a closed mesh of size {case}, -robust: lit points outside of 20,000"),
            0.0,
            lit("-robust") as f64,
        );
        if scale == 1.0 {
            check(
                "lamp in a closed mesh, the starter's rays: dark points outside of 20,000",
                0.0,
                (20_000 - lit("")) as f64,
            );
        }
    }
}

#[test]
fn no_light_gets_through_a_thin_wall() {
    // A slab thinner than 0.01 is lit from above and seen from below: its underside is dark. The starter's shadow
    // rays from the underside start above the slab and reach the light.
    for (case, thickness) in [("1e-3", 1e-3), ("1e-6", 1e-6), ("1e-9", 1e-9)] {
        let scene = format!(
            "{}Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 0 color 1 1 1 }} }}
            Materials {{ numMaterials 1 Material {{ diffuseColor 1 1 1 specularColor 1 1 1 }} }}
            Group {{ numObjects 1 MaterialIndex 0 Transform {{ Scale 1 {:e} 1 {MESH} }} }}",
            super::support::CAMERA,
            thickness / 2.0
        );
        let obj = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
            f 1 2 6 5\nf 4 8 7 3\nf 1 4 3 2\nf 5 6 7 8\nf 1 5 8 4\nf 2 3 7 6\n";
        for mode in modes() {
            let studio =
                Studio::with_meshes(&scene, &[("m.obj", obj)], &format!("-shadows {}", mode.flags)).at(mode);
            let mut random = Random(13);
            let lit = (0..2000)
                .filter(|_| {
                    let from = [0.3 * random.signed(), -2.0, 0.3 * random.signed()];
                    let ray = Ray {
                        origin: vector(from),
                        direction: vector([0.2 * random.signed(), 1.0, 0.2 * random.signed()]).normalized(),
                    };
                    studio.color(&ray) != [0.0; 3]
                })
                .count() as f64;
            if mode.robust() {
                check(&format!("underside of a lit slab {case} thick, -robust: lit points of 2,000"), 0.0, lit);
            } else {
                check(
                    &format!("underside of a lit slab {case} thick, the starter's rays: dark points of 2,000"),
                    0.0,
                    2000.0 - lit,
                );
            }
        }
    }
}

/// Runs for minutes: `cargo test --release --test numerics -- --ignored soak`. `A2_SOAK_RAYS` is the number of rays
/// (default 1e8).
#[test]
#[ignore = "takes minutes"]
fn soak() {
    let rays: u64 = std::env::var("A2_SOAK_RAYS").map_or(100_000_000, |n| n.parse().unwrap());
    let obj = ball(4, 1);
    let share = rays / 4;
    let Some(mode) = modes().find(|mode| !mode.robust() && mode.instruction_set == InstructionSet::detected())
    else {
        panic!()
    };
    let workers = (0..4_u64).map(|worker| {
        let obj = obj.clone();
        std::thread::spawn(move || leaks(&objects(MESH), &obj, |p| p, mode, share, 100 + worker))
    });
    let workers: Vec<_> = workers.collect();
    let leaks: u64 = workers.into_iter().map(|worker| worker.join().unwrap()).sum();
    println!("{leaks} leaks in {} rays against a closed mesh of 2048 faces", 4 * share);
    assert_eq!(leaks, 0);
}
