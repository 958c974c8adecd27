//! Finds objects that no picture shows: a sphere stands between them and everything that looks at them.
//!
//! All surfaces are opaque. So a ray that comes from outside hits the sphere before anything inside. A shadow ray to a
//! light outside hits the sphere, too, wherever it starts. If the eye is inside, so is all that it sees, and a shadow ray to
//! a light inside does not leave the sphere. Mirror rays start up to the ray offset away from a surface, so they may begin
//! on the other side of a sphere that touches it: where there are mirrors, nothing is hidden.

use crate::light::Light;
use crate::objects::{Aabb, Object, Shape, Sphere};
use crate::options::Epsilon;
use crate::plan::Plan;
use vecmath::{Real, UNIT_ROUNDOFF, Vector3};

/// Number of spheres, the largest ones, that may hide something.
const HIDING: usize = 8;

/// How many objects a sphere hides.
#[derive(Default)]
pub(super) struct Hidden {
    /// Inside a sphere, with the eye and all lights outside.
    pub inside: usize,
    /// Outside a sphere, with the eye and all lights inside.
    pub outside: usize,
}

/// Removes the objects that a sphere hides from `eye` and `lights`.
pub(super) fn remove_hidden(objects: &mut Vec<Object>, eye: Vector3, lights: &[Light], plan: &Plan) -> Hidden {
    if plan.bounces > 0 {
        return Hidden::default();
    }
    let lights = if plan.shadows { lights } else { &[] };
    let watchers = Watchers { eye, lights, epsilon: plan.epsilon };
    let origins = if plan.shadows { around(objects) } else { Some(Aabb::of_points([eye])) };
    let spheres = || objects.iter().filter_map(sphere_of);
    let seen_from_outside =
        |sphere: &Sphere| origins.is_some_and(|origins| watchers.are_outside(sphere, &origins));
    let mut outer: Vec<Sphere> = spheres().filter(seen_from_outside).collect();
    outer.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    outer.truncate(HIDING);
    let smallest = |a: &Sphere, b: &Sphere| a.radius.total_cmp(&b.radius);
    let room = spheres().filter(|sphere| watchers.are_inside(sphere)).min_by(smallest);
    let mut remove = |is_hidden: &dyn Fn(&Object) -> bool| {
        let before = objects.len();
        objects.retain(|object| !is_hidden(object));
        before - objects.len()
    };
    Hidden {
        inside: remove(&|object| outer.iter().any(|sphere| contains(sphere, object))),
        outside: remove(&|object| room.is_some_and(|room| excludes(&room, object))),
    }
}

/// Returns the box around all objects; `None` if one is unbounded.
fn around(objects: &[Object]) -> Option<Aabb> {
    objects.iter().try_fold(Aabb::EMPTY, |all, object| Some(all.union(object.bounds.as_ref()?)))
}

fn sphere_of(object: &Object) -> Option<Sphere> {
    match &object.shape {
        Shape::Sphere(sphere) if object.transform.is_none() => Some(*sphere),
        _ => None,
    }
}

/// The depth below the surface, in radii, from which on an object is inside. A hit has an error of some u D, where u is
/// the unit roundoff and D the distance to the ray's origin. At the edge of a sphere of radius r, the squared distance
/// of a hit to the edge has an error of some 8 u D r, and this depth makes a difference of 2 r. Both are far less than
/// what this depth makes if D is at most [`FARTHEST`].
fn depth() -> Real {
    UNIT_ROUNDOFF.sqrt()
}

/// The largest distance of an origin from the centre, as a multiple of radius / [`depth`].
const FARTHEST: Real = 0.01;

/// What an object must be hidden from.
struct Watchers<'a> {
    eye: Vector3,
    /// Those that cast shadows.
    lights: &'a [Light],
    epsilon: Epsilon,
}

impl Watchers<'_> {
    /// Returns whether the eye and all lights are outside of a sphere, and no ray begins too far away: camera rays at the
    /// eye, shadow rays in a box.
    fn are_outside(&self, sphere: &Sphere, origins: &Aabb) -> bool {
        let farthest = FARTHEST * sphere.radius / depth();
        let near = sphere.radius * (1.0 + depth());
        (near..=farthest).contains(&distance(sphere, self.eye))
            && sphere.center.max_abs() <= farthest
            && origins.corners().into_iter().all(|corner| distance(sphere, corner) <= farthest)
            && self.lights_are(sphere, true, |distance| distance >= near + self.overshoot())
    }

    /// Returns whether the eye and all lights are inside of a sphere.
    fn are_inside(&self, sphere: &Sphere) -> bool {
        let inside = sphere.radius * (1.0 - depth());
        distance(sphere, self.eye) < inside
            && sphere.center.max_abs() <= FARTHEST * sphere.radius / depth()
            && self.lights_are(sphere, false, |distance| distance + self.overshoot() <= inside)
    }

    /// Returns whether the distances of all lights to the centre of a sphere are as wanted; `far` says so of directional
    /// ones.
    fn lights_are(&self, sphere: &Sphere, far: bool, is_wanted: impl Fn(Real) -> bool) -> bool {
        self.lights.iter().all(|light| match light {
            Light::Directional { .. } => far,
            Light::Point { position, .. } => is_wanted(distance(sphere, *position)),
            Light::ExtremePoint { .. } => false,
        })
    }

    /// Returns how far a shadow ray may go beyond its light: by the ray offset.
    fn overshoot(&self) -> Real {
        match self.epsilon {
            Epsilon::Along(epsilon) => 2.0 * epsilon.abs() as Real,
            Epsilon::Auto => 0.0,
        }
    }
}

/// Returns the distance of a point to the centre of a sphere.
fn distance(sphere: &Sphere, point: Vector3) -> Real {
    (point - sphere.center).length()
}

/// Returns whether an object lies deep enough inside a sphere.
fn contains(sphere: &Sphere, object: &Object) -> bool {
    let inside = sphere.radius * (1.0 - depth());
    if let Some(Sphere { center, radius }) = sphere_of(object) {
        return distance(sphere, center) + radius <= inside;
    }
    object.sideways_error == 0.0
        && object
            .bounds
            .is_some_and(|bounds| bounds.corners().iter().all(|corner| distance(sphere, *corner) <= inside))
}

/// Returns whether an object lies far enough outside of a sphere, or around it.
fn excludes(sphere: &Sphere, object: &Object) -> bool {
    let outside = sphere.radius * (1.0 + depth());
    if let Some(Sphere { center, radius }) = sphere_of(object) {
        let distance = distance(sphere, center);
        return distance - radius >= outside || radius - distance >= outside;
    }
    object.sideways_error == 0.0
        && object
            .bounds
            .is_some_and(|bounds| distance(sphere, sphere.center.max(bounds.min).min(bounds.max)) >= outside)
}
