//! What one ray sees: the definition of the picture. **Begin reading here.**
//!
//! This is Whitted ray tracing (Whitted: An Improved Illumination Model for Shaded Display, 1980) with the Phong model, as
//! the course defines it. Light is followed backwards. A ray goes from the eye through a pixel and finds the nearest
//! surface. Each light adds to that point's colour, unless a *shadow ray* towards it is blocked. If the surface is a
//! mirror, a *mirror ray* goes on, and what it sees is added too. A ray that meets nothing sees the background.
//!
//! ```text
//!        eye ----camera ray----> surface ----shadow rays----> lights
//!                                   '------mirror ray----> surface ... --> background
//! ```
//!
//! The renderer in [`wide`](crate::wide) follows 64 rays at a time and gives every pixel the same bits. `-plain` renders
//! with this file instead: it is slower, and the first thing to try when a picture looks wrong. `-pixel` shows the steps
//! below with their numbers: an [`Observer`] is told each of them.

mod observer;

pub use observer::{LightTerm, Observer, RayKind, Shadow};

use crate::light::Light;
use crate::material::{Material, mirrored};
use crate::objects::{Hit, Ray};
use crate::options::Epsilon;
use crate::plan::Plan;
use crate::ray_offset::{BesideSurface, RayOffset};
use crate::scene::Scene;
use crate::timing::Deadline;
use vecmath::{Real, Vector3};

/// What a camera ray saw.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Zero unless a colour picture is asked for.
    pub color: Vector3,
    /// t of the nearest hit; the camera ray is a unit vector, so this is a distance.
    pub depth: Option<Real>,
    /// Normal at the nearest hit; zero without a hit, or if no picture of normals is asked for.
    pub normal: Vector3,
}

/// A path looks at the clock once in so many mirrors.
const MIRRORS_BETWEEN_LOOKS: u32 = 64;

/// Returns what a camera ray sees, and tells the observer how.
///
/// The course's `traceRay` calls itself for the mirror ray and multiplies on the way back. Here the product is carried
/// along instead: the *throughput* is the share of further light that reaches the eye. So the stack stays small
/// whatever `-bounces` is.
///
/// Returns `None` if the deadline comes before the end of the path.
pub fn trace_ray(
    scene: &Scene,
    plan: &Plan,
    camera_ray: Ray,
    deadline: Deadline,
    observer: &mut impl Observer,
) -> Option<Seen> {
    let mut ray = camera_ray;
    let mut hit = scene.geometry.closest_hit(&ray);
    observer.ray(RayKind::Camera, &ray, Vector3::splat(1.0), hit.as_ref());
    let mut seen = first_seen(scene, plan, &ray, hit.as_ref());
    if !plan.color {
        return Some(seen);
    }
    let (mut throughput, mut bounces) = (Vector3::splat(1.0), plan.bounces);
    while let Some(found) = hit {
        let surface = Surface::at(scene, plan, &ray, &found);
        let reflected = surface.reflected_light(scene, plan, observer);
        observer.surface(&surface, reflected);
        seen.color += throughput.scaled_by(reflected);
        if bounces == 0 || !surface.material.is_mirror() {
            return Some(seen);
        }
        // The mirror shows what lies in the mirrored direction, tinted by its specular colour.
        bounces -= 1;
        throughput = throughput.scaled_by(surface.material.specular);
        if !can_change(further_light(scene, plan, bounces), seen.color, throughput) {
            return Some(seen);
        }
        if bounces % MIRRORS_BETWEEN_LOOKS == 0 && deadline.is_over() {
            return None;
        }
        (seen.color, throughput) = kept_finite(scene, seen.color, throughput);
        ray = surface.mirror_ray(plan);
        hit = scene.geometry.closest_hit(&ray);
        observer.ray(RayKind::Mirror, &ray, throughput, hit.as_ref());
    }
    let background = scene.background.color(ray.direction);
    observer.background(background);
    seen.color += throughput.scaled_by(background);
    Some(seen)
}

/// Returns what the pictures of depths and normals show of a ray's hit.
fn first_seen(scene: &Scene, plan: &Plan, ray: &Ray, hit: Option<&Hit>) -> Seen {
    let normal = hit.filter(|_| plan.normals).map(|hit| scene.geometry.normal(ray, hit));
    Seen { color: Vector3::ZERO, depth: hit.map(|hit| hit.surface.t), normal: normal.unwrap_or(Vector3::ZERO) }
}

/// The point of a surface that a ray has hit.
#[derive(Debug)]
pub struct Surface<'a> {
    pub material: &'a Material,
    pub normal: Vector3,
    /// The mirrored direction of the ray.
    pub reflected: Vector3,
    /// The point, and where rays that leave it start.
    pub offset: RayOffset,
}

impl<'a> Surface<'a> {
    fn at(scene: &'a Scene, plan: &Plan, ray: &Ray, hit: &Hit) -> Self {
        let material = scene.geometry.objects[hit.object as usize].material;
        let normal = scene.geometry.normal(ray, hit);
        let offset = match plan.epsilon {
            Epsilon::Along(epsilon) => RayOffset::Along { point: ray.at(hit.surface.t), epsilon: epsilon as Real },
            Epsilon::Auto => RayOffset::Beside(BesideSurface::new(ray, scene.geometry.surface_point(ray, hit))),
        };
        Self {
            material: &scene.materials[material as usize],
            normal,
            reflected: mirrored(ray.direction, normal),
            offset,
        }
    }

    /// Returns the light that the surface reflects along the ray, without what it mirrors: ambient light, and diffuse
    /// light and a highlight from each light that is not blocked.
    fn reflected_light(&self, scene: &Scene, plan: &Plan, observer: &mut impl Observer) -> Vector3 {
        let lights = scene.lights.iter().map(|light| self.reflected_from(light, scene, plan, observer));
        let color = lights.fold(Vector3::ZERO, |sum, reflected| sum + reflected);
        color + scene.ambient_light.scaled_by(self.material.diffuse)
    }

    fn reflected_from(&self, light: &Light, scene: &Scene, plan: &Plan, observer: &mut impl Observer) -> Vector3 {
        let seen = light.illuminate(self.offset.point());
        let reflected = self.material.phong(&seen, self.normal, self.reflected);
        let shadow = if !plan.shadows {
            Shadow::NotWanted
        } else if reflected == Vector3::ZERO {
            // No shadow ray where the light contributes exactly zero.
            Shadow::LeftOut
        } else {
            let (ray, t_max) = self.offset.shadow_ray(light, &seen, plan.robust);
            Shadow::Traced { ray, t_max, is_blocked: scene.geometry.any_hit(&ray, t_max) }
        };
        let term = LightTerm { seen, reflected, shadow };
        observer.light(self, &term);
        term.added()
    }

    fn mirror_ray(&self, plan: &Plan) -> Ray {
        self.offset.mirror_ray(self.reflected, plan.robust)
    }
}

/// Returns an upper bound of the light that a path may still gather in this many `bounces`, in any component, if its
/// throughput were 1. `None`: there is no bound.
pub fn further_light(scene: &Scene, plan: &Plan, bounces: u32) -> Option<Real> {
    let bound = plan.radiance_bound.filter(|_| scene.throughput_never_grows)?;
    Some(Real::from(bounces as f32 + 1.0) * bound)
}

/// Returns whether anything further along a path can change a bit of its colour: with a throughput of zero nothing can,
/// nor with one so small that all [further light](further_light) is lost in rounding. There are no branches, so that
/// loops over paths vectorise.
#[inline(always)]
pub fn can_change(further: Option<Real>, color: Vector3, throughput: Vector3) -> bool {
    let changes = |c: Real, t: Real| c + t.abs() * further.unwrap_or(0.0) != c;
    let (c, t) = (color, throughput);
    let is_something = (t.x != 0.0) | (t.y != 0.0) | (t.z != 0.0);
    is_something & (further.is_none() | changes(c.x, t.x) | changes(c.y, t.y) | changes(c.z, t.z))
}

/// Returns the colour and the throughput of a path that goes on, with components that are finite. Mirrors that brighten
/// can make a throughput infinite, and infinity times the black of a surface is NaN. The course multiplies on the way
/// back, which gives a huge colour and no NaN.
#[inline]
pub fn kept_finite(scene: &Scene, color: Vector3, throughput: Vector3) -> (Vector3, Vector3) {
    if scene.throughput_never_grows {
        return (color, throughput);
    }
    let finite = |v: Vector3| v.map(|component| component.clamp(-Real::MAX, Real::MAX));
    (finite(color), finite(throughput))
}

/// Returns the direction in which a camera ray leaves the scene, at once or after at most `mirrors` mirrors.
pub fn escape_direction(scene: &Scene, plan: &Plan, camera_ray: Ray, mirrors: u32) -> Option<Vector3> {
    let mut ray = camera_ray;
    for _ in 0..=plan.bounces.min(mirrors) {
        let Some(hit) = scene.geometry.closest_hit(&ray) else { return Some(ray.direction) };
        let surface = Surface::at(scene, plan, &ray, &hit);
        if !surface.material.is_mirror() {
            return None;
        }
        ray = surface.mirror_ray(plan);
    }
    None
}
