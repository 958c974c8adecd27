//! Warnings about the numbers of a scene: where the starter's fixed ray offset of 0.01 does not fit, where the normal
//! of a plane is not a unit vector, and where a matrix loses many digits.
//!
//! There is one sentence for each kind of warning, which names the first object concerned.

use super::obj::others;
use crate::camera::Camera;
use crate::error::{Remarks, SourceText, Span, shown_number};
use crate::objects::{Aabb, ExtremeSphere, Object, Plane, Shape, Sphere};
use crate::options::Epsilon;
use crate::plan::Plan;
use vecmath::{Matrix4, Real, UNIT_ROUNDOFF, Vector3, exponent};

/// For each kind of warning, the first object concerned and their number.
#[derive(Default)]
pub(super) struct Hints {
    unnormalized_planes: Found,
    thin_walls: Found,
    nearly_singular: Found,
    without_area: Found,
    too_thin: Found,
    too_far: Found,
    at_an_end: Found,
}

#[derive(Default)]
struct Found {
    count: usize,
    place: Span,
    what: String,
}

impl Found {
    fn add(&mut self, place: Span, what: impl FnOnce() -> String) {
        if self.count == 0 {
            (self.place, self.what) = (place, what());
        }
        self.count += 1;
    }

    fn sentence(&self, source: &SourceText, advice: &str) -> Option<String> {
        let sentence = || format!("{}: {}{}{advice}", source.location(self.place), self.what, others(self.count));
        (self.count > 0).then(sentence)
    }
}

/// Sizes of scenes that look right with a ray offset of 0.01.
const SIZES: std::ops::RangeInclusive<Real> = 1.0..=1e5;
/// Twice the ray offset. Rays that leave one side of a thinner wall may start on its other side.
const THIN: Real = 0.02;
/// Share of its distance that an object spans if it is seen at all.
const SEEN: Real = 1e-6;
/// Share of the picture's height that an object spans if much of it is seen.
const LARGE: Real = 0.01;
/// Tangent of half the angle of a camera whose neighbouring rays may be equal, by rounding.
const NARROWEST: Real = 8192.0 * UNIT_ROUNDOFF;
/// Beyond this power of two, and below its inverse, products of coordinates may leave the range of numbers.
const LARGEST_EXPONENT: i32 = Real::MAX_EXP - Real::MAX_EXP / 32;
/// Share of the size of a scene beyond which a ray offset loses much of its shadows and mirror images.
const LARGE_OFFSET: f64 = 0.1;
/// Rounding error, in radii of a sphere, with which its picture is lost.
const LOST: Real = 1e-3;
/// Condition number from which half of the digits of an `f64` are lost.
const NEARLY_SINGULAR: Real = 1e8;

impl Hints {
    /// Notes a triangle without area.
    pub fn left_out(&mut self, place: Span) {
        self.without_area.add(place, || "this triangle has no area and is left out".to_owned());
    }

    /// Notes the warnings about an object.
    pub fn note(&mut self, place: Span, shape: &Shape, matrix: Option<&Matrix4>, bounds: Option<&Aabb>) {
        let condition = matrix.map_or(1.0, |matrix| matrix.linear().condition_number());
        if condition > NEARLY_SINGULAR {
            self.nearly_singular.add(place, || {
                format!("the transforms around this object are nearly singular: condition number {condition:.1e}")
            });
        }
        if let (Shape::Plane(plane), None) = (shape, matrix) {
            let length = plane.shading_normal.length();
            if (length - 1.0).abs() > 1e-6 {
                self.unnormalized_planes.add(place, || {
                    let length = length as f64;
                    format!("the normal of this plane is not a unit vector (its length is {length:.4}), which the colours show")
                });
            }
        }
        let thickness = bounds.map_or(Real::INFINITY, |bounds| thickness(shape, bounds, matrix));
        if thickness < THIN {
            self.thin_walls.add(place, || {
                format!("this object is only {:.1e} thick, and rays start 0.01 from a surface", thickness as f64)
            });
        }
    }

    /// Notes what a camera sees wrongly.
    pub fn note_seen(&mut self, place: Span, object: &Object, camera: &Camera) {
        match &object.shape {
            Shape::Plane(plane) => self.note_plane_at_an_end(place, object, plane, camera),
            Shape::Sphere(sphere) | Shape::ExtremeSphere(ExtremeSphere(sphere)) => {
                self.note_too_thin(place, object, sphere, camera);
            }
            Shape::Triangle(_) | Shape::Mesh(_) => {}
        }
    }

    /// Notes a plane if products in its test with a ray of length 1 from the eye may leave the range of numbers.
    fn note_plane_at_an_end(&mut self, place: Span, object: &Object, plane: &Plane, camera: &Camera) {
        let matrix = object.transform.as_ref().map_or(Matrix4::IDENTITY, |transform| transform.object_from_world);
        let reach = matrix.linear().abs() * camera.center.map(|x| x.abs() + 1.0) + matrix.offset().map(Real::abs);
        let largest = (reach.max_abs() * plane.normal.max_abs().max(1.0)).min(Real::MAX);
        if exponent(largest) > LARGEST_EXPONENT {
            self.at_an_end.add(place, || at_an_end(largest));
        }
    }

    /// Notes a sphere that is flattened so much, or so far from the eye, that rays hit or miss it by rounding only. The test of
    /// a sphere has some 16 roundings of the distance in object space.
    fn note_too_thin(&mut self, place: Span, object: &Object, sphere: &Sphere, camera: &Camera) {
        let Some(bounds) = &object.bounds else { return };
        let eye = camera.center;
        let eye_in_object =
            object.transform.as_ref().map_or(eye, |transform| transform.object_from_world.transform_point(eye));
        let distance = (eye_in_object - sphere.center).max_abs() / sphere.radius;
        let least = SEEN.min(LARGE * camera.half_height());
        let is_seen = bounds.size().max_abs() > least * (eye - bounds.center()).max_abs();
        if !is_seen || 16.0 * UNIT_ROUNDOFF * distance <= LOST {
            return;
        }
        if !distance.is_finite() {
            self.at_an_end.add(place, || at_an_end(Real::MAX));
        } else if object.transform.is_some() {
            self.too_thin.add(place, || {
                format!("this sphere is flattened to {:.1e} of its distance", 1.0 / distance as f64)
            });
        } else {
            self.too_far
                .add(place, || format!("this sphere is seen from {:.1e} times its radius", distance as f64));
        }
    }

    /// Adds the warnings that matter for the pictures of `plan`.
    pub fn finish(
        &self,
        plan: &Plan,
        objects: &[Object],
        camera: &Camera,
        source: &SourceText,
        remarks: &mut Remarks,
    ) {
        let Remarks { warnings, hints } = remarks;
        warnings.extend(self.without_area.sentence(source, ""));
        warnings.extend(self.nearly_singular.sentence(source, ""));
        warnings
            .extend(self.too_thin.sentence(source, ": rays hit or miss it by rounding; two triangles are exact"));
        warnings.extend(self.too_far.sentence(source, ": rays hit or miss it by rounding; a nearer eye sees it"));
        let at_an_end = || self.at_an_end.sentence(source, ": pixels may be wrong");
        warnings.extend(of_numbers(objects, camera, source).or_else(at_an_end));
        if !plan.robust && (plan.color || plan.normals) {
            hints.extend(self.unnormalized_planes.sentence(source, ": -robust takes it as one"));
        }
        if !plan.shadows && plan.bounces == 0 {
            return;
        }
        let bounds = objects.iter().filter_map(|object| object.bounds).fold(Aabb::EMPTY, |a, b| a.union(&b));
        if let Epsilon::Along(epsilon) = plan.epsilon
            && (epsilon == 0.0 || !bounds.is_empty() && epsilon < f64::from(UNIT_ROUNDOFF * bounds.max_abs()))
        {
            warnings.push(format!(
                "with -epsilon {} rays hit the surface that they leave: -epsilon auto does without",
                shown_number(epsilon)
            ));
        }
        let size = bounds.size().max_abs();
        if plan.epsilon != Epsilon::default() {
            if let Epsilon::Along(epsilon) = plan.epsilon
                && epsilon > LARGE_OFFSET * f64::from(size)
                && size > 0.0
            {
                warnings.push(format!(
                    "with -epsilon {} shadows and mirror images are lost in a scene that is {:.1e} across: \
                     -epsilon auto fits any size",
                    shown_number(epsilon),
                    size as f64
                ));
            }
            return;
        }
        if !bounds.is_empty() && !SIZES.contains(&size) {
            let (path, what) = (source.path.display(), if size < 1.0 { "small" } else { "large" });
            warnings.push(format!(
                "{path}: the scene is {what}, {:.1e} across, for rays that start 0.01 from a surface: -robust fits any size",
                size as f64
            ));
        }
        warnings.extend(self.thin_walls.sentence(source, ": -robust fits any thickness"));
    }
}

/// Warns of a picture that numbers cannot show: of too small an angle, or of a scene at the end of the range.
fn of_numbers(objects: &[Object], camera: &Camera, source: &SourceText) -> Option<String> {
    let path = source.path.display();
    if camera.half_height() < NARROWEST {
        return Some(format!(
            "{path}: the angle of the camera is so small that neighbouring rays differ by rounding only: a nearer eye does without"
        ));
    }
    let is_plane = |object: &Object| matches!(object.shape, Shape::Plane(_));
    // Bounds that would overflow are missing.
    let size = |object: &Object| object.bounds.map_or(Real::MAX, |bounds| bounds.max_abs());
    let sizes = objects.iter().filter(|object| !is_plane(object)).map(size);
    let largest = sizes.fold(camera.center.max_abs(), Real::max);
    let is_at_an_end = largest > 0.0 && exponent(largest).abs() > LARGEST_EXPONENT;
    is_at_an_end.then(|| {
        let largest = largest as f64;
        format!("{path}: coordinates of {largest:.1e} are at the end of the range of numbers, so that pixels may be wrong")
    })
}

/// Says that numbers of this size occur where rays meet an object.
fn at_an_end(largest: Real) -> String {
    let largest = largest as f64;
    format!("coordinates of {largest:.1e} in the space of this object are at the end of the range of numbers")
}

/// Returns the smallest extent of an object in world space, or infinity if it is flat and so has no inside. It is
/// estimated from the object's box, which is exact for spheres and for slabs in any orientation.
fn thickness(shape: &Shape, bounds: &Aabb, matrix: Option<&Matrix4>) -> Real {
    if matches!(shape, Shape::Triangle(_) | Shape::Plane(_)) {
        return Real::INFINITY;
    }
    let stretch = matrix.map_or([1.0; 3], |matrix| matrix.linear().columns.map(Vector3::length));
    let size = bounds.size();
    let least = (0..3).map(|axis| size[axis] * stretch[axis]).fold(Real::INFINITY, Real::min);
    if least > 0.0 { least } else { Real::INFINITY }
}
