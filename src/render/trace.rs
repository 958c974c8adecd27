//! What one ray sees: the heart of the program.

use super::robust::{Departure, Epsilon, shadow_limit};
use crate::accel::Hit;
use crate::light::Illumination;
use crate::material::mirrored;
use crate::objects::Ray;
use crate::plan::Plan;
use crate::report::RayCounts;
use crate::scene::Scene;
use vecmath::{Real, Vector3};

/// What a camera ray saw.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Zero unless a colour picture is asked for.
    pub color: Vector3,
    /// Distance of the nearest hit.
    pub depth: Option<Real>,
    /// Normal at the nearest hit, zero without one.
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
    batch: Batch,
}

/// The rays that are followed together, and what is known of them. Kept to spare allocations.
#[derive(Default)]
struct Batch {
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    paths: Vec<Path>,
    surfaces: Vec<Surface>,
    /// One a surface, where rays start just off it; none where they start at a fixed distance.
    departures: Vec<Departure>,
    shadow_rays: Vec<Ray>,
    /// How far each shadow ray goes.
    distances: Vec<Real>,
    /// For each shadow ray: the surface, and what the light adds to it if nothing is in the way.
    shadowed: Vec<(usize, Vector3)>,
    blocked: Vec<bool>,
}

/// What has been gathered on the way from the camera, and what further light counts.
struct Path {
    camera_ray: usize,
    color: Vector3,
    weight: Vector3,
}

/// A point that is being shaded.
struct Surface {
    point: Vector3,
    normal: Vector3,
    /// The mirrored ray direction.
    reflected: Vector3,
    material: u32,
    /// Light that the surface sends back along the ray, mirrors aside.
    color: Vector3,
}

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a Scene, plan: &'a Plan) -> Self {
        let weights_never_grow = scene.materials.iter().all(|material| material.specular.max_abs() <= 1.0);
        let epsilon = match plan.epsilon {
            Epsilon::Along(epsilon) => epsilon as Real,
            Epsilon::Auto => 0.0,
        };
        Self { scene, plan, weights_never_grow, epsilon, counts: RayCounts::default(), batch: Batch::default() }
    }

    /// What rays from the camera see, one entry of `seen` for each. Rays that lie side by side are best asked about
    /// together.
    pub fn see(&mut self, rays: &[Ray], seen: &mut Vec<Seen>) {
        self.counts.camera += rays.len() as u64;
        let mut batch = std::mem::take(&mut self.batch);
        batch.rays.clear();
        batch.rays.extend_from_slice(rays);
        self.closest_hits(&batch.rays, &mut batch.hits);
        seen.clear();
        for (ray, hit) in rays.iter().zip(&batch.hits) {
            let normal = hit.as_ref().filter(|_| self.plan.normals).map(|hit| self.normal(ray, hit));
            let depth = hit.as_ref().map(|hit| hit.at.t);
            seen.push(Seen { depth, normal: normal.unwrap_or_default(), ..Seen::default() });
        }
        if self.plan.color {
            self.see_colors(&mut batch, seen);
        }
        self.batch = batch;
    }

    /// The directions in which rays from the camera leave the scene, at once or after a few mirrors.
    pub fn escaping(&self, rays: &[Ray]) -> Vec<Vector3> {
        const MIRRORS: u32 = 4;
        let (mut rays, mut hits, mut escaped) = (rays.to_vec(), Vec::new(), Vec::new());
        for _ in 0..=self.plan.bounces.min(MIRRORS) {
            self.closest_hits(&rays, &mut hits);
            let onward = rays.iter().zip(&hits).filter_map(|(ray, hit)| {
                let Some(hit) = hit else {
                    escaped.push(ray.direction);
                    return None;
                };
                let object = &self.scene.objects[hit.object as usize];
                let reflected = mirrored(ray.direction, self.normal(ray, hit));
                let origin = ray.at(hit.at.t) + reflected * self.epsilon;
                let is_mirror = self.scene.materials[object.material as usize].is_mirror();
                is_mirror.then_some(Ray { origin, direction: reflected })
            });
            rays = onward.collect();
        }
        escaped
    }

    /// The colours of rays whose nearest hits are known, mirrors included.
    ///
    /// The recursion of the course, written as a loop with running weights: as deep as `-bounces` asks for without
    /// growing the stack, and all rays take each step together.
    fn see_colors(&mut self, batch: &mut Batch, seen: &mut [Seen]) {
        let start = |camera_ray| Path { camera_ray, color: Vector3::ZERO, weight: Vector3::splat(1.0) };
        batch.paths.clear();
        batch.paths.extend((0..batch.rays.len()).map(start));
        let mut bounces = self.plan.bounces;
        loop {
            self.find_surfaces(batch, seen);
            self.shade(batch);
            let last = bounces == 0;
            bounces = bounces.saturating_sub(1);
            batch.rays.clear();
            let mut surfaces = batch.surfaces.iter().enumerate();
            batch.paths.retain_mut(|path| {
                // There is a surface for every path.
                let Some((index, surface)) = surfaces.next() else { return false };
                let material = &self.scene.materials[surface.material as usize];
                path.color += path.weight.scaled_by(surface.color);
                let mut goes_on = !last && material.is_mirror();
                if goes_on {
                    path.weight = path.weight.scaled_by(material.specular);
                    goes_on = !self.no_longer_matters(path.color, path.weight, bounces);
                }
                if goes_on {
                    batch.rays.push(match batch.departures.get(index) {
                        Some(departure) => departure.mirror_ray(surface.reflected, self.plan.robust),
                        None => surface.mirror_ray(self.epsilon),
                    });
                } else {
                    seen[path.camera_ray].color = path.color;
                }
                goes_on
            });
            if batch.paths.is_empty() {
                return;
            }
            self.counts.mirror += batch.rays.len() as u64;
            self.closest_hits(&batch.rays, &mut batch.hits);
        }
    }

    /// Ends the paths that leave the scene, and finds out where the other ones are.
    fn find_surfaces(&self, batch: &mut Batch, seen: &mut [Seen]) {
        let Batch { rays, hits, paths, surfaces, departures, .. } = batch;
        surfaces.clear();
        departures.clear();
        let mut rays_and_hits = rays.iter().zip(hits);
        paths.retain(|path| {
            // There is a ray for every path.
            let Some((ray, hit)) = rays_and_hits.next() else { return false };
            let Some(hit) = hit else {
                seen[path.camera_ray].color = path.color + path.weight.scaled_by(self.background(ray));
                return false;
            };
            let normal = self.normal(ray, hit);
            let mut point = ray.at(hit.at.t);
            if self.plan.epsilon == Epsilon::Auto {
                let object = &self.scene.objects[hit.object as usize];
                let surface = object.surface_point(&self.scene.meshes, ray, &hit.at);
                point = surface.point;
                departures.push(Departure::new(ray, surface));
            }
            surfaces.push(Surface {
                point,
                normal,
                reflected: mirrored(ray.direction, normal),
                material: self.scene.objects[hit.object as usize].material,
                color: Vector3::ZERO,
            });
            true
        });
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

    /// Adds up the light that surfaces send back along their rays, mirrors aside.
    fn shade(&mut self, batch: &mut Batch) {
        let scene = self.scene;
        for light in &scene.lights {
            batch.shadow_rays.clear();
            batch.distances.clear();
            batch.shadowed.clear();
            for (index, surface) in batch.surfaces.iter_mut().enumerate() {
                let illumination = light.illuminate(surface.point);
                let material = &scene.materials[surface.material as usize];
                let added = material.phong(&illumination, surface.normal, surface.reflected);
                if added == Vector3::ZERO {
                    // Blocked or not, this light adds nothing.
                    self.counts.shadow_left_out += u64::from(self.plan.shadows);
                } else if self.plan.shadows {
                    let (ray, distance) = match (batch.departures.get(index), self.plan.robust) {
                        (Some(departure), true) => departure.shadow_ray(light),
                        (Some(departure), false) => departure.plain_shadow_ray(&illumination),
                        (None, robust) => shadow_ray(surface.point, &illumination, self.epsilon, robust),
                    };
                    batch.shadow_rays.push(ray);
                    batch.distances.push(distance);
                    batch.shadowed.push((index, added));
                } else {
                    surface.color += added;
                }
            }
            if batch.shadow_rays.is_empty() {
                continue;
            }
            self.counts.shadow += batch.shadow_rays.len() as u64;
            let Batch { shadow_rays, distances, blocked, .. } = &mut *batch;
            scene.accelerator.any_hits(&scene.objects, &scene.meshes, shadow_rays, distances, blocked);
            for (&(index, added), blocked) in batch.shadowed.iter().zip(&batch.blocked) {
                if !blocked {
                    batch.surfaces[index].color += added;
                }
            }
        }
        for surface in &mut batch.surfaces {
            let material = &scene.materials[surface.material as usize];
            surface.color += scene.ambient_light.scaled_by(material.diffuse);
        }
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        self.scene.accelerator.closest_hits(&self.scene.objects, &self.scene.meshes, rays, hits);
    }

    fn normal(&self, ray: &Ray, hit: &Hit) -> Vector3 {
        self.scene.objects[hit.object as usize].normal(&self.scene.meshes, ray, &hit.at)
    }

    fn background(&self, ray: &Ray) -> Vector3 {
        match &self.scene.background.cube_map {
            Some(cube_map) => cube_map.color(ray.direction),
            None => self.scene.background.color,
        }
    }
}

impl Surface {
    /// The mirror ray that starts `epsilon` along itself.
    fn mirror_ray(&self, epsilon: Real) -> Ray {
        Ray { origin: self.point + self.reflected * epsilon, direction: self.reflected }
    }
}

/// The ray from a point to a light that starts `epsilon` along itself, and how far it goes. The distance is measured
/// from the moved origin, as in the starter: something up to one offset behind the light blocks it too, unless with
/// `-robust`.
fn shadow_ray(point: Vector3, illumination: &Illumination, epsilon: Real, robust: bool) -> (Ray, Real) {
    let direction = illumination.to_light;
    let origin = point + direction * epsilon;
    let distance = illumination.distance;
    (Ray { origin, direction }, if robust { shadow_limit(origin, distance - epsilon) } else { distance })
}
