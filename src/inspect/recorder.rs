//! [`Recorder`] writes down the steps of a path; a [`Path`] is what it has written.

use super::names::{Material, Names, Object};
use crate::light::Illumination;
use crate::objects::{Hit, Ray};
use crate::plan::Plan;
use crate::scene::Place;
use crate::trace::{LightTerm, Observer, RayKind, Shadow, Surface};
use vecmath::{Real, Vector3};

/// The way of a camera ray and of its mirror rays.
#[derive(Debug)]
pub struct Path {
    pub steps: Vec<Step>,
    /// Why no ray follows the last one.
    pub end: String,
}

/// A camera or mirror ray, and what it meets.
#[derive(Debug)]
pub struct Step {
    pub kind: RayKind,
    pub ray: Ray,
    /// The share of its light that reaches the eye.
    pub throughput: Vector3,
    pub met: Met,
}

#[derive(Debug)]
pub enum Met {
    /// Nothing: the ray sees the background's colour.
    Background(Vector3),
    Surface(Box<Shaded>),
}

impl Step {
    pub fn surface(&self) -> Option<&Shaded> {
        match &self.met {
            Met::Background(_) => None,
            Met::Surface(surface) => Some(surface),
        }
    }

    /// Returns the light that the ray sees, without what a mirror adds.
    pub fn light(&self) -> Vector3 {
        match &self.met {
            Met::Background(color) => *color,
            Met::Surface(surface) => surface.reflected,
        }
    }
}

/// A surface that was hit, and the light that it reflects along the ray.
#[derive(Debug)]
pub struct Shaded {
    pub object: Object,
    pub t: Real,
    pub point: Vector3,
    pub normal: Vector3,
    pub material: Material,
    pub lights: Vec<Light>,
    /// What the surface reflects of the ambient light.
    pub ambient: Vector3,
    /// The sum of all lights and of the ambient light.
    pub reflected: Vector3,
}

/// A light, seen from a surface.
#[derive(Debug)]
pub struct Light {
    pub place: Place,
    pub seen: Illumination,
    /// N.L, with the normal N and the direction L to the light.
    pub normal_dot_light: Real,
    /// R.L, with the mirrored ray R.
    pub mirrored_dot_light: Real,
    /// What the surface reflects if nothing blocks the light: diffuse light, and the highlight.
    pub diffuse: Vector3,
    pub highlight: Vector3,
    pub shadow: Way,
    /// What is added to the colour of the surface.
    pub added: Vector3,
}

/// What is known of the way between a surface and a light.
#[derive(Debug)]
pub enum Way {
    /// There are no shadows.
    NotLookedAt,
    /// The light contributes exactly zero.
    LeftOut,
    Free,
    /// The nearest object on the way, and its t.
    Blocked(Object, Real),
}

/// Writes down the steps of [`trace_ray`](crate::trace::trace_ray).
pub struct Recorder<'a> {
    names: &'a Names<'a>,
    steps: Vec<Step>,
    /// The last ray's hit, until it is known what the surface reflects.
    hit: Option<Hit>,
    /// Lights at the last hit so far.
    lights: Vec<Light>,
}

impl<'a> Recorder<'a> {
    pub fn new(names: &'a Names<'a>) -> Self {
        Self { names, steps: Vec::new(), hit: None, lights: Vec::new() }
    }

    pub fn finish(self, plan: &Plan) -> Path {
        let mirrors = self.steps.len().saturating_sub(1);
        let end = match self.steps.last().and_then(Step::surface) {
            None => "the ray leaves the scene".to_owned(),
            Some(surface) if !surface.material.is_mirror => {
                "the surface is no mirror: its specularColor is not longer than 0.1".to_owned()
            }
            Some(_) if mirrors == plan.bounces as usize => {
                format!("the surface is a mirror, but -bounces is {mirrors}")
            }
            Some(_) => "what a further mirror ray sees is too dark to change the sum".to_owned(),
        };
        Path { steps: self.steps, end }
    }

    fn way(&self, term: &LightTerm) -> Way {
        match term.shadow {
            Shadow::NotWanted => Way::NotLookedAt,
            Shadow::LeftOut => Way::LeftOut,
            Shadow::Traced { is_blocked: false, .. } => Way::Free,
            // The nearest object in the way is one that blocks.
            Shadow::Traced { ray, .. } => match self.names.scene.geometry.closest_hit(&ray) {
                Some(hit) => Way::Blocked(self.names.object(&hit), hit.surface.t),
                None => Way::Free,
            },
        }
    }

    fn set_met(&mut self, met: Met) {
        if let Some(step) = self.steps.last_mut() {
            step.met = met;
        }
    }
}

impl Observer for Recorder<'_> {
    fn ray(&mut self, kind: RayKind, ray: &Ray, throughput: Vector3, hit: Option<&Hit>) {
        self.hit = hit.copied();
        self.steps.push(Step { kind, ray: *ray, throughput, met: Met::Background(Vector3::ZERO) });
    }

    fn light(&mut self, surface: &Surface, term: &LightTerm) {
        let (seen, material) = (term.seen, &surface.material);
        let highlight = material.highlight(seen.to_light, surface.reflected);
        self.lights.push(Light {
            place: self.names.places.light(self.lights.len()),
            seen,
            normal_dot_light: surface.normal.dot(seen.to_light),
            mirrored_dot_light: surface.reflected.dot(seen.to_light),
            diffuse: material.reflect(seen.intensity, surface.normal.dot(seen.to_light), 0.0),
            highlight: material.reflect(seen.intensity, 0.0, highlight),
            shadow: self.way(term),
            added: term.added(),
        });
    }

    fn surface(&mut self, surface: &Surface, reflected: Vector3) {
        let Some(hit) = self.hit else { return };
        let shaded = Shaded {
            object: self.names.object(&hit),
            t: hit.surface.t,
            point: surface.offset.point(),
            normal: surface.normal,
            material: self.names.material(&hit),
            lights: std::mem::take(&mut self.lights),
            ambient: self.names.scene.ambient_light.scaled_by(surface.material.diffuse),
            reflected,
        };
        self.set_met(Met::Surface(Box::new(shaded)));
    }

    fn background(&mut self, color: Vector3) {
        self.set_met(Met::Background(color));
    }
}
