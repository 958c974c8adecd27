//! [`Surfaces`]: the points of a run of rays that are being shaded, and what a light adds to each.
//!
//! Loops over the rays of a run that call the formulas of [`light`](crate::light) and [`material`](crate::material), so
//! that these are compiled to several rays an instruction.

use super::robust::shadow_limit;
use crate::accel::simd::{Lanes, Task};
use crate::light::{Illumination, Light, from_direction, from_point};
use crate::material::{Material, mirrored, powers};
use crate::objects::Ray;
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

    /// The mirror ray that starts `epsilon` along itself.
    pub fn mirror_ray(&self, number: usize, epsilon: Real) -> Ray {
        let direction = self.reflected.get(number);
        Ray { origin: self.point.get(number) + direction * epsilon, direction }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd::Level;

    /// Two materials and directions all around, at both levels, for rays with gaps between them.
    #[test]
    fn a_run_is_lit_as_each_of_its_points() {
        let material = |shininess| Material {
            diffuse: Vector3::new(0.7, 0.1, 0.0),
            specular: Vector3::new(0.2, 0.0, 0.4),
            shininess,
        };
        let around = |number: usize, turn: Real| {
            let angle = number as Real * turn;
            Vector3::new(libm::sin(angle as f64) as Real, libm::cos(angle as f64) as Real, 0.3)
        };
        let position = Vector3::new(1.0, 2.0, 0.5);
        let lights = [
            Light::Directional { to_light: Vector3::new(0.6, 0.0, 0.8), color: Vector3::splat(0.9) },
            Light::Point { position, color: Vector3::new(0.5, 0.0, 1.0), falloff: 0.25 },
            Light::Point { position, color: Vector3::new(0.5, 0.0, 1.0), falloff: 0.0 },
        ];
        let mask = 0xfff0_0ff7_ffff_fffe;
        for (shininess, level) in [(20.0, "scalar"), (0.5, "scalar"), (20.0, "avx2"), (0.5, "avx2")] {
            let Some(level) = Level::named(level) else { continue };
            let mut surfaces = Surfaces::NONE;
            surfaces.set_material(u64::MAX, &material(20.0));
            surfaces.set_material(0x0000_00ff_0000_0000, &material(shininess));
            for number in 0..RUN {
                surfaces.point.set(number, around(number, 0.4));
                surfaces.normal.set(number, around(number, 0.9));
                surfaces.reflected.set(number, around(number, 1.7));
            }
            surfaces.point.set(9, position);
            for light in &lights {
                let mut lit = Lit::NONE;
                let added = level.run(Illuminate { light, surfaces: &surfaces, mask, lit: &mut lit });
                assert_eq!(added & !mask, 0);
                for number in numbers_in(mask) {
                    let seen = light.illuminate(surfaces.point.get(number));
                    let (normal, reflected) = (surfaces.normal.get(number), surfaces.reflected.get(number));
                    let expected = surfaces.material(number).phong(&seen, normal, reflected);
                    let found = lit.added.get(number);
                    let bits = |v: Vector3| v.to_array().map(|c| if c.is_nan() { Real::MAX } else { c });
                    assert_eq!(bits(found), bits(expected), "{level} {number}");
                    assert_eq!(added >> number & 1 == 1, expected != Vector3::ZERO, "{level} {number}");
                }
            }
        }
    }
}
