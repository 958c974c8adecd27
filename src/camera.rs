//! [`Camera`]: makes the ray through a place in the picture.

use crate::objects::{Aabb, Ray};
use vecmath::{Real, Vector3};

/// A pinhole camera.
#[derive(Clone, Debug)]
pub struct Camera {
    pub(crate) center: Vector3,
    /// The view direction, with the length at which the picture spans -1 to 1 along `horizontal` and `up`.
    forward: Vector3,
    /// Unit vector to the right.
    horizontal: Vector3,
    /// As in the scene file: neither normalised nor made orthogonal, because the starter's camera does neither.
    up: Vector3,
}

impl Camera {
    /// Makes a camera with an opening angle from bottom to top, in radians, above 0 and below pi.
    ///
    /// # Errors
    /// [`CameraError`] if the camera would see nothing.
    pub fn new(center: Vector3, direction: Vector3, up: Vector3, angle_radians: f64) -> Result<Self, CameraError> {
        if !(angle_radians > 0.0 && angle_radians < std::f64::consts::PI) {
            return Err(CameraError::Angle);
        }
        let direction = direction.try_normalized().ok_or(CameraError::Direction)?;
        let up_direction = up.try_normalized().ok_or(CameraError::Up)?;
        let across = direction.cross(up_direction);
        // Two unit vectors that are parallel up to rounding have a cross product of a few rounding units.
        if across.length() <= 4.0 * Real::EPSILON {
            return Err(CameraError::UpAlongDirection);
        }
        // libm gives the same bits on every machine.
        let half_height = libm::tan(angle_radians / 2.0) as Real;
        // Products with a vector of extreme length would overflow or underflow; any other vector is used as it is.
        let usual = (1e-30..1e30).contains(&up.max_abs());
        let horizontal = if usual { direction.cross(up).normalized() } else { across.normalized() };
        Ok(Self { center, forward: direction / half_height, horizontal, up })
    }

    /// Returns the tangent of half the angle from bottom to top.
    pub fn half_height(&self) -> Real {
        1.0 / self.forward.length()
    }

    /// Returns the ray through a place in the picture; (-1, -1) is the bottom left corner, (1, 1) the top right one.
    pub fn ray(&self, ndc: (Real, Real)) -> Ray {
        Ray { origin: self.center, direction: self.direction(ndc).normalized() }
    }

    /// Returns where the ray through a point goes through the picture, in normalised device coordinates; `None` unless
    /// the point lies clearly before the camera.
    pub fn ndc_of(&self, point: Vector3) -> Option<(Real, Real)> {
        let [right, up, into] = self.coordinates(point);
        let is_before = into > 1e-6 * (point - self.center).length() / self.forward.length();
        is_before.then_some((right / into, up / into))
    }

    /// Returns whether a part of a box may lie in the picture, without the half pixels beyond its border.
    pub fn may_see(&self, bounds: &Aabb) -> bool {
        let corners = bounds.corners().map(|corner| self.coordinates(corner));
        let all = |is_outside: fn(&[Real; 3]) -> bool| corners.iter().all(is_outside);
        !(all(|c| c[0] > c[2]) || all(|c| c[0] < -c[2]) || all(|c| c[1] > c[2]) || all(|c| c[1] < -c[2]))
    }

    /// Returns how far to the right, up and into the picture a point lies, in multiples of the camera's vectors.
    fn coordinates(&self, point: Vector3) -> [Real; 3] {
        // Cramer's rule.
        let normals =
            [self.up.cross(self.forward), self.forward.cross(self.horizontal), self.horizontal.cross(self.up)];
        let volume = self.forward.dot(normals[2]);
        normals.map(|normal| normal.dot(point - self.center) / volume)
    }

    /// Returns the direction of that ray before it is normalised.
    #[inline(always)]
    pub(crate) fn direction(&self, (ndc_x, ndc_y): (Real, Real)) -> Vector3 {
        self.forward + self.horizontal * ndc_x + self.up * ndc_y
    }
}

/// Why a camera sees nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraError {
    Angle,
    Direction,
    Up,
    UpAlongDirection,
}

/// A place in a grid of pixels: x to the right and y upward, in pixels.
pub type Place = (Real, Real);

/// The grid of a picture's pixels: takes pixels to places, and places to camera coordinates.
#[derive(Clone, Copy, Debug)]
pub struct PixelGrid {
    pub width: u32,
    pub height: u32,
}

impl PixelGrid {
    /// Returns the place of pixel (`x`, `row`), row 0 at the top, moved right by `offset_x` and up by `offset_y`
    /// pixels. Places are counted in pixels from the bottom left pixel.
    #[inline(always)]
    pub fn place(&self, (x, row): (u32, u32), (offset_x, offset_y): (Real, Real)) -> Place {
        (x as Real + offset_x, (self.height - 1 - row) as Real + offset_y)
    }

    /// Takes a place to normalised device coordinates, from (-1, -1) at the bottom left to (1, 1) at the top right.
    ///
    /// The outermost pixels lie on the picture's border. In a grid one pixel wide the pixel is in the middle, and
    /// `offset_x` has no effect.
    #[inline(always)]
    pub fn ndc(&self, (x, y): Place) -> (Real, Real) {
        let ndc = |place: Real, count: u32| match count {
            1 => 0.0,
            _ => 2.0 * place / (count - 1) as Real - 1.0,
        };
        (ndc(x, self.width), ndc(y, self.height))
    }

    /// Returns the place with these coordinates; `None` in a grid one pixel wide, where all places have the same.
    pub fn place_of(&self, (x, y): (Real, Real)) -> Option<Place> {
        let place = |ndc: Real, count: u32| (count > 1).then(|| (ndc + 1.0) * 0.5 * (count - 1) as Real);
        Some((place(x, self.width)?, place(y, self.height)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const Z: Vector3 = Vector3::new(0.0, 0.0, 1.0);
    const Y: Vector3 = Vector3::new(0.0, 1.0, 0.0);

    fn camera() -> Camera {
        Camera::new(Vector3::new(0.0, 0.0, 5.0), -2.0 * Z, Y, std::f64::consts::FRAC_PI_2).unwrap()
    }

    #[test]
    fn a_point_lies_where_its_ray_goes() {
        let skew = Camera::new(
            Vector3::new(1.0, 2.0, 3.0),
            Vector3::new(0.5, -1.0, 2.0),
            Vector3::new(0.1, 3.0, 0.2),
            1.0,
        );
        let skew = skew.unwrap();
        for ndc in [(0.0, 0.0), (-0.7, 0.9), (1.0, -1.0)] {
            let ray = skew.ray(ndc);
            let found = skew.ndc_of(ray.origin + ray.direction * 7.0).unwrap();
            assert!((found.0 - ndc.0).abs().max((found.1 - ndc.1).abs()) < 1e3 * Real::EPSILON, "{found:?}");
            assert_eq!(skew.ndc_of(ray.origin - ray.direction * 7.0), None);
        }
        assert_eq!(skew.ndc_of(skew.center), None);
        assert_eq!(skew.ndc_of(Vector3::splat(Real::NAN)), None);
    }

    #[test]
    fn the_angle_is_the_full_height() {
        let half = (0.5 as Real).sqrt();
        let top = camera().ray((0.0, 1.0)).direction;
        assert!((top - Vector3::new(0.0, half, -half)).max_abs() < 4.0 * Real::EPSILON, "{top:?}");
        assert_eq!(camera().ray((0.0, 0.0)).direction, -Z);
    }

    #[test]
    fn up_is_used_as_given() {
        let skewed = Camera::new(Vector3::ZERO, -Z, Vector3::new(0.0, 3.0, -1.0), std::f64::consts::FRAC_PI_2);
        let direction = skewed.unwrap().ray((0.0, 1.0)).direction;
        let expected = Vector3::new(0.0, 3.0, -2.0).normalized();
        assert!((direction - expected).max_abs() < 4.0 * Real::EPSILON);
    }

    #[test]
    fn up_may_be_of_any_length() {
        for length in [Real::MIN_POSITIVE, 1e-31, 1e31, Real::MAX] {
            let up = Vector3::new(0.6, 0.8, 0.5) * length;
            let camera = Camera::new(Vector3::ZERO, -Z, up, std::f64::consts::FRAC_PI_2).unwrap();
            let sideways = camera.ray((1.0, 0.0)).direction - camera.ray((-1.0, 0.0)).direction;
            let expected = Vector3::new(0.8, -0.6, 0.0) * (2.0 as Real).sqrt();
            assert!((sideways - expected).max_abs() < 8.0 * Real::EPSILON, "{length}: {sideways:?}");
        }
    }

    #[test]
    fn cameras_that_see_nothing_are_refused() {
        let camera = |direction, up, degrees: f64| Camera::new(Vector3::ZERO, direction, up, degrees.to_radians());
        assert_eq!(camera(Vector3::ZERO, Y, 30.0).unwrap_err(), CameraError::Direction);
        assert_eq!(camera(Z, Vector3::ZERO, 30.0).unwrap_err(), CameraError::Up);
        assert_eq!(camera(Z, -7.0 * Z, 30.0).unwrap_err(), CameraError::UpAlongDirection);
        for degrees in [0.0, -30.0, 180.0, 400.0, f64::NAN] {
            assert_eq!(camera(Z, Y, degrees).unwrap_err(), CameraError::Angle);
        }
    }

    #[test]
    fn pixels_span_the_picture_and_a_single_pixel_is_in_the_middle() {
        let grid = PixelGrid { width: 5, height: 3 };
        let ndc = |grid: &PixelGrid, pixel, offset| grid.ndc(grid.place(pixel, offset));
        assert_eq!(ndc(&grid, (0, 2), (0.0, 0.0)), (-1.0, -1.0));
        assert_eq!(ndc(&grid, (4, 0), (0.0, 0.0)), (1.0, 1.0));
        assert_eq!(ndc(&grid, (0, 2), (0.5, 1.0)), (-0.75, 0.0));
        assert_eq!(ndc(&PixelGrid { width: 1, height: 1 }, (0, 0), (0.3, 0.9)), (0.0, 0.0));
    }
}
