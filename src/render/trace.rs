//! What one ray sees: the heart of the program.

use crate::accel::Hit;
use crate::light::Light;
use crate::material::{Material, mirrored};
use crate::objects::Ray;
use crate::plan::Plan;
use crate::report::RayCounts;
use crate::scene::Scene;
use vecmath::{Real, Vector3};

/// Shadow and mirror rays start this far from the surface: in world units, times the length of their direction. The
/// course's pictures depend on it.
const RAY_OFFSET: Real = 0.01;

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
    pub counts: RayCounts,
}

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a Scene, plan: &'a Plan) -> Self {
        Self { scene, plan, counts: RayCounts::default() }
    }

    /// What rays from the camera see, one entry of `seen` for each. Rays that lie side by side are best asked about
    /// together.
    pub fn see(&mut self, rays: &[Ray], seen: &mut Vec<Seen>) {
        self.counts.camera += rays.len() as u64;
        seen.clear();
        for ray in rays {
            let hit = self.closest_hit(ray);
            seen.push(self.seen(ray, hit));
        }
    }

    /// What a camera ray sees whose nearest hit is known.
    fn seen(&mut self, ray: &Ray, hit: Option<Hit>) -> Seen {
        let mut seen = Seen { depth: hit.map(|hit| hit.at.t), ..Seen::default() };
        if let Some(hit) = hit.filter(|_| self.plan.normals) {
            seen.normal = self.normal(ray, &hit);
        }
        if self.plan.color {
            seen.color = self.color(ray, hit);
        }
        seen
    }

    /// The colour of a ray whose nearest hit is known, mirrors included.
    ///
    /// The recursion of the course, written as a loop with a running weight: as deep as `-bounces` asks for without
    /// growing the stack.
    fn color(&mut self, ray: &Ray, hit: Option<Hit>) -> Vector3 {
        let (mut ray, mut hit) = (*ray, hit);
        let mut color = Vector3::ZERO;
        let mut weight = Vector3::splat(1.0);
        let mut bounces = self.plan.bounces;
        loop {
            let Some(found) = hit else {
                return color + weight.scaled_by(self.background(&ray));
            };
            let point = ray.at(found.at.t);
            let normal = self.normal(&ray, &found);
            let material = &self.scene.materials[self.scene.objects[found.object as usize].material as usize];
            let reflected = mirrored(ray.direction, normal);
            color += weight.scaled_by(self.shade(material, point, normal, reflected));
            if bounces == 0 || !material.is_mirror() {
                return color;
            }
            weight = weight.scaled_by(material.specular);
            bounces -= 1;
            if self.no_longer_matters(color, weight, bounces) {
                return color;
            }
            ray = Ray { origin: point + reflected * RAY_OFFSET, direction: reflected };
            self.counts.mirror += 1;
            hit = self.closest_hit(&ray);
        }
    }

    /// Whether everything that can still be added to `color` leaves every bit of it as it is.
    fn no_longer_matters(&self, color: Vector3, weight: Vector3, bounces: u32) -> bool {
        if weight == Vector3::ZERO {
            return true;
        }
        let Some(bound) = self.plan.radiance_bound else {
            return false;
        };
        // Weights may grow again at a mirror with a specular colour above 1, so this holds for the others only.
        let never_grows = self.scene.materials.iter().all(|material| material.specular.max_abs() <= 1.0);
        let rest = Real::from(bounces as f32 + 1.0) * bound;
        never_grows && (0..3).all(|c| color[c] + weight[c].abs() * rest == color[c])
    }

    /// The light that a point of a surface sends back along the ray, mirrors aside.
    fn shade(&mut self, material: &Material, point: Vector3, normal: Vector3, reflected: Vector3) -> Vector3 {
        let mut color = Vector3::ZERO;
        for light in &self.scene.lights {
            let illumination = light.illuminate(point);
            let added = material.phong(&illumination, normal, reflected);
            if added == Vector3::ZERO {
                // Blocked or not, this light adds nothing.
                self.counts.shadow_left_out += u64::from(self.plan.shadows);
                continue;
            }
            if !self.plan.shadows || !self.is_blocked(light, point) {
                color += added;
            }
        }
        color + self.scene.ambient_light.scaled_by(material.diffuse)
    }

    /// Whether anything stands between a point and a light. The distance is measured from the moved origin, as in
    /// the starter: something up to one offset behind the light blocks it too.
    fn is_blocked(&mut self, light: &Light, point: Vector3) -> bool {
        let illumination = light.illuminate(point);
        let direction = illumination.to_light;
        self.counts.shadow += 1;
        let ray = Ray { origin: point + direction * RAY_OFFSET, direction };
        self.scene.accelerator.any_hit(&self.scene.objects, &self.scene.meshes, &ray, illumination.distance)
    }

    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.scene.accelerator.closest_hit(&self.scene.objects, &self.scene.meshes, ray)
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
