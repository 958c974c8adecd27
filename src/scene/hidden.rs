//! Finds objects that no picture shows: they lie inside a sphere, and everything that looks at them is outside of it.
//!
//! All surfaces are opaque. So a ray that comes from outside hits the sphere before anything inside. A shadow ray to a
//! light outside hits the sphere, too, wherever it starts. Mirror rays start up to the ray offset away from a surface,
//! so they may begin inside of a sphere that touches it: where there are mirrors, nothing is hidden.

use crate::light::Light;
use crate::objects::{Aabb, Object, Shape, Sphere};
use crate::options::Epsilon;
use crate::plan::Plan;
use vecmath::{Real, UNIT_ROUNDOFF, Vector3};

/// Number of spheres, the largest ones, that may hide something.
const HIDING: usize = 8;

/// Removes the objects that a sphere hides from `eye` and `lights`, and returns how many there were.
pub(super) fn remove_hidden(objects: &mut Vec<Object>, eye: Vector3, lights: &[Light], plan: &Plan) -> usize {
    if plan.bounces > 0 {
        return 0;
    }
    let shadow_casting = if plan.shadows { lights } else { &[] };
    let origins = if plan.shadows { around(objects) } else { Some(Aabb::of_points([eye])) };
    let Some(origins) = origins else { return 0 };
    let is_outside = |sphere: &Sphere| is_seen_from_outside(sphere, eye, &origins, shadow_casting, plan.epsilon);
    let mut spheres: Vec<Sphere> = objects.iter().filter_map(sphere_of).filter(is_outside).collect();
    spheres.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    spheres.truncate(HIDING);
    let before = objects.len();
    objects.retain(|object| !spheres.iter().any(|sphere| contains(sphere, object)));
    before - objects.len()
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

/// Returns whether the eye and all lights that cast shadows are outside of a sphere, and no ray begins too far away:
/// camera rays at the eye, shadow rays in a box.
fn is_seen_from_outside(
    sphere: &Sphere,
    eye: Vector3,
    origins: &Aabb,
    shadow_casting: &[Light],
    epsilon: Epsilon,
) -> bool {
    let farthest = FARTHEST * sphere.radius / depth();
    let near = sphere.radius * (1.0 + depth());
    let distance = |point: Vector3| (point - sphere.center).length();
    // A shadow ray may go beyond the light by the ray offset.
    let offset = match epsilon {
        Epsilon::Along(epsilon) => 2.0 * epsilon.abs() as Real,
        Epsilon::Auto => 0.0,
    };
    let is_light_outside = |light: &Light| match light {
        Light::Directional { .. } => true,
        Light::Point { position, .. } => distance(*position) >= near + offset,
        Light::ExtremePoint { .. } => false,
    };
    (near..=farthest).contains(&distance(eye))
        && sphere.center.max_abs() <= farthest
        && origins.corners().into_iter().all(|corner| distance(corner) <= farthest)
        && shadow_casting.iter().all(is_light_outside)
}

/// Returns whether an object lies deep enough inside a sphere.
fn contains(sphere: &Sphere, object: &Object) -> bool {
    let inside = sphere.radius * (1.0 - depth());
    if let Some(Sphere { center, radius }) = sphere_of(object) {
        return (center - sphere.center).length() + radius <= inside;
    }
    object.sideways_error == 0.0
        && object.bounds.is_some_and(|bounds| {
            bounds.corners().iter().all(|corner| (*corner - sphere.center).length() <= inside)
        })
}
