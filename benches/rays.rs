//! Rays a second in one mesh, and building times, in the form that `benches/peers/rays.py` reads.
//!
//! ```text
//! rays MESH.obj --rays FILE [--threads N] [--repeats N] [--simd LEVEL] [--alone]
//! rays MESH.obj --build [--repeats N]
//! ```
//!
//! The ray file is described in `benches/peers/README.md`. Rays are asked for 256 at a time, as the renderer does;
//! with `--alone` one by one. What is timed is the whole answer, from rays to hits in `f64`.
#![forbid(unsafe_code)]

use a2::accel::simd::Level;
use a2::accel::{Accelerator, Hit};
use a2::objects::{Mesh, Object, Ray, Shape};
use a2::scene::parse_mesh;
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use vecmath::{Real, Vector3};

const AT_ONCE: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let Some(mesh_path) = words.first().map(Path::new) else {
        println!(
            "rays MESH.obj --rays FILE [--threads N] [--repeats N] [--simd LEVEL] [--alone], or MESH.obj --build"
        );
        return Ok(());
    };
    let value = |flag: &str| words.iter().position(|word| word == flag).and_then(|at| words.get(at + 1));
    let number = |flag: &str, default: usize| value(flag).map_or(Ok(default), |word| word.parse());
    let repeats = number("--repeats", 5)?;
    let mut mesh = parse_mesh(mesh_path, &std::fs::read(mesh_path)?)?;
    if words.iter().any(|word| word == "--build") {
        return time_building(&mesh, repeats);
    }
    let level = match value("--simd") {
        Some(name) => Level::named(name).ok_or("no such level here")?,
        None => Level::detected(),
    };
    mesh.set_level(level);
    let rays = read_rays(&std::fs::read(value("--rays").ok_or("--rays FILE or --build is missing")?)?)?;
    let scene = Scene::new(mesh, level);
    let alone = words.iter().any(|word| word == "--alone");
    let threads = number("--threads", 1)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(|| {
        for (name, query) in [("closest_hit", Query::Closest), ("any_hit", Query::Any)] {
            let mut hits = 0;
            let rates = timed(repeats, || hits = scene.ask(&rays, query, alone));
            let rates = rates.map(|seconds| rays.len() as f64 / seconds / 1e6);
            println!(
                "{name:<13} threads {threads}  Mrays/s {:7.2}  ({:.2} .. {:.2})  hits {hits} of {}",
                rates[1],
                rates[2],
                rates[0],
                rays.len()
            );
        }
    });
    Ok(())
}

#[derive(Clone, Copy)]
enum Query {
    Closest,
    Any,
}

/// The mesh alone.
struct Scene {
    objects: Vec<Object>,
    meshes: Vec<Mesh>,
    accelerator: Accelerator,
}

impl Scene {
    fn new(mesh: Mesh, level: Level) -> Self {
        let objects = vec![Object::new(Shape::Mesh(0), None, 0, Some(mesh.bounds()))];
        Self { accelerator: Accelerator::with_level(&objects, level), objects, meshes: vec![mesh] }
    }

    /// How many rays hit something.
    fn ask(&self, rays: &[(Ray, Real)], query: Query, alone: bool) -> usize {
        let chunks = rays.par_chunks(16 * AT_ONCE);
        chunks.map(|rays| rays.chunks(AT_ONCE).map(|rays| self.ask_some(rays, query, alone)).sum::<usize>()).sum()
    }

    fn ask_some(&self, rays: &[(Ray, Real)], query: Query, alone: bool) -> usize {
        let Self { objects, meshes, accelerator } = self;
        let counts = |ray: &(Ray, Real), hit: &Option<Hit>| hit.is_some_and(|hit| hit.at.t <= ray.1);
        match (query, alone) {
            (Query::Closest, true) => {
                let hit = |ray: &(Ray, Real)| accelerator.closest_hit(objects, meshes, &ray.0);
                rays.iter().filter(|ray| counts(ray, &hit(ray))).count()
            }
            (Query::Closest, false) => {
                let just_rays: Vec<Ray> = rays.iter().map(|ray| ray.0).collect();
                let mut hits = Vec::new();
                accelerator.closest_hits(objects, meshes, &just_rays, &mut hits);
                rays.iter().zip(&hits).filter(|(ray, hit)| counts(ray, hit)).count()
            }
            (Query::Any, true) => {
                rays.iter().filter(|(ray, t_max)| accelerator.any_hit(objects, meshes, ray, *t_max)).count()
            }
            (Query::Any, false) => {
                let (just_rays, t_max): (Vec<Ray>, Vec<Real>) = rays.iter().copied().unzip();
                let mut found = Vec::new();
                accelerator.any_hits(objects, meshes, &just_rays, &t_max, &mut found);
                found.into_iter().filter(|&found| found).count()
            }
        }
    }
}

/// Seconds of the fastest, the middle and the slowest of some runs.
fn timed(repeats: usize, mut run: impl FnMut()) -> [f64; 3] {
    let mut seconds: Vec<f64> = (0..repeats.max(1))
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    [seconds[0], seconds[seconds.len() / 2], seconds[seconds.len() - 1]]
}

fn time_building(mesh: &Mesh, repeats: usize) -> Result<(), Box<dyn Error>> {
    for threads in [1, 2] {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(|| {
            let [best, middle, worst] = timed(repeats, || drop(mesh.built_tree())).map(|seconds| 1e3 * seconds);
            println!("build         threads {threads}  ms      {middle:7.2}  ({best:.2} .. {worst:.2})");
        });
    }
    let (mesh_bytes, tree_bytes) = mesh.bytes();
    let per_triangle = |bytes: usize| bytes as f64 / mesh.triangle_count() as f64;
    println!("bytes a triangle: mesh {:.1}, tree {:.1}", per_triangle(mesh_bytes), per_triangle(tree_bytes));
    Ok(())
}

fn read_rays(bytes: &[u8]) -> Result<Vec<(Ray, Real)>, Box<dyn Error>> {
    let (head, rest) = bytes.split_at_checked(16).ok_or("the ray file is too short")?;
    let count = u64::from_le_bytes(head[8..].try_into()?) as usize;
    if &head[..8] != b"A2RAYS1\0" || rest.len() != 28 * count {
        return Err("this is no ray file".into());
    }
    let (numbers, _) = rest.as_chunks::<4>();
    let numbers: Vec<Real> = numbers.iter().map(|&bytes| Real::from(f32::from_le_bytes(bytes))).collect();
    let ray = |n: &[Real]| {
        let (origin, direction) = (Vector3::new(n[0], n[1], n[2]), Vector3::new(n[3], n[4], n[5]));
        (Ray { origin, direction }, n[6])
    };
    Ok(numbers.chunks_exact(7).map(ray).collect())
}
