//! [`PacketTracer`]: does for 64 rays at a time what [`trace_ray`](crate::trace::trace_ray) does for one.
//!
//! The steps have the same names and come in the same order. Mirror rays of several packets are gathered into packets of
//! their own, one generation of bounces after the other.

use super::camera::camera_rays;
use super::cube_map::{self, CubeMapScratch};
use super::hit_packet::HitPacket;
use super::intersect::Scratch;
use super::light_culling::{FEW_LIGHTS, SurfaceBounds};
use super::mirror_queue::{MirrorQueue, PathPacket};
use super::normals::{NormalScratch, normals};
use super::shade::{LightPacket, SurfacePacket};
use crate::camera::{PixelGrid, Place};
use crate::light::Light;
use crate::options::Epsilon;
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::ray_offset::BesideSurface;
use crate::scene::Scene;
use crate::simd::Simd;
use crate::simd::packet::{PACKET, RayPacket, Scalars, has_lane, lanes_in};
use crate::timing::Deadline;
use crate::trace::{Seen, further_light, kept_finite};
use vecmath::{Real, Vector3};

/// So many packets of camera rays are followed together: their mirror rays fill packets of their own. Four pixels of 144
/// rays fill nine packets.
pub const PACKETS_AT_ONCE: usize = 9;

/// Follows packets of rays through a scene, and counts the rays.
pub struct PacketTracer<'a, S> {
    simd: S,
    scene: &'a Scene,
    plan: &'a Plan,
    /// How far along themselves shadow and mirror rays start, if that is how they do.
    epsilon: Real,
    deadline: Deadline,
    pub counts: RayCounts,
    /// A packet of camera rays; none while it is in use.
    camera_rays: Option<Box<(RayPacket, PathPacket)>>,
    scratch: Box<PacketScratch>,
    /// Mirror rays that are followed next.
    mirror_rays: MirrorQueue,
    /// Scratch: the generation that is being followed.
    spare: MirrorQueue,
}

/// What is known of a packet. It is kept for the next one, because clearing it would cost as much as tracing.
struct PacketScratch {
    hits: HitPacket,
    surfaces: SurfacePacket,
    /// With [`Epsilon::Auto`], where rays leave each surface, in the order of the lanes that are hit.
    beside: Vec<BesideSurface>,
    light: LightPacket,
    /// Shadow rays, and how far each goes. Made for the first ones.
    shadow_rays: Option<Box<(RayPacket, Scalars)>>,
    queries: Scratch,
    normals: NormalScratch,
    /// Made for the first rays that need it.
    cube_map: Option<Box<CubeMapScratch>>,
}

impl PacketScratch {
    const EMPTY: Self = Self {
        hits: HitPacket::NONE,
        surfaces: SurfacePacket::NONE,
        beside: Vec::new(),
        light: LightPacket::NONE,
        shadow_rays: None,
        queries: Scratch::EMPTY,
        normals: NormalScratch::EMPTY,
        cube_map: None,
    };
}

impl<'a, S: Simd> PacketTracer<'a, S> {
    pub fn new(simd: S, scene: &'a Scene, plan: &'a Plan, deadline: Deadline) -> Self {
        let epsilon = match plan.epsilon {
            Epsilon::Along(epsilon) => epsilon as Real,
            Epsilon::Auto => 0.0,
        };
        Self {
            simd,
            scene,
            plan,
            epsilon,
            deadline,
            counts: RayCounts::default(),
            camera_rays: None,
            scratch: Box::new(PacketScratch::EMPTY),
            mirror_rays: MirrorQueue::default(),
            spare: MirrorQueue::default(),
        }
    }

    /// Replaces `seen` by what the camera sees through each place. Places that lie side by side are traced fastest.
    /// Returns false if the deadline came before the end of a path.
    pub fn trace(&mut self, grid: PixelGrid, places: &[Place], seen: &mut Vec<Seen>) -> bool {
        let mut is_whole = true;
        self.counts.camera += places.len() as u64;
        // Paths set colours; without a colour picture they stay black.
        seen.truncate(if self.plan.color { places.len() } else { 0 });
        seen.resize(places.len(), Seen::default());
        let mut packet = self.camera_rays.take().unwrap_or_else(|| Box::new((RayPacket::NONE, PathPacket::NONE)));
        let (rays, paths) = &mut *packet;
        for (index, places) in places.chunks(PACKET).enumerate() {
            let active = camera_rays(self.simd, &self.scene.camera, grid, places, rays);
            let hit = self.find_hits(rays, active);
            self.counts.camera_hits += u64::from(hit.count_ones());
            let first = index * PACKET;
            if self.plan.depth || self.plan.normals {
                self.record(active, hit, &mut seen[first..]);
            }
            if self.plan.color {
                paths.start(first as u32);
                self.follow(rays, active, hit, paths, self.plan.bounces, seen);
                if index % PACKETS_AT_ONCE == PACKETS_AT_ONCE - 1 {
                    is_whole &= self.follow_mirror_rays(seen);
                }
            }
        }
        is_whole &= self.follow_mirror_rays(seen);
        self.camera_rays = Some(packet);
        is_whole
    }

    /// Follows the paths of the queue to their ends, one generation of mirror rays after the other. Returns false if the
    /// deadline came first; then the queue is emptied.
    fn follow_mirror_rays(&mut self, seen: &mut [Seen]) -> bool {
        let mut is_whole = true;
        let mut bounces = self.plan.bounces;
        let mut current = std::mem::take(&mut self.spare);
        while !self.mirror_rays.is_empty() {
            if self.deadline.is_over() {
                self.mirror_rays.clear();
                is_whole = false;
                break;
            }
            bounces -= 1;
            self.counts.mirror += self.mirror_rays.len() as u64;
            std::mem::swap(&mut current, &mut self.mirror_rays);
            self.mirror_rays.clear();
            for (rays, paths, active) in current.packets() {
                let hit = self.find_hits(rays, active);
                self.follow(rays, active, hit, paths, bounces, seen);
            }
        }
        self.spare = current;
        is_whole
    }

    /// Finds what the active rays hit, and normals and materials there. Returns the lanes that hit anything.
    fn find_hits(&mut self, rays: &mut RayPacket, active: u64) -> u64 {
        let (simd, scene) = (self.simd, self.scene);
        let PacketScratch { hits, surfaces, queries, normals: normal_scratch, .. } = &mut *self.scratch;
        scene.geometry.closest_hits(simd, rays, active, queries, hits);
        let hit = active & !hits.lanes_of(simd, active, HitPacket::NOTHING);
        let mut rest = if self.plan.shows_normals() { hit } else { 0 };
        if rest != 0 {
            // Loops run over these lanes too. Numbers at the end of the range would take the slow way there.
            lanes_in(!hit).for_each(|lane| hits.t[lane] = 0.0);
        }
        while rest != 0 {
            let index = hits.object[rest.trailing_zeros() as usize % PACKET];
            let of_object = hits.lanes_of(simd, rest, index);
            let object = &scene.geometry.objects[index as usize];
            normals(
                simd,
                object,
                &scene.geometry.meshes,
                rays,
                of_object,
                hits,
                rest != hit,
                normal_scratch,
                &mut surfaces.normal,
            );
            if self.plan.color {
                // Setting all lanes is cheapest; the lanes of other objects get their material in a later turn.
                let mask = if rest == hit { u64::MAX } else { of_object };
                surfaces.set_material(mask, object.material, &scene.materials[object.material as usize]);
            }
            rest &= !of_object;
        }
        hit
    }

    /// Sets what pictures of depths and normals show of the active camera rays.
    fn record(&self, active: u64, hit: u64, seen: &mut [Seen]) {
        let PacketScratch { hits, surfaces, .. } = &*self.scratch;
        for (lane, seen) in lanes_in(active).zip(seen) {
            let is_hit = has_lane(hit, lane);
            seen.depth = is_hit.then_some(hits.t[lane]);
            if self.plan.normals {
                seen.normal = if is_hit { surfaces.normal.get(lane) } else { Vector3::ZERO };
            }
        }
    }

    /// Follows paths along the active rays, of which some have `hit` something: to the background, where they end, or to
    /// a surface, where they end unless it is a mirror.
    fn follow(
        &mut self,
        rays: &RayPacket,
        active: u64,
        hit: u64,
        paths: &mut PathPacket,
        bounces: u32,
        seen: &mut [Seen],
    ) {
        self.add_background(rays, active & !hit, paths, seen);
        if hit == 0 {
            return;
        }
        self.arrive(rays, hit);
        self.add_lights(hit);
        let surfaces = &self.scratch.surfaces;
        surfaces.add_to_paths(self.simd, self.scene.ambient_light, hit, paths);
        let mut goes_on = if bounces > 0 { hit & surfaces.mirrors } else { 0 };
        if goes_on != 0 {
            let further = further_light(self.scene, self.plan, bounces - 1);
            goes_on = surfaces.lower_throughput(self.simd, further, goes_on, paths);
            self.leave(hit, goes_on, paths);
        }
        paths.end(hit & !goes_on, seen);
    }

    /// Adds the background to the paths of the active rays, and ends them.
    fn add_background(&mut self, rays: &RayPacket, active: u64, paths: &mut PathPacket, seen: &mut [Seen]) {
        if active == 0 {
            return;
        }
        let background = &self.scene.background;
        match &background.cube_map {
            None => paths.add(
                self.simd,
                active,
                #[inline(always)]
                |_| background.color,
            ),
            Some(cube_map) => {
                let scratch = self.scratch.cube_map.get_or_insert_with(|| Box::new(CubeMapScratch::EMPTY));
                let colors = cube_map::colors(self.simd, cube_map, &rays.direction, active, scratch);
                paths.add(
                    self.simd,
                    active,
                    #[inline(always)]
                    |lane| colors.get(lane),
                );
            }
        }
        paths.end(active, seen);
    }

    /// Has the mirror rays of `goes_on`, a part of the points of `hit`, followed later.
    fn leave(&mut self, hit: u64, goes_on: u64, paths: &mut PathPacket) {
        let PacketScratch { surfaces, beside, .. } = &mut *self.scratch;
        if self.plan.epsilon != Epsilon::Auto {
            surfaces.start_mirror_rays(self.simd, goes_on, self.epsilon);
        }
        for (lane, beside) in lanes_in(hit).zip(beside.iter()) {
            let ray = beside.mirror_ray(surfaces.reflected.get(lane), self.plan.robust);
            surfaces.point.set(lane, ray.origin);
            surfaces.reflected.set(lane, ray.direction);
        }
        if !self.scene.throughput_never_grows {
            for lane in lanes_in(goes_on) {
                let (color, throughput) =
                    kept_finite(self.scene, paths.color.get(lane), paths.throughput.get(lane));
                paths.color.set(lane, color);
                paths.throughput.set(lane, throughput);
            }
        }
        self.mirror_rays.append(goes_on, &surfaces.point, &surfaces.reflected, paths);
    }

    /// Finds the points that the rays of a mask have hit, and the mirrored directions.
    fn arrive(&mut self, rays: &RayPacket, hit: u64) {
        let PacketScratch { hits, surfaces, beside, .. } = &mut *self.scratch;
        beside.clear();
        if self.plan.epsilon == Epsilon::Auto {
            for lane in lanes_in(hit) {
                let (ray, object) = (rays.get(lane), &self.scene.geometry.objects[hits.object[lane] as usize]);
                let surface = object.surface_point(&self.scene.geometry.meshes, &ray, &hits.surface(lane));
                surfaces.point.set(lane, surface.point);
                beside.push(BesideSurface::new(&ray, surface));
            }
        } else {
            surfaces.set_points(self.simd, rays, hit, &hits.t);
        }
        surfaces.mirror_rays(self.simd, rays, hit);
    }

    /// Adds to the points of a mask what they reflect of each light that is not blocked.
    fn add_lights(&mut self, mask: u64) {
        let lights = &self.scene.lights;
        if lights.len() <= FEW_LIGHTS {
            return lights.iter().for_each(|light| self.add_light(light, mask));
        }
        let bounds = SurfaceBounds::of(self.simd, &self.scratch.surfaces, mask);
        for light in lights {
            if !bounds.are_dark_to(light) {
                self.add_light(light, mask);
            } else if self.plan.shadows {
                self.counts.shadow_left_out += u64::from(mask.count_ones());
            }
        }
    }

    /// Adds to the points of a mask what they reflect of a light, unless it is blocked.
    fn add_light(&mut self, light: &Light, mask: u64) {
        let PacketScratch { surfaces, light: seen, .. } = &mut *self.scratch;
        let mut lit = seen.illuminate(self.simd, light, surfaces, mask);
        if self.plan.shadows {
            // No shadow ray where the light contributes exactly zero.
            self.counts.shadow_left_out += u64::from((mask & !lit).count_ones());
            self.counts.shadow += u64::from(lit.count_ones());
            lit &= !self.blocked(light, mask, lit);
        }
        let PacketScratch { surfaces, light: seen, .. } = &mut *self.scratch;
        surfaces.add(self.simd, seen, lit);
    }

    /// Returns the points of `lit`, a part of `mask`, whose shadow ray is blocked.
    fn blocked(&mut self, light: &Light, mask: u64, lit: u64) -> u64 {
        if lit == 0 {
            return 0;
        }
        let PacketScratch { surfaces, beside, light: seen, shadow_rays, queries, .. } = &mut *self.scratch;
        let shadow_rays = shadow_rays.get_or_insert_with(|| Box::new((RayPacket::NONE, [0.0; PACKET])));
        let (shadow_rays, shadow_t_max) = &mut **shadow_rays;
        let (epsilon, is_robust) = (self.epsilon, self.plan.robust);
        if self.plan.epsilon != Epsilon::Auto {
            seen.shadow_rays(self.simd, surfaces, lit, epsilon, is_robust, shadow_rays, shadow_t_max);
        }
        for (lane, beside) in lanes_in(mask).zip(beside.iter()) {
            let (to_light, distance) = (seen.to_light.get(lane), seen.distance[lane]);
            let (ray, t_max) = beside.shadow_ray(light, to_light, distance, is_robust);
            shadow_rays.set(lane, ray);
            shadow_t_max[lane] = t_max;
        }
        self.scene.geometry.any_hits(self.simd, shadow_rays, lit, queries, shadow_t_max)
    }
}
