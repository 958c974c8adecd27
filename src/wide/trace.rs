//! What rays see: the heart of the program.
//!
//! Rays go in runs of 64. Everything that is computed for each of them is computed for the run, several rays an
//! instruction; the formulas are those of [`light`](crate::light) and [`material`](crate::material).

use super::robust::Departure;
use super::surfaces::{AddLight, Arrive, Gather, Illuminate, Lit, ShadowRays, Surfaces};
use crate::light::Light;
use crate::objects::HitRun;
use crate::objects::run::{Lanewise, Numbers, RUN, RayRun, Rays, Runs, Vectors, numbers_in};
use crate::options::Epsilon;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::scene::Scene;
use vecmath::{Real, Vector3};

/// So many runs of camera rays are followed together: their mirror rays fill runs of their own.
pub const RUNS_AT_ONCE: usize = 4;

/// What a camera ray saw.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Zero unless a colour picture is asked for.
    pub color: Vector3,
    /// Distance of the nearest hit.
    pub depth: Option<Real>,
    /// Normal at the nearest hit, zero without one or unless a picture needs it.
    pub normal: Vector3,
}

/// Follows rays through a scene, and counts them.
pub struct Tracer<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    /// Weights never grow on their way from mirror to mirror.
    weights_never_grow: bool,
    /// How far along themselves shadow and mirror rays start, if that is how they do.
    epsilon: Real,
    pub counts: RayCounts,
    room: Box<Room>,
    /// Those to be followed next.
    mirror_rays: MirrorRays,
    /// Room for others.
    spare: MirrorRays,
}

/// Room for what is known of a run of rays, kept to spare setting it up for each.
struct Room {
    hits: HitRun,
    surfaces: Surfaces,
    /// One for each ray that has hit something, in order, where rays start just off a surface; none where they start at
    /// a fixed distance.
    departures: Vec<Departure>,
    lit: Lit,
    shadow_rays: RayRun,
    /// How far each shadow ray goes.
    distances: Numbers,
    background: Vectors,
    paths: Option<Box<Paths>>,
}

/// What has been gathered on the way from the camera.
#[derive(Clone)]
struct Paths {
    camera_ray: [u32; RUN],
    color: Vectors,
    /// What further light counts.
    weight: Vectors,
}

/// Mirror rays that have passed as many mirrors as each other.
type MirrorRays = Runs<(RayRun, Paths)>;

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a Scene, plan: &'a Plan) -> Self {
        let weights_never_grow = scene.materials.iter().all(|material| material.specular.max_abs() <= 1.0);
        let epsilon = match plan.epsilon {
            Epsilon::Along(epsilon) => epsilon as Real,
            Epsilon::Auto => 0.0,
        };
        let counts = RayCounts::default();
        Self {
            scene,
            plan,
            weights_never_grow,
            epsilon,
            counts,
            room: Box::default(),
            mirror_rays: Runs::default(),
            spare: Runs::default(),
        }
    }

    /// What rays from the camera see, one entry of `seen` for each. Rays that lie side by side are best asked about
    /// together.
    ///
    /// The recursion of the course, written as a loop with running weights: as deep as `-bounces` asks for without
    /// growing the stack, and all rays take each step together.
    pub fn see(&mut self, rays: &Rays, seen: &mut Vec<Seen>) {
        self.counts.camera += rays.len() as u64;
        seen.clear();
        for (index, (rays, mask)) in rays.runs().enumerate() {
            let hit = self.find_hits(rays, mask);
            let camera_ray = seen.len();
            self.record(mask, hit, seen);
            if self.plan.color {
                let mut paths = self.room.paths.take().unwrap_or_else(|| Box::new(Paths::NONE));
                paths.start(camera_ray);
                self.follow(rays, mask, hit, &mut paths, self.plan.bounces, seen);
                self.room.paths = Some(paths);
                if index % RUNS_AT_ONCE == RUNS_AT_ONCE - 1 {
                    self.follow_mirror_rays(seen);
                }
            }
        }
        self.follow_mirror_rays(seen);
    }

    /// Follows all paths that have passed one mirror to their ends.
    fn follow_mirror_rays(&mut self, seen: &mut [Seen]) {
        let mut bounces = self.plan.bounces;
        let mut current = std::mem::take(&mut self.spare);
        while !self.mirror_rays.is_empty() {
            bounces -= 1;
            self.counts.mirror += self.mirror_rays.len() as u64;
            std::mem::swap(&mut current, &mut self.mirror_rays);
            self.mirror_rays.clear();
            for ((rays, paths), mask) in current.runs_mut() {
                let hit = self.find_hits(rays, mask);
                self.follow(rays, mask, hit, paths, bounces, seen);
            }
        }
        self.spare = current;
    }

    /// Finds what the rays of a mask hit, and the normals there. The output are those that hit anything.
    fn find_hits(&mut self, rays: &RayRun, mask: u64) -> u64 {
        let scene = self.scene;
        let Room { hits, surfaces, .. } = &mut *self.room;
        scene.accelerator.closest_hits(&scene.objects, &scene.meshes, rays, mask, hits);
        let level = self.plan.simd;
        let hit = mask & !hits.of_object(level, mask, HitRun::NOTHING);
        let mut rest = if self.plan.color || self.plan.normals { hit } else { 0 };
        while rest != 0 {
            let index = hits.object[rest.trailing_zeros() as usize % RUN];
            let of_object = hits.of_object(level, rest, index);
            let object = &scene.objects[index as usize];
            object.normals(&scene.meshes, level, rays, of_object, &hits.at, &mut surfaces.normal);
            if self.plan.color {
                // The first object's material may stand for all others until they are asked.
                let mask = if rest == hit { u64::MAX } else { of_object };
                surfaces.set_material(mask, &scene.materials[object.material as usize]);
            }
            rest &= !of_object;
        }
        hit
    }

    /// Notes what pictures of depths and normals show of the rays of a mask.
    fn record(&self, mask: u64, hit: u64, seen: &mut Vec<Seen>) {
        let Room { hits, surfaces, .. } = &*self.room;
        for number in numbers_in(mask) {
            let mut what = Seen::default();
            if hit >> number & 1 == 1 {
                what.depth = Some(hits.at.t[number]);
                if self.plan.normals {
                    what.normal = surfaces.normal.get(number);
                }
            }
            seen.push(what);
        }
    }

    /// Follows paths that have gone on along the rays of a mask, of which some have `hit` something: to the background,
    /// where they end, or to a surface, where they end unless it is a mirror and may still matter.
    fn follow(&mut self, rays: &RayRun, mask: u64, hit: u64, paths: &mut Paths, bounces: u32, seen: &mut [Seen]) {
        self.leave(rays, mask & !hit, paths, seen);
        if hit == 0 {
            return;
        }
        self.arrive(rays, hit);
        self.shade(hit);
        let Room { surfaces, departures, .. } = &*self.room;
        let Paths { color, weight, .. } = paths;
        self.plan.simd.run(Gather { ambient: self.scene.ambient_light, surfaces, mask: hit, weight, color });
        let mut departures = departures.iter();
        let mirrors = if bounces > 0 { surfaces.mirrors } else { 0 };
        for number in numbers_in(hit) {
            let departure = departures.next();
            let (color, weight) = (paths.color.get(number), paths.weight.get(number));
            let is_mirror = mirrors >> number & 1 == 1;
            if !is_mirror || self.no_longer_matters(color, weight, bounces - 1) {
                seen[paths.camera_ray[number] as usize].color = color;
                continue;
            }
            let ray = match departure {
                Some(departure) => departure.mirror_ray(surfaces.reflected.get(number), self.plan.robust),
                None => surfaces.mirror_ray(number, self.epsilon),
            };
            let ((next_rays, next_paths), place) = self.mirror_rays.add();
            next_rays.set(place, ray);
            next_paths.camera_ray[place] = paths.camera_ray[number];
            next_paths.color.set(place, color);
            next_paths.weight.set(place, weight);
        }
    }

    /// Ends the paths of rays that leave the scene.
    fn leave(&mut self, rays: &RayRun, mask: u64, paths: &Paths, seen: &mut [Seen]) {
        let background = &self.scene.background;
        if mask == 0 {
            return;
        }
        let colors = &mut self.room.background;
        if let Some(cube_map) = &background.cube_map {
            cube_map.colors(self.plan.simd, &rays.direction, mask, colors);
        }
        for number in numbers_in(mask) {
            let light = if background.cube_map.is_some() { colors.get(number) } else { background.color };
            let color = paths.color.get(number) + paths.weight.get(number).scaled_by(light);
            seen[paths.camera_ray[number] as usize].color = color;
        }
    }

    /// Finds out where on surfaces rays have arrived.
    fn arrive(&mut self, rays: &RayRun, hit: u64) {
        let Room { hits, surfaces, departures, .. } = &mut *self.room;
        departures.clear();
        if self.plan.epsilon != Epsilon::Auto {
            return self.plan.simd.run(Arrive { rays, mask: hit, t: Some(&hits.at.t), surfaces });
        }
        for number in numbers_in(hit) {
            let (ray, object) = (rays.get(number), &self.scene.objects[hits.object[number] as usize]);
            let surface = object.surface_point(&self.scene.meshes, &ray, &hits.at.get(number));
            surfaces.point.set(number, surface.point);
            departures.push(Departure::new(&ray, surface));
        }
        self.plan.simd.run(Arrive { rays, mask: hit, t: None, surfaces });
    }

    /// Whether everything that can still be added to `color` leaves every bit of it as it is.
    fn no_longer_matters(&self, color: Vector3, weight: Vector3, bounces: u32) -> bool {
        if weight == Vector3::ZERO {
            return true;
        }
        let Some(bound) = self.plan.radiance_bound else {
            return false;
        };
        let rest = Real::from(bounces as f32 + 1.0) * bound;
        self.weights_never_grow && (0..3).all(|c| color[c] + weight[c].abs() * rest == color[c])
    }

    /// Adds up the light that the surfaces of a mask send back along their rays, mirrors aside.
    fn shade(&mut self, mask: u64) {
        for light in &self.scene.lights {
            let Room { surfaces, lit, .. } = &mut *self.room;
            let mut added = self.plan.simd.run(Illuminate { light, surfaces, mask, lit });
            if self.plan.shadows {
                // Blocked or not, a light that adds nothing adds nothing.
                self.counts.shadow_left_out += u64::from((mask & !added).count_ones());
                self.counts.shadow += u64::from(added.count_ones());
                added &= !self.blocked(light, mask, added);
            }
            let Room { surfaces, lit, .. } = &mut *self.room;
            self.plan.simd.run(AddLight { lit, mask: added, surfaces });
        }
    }

    /// Those surfaces of `asking`, a part of `mask`, that something keeps a light from.
    fn blocked(&mut self, light: &Light, mask: u64, asking: u64) -> u64 {
        if asking == 0 {
            return 0;
        }
        let Room { surfaces, departures, lit, shadow_rays, distances, .. } = &mut *self.room;
        let (epsilon, robust) = (self.epsilon, self.plan.robust);
        if self.plan.epsilon != Epsilon::Auto {
            let (rays, t_max) = (&mut *shadow_rays, &mut *distances);
            self.plan.simd.run(ShadowRays { surfaces, lit, mask: asking, epsilon, robust, rays, t_max });
        }
        for (number, departure) in numbers_in(mask).zip(departures.iter()) {
            let (ray, distance) = match robust {
                true => departure.shadow_ray(light),
                false => departure.plain_shadow_ray(lit.to_light.get(number), lit.distance[number]),
            };
            shadow_rays.set(number, ray);
            distances[number] = distance;
        }
        let scene = self.scene;
        scene.accelerator.any_hits(&scene.objects, &scene.meshes, shadow_rays, asking, distances)
    }

    /// The directions in which rays from the camera leave the scene, at once or after a few mirrors.
    pub fn escaping(&mut self, rays: Rays) -> Vec<Vector3> {
        const MIRRORS: u32 = 4;
        let (mut rays, mut escaped) = (rays, Vec::new());
        for _ in 0..=self.plan.bounces.min(MIRRORS) {
            let mut onward = Rays::default();
            for (run, mask) in rays.runs() {
                let hit = self.find_hits(run, mask);
                self.arrive(run, hit);
                escaped.extend(numbers_in(mask & !hit).map(|number| run.direction.get(number)));
                let surfaces = &self.room.surfaces;
                numbers_in(hit & surfaces.mirrors)
                    .for_each(|number| onward.push(surfaces.mirror_ray(number, self.epsilon)));
            }
            rays = onward;
        }
        escaped
    }
}

impl Paths {
    const NONE: Self = Self { camera_ray: [0; RUN], color: Vectors::ZERO, weight: Vectors([[1.0; RUN]; 3]) };

    /// Begins paths, the first one for this camera ray, the others for those after it.
    fn start(&mut self, camera_ray: usize) {
        *self = Self::NONE;
        for (number, place) in self.camera_ray.iter_mut().enumerate() {
            *place = (camera_ray + number) as u32;
        }
    }
}

impl Lanewise for (RayRun, Paths) {
    const NONE: Self = (RayRun::NONE, Paths::NONE);
}

impl Default for Room {
    fn default() -> Self {
        Self {
            hits: HitRun::NONE,
            surfaces: Surfaces::NONE,
            departures: Vec::new(),
            lit: Lit::NONE,
            shadow_rays: RayRun::NONE,
            distances: [0.0; RUN],
            background: Vectors::ZERO,
            paths: None,
        }
    }
}
