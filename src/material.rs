//! [`Material`]: the Phong reflection model.

use crate::light::Illumination;
use vecmath::{Real, Vector3, lesser};

/// How a surface reflects light.
#[derive(Clone, Debug)]
pub struct Material {
    pub diffuse: Vector3,
    pub specular: Vector3,
    pub shininess: Real,
}

/// Surfaces whose specular colour is longer than this are mirrors.
const MIRROR_LENGTH: Real = 0.1;

impl Material {
    /// Returns whether the surface reflects its surroundings, and not only lights.
    pub fn is_mirror(&self) -> bool {
        self.specular.length() > MIRROR_LENGTH
    }

    /// Returns max(0, N.L) I diffuse + max(0, R.L)^shininess I specular, with N the normal and R the mirrored ray.
    ///
    /// As in the starter, the highlight does not depend on whether the light is in front of the surface, and 0^0 is
    /// 1.
    pub fn phong(&self, light: &Illumination, normal: Vector3, mirrored: Vector3) -> Vector3 {
        let highlight = self.highlight(light.to_light, mirrored);
        self.reflect(light.intensity, normal.dot(light.to_light), highlight)
    }

    /// Returns max(0, R.L)^shininess, with R the mirrored ray and L the direction to a light.
    pub fn highlight(&self, to_light: Vector3, mirrored: Vector3) -> Real {
        power(mirrored.dot(to_light).max(0.0), self.shininess)
    }

    /// Returns max(0, N.L) I diffuse + highlight I specular, with N.L the `cosine`.
    ///
    /// The highlight of a plane whose normal is long may overflow. It is kept finite, because infinity times black is NaN.
    #[inline(always)]
    pub fn reflect(&self, intensity: Vector3, cosine: Real, highlight: Real) -> Vector3 {
        let highlight = lesser(highlight, Real::MAX);
        intensity.scaled_by(self.diffuse) * cosine.max(0.0) + intensity.scaled_by(self.specular) * highlight
    }

    /// Returns whether the surface reflects any light of this colour.
    pub fn reflects(&self, color: Vector3) -> bool {
        color.scaled_by(self.diffuse) != Vector3::ZERO || color.scaled_by(self.specular) != Vector3::ZERO
    }
}

/// Returns the mirrored direction of a ray: R = D - 2 (D.N) N. It has the length of D only if N is a unit vector.
pub fn mirrored(direction: Vector3, normal: Vector3) -> Vector3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Largest whole exponent that is computed by multiplication.
const LARGEST_BY_SQUARING: Real = 1024.0;

/// Returns the exponent as a whole number, if [`power`] computes it by multiplication.
pub(crate) fn whole_exponent(exponent: Real) -> Option<u32> {
    let bits = exponent as u32;
    let is_whole = (0.0..=LARGEST_BY_SQUARING).contains(&exponent) && Real::from(bits as f32) == exponent;
    is_whole.then_some(bits)
}

/// Returns `base`^`exponent` for base >= 0; 0^0 = 1.
///
/// Whole exponents, the usual case, are computed by repeated squaring. This is several times faster than the general
/// function, and within `exponent` rounding units of it.
pub(crate) fn power(base: Real, exponent: Real) -> Real {
    let Some(mut bits) = whole_exponent(exponent) else {
        // libm gives the same bits on every machine.
        return libm::pow(base as f64, exponent as f64) as Real;
    };
    let (mut result, mut square) = (1.0, base);
    while bits > 0 {
        if bits & 1 == 1 {
            result *= square;
        }
        square *= square;
        bits >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    const Y: Vector3 = Vector3::new(0.0, 1.0, 0.0);

    fn light(to_light: Vector3) -> Illumination {
        Illumination { to_light, distance: 1.0, intensity: Vector3::splat(2.0) }
    }

    #[test]
    fn phong_adds_diffuse_and_highlight() {
        let material = Material {
            diffuse: Vector3::new(0.5, 0.0, 0.0),
            specular: Vector3::new(0.0, 0.25, 0.0),
            shininess: 2.0,
        };
        let half = (0.5 as Real).sqrt();
        let color = material.phong(&light(Y), Y, Vector3::new(half, half, 0.0));
        assert!((color - Vector3::new(1.0, 0.25, 0.0)).max_abs() < 8.0 * Real::EPSILON, "{color:?}");
    }

    #[test]
    fn the_highlight_is_the_same_on_both_sides() {
        let material = Material { diffuse: Vector3::splat(1.0), specular: Vector3::splat(1.0), shininess: 1.0 };
        assert_eq!(material.phong(&light(-Y), Y, -Y), Vector3::splat(2.0));
    }

    #[test]
    fn zero_to_the_power_of_zero_is_one() {
        let material = Material { diffuse: Vector3::ZERO, specular: Vector3::splat(0.5), shininess: 0.0 };
        assert_eq!(material.phong(&light(Y), Y, -Y), Vector3::splat(1.0));
        assert_eq!(power(0.0, 1.0), 0.0);
    }

    #[test]
    fn powers_by_squaring_agree_with_the_general_function() {
        for exponent in [1.0, 2.0, 20.0, 30.0, 255.0, 1024.0] {
            for base in [0.1, 0.5, 0.9, 0.999, 1.0, 1.1] {
                let general = libm::pow(base as f64, exponent as f64) as Real;
                let error = (power(base, exponent) - general).abs();
                assert!(error <= general * exponent * Real::EPSILON, "{base}^{exponent}");
            }
        }
        assert_eq!(power(0.25, 0.5), 0.5);
        assert_eq!(power(0.5, 1e30), 0.0);
        assert_eq!(power(1.0, 1e30), 1.0);
    }

    #[test]
    fn mirrors_need_a_long_enough_specular_colour() {
        let material = |specular: Vector3| Material { diffuse: Vector3::ZERO, specular, shininess: 0.0 };
        assert!(!material(Vector3::new(0.1, 0.0, 0.0)).is_mirror());
        // Each component is below the threshold, the Euclidean length is not.
        assert!(material(Vector3::splat(0.06)).is_mirror());
    }
}
