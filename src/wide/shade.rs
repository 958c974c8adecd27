//! Shading of a packet: the formulas of [`light`](crate::light) and [`material`](crate::material) in loops over lanes.

use super::mirror_queue::PathPacket;
use crate::light::Light;
use crate::material::{Material, mirrored, power, whole_exponent};
use crate::ray_offset::{offset_along, shadow_t_max};
use crate::simd::packet::{PACKET, RayPacket, Scalars, Vectors, has_lane, lanes_in, span};
use crate::simd::{Simd, vectorize};
use crate::trace::can_change;
use vecmath::{Real, Vector3};

/// The points of a packet that are being shaded, one a lane.
pub struct SurfacePacket {
    pub point: Vectors,
    pub normal: Vectors,
    /// The mirrored ray direction.
    pub reflected: Vectors,
    pub diffuse: Vectors,
    pub specular: Vectors,
    pub shininess: Scalars,
    /// The index of the material that all lanes have; `None` if they may differ.
    common: Option<u32>,
    /// Lanes whose material is a mirror; bits of inactive lanes are undefined.
    pub mirrors: u64,
    /// The light that the surface reflects along its ray, without what it mirrors.
    pub color: Vectors,
}

impl SurfacePacket {
    pub const NONE: Self = Self {
        point: Vectors::ZERO,
        normal: Vectors::ZERO,
        reflected: Vectors::ZERO,
        diffuse: Vectors::ZERO,
        specular: Vectors::ZERO,
        shininess: [0.0; PACKET],
        common: None,
        mirrors: 0,
        color: Vectors::ZERO,
    };

    /// Sets the material of the lanes of a mask.
    pub fn set_material(&mut self, mask: u64, index: u32, material: &Material) {
        if self.common == Some(index) {
            return;
        }
        self.mirrors = if material.is_mirror() { self.mirrors | mask } else { self.mirrors & !mask };
        self.common = (mask == u64::MAX).then_some(index);
        if mask == u64::MAX {
            self.diffuse = Vectors::splat(material.diffuse);
            self.specular = Vectors::splat(material.specular);
            self.shininess = [material.shininess; PACKET];
            return;
        }
        for lane in lanes_in(mask) {
            self.diffuse.set(lane, material.diffuse);
            self.specular.set(lane, material.specular);
            self.shininess[lane] = material.shininess;
        }
    }

    #[inline(always)]
    fn material(&self, lane: usize) -> Material {
        let (diffuse, specular) = (self.diffuse.get(lane), self.specular.get(lane));
        Material { diffuse, specular, shininess: self.shininess[lane] }
    }

    /// Sets the points at `t` of the active rays.
    pub fn set_points<S: Simd>(&mut self, simd: S, rays: &RayPacket, active: u64, t: &Scalars) {
        vectorize!(simd, {
            for lane in span(active) {
                self.point.set(lane, rays.get(lane).at(t[lane]));
            }
        });
    }

    /// Mirrors the active rays, and makes the points black.
    pub fn mirror_rays<S: Simd>(&mut self, simd: S, rays: &RayPacket, active: u64) {
        vectorize!(simd, {
            for lane in span(active) {
                let reflected = mirrored(rays.direction.get(lane), self.normal.get(lane));
                self.reflected.set(lane, reflected);
                self.color.set(lane, Vector3::ZERO);
            }
        });
    }

    /// Adds a light to the points of a mask.
    pub fn add<S: Simd>(&mut self, simd: S, light: &LightPacket, mask: u64) {
        vectorize!(simd, {
            for lane in span(mask) {
                let added = if has_lane(mask, lane) { light.reflected.get(lane) } else { Vector3::ZERO };
                self.color.set(lane, self.color.get(lane) + added);
            }
        });
    }

    /// Adds what the active points reflect, ambient light included, to the colours of their paths.
    pub fn add_to_paths<S: Simd>(&self, simd: S, ambient: Vector3, active: u64, paths: &mut PathPacket) {
        let PathPacket { color, throughput, .. } = paths;
        vectorize!(simd, {
            for lane in span(active) {
                let reflected = self.color.get(lane) + ambient.scaled_by(self.diffuse.get(lane));
                color.set(lane, color.get(lane) + throughput.get(lane).scaled_by(reflected));
            }
        });
    }

    /// Lowers the throughput of the active paths to that of their mirrors. Returns the paths of which something further
    /// [can change](can_change) the colour.
    pub fn lower_throughput<S: Simd>(
        &self,
        simd: S,
        further: Option<Real>,
        active: u64,
        PathPacket { color, throughput, .. }: &mut PathPacket,
    ) -> u64 {
        active
            & vectorize!(simd, {
                let mut changing = 0;
                for lane in span(active) {
                    let lowered = throughput.get(lane).scaled_by(self.specular.get(lane));
                    throughput.set(lane, lowered);
                    changing |= u64::from(can_change(further, color.get(lane), lowered)) << lane;
                }
                changing
            })
    }

    /// Moves the active points to where their mirror rays start: `epsilon` along these.
    pub fn start_mirror_rays<S: Simd>(&mut self, simd: S, active: u64, epsilon: Real) {
        vectorize!(simd, {
            for lane in span(active) {
                let ray = offset_along(self.point.get(lane), self.reflected.get(lane), epsilon);
                self.point.set(lane, ray.origin);
            }
        });
    }
}

/// One light as the points of a packet see it.
pub struct LightPacket {
    pub to_light: Vectors,
    pub distance: Scalars,
    /// What each point reflects of the light along its ray, if nothing blocks it.
    pub reflected: Vectors,
    intensity: Vectors,
    /// Cosines, then the powers of them.
    highlight: Scalars,
}

impl LightPacket {
    pub const NONE: Self = Self {
        to_light: Vectors::ZERO,
        distance: [0.0; PACKET],
        reflected: Vectors::ZERO,
        intensity: Vectors::ZERO,
        highlight: [0.0; PACKET],
    };

    /// Lights the active points. Returns those that the light changes.
    pub fn illuminate<S: Simd>(&mut self, simd: S, light: &Light, surfaces: &SurfacePacket, active: u64) -> u64 {
        vectorize!(simd, {
            light.illuminate_each(
                span(active),
                #[inline(always)]
                |lane| surfaces.point.get(lane),
                #[inline(always)]
                |lane, seen| {
                    self.to_light.set(lane, seen.to_light);
                    self.distance[lane] = seen.distance;
                    self.intensity.set(lane, seen.intensity);
                    self.highlight[lane] = surfaces.reflected.get(lane).dot(seen.to_light).max(0.0);
                },
            );
            raise_to_powers(&mut self.highlight, &surfaces.shininess, surfaces.common.is_some(), active);
            let mut changed = 0;
            for lane in span(active) {
                let (to_light, intensity) = (self.to_light.get(lane), self.intensity.get(lane));
                let cosine = surfaces.normal.get(lane).dot(to_light);
                let added = surfaces.material(lane).reflect(intensity, cosine, self.highlight[lane]);
                self.reflected.set(lane, added);
                changed |= u64::from((added.x != 0.0) | (added.y != 0.0) | (added.z != 0.0)) << lane;
            }
            changed & active
        })
    }

    /// Makes the active shadow rays, which start `epsilon` along themselves, and says how far they go.
    #[expect(clippy::too_many_arguments)]
    pub fn shadow_rays<S: Simd>(
        &self,
        simd: S,
        surfaces: &SurfacePacket,
        active: u64,
        epsilon: Real,
        is_robust: bool,
        rays: &mut RayPacket,
        t_max: &mut Scalars,
    ) {
        vectorize!(simd, {
            for lane in span(active) {
                rays.set(lane, offset_along(surfaces.point.get(lane), self.to_light.get(lane), epsilon));
                t_max[lane] = self.distance[lane];
            }
            if is_robust {
                for lane in lanes_in(active) {
                    t_max[lane] = shadow_t_max(rays.origin.get(lane), self.distance[lane] - epsilon);
                }
            }
        });
    }
}

/// Replaces the bases of the active lanes by their [`power`]s, each with its own exponent. `is_common` says that all
/// exponents are the same.
#[inline(always)]
fn raise_to_powers(bases: &mut Scalars, exponents: &Scalars, is_common: bool, active: u64) {
    let exponent = exponents[active.trailing_zeros() as usize % PACKET];
    let is_common = is_common || lanes_in(active).all(|lane| exponents[lane] == exponent);
    let (Some(mut bits), true) = (whole_exponent(exponent), is_common) else {
        return lanes_in(active).for_each(|lane| bases[lane] = power(bases[lane], exponents[lane]));
    };
    // The loop of `power`, with the loop over lanes inside.
    let mut squares = *bases;
    *bases = [1.0; PACKET];
    while bits > 0 {
        if bits & 1 == 1 {
            for lane in span(active) {
                bases[lane] *= squares[lane];
            }
        }
        bits >>= 1;
        if bits > 0 {
            for lane in span(active) {
                squares[lane] *= squares[lane];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{InstructionSet, with_simd};

    /// Two materials, directions all around, every instruction set, and a mask with gaps.
    #[test]
    fn a_packet_is_lit_as_each_of_its_points() {
        let material = |shininess| Material {
            diffuse: Vector3::new(0.7, 0.1, 0.0),
            specular: Vector3::new(0.2, 0.0, 0.4),
            shininess,
        };
        let around = |lane: usize, turn: Real| {
            let angle = lane as Real * turn;
            Vector3::new(libm::sin(angle as f64) as Real, libm::cos(angle as f64) as Real, 0.3)
        };
        let position = Vector3::new(1.0, 2.0, 0.5);
        let lights = [
            Light::Directional { to_light: Vector3::new(0.6, 0.0, 0.8), color: Vector3::splat(0.9) },
            Light::Point { position, color: Vector3::new(0.5, 0.0, 1.0), falloff: 0.25 },
            Light::Point { position, color: Vector3::new(0.5, 0.0, 1.0), falloff: 0.0 },
        ];
        let mask = 0xfff0_0ff7_ffff_fffe;
        let sets = InstructionSet::available().flat_map(|set| [(20.0, set), (0.5, set)]);
        for (shininess, set) in sets {
            let mut surfaces = SurfacePacket::NONE;
            surfaces.set_material(u64::MAX, 0, &material(20.0));
            surfaces.set_material(0x0000_00ff_0000_0000, 1, &material(shininess));
            for lane in 0..PACKET {
                surfaces.point.set(lane, around(lane, 0.4));
                surfaces.normal.set(lane, around(lane, 0.9));
                surfaces.reflected.set(lane, around(lane, 1.7));
            }
            surfaces.point.set(9, position);
            for light in &lights {
                let mut lit = LightPacket::NONE;
                let added = with_simd!(set, simd => lit.illuminate(simd, light, &surfaces, mask));
                assert_eq!(added & !mask, 0);
                for lane in lanes_in(mask) {
                    let seen = light.illuminate(surfaces.point.get(lane));
                    let (normal, reflected) = (surfaces.normal.get(lane), surfaces.reflected.get(lane));
                    let expected = surfaces.material(lane).phong(&seen, normal, reflected);
                    let found = lit.reflected.get(lane);
                    let bits = |v: Vector3| v.to_array().map(|c| if c.is_nan() { Real::MAX } else { c });
                    assert_eq!(bits(found), bits(expected), "{set} {lane}");
                    assert_eq!(added >> lane & 1 == 1, expected != Vector3::ZERO, "{set} {lane}");
                }
            }
        }
    }
}
