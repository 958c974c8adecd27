//! [`Observer`]: is told what [`trace_ray`](super::trace_ray) does, step by step.

use super::Surface;
use crate::light::Illumination;
use crate::objects::{Hit, Ray};
use crate::ray_counts::RayCounts;
use vecmath::{Real, Vector3};

/// Is told the steps along a path, in their order. It changes nothing of what is seen.
///
/// [`RayCounts`] count rays, which is all that a picture needs. `-pixel` writes everything down.
pub trait Observer {
    /// A ray was traced. `throughput` is the share of its light that reaches the eye.
    fn ray(&mut self, kind: RayKind, ray: &Ray, throughput: Vector3, hit: Option<&Hit>);

    /// A light was looked at from a surface that the last ray has hit.
    fn light(&mut self, surface: &Surface, term: &LightTerm);

    /// All lights were looked at: together the surface reflects this along the ray, without what it mirrors.
    fn surface(&mut self, _surface: &Surface, _reflected: Vector3) {}

    /// The last ray has hit nothing, and sees this colour.
    fn background(&mut self, _color: Vector3) {}
}

/// A ray that finds the nearest surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    Camera,
    Mirror,
}

/// What one light adds to the light that a surface reflects.
#[derive(Clone, Copy, Debug)]
pub struct LightTerm {
    /// The light that arrives if nothing blocks it.
    pub seen: Illumination,
    /// What the surface reflects of it along the ray, if nothing blocks it.
    pub reflected: Vector3,
    pub shadow: Shadow,
}

impl LightTerm {
    /// Returns what is added.
    pub fn added(&self) -> Vector3 {
        match self.shadow {
            Shadow::NotWanted | Shadow::Traced { is_blocked: false, .. } => self.reflected,
            Shadow::LeftOut | Shadow::Traced { .. } => Vector3::ZERO,
        }
    }
}

/// What is known of the way between a surface and a light.
#[derive(Clone, Copy, Debug)]
pub enum Shadow {
    /// Nothing: there are no shadows.
    NotWanted,
    /// Nothing, because the light contributes exactly zero.
    LeftOut,
    /// Whether the shadow ray hits anything up to `t_max`.
    Traced { ray: Ray, t_max: Real, is_blocked: bool },
}

impl Observer for RayCounts {
    fn ray(&mut self, kind: RayKind, _: &Ray, _: Vector3, hit: Option<&Hit>) {
        match kind {
            RayKind::Camera => {
                self.camera += 1;
                self.camera_hits += u64::from(hit.is_some());
            }
            RayKind::Mirror => self.mirror += 1,
        }
    }

    fn light(&mut self, _: &Surface, term: &LightTerm) {
        match term.shadow {
            Shadow::NotWanted => {}
            Shadow::LeftOut => self.shadow_left_out += 1,
            Shadow::Traced { .. } => self.shadow += 1,
        }
    }
}
