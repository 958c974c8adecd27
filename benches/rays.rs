//! Rays a second in one mesh, and building times, in the form that `benches/peers/rays.py` reads.
//!
//! ```text
//! rays MESH.obj --rays FILE [--threads N] [--repeats N] [--simd LEVEL] [--alone]
//! rays MESH.obj --build [--repeats N]
//! ```
//!
//! The ray file is described in `benches/peers/README.md`. Rays are asked for 64 at a time, as the renderer does;
//! with `--alone` one by one. What is timed is the whole answer, from rays as the file has them to hits in `f64`.
#![forbid(unsafe_code)]

use a2::accel::Accelerator;
use a2::accel::simd::Level;
use a2::objects::HitRun;
use a2::objects::run::{Numbers, RUN, RayRun, first, numbers_in};
use a2::objects::{Mesh, Object, Shape};
use a2::scene::parse_mesh;
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use vecmath::Real;

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
    mesh.build_tree();
    mesh.set_level(level);
    let rays = read_rays(&std::fs::read(value("--rays").ok_or("--rays FILE or --build is missing")?)?)?;
    let count: u32 = rays.iter().map(|run| run.mask.count_ones()).sum();
    let scene = Scene::new(mesh, level);
    let alone = words.iter().any(|word| word == "--alone");
    let threads = number("--threads", 1)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(|| {
        for (name, query) in [("closest_hit", Query::Closest), ("any_hit", Query::Any)] {
            let mut hits = 0;
            let rates = timed(repeats, || hits = scene.ask(&rays, query, alone));
            let rates = rates.map(|seconds| f64::from(count) / seconds / 1e6);
            println!(
                "{name:<13} threads {threads}  Mrays/s {:7.2}  ({:.2} .. {:.2})  hits {hits} of {}",
                rates[1], rates[2], rates[0], count
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

/// Rays that are asked about together: origin, direction and largest t, as precise as the file has them.
struct Run {
    numbers: [[f32; RUN]; 7],
    mask: u64,
}

/// What a thread has room for.
struct Room {
    rays: RayRun,
    t_max: Numbers,
    hits: HitRun,
}

impl Room {
    const EMPTY: Self = Self { rays: RayRun::NONE, t_max: [0.0; RUN], hits: HitRun::NONE };

    /// Takes the rays of a run in.
    fn read(&mut self, run: &Run) {
        let [origin, direction] = [&mut self.rays.origin.0, &mut self.rays.direction.0];
        let into = origin.iter_mut().chain(direction).chain([&mut self.t_max]);
        for (into, from) in into.zip(&run.numbers) {
            for (into, from) in into.iter_mut().zip(from) {
                *into = Real::from(*from);
            }
        }
    }
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
    fn ask(&self, runs: &[Run], query: Query, alone: bool) -> usize {
        let of_chunk = |runs: &[Run]| {
            let mut room = Room::EMPTY;
            let mut ask = |run: &Run| {
                room.read(run);
                self.ask_run(run.mask, query, alone, &mut room)
            };
            runs.iter().map(&mut ask).sum::<usize>()
        };
        runs.par_chunks(64).map(of_chunk).sum()
    }

    fn ask_run(&self, mask: u64, query: Query, alone: bool, room: &mut Room) -> usize {
        let Self { objects, meshes, accelerator } = self;
        let Room { rays, t_max, hits } = room;
        let count = |is_hit: &dyn Fn(usize) -> bool| numbers_in(mask).filter(|&number| is_hit(number)).count();
        match (query, alone) {
            (Query::Closest, true) => count(&|number| {
                let hit = accelerator.closest_hit(objects, meshes, &rays.get(number));
                hit.is_some_and(|hit| hit.at.t <= t_max[number])
            }),
            (Query::Closest, false) => {
                accelerator.closest_hits(objects, meshes, rays, mask, hits);
                let is_hit = |number: usize| hits.object[number] != HitRun::NOTHING;
                let is_near = |number: usize| hits.at.t[number] <= t_max[number];
                // Nothing is hit outside the mask.
                (0..RUN).map(|number| usize::from(is_hit(number) & is_near(number))).sum()
            }
            (Query::Any, true) => {
                count(&|number| accelerator.any_hit(objects, meshes, &rays.get(number), t_max[number]))
            }
            (Query::Any, false) => accelerator.any_hits(objects, meshes, rays, mask, t_max).count_ones() as usize,
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

/// Rays by coordinates, as the renderer has them.
fn read_rays(bytes: &[u8]) -> Result<Vec<Run>, Box<dyn Error>> {
    let (head, rest) = bytes.split_at_checked(16).ok_or("the ray file is too short")?;
    let count = u64::from_le_bytes(head[8..].try_into()?) as usize;
    if &head[..8] != b"A2RAYS1\0" || rest.len() != 28 * count {
        return Err("this is no ray file".into());
    }
    let (numbers, _) = rest.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
    let run = |rays: &[f32]| {
        let mut run = Run { numbers: [[1.0; RUN]; 7], mask: first(rays.len() / 7) };
        for (ray, numbers) in rays.chunks_exact(7).enumerate() {
            for (apart, number) in run.numbers.iter_mut().zip(numbers) {
                apart[ray] = *number;
            }
        }
        run
    };
    Ok(numbers.chunks(7 * RUN).map(run).collect())
}
