//! [`SurfaceBounds`]: tells in one step that a light adds nothing to any point of a packet.
//!
//! A surface that looks away from a light reflects exactly zero, but finding that out point by point takes as long as
//! lighting it. Here the ranges of all points, normals and mirrored directions of a packet are compared with the light.

use super::shade::SurfacePacket;
use crate::light::Light;
use crate::objects::Aabb;
use crate::simd::packet::{Vectors, has_lane, lanes_in, span};
use crate::simd::{Simd, WIDTH, vectorize};
use vecmath::{Real, UNIT_ROUNDOFF, Vector3, greater, lesser};

/// So many lights are lit in the time that the bounds take.
pub const FEW_LIGHTS: usize = 4;

/// Roundings of a cosine N.L and of its bound, in units of the sum of |N_i| |L_i|: the difference of light and point, its
/// length (5), the division, and two scalar products (3 each). Twice that.
const COSINE_ROUNDINGS: Real = 32.0;

/// The ranges of what decides how the points of a packet are lit.
pub struct SurfaceBounds {
    point: Aabb,
    normal: Aabb,
    /// The mirrored directions; `None` if no material has a highlight.
    reflected: Option<Aabb>,
    /// Whether a highlight is everywhere, because 0^0 is 1.
    shines_everywhere: bool,
}

impl SurfaceBounds {
    /// Returns the bounds of the active points. There must be one.
    pub fn of<S: Simd>(simd: S, surfaces: &SurfacePacket, active: u64) -> Self {
        vectorize!(simd, {
            let specular = range(&surfaces.specular, active);
            let is_dull = specular.min == Vector3::ZERO && specular.max == Vector3::ZERO;
            Self {
                point: range(&surfaces.point, active),
                normal: range(&surfaces.normal, active),
                reflected: if is_dull { None } else { Some(range(&surfaces.reflected, active)) },
                shines_everywhere: !is_dull && lanes_in(active).any(|lane| surfaces.shininess[lane] == 0.0),
            }
        })
    }

    /// Returns true only if none of the points reflects anything of the light.
    pub fn are_dark_to(&self, light: &Light) -> bool {
        let to_light = match *light {
            Light::Directional { to_light, .. } => Aabb { min: to_light, max: to_light },
            Light::Point { position, .. } => {
                Aabb { min: position - self.point.max, max: position - self.point.min }
            }
            _ => return false,
        };
        let looks_away = |directions: &Aabb| {
            let (mut largest, mut terms) = (0.0, 0.0);
            for axis in 0..3 {
                let ([a, b], [c, d]) =
                    ([directions.min[axis], directions.max[axis]], [to_light.min[axis], to_light.max[axis]]);
                largest += greater(greater(a * c, a * d), greater(b * c, b * d));
                terms += greater(a.abs(), b.abs()) * greater(c.abs(), d.abs());
            }
            // Not true for NaN and infinities.
            largest < -COSINE_ROUNDINGS * UNIT_ROUNDOFF * terms
        };
        !self.shines_everywhere && looks_away(&self.normal) && self.reflected.as_ref().is_none_or(looks_away)
    }
}

/// Returns the box around the vectors of the active lanes.
#[inline(always)]
fn range(vectors: &Vectors, active: u64) -> Aabb {
    let first = active.trailing_zeros() as usize;
    let [(a, d), (b, e), (c, f)] = [0, 1, 2].map(|axis| {
        let values = &vectors.0[axis];
        let (mut low, mut high) = ([values[first]; WIDTH], [values[first]; WIDTH]);
        for group in span(active).step_by(WIDTH) {
            for place in 0..WIDTH {
                let lane = group + place;
                let value = if has_lane(active, lane) { values[lane] } else { values[first] };
                (low[place], high[place]) = (lesser(low[place], value), greater(high[place], value));
            }
        }
        (low.into_iter().fold(values[first], lesser), high.into_iter().fold(values[first], greater))
    });
    Aabb { min: Vector3::new(a, b, c), max: Vector3::new(d, e, f) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::simd::packet::PACKET;
    use crate::simd::{InstructionSet, with_simd};

    /// Small patches of surfaces look in all directions; every one is asked about lights all around.
    #[test]
    fn no_light_that_adds_anything_is_left_out() {
        let direction = |angle: Real, height: Real| {
            Vector3::new(libm::sin(angle as f64) as Real, height, libm::cos(angle as f64) as Real).normalized()
        };
        let mask = 0x0fff_ffff_ffff_ff3e;
        let (mut dark, mut lit) = (0, 0);
        for (specular, shininess) in [(0.0, 0.0), (0.5, 20.0), (0.5, 0.0)] {
            let specular = Vector3::new(specular, 0.0, 0.0);
            let material = Material { diffuse: Vector3::splat(0.5), specular, shininess };
            for patch in 0..40 {
                let mut surfaces = SurfacePacket::NONE;
                surfaces.set_material(u64::MAX, 0, &material);
                for lane in 0..PACKET {
                    let angle = patch as Real * 0.4 + lane as Real * 0.01;
                    surfaces.normal.set(lane, direction(angle, 0.2));
                    surfaces.point.set(lane, direction(angle, 0.2) * 2.0);
                    surfaces.reflected.set(lane, direction(angle * 1.1, 0.1));
                }
                for light in 0..60 {
                    let way = direction(light as Real * 0.7, light as Real * 0.03 - 0.9);
                    let (color, falloff) = (Vector3::splat(1.0), 0.5);
                    for light in [
                        Light::Directional { to_light: way, color },
                        Light::Point { position: way * 2.1, color, falloff },
                    ] {
                        let adds = lanes_in(mask).any(|lane| {
                            let seen = light.illuminate(surfaces.point.get(lane));
                            material.phong(&seen, surfaces.normal.get(lane), surfaces.reflected.get(lane))
                                != Vector3::ZERO
                        });
                        for set in InstructionSet::available() {
                            let bounds = with_simd!(set, simd => SurfaceBounds::of(simd, &surfaces, mask));
                            let is_dark = bounds.are_dark_to(&light);
                            assert!(!(is_dark && adds), "{set} {patch} {light:?}");
                            (dark, lit) = (dark + u32::from(is_dark), lit + u32::from(!adds && !is_dark));
                        }
                    }
                }
            }
        }
        // Few that add nothing are not found out.
        assert!(dark > 1000 && lit < dark / 2, "{dark} found dark, {lit} not");
    }
}
