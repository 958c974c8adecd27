//! [`Surfaces`]: the points of a run of rays that are being shaded, and what a light adds to each.
//!
//! Loops over the rays of a run that call the formulas of [`light`](crate::light) and [`material`](crate::material), so
//! that these are compiled to several rays an instruction.

use super::robust::shadow_limit;
use crate::accel::simd::{Lanes, Task};
use crate::light::{Illumination, Light, from_direction, from_point};
use crate::material::{Material, mirrored, powers};
use crate::objects::run::{Numbers, RUN, RayRun, Vectors, around, numbers_in};
use std::ops::Range;
use vecmath::{Real, Vector3};

/// Points that are being shaded, one a ray.
pub struct Surfaces {
    pub point: Vectors,
    pub normal: Vectors,
    /// The mirrored ray direction.
    pub reflected: Vectors,
    pub diffuse: Vectors,
    pub specular: Vectors,
    pub shininess: Numbers,
    /// Those that are mirrors, and perhaps others that nobody asks about.
    pub mirrors: u64,
    /// Light that the surface sends back along the ray, mirrors aside.
    pub color: Vectors,
}

impl Surfaces {
    pub const NONE: Self = Self {
        point: Vectors::ZERO,
        normal: Vectors::ZERO,
        reflected: Vectors::ZERO,
        diffuse: Vectors::ZERO,
        specular: Vectors::ZERO,
        shininess: [0.0; RUN],
        mirrors: 0,
        color: Vectors::ZERO,
    };

    /// Sets the material of the surfaces of a mask.
    pub fn set_material(&mut self, mask: u64, material: &Material) {
        self.mirrors = if material.is_mirror() { self.mirrors | mask } else { self.mirrors & !mask };
        if mask == u64::MAX {
            for (to, from) in [(&mut self.diffuse, material.diffuse), (&mut self.specular, material.specular)] {
                to.0 = from.to_array().map(|component| [component; RUN]);
            }
            self.shininess = [material.shininess; RUN];
            return;
        }
        for number in numbers_in(mask) {
            self.diffuse.set(number, material.diffuse);
            self.specular.set(number, material.specular);
            self.shininess[number] = material.shininess;
        }
    }

    #[inline(always)]
    fn material(&self, number: usize) -> Material {
        let (diffuse, specular) = (self.diffuse.get(number), self.specular.get(number));
        Material { diffuse, specular, shininess: self.shininess[number] }
    }
}

/// Finds the points where rays have ended at t, if `t` is given, and mirrors the rays there.
pub struct Arrive<'a> {
    pub rays: &'a RayRun,
    pub mask: u64,
    pub t: Option<&'a Numbers>,
    pub surfaces: &'a mut Surfaces,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { rays, mask, t, surfaces } = self;
        if let Some(t) = t {
            for number in around(mask) {
                surfaces.point.set(number, rays.get(number).at(t[number]));
            }
        }
        for number in around(mask) {
            let reflected = mirrored(rays.direction.get(number), surfaces.normal.get(number));
            surfaces.reflected.set(number, reflected);
            surfaces.color.set(number, Vector3::ZERO);
        }
    }
}

/// A light as the points of a run see it, and what it adds to them.
pub struct Lit {
    pub to_light: Vectors,
    pub distance: Numbers,
    /// Diffuse light and highlight, if nothing is in the way.
    pub added: Vectors,
    intensity: Vectors,
    /// Cosines, and then powers of them.
    highlight: Numbers,
}

impl Lit {
    pub const NONE: Self = Self {
        to_light: Vectors::ZERO,
        distance: [0.0; RUN],
        added: Vectors::ZERO,
        intensity: Vectors::ZERO,
        highlight: [0.0; RUN],
    };

    /// Finds out how the points of surfaces see the light.
    #[inline(always)]
    fn find(&mut self, surfaces: &Surfaces, lanes: Range<usize>, light: impl Fn(Vector3) -> Illumination) {
        for number in lanes {
            let seen = light(surfaces.point.get(number));
            self.to_light.set(number, seen.to_light);
            self.distance[number] = seen.distance;
            self.intensity.set(number, seen.intensity);
            self.highlight[number] = surfaces.reflected.get(number).dot(seen.to_light).max(0.0);
        }
    }
}

/// Lights surfaces. The output are those to which the light adds anything.
pub struct Illuminate<'a> {
    pub light: &'a Light,
    pub surfaces: &'a Surfaces,
    pub mask: u64,
    pub lit: &'a mut Lit,
}

impl Task for Illuminate<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { light, surfaces, mask, lit } = self;
        let lanes = around(mask);
        // The compiler takes no choice out of a loop as long as this.
        match *light {
            Light::Directional { to_light, color } => {
                lit.find(surfaces, lanes.clone(), |_| from_direction(to_light, color));
            }
            Light::Point { position, color, falloff } => {
                lit.find(surfaces, lanes.clone(), |point| from_point(position, color, falloff, point));
            }
        }
        powers(&mut lit.highlight, &surfaces.shininess, mask);
        let mut any_added = 0;
        for number in lanes {
            let (to_light, intensity) = (lit.to_light.get(number), lit.intensity.get(number));
            let cosine = surfaces.normal.get(number).dot(to_light);
            let added = surfaces.material(number).reflect(intensity, cosine, lit.highlight[number]);
            lit.added.set(number, added);
            any_added |= u64::from((added.x != 0.0) | (added.y != 0.0) | (added.z != 0.0)) << number;
        }
        any_added & mask
    }
}

/// Rays from surfaces to a light that start `epsilon` along themselves, and how far they go. The distance is measured
/// from the moved origin, as in the starter: something up to one offset behind the light blocks it too, unless with
/// `-robust`.
pub struct ShadowRays<'a> {
    pub surfaces: &'a Surfaces,
    pub lit: &'a Lit,
    pub mask: u64,
    pub epsilon: Real,
    pub robust: bool,
    pub rays: &'a mut RayRun,
    pub t_max: &'a mut Numbers,
}

impl Task for ShadowRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { surfaces, lit, mask, epsilon, robust, rays, t_max } = self;
        for number in around(mask) {
            let direction = lit.to_light.get(number);
            rays.direction.set(number, direction);
            rays.origin.set(number, surfaces.point.get(number) + direction * epsilon);
            t_max[number] = lit.distance[number];
        }
        if robust {
            for number in numbers_in(mask) {
                t_max[number] = shadow_limit(rays.origin.get(number), lit.distance[number] - epsilon);
            }
        }
    }
}

/// Adds what a light adds to the surfaces of a mask.
pub struct AddLight<'a> {
    pub lit: &'a Lit,
    pub mask: u64,
    pub surfaces: &'a mut Surfaces,
}

impl Task for AddLight<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { lit, mask, surfaces } = self;
        for number in around(mask) {
            let added = if mask >> number & 1 == 1 { lit.added.get(number) } else { Vector3::ZERO };
            surfaces.color.set(number, surfaces.color.get(number) + added);
        }
    }
}

/// Adds the ambient light, and then what surfaces send back to what has been gathered on the way to them. What a mirror
/// sees counts less from there on.
pub struct Gather<'a> {
    pub ambient: Vector3,
    pub surfaces: &'a Surfaces,
    pub mask: u64,
    pub weight: &'a mut Vectors,
    pub color: &'a mut Vectors,
}

impl Task for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { ambient, surfaces, mask, weight, color } = self;
        for number in around(mask) {
            let reflected = surfaces.color.get(number) + ambient.scaled_by(surfaces.diffuse.get(number));
            color.set(number, color.get(number) + weight.get(number).scaled_by(reflected));
        }
        for number in around(mask) {
            weight.set(number, weight.get(number).scaled_by(surfaces.specular.get(number)));
        }
    }
}
