//! [`Light`]: where light comes from, and how much of it.

use vecmath::{Real, Vector3};

/// A light without extent.
#[derive(Clone, Debug)]
pub enum Light {
    Directional {
        /// Unit vector.
        to_light: Vector3,
        color: Vector3,
    },
    Point {
        position: Vector3,
        color: Vector3,
        falloff: Real,
    },
}

/// A light as a point sees it.
#[derive(Clone, Copy, Debug)]
pub struct Illumination {
    /// Unit vector to the light.
    pub to_light: Vector3,
    /// Infinite for a directional light.
    pub distance: Real,
    pub intensity: Vector3,
}

impl Light {
    /// The light that falls on `point` if nothing is in the way. A point light fades with falloff times the squared
    /// distance, and is infinite where that is zero.
    pub fn illuminate(&self, point: Vector3) -> Illumination {
        match *self {
            Self::Directional { to_light, color } => from_direction(to_light, color),
            Self::Point { position, color, falloff } => from_point(position, color, falloff, point),
        }
    }

    /// Returns the colour, before it fades.
    pub fn color(&self) -> Vector3 {
        match *self {
            Self::Directional { color, .. } | Self::Point { color, .. } => color,
        }
    }

    /// Returns whether the light is infinite everywhere: a point light that does not fade.
    pub fn is_infinite(&self) -> bool {
        matches!(self, Self::Point { falloff: 0.0, .. })
    }

    /// Returns the most light that can fall on a point, in any component; `None` if there is no bound, as near a point
    /// light.
    pub fn max_radiance(&self) -> Option<Real> {
        match self {
            Self::Directional { color, .. } => Some(color.max_abs()),
            Self::Point { .. } => None,
        }
    }

    /// Illuminates many points: calls `lit` with each index and the light at `point` of it. The choice of the formula
    /// stands outside the loops, so that they vectorise.
    #[inline(always)]
    pub fn illuminate_each(
        &self,
        indices: std::ops::Range<usize>,
        point: impl Fn(usize) -> Vector3,
        mut lit: impl FnMut(usize, Illumination),
    ) {
        match *self {
            Self::Directional { to_light, color } => {
                for index in indices {
                    lit(index, from_direction(to_light, color));
                }
            }
            Self::Point { position, color, falloff } => {
                for index in indices {
                    lit(index, from_point(position, color, falloff, point(index)));
                }
            }
        }
    }
}

#[inline(always)]
fn from_direction(to_light: Vector3, color: Vector3) -> Illumination {
    Illumination { to_light, distance: Real::INFINITY, intensity: color }
}

#[inline(always)]
fn from_point(position: Vector3, color: Vector3, falloff: Real, point: Vector3) -> Illumination {
    let offset = position - point;
    let distance = offset.length();
    // A light is not lit by itself: from its own place it has no direction.
    let is_elsewhere = distance != 0.0;
    let (to_light, intensity) = (offset / distance, color / (falloff * distance * distance));
    Illumination {
        to_light: if is_elsewhere { to_light } else { Vector3::ZERO },
        distance,
        intensity: if is_elsewhere { intensity } else { Vector3::ZERO },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_light_fades_with_the_square_of_the_distance() {
        let light = Light::Point {
            position: Vector3::new(0.0, 4.0, 0.0),
            color: Vector3::new(1.0, 2.0, 0.0),
            falloff: 0.25,
        };
        let seen = light.illuminate(Vector3::new(0.0, 2.0, 0.0));
        assert_eq!((seen.to_light, seen.distance), (Vector3::new(0.0, 1.0, 0.0), 2.0));
        assert_eq!(seen.intensity, Vector3::new(1.0, 2.0, 0.0));
    }

    #[test]
    fn in_its_own_place_it_gives_no_light() {
        let light = Light::Point { position: Vector3::splat(1.0), color: Vector3::splat(0.5), falloff: 0.0 };
        let seen = light.illuminate(Vector3::splat(1.0));
        assert_eq!((seen.to_light, seen.intensity), (Vector3::ZERO, Vector3::ZERO));
    }

    #[test]
    fn without_falloff_it_is_infinite() {
        let light = Light::Point { position: Vector3::ZERO, color: Vector3::splat(0.5), falloff: 0.0 };
        assert_eq!(light.illuminate(Vector3::splat(1.0)).intensity, Vector3::splat(Real::INFINITY));
    }
}
