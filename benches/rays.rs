//! Measures rays a second in one mesh, and building times. `benches/peers/rays.py` reads the output.
//!
//! ```text
//! rays MESH.obj --rays FILE [--threads N] [--repeats N] [--simd NAME] [--single]
//! rays MESH.obj --build [--repeats N]
//! ```
//!
//! `benches/peers/README.md` describes the ray file. Queries are for packets of 64 rays, as in the renderer, or for
//! single rays with `--single`. The time is that of whole queries, from the rays of the file to hits in `f64`.
#![forbid(unsafe_code)]

use a2::objects::{Mesh, Object, Shape};
use a2::scene::{Geometry, build_mesh_tree, parse_mesh};
use a2::simd::packet::{PACKET, RayPacket, Scalars, first_lanes, lanes_in};
use a2::simd::{InstructionSet, Simd, with_simd};
use a2::wide::{HitPacket, Scratch};
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use vecmath::Real;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let Some(mesh_path) = words.first().map(Path::new) else {
        println!(
            "rays MESH.obj --rays FILE [--threads N] [--repeats N] [--simd NAME] [--single], or MESH.obj --build"
        );
        return Ok(());
    };
    let value = |flag: &str| words.iter().position(|word| word == flag).and_then(|at| words.get(at + 1));
    let number = |flag: &str, default: usize| value(flag).map_or(Ok(default), |word| word.parse());
    let repeats = number("--repeats", 5)?;
    let mesh = parse_mesh(mesh_path, &std::fs::read(mesh_path)?)?.mesh;
    if words.iter().any(|word| word == "--build") {
        return time_building(&mesh, repeats);
    }
    let set = match value("--simd") {
        Some(name) => InstructionSet::named(name).ok_or("no such instruction set here")?,
        None => InstructionSet::detected(),
    };
    let rays = read_rays(&std::fs::read(value("--rays").ok_or("--rays FILE or --build is missing")?)?)?;
    let count: u32 = rays.iter().map(|packet| packet.active.count_ones()).sum();
    let object = Object::new(Shape::Mesh(0), None, 0, Some(mesh.bounds()));
    let geometry = Geometry::new(vec![object], vec![mesh], set);
    let single = words.iter().any(|word| word == "--single" || word == "--alone");
    let threads = number("--threads", 1)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(|| {
        for (name, query) in [("closest_hit", Query::Closest), ("any_hit", Query::Any)] {
            let mut hits = 0;
            let rates = timed(repeats, || {
                hits = with_simd!(set, simd => count_hits(simd, &geometry, &rays, query, single))
            });
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

/// A packet of the file: origins, directions and largest t.
struct Packet {
    numbers: [[f32; PACKET]; 7],
    active: u64,
}

/// Scratch of a thread.
struct Buffers {
    rays: RayPacket,
    t_max: Scalars,
    hits: HitPacket,
    scratch: Scratch,
}

impl Buffers {
    fn new() -> Self {
        Self { rays: RayPacket::NONE, t_max: [0.0; PACKET], hits: HitPacket::NONE, scratch: Scratch::EMPTY }
    }

    /// Converts the rays of a packet to `f64`.
    fn read(&mut self, packet: &Packet) {
        let [origin, direction] = [&mut self.rays.origin.0, &mut self.rays.direction.0];
        let into = origin.iter_mut().chain(direction).chain([&mut self.t_max]);
        for (into, from) in into.zip(&packet.numbers) {
            for (into, from) in into.iter_mut().zip(from) {
                *into = Real::from(*from);
            }
        }
    }
}

/// Counts the rays that hit something.
fn count_hits<S: Simd>(simd: S, geometry: &Geometry, packets: &[Packet], query: Query, single: bool) -> usize {
    // Each thread keeps its scratch, as in the renderer.
    let of_packet = |buffers: &mut Box<Buffers>, packet: &Packet| {
        buffers.read(packet);
        match single {
            true => count_singly(geometry, packet.active, query, buffers),
            false => count_in_packet(simd, geometry, packet.active, query, buffers),
        }
    };
    packets.par_iter().with_min_len(64).map_init(|| Box::new(Buffers::new()), of_packet).sum()
}

fn count_singly(geometry: &Geometry, active: u64, query: Query, buffers: &Buffers) -> usize {
    let is_hit = |&lane: &usize| {
        let (ray, t_max) = (buffers.rays.get(lane), buffers.t_max[lane]);
        match query {
            Query::Closest => geometry.closest_hit(&ray).is_some_and(|hit| hit.surface.t <= t_max),
            Query::Any => geometry.any_hit(&ray, t_max),
        }
    };
    lanes_in(active).filter(is_hit).count()
}

fn count_in_packet<S: Simd>(
    simd: S,
    geometry: &Geometry,
    active: u64,
    query: Query,
    buffers: &mut Buffers,
) -> usize {
    let Buffers { rays, t_max, hits, scratch } = buffers;
    match query {
        Query::Closest => {
            geometry.closest_hits(simd, rays, active, scratch, hits);
            let is_hit = |lane: usize| hits.object[lane] != HitPacket::NOTHING;
            let is_near = |lane: usize| hits.t[lane] <= t_max[lane];
            // Inactive lanes hit nothing.
            (0..PACKET).map(|lane| usize::from(is_hit(lane) & is_near(lane))).sum()
        }
        Query::Any => geometry.any_hits(simd, rays, active, scratch, t_max).count_ones() as usize,
    }
}

/// Returns the seconds of the fastest, the median and the slowest run.
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
            let [best, middle, worst] =
                timed(repeats, || drop(build_mesh_tree(mesh))).map(|seconds| 1e3 * seconds);
            println!("build         threads {threads}  ms      {middle:7.2}  ({best:.2} .. {worst:.2})");
        });
    }
    let (mesh_bytes, tree_bytes) = (mesh.bytes(), build_mesh_tree(mesh).map_or(0, |tree| tree.bytes()));
    let per_triangle = |bytes: usize| bytes as f64 / mesh.triangle_count() as f64;
    println!("bytes a triangle: mesh {:.1}, tree {:.1}", per_triangle(mesh_bytes), per_triangle(tree_bytes));
    Ok(())
}

/// Reads packets of rays.
fn read_rays(bytes: &[u8]) -> Result<Vec<Packet>, Box<dyn Error>> {
    let (head, rest) = bytes.split_at_checked(16).ok_or("the ray file is too short")?;
    let count = u64::from_le_bytes(head[8..].try_into()?) as usize;
    if &head[..8] != b"A2RAYS1\0" || rest.len() != 28 * count {
        return Err("this is no ray file".into());
    }
    let (numbers, _) = rest.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
    let packet = |rays: &[f32]| {
        let mut packet = Packet { numbers: [[1.0; PACKET]; 7], active: first_lanes(rays.len() / 7) };
        for (ray, numbers) in rays.chunks_exact(7).enumerate() {
            for (apart, number) in packet.numbers.iter_mut().zip(numbers) {
                apart[ray] = *number;
            }
        }
        packet
    };
    Ok(numbers.chunks(7 * PACKET).map(packet).collect())
}
