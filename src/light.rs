//! [`Light`]: point lights and directional lights, and how much light they give.

use vecmath::{Real, Vector3, exponent, greater, is_unusual, scaled};

/// A light source.
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
        /// 0 or above.
        falloff: Real,
    },
    /// A point light among numbers so large or small that products of them may leave the range.
    ExtremePoint {
        position: Vector3,
        color: Vector3,
        falloff: Real,
        /// No component of its light is larger than this.
        brightest: Real,
    },
}

/// The light that a point receives from a light source.
#[derive(Clone, Copy, Debug)]
pub struct Illumination {
    /// Unit vector to the light.
    pub to_light: Vector3,
    /// Infinite for a directional light.
    pub distance: Real,
    pub intensity: Vector3,
}

impl Light {
    /// Returns the light that falls on `point` if nothing blocks it. The colour of a point light is divided by
    /// falloff times the squared distance, or by a [least divisor](least_fading) if that is larger.
    pub fn illuminate(&self, point: Vector3) -> Illumination {
        match *self {
            Self::Directional { to_light, color } => from_direction(to_light, color),
            Self::Point { position, color, falloff } => {
                from_point(position, color, falloff, least_fading(color), point)
            }
            Self::ExtremePoint { position, color, falloff, brightest } => {
                from_extreme_point(position, color, falloff, brightest, point)
            }
        }
    }

    /// Returns the same light for a scene in which no point may receive more than `brightest`, in any component. `is_usual`
    /// says that no size in the scene [is unusual](is_unusual).
    #[must_use]
    pub fn within_range(self, is_usual: bool, brightest: Real) -> Self {
        match self {
            Self::Directional { to_light, color } => {
                Self::Directional { to_light, color: color.map(|c| c.clamp(-brightest, brightest)) }
            }
            // Moving the sign to the colour changes no bit.
            Self::Point { position, color, falloff } if falloff < 0.0 => {
                Self::Point { position, color: -color, falloff: -falloff }.within_range(is_usual, brightest)
            }
            Self::Point { position, color, falloff } => {
                let mut numbers = [position.max_abs(), falloff].into_iter().chain(color.to_array());
                let is_usual = is_usual
                    && color.max_abs() <= USUAL_BRIGHTNESS
                    && brightest >= USUAL_BRIGHTNESS / WITHOUT_FALLOFF
                    && !numbers.any(is_unusual);
                if is_usual { self } else { Self::ExtremePoint { position, color, falloff, brightest } }
            }
            Self::ExtremePoint { .. } => self,
        }
    }

    /// Returns the colour at the source.
    pub fn color(&self) -> Vector3 {
        match *self {
            Self::Directional { color, .. } | Self::Point { color, .. } | Self::ExtremePoint { color, .. } => {
                color
            }
        }
    }

    /// Returns whether the light is beyond any picture everywhere: a point light that does not fade.
    pub fn is_infinite(&self) -> bool {
        matches!(self, Self::Point { falloff: 0.0, .. })
    }

    /// Returns an upper bound of the light that falls on any point, in any component. `None` if there is no bound,
    /// because a point light has none near its position.
    pub fn max_radiance(&self) -> Option<Real> {
        match self {
            Self::Directional { color, .. } => Some(color.max_abs()),
            Self::Point { .. } | Self::ExtremePoint { .. } => None,
        }
    }

    /// Illuminates many points: calls `lit` with each index and the light at `point(index)`. The formula is chosen
    /// outside the loops, so that they vectorise.
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
                let least = least_fading(color);
                for index in indices {
                    lit(index, from_point(position, color, falloff, least, point(index)));
                }
            }
            Self::ExtremePoint { .. } => {
                for index in indices {
                    lit(index, self.illuminate(point(index)));
                }
            }
        }
    }
}

/// What stands for a divisor of zero: so small that any colour becomes brighter than a picture shows, and so large that
/// it stays finite. An infinite light would be NaN, and so black, on the dark side and wherever a colour is zero.
const WITHOUT_FALLOFF: Real = Real::MIN_POSITIVE / Real::EPSILON;
/// Colours of usual point lights are no brighter than this, so that their light stays finite, and what reflects it too.
const USUAL_BRIGHTNESS: Real = (1u32 << 20) as Real;

/// Returns the least divisor of a point light's colour.
#[inline(always)]
fn least_fading(color: Vector3) -> Real {
    WITHOUT_FALLOFF * greater(1.0, color.max_abs())
}

#[inline(always)]
fn from_direction(to_light: Vector3, color: Vector3) -> Illumination {
    Illumination { to_light, distance: Real::INFINITY, intensity: color }
}

#[inline(always)]
fn from_point(position: Vector3, color: Vector3, falloff: Real, least: Real, point: Vector3) -> Illumination {
    let offset = position - point;
    let distance = offset.length();
    // A point at the light's own position receives nothing, because there is no direction to the light.
    let is_elsewhere = distance != 0.0;
    let fading = greater(least, falloff * distance * distance);
    let (to_light, intensity) = (offset / distance, color / fading);
    Illumination {
        to_light: if is_elsewhere { to_light } else { Vector3::ZERO },
        distance,
        intensity: if is_elsewhere { intensity } else { Vector3::ZERO },
    }
}

/// Does what [`from_point`] does, with the powers of two of all factors set aside.
#[cold]
fn from_extreme_point(
    position: Vector3,
    color: Vector3,
    falloff: Real,
    brightest: Real,
    point: Vector3,
) -> Illumination {
    // Half of the way, because the whole may overflow.
    let offset = position * 0.5 - point * 0.5;
    let (to_light, half) = offset.direction_and_length();
    if half == 0.0 {
        return Illumination { to_light, distance: 0.0, intensity: Vector3::ZERO };
    }
    let (of_falloff, of_distance) = (exponent(falloff), exponent(half));
    let distance = scaled(half, -of_distance);
    let fading = scaled(falloff, -of_falloff) * distance * distance;
    let power = -of_falloff - 2 * (of_distance + 1);
    let light = color.map(|c| {
        let of_color = exponent(c);
        // Without falloff it is infinite, and NaN where there is no colour.
        let quotient = if c == 0.0 { 0.0 } else { scaled(c, -of_color) / fading };
        scaled(quotient, of_color + power).clamp(-brightest, brightest)
    });
    Illumination { to_light, distance: half * 2.0, intensity: light }
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
    fn a_point_light_gives_no_light_at_its_own_position() {
        let light = Light::Point { position: Vector3::splat(1.0), color: Vector3::splat(0.5), falloff: 0.0 };
        let seen = light.illuminate(Vector3::splat(1.0));
        assert_eq!((seen.to_light, seen.intensity), (Vector3::ZERO, Vector3::ZERO));
    }

    #[test]
    fn a_point_light_without_falloff_is_huge_but_finite() {
        let light = Light::Point { position: Vector3::ZERO, color: Vector3::new(0.5, 1e9, 0.0), falloff: 0.0 };
        let [red, green, blue] = light.illuminate(Vector3::splat(1.0)).intensity.to_array();
        assert!(red > 1e30 && green > red && green.is_finite(), "{red} {green}");
        assert_eq!(blue, 0.0);
    }
}
