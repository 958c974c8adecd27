//! How bright anything in a scene can be. What no sample has met is no brighter.

use super::{Geometry, Scene};
use crate::light::Light;
use crate::objects::{Object, Ray, Shape, SurfaceHit};
use crate::plan::Plan;
use vecmath::{Real, Vector3};

impl Scene {
    /// Returns an upper bound of the colour that a camera ray sees, in any component. It may be infinite, where mirrors
    /// brighten.
    ///
    /// `None` if nothing bounds it: a point light lies in the box around an object, or on a plane, and so it may be as
    /// near to a surface as you like; or the normal of a plane is not a unit vector.
    ///
    /// No cosine and no highlight is above 1 of the light. So an object reflects at most its colours times the light at
    /// the point of its box that is nearest to the light. A mirror adds its specular colour times what any ray sees.
    pub fn brightest(&self, plan: &Plan) -> Option<f64> {
        // Of each material what it reflects at most, if any object has it.
        let mut reflected: Vec<Option<Vector3>> = vec![None; self.materials.len()];
        for object in &self.geometry.objects {
            let color = self.most_reflected(object)?;
            let most = &mut reflected[object.material as usize];
            *most = Some(most.map_or(color, |most| most.max(color)));
        }
        let background = self.background.cube_map.as_ref().map_or(absolute(self.background.color), |_| WHITE);
        let without_mirrors = reflected.iter().flatten().fold(background, |most, color| most.max(*color));
        let mirrors: Vec<(Vector3, Vector3)> = (self.materials.iter().zip(&reflected))
            .filter(|(material, _)| material.is_mirror())
            .filter_map(|(material, reflected)| Some(((*reflected)?, absolute(material.specular))))
            .collect();
        let mut seen = without_mirrors;
        for _ in 0..plan.bounces {
            let before = seen;
            for (reflected, specular) in &mirrors {
                seen = seen.max(*reflected + specular.scaled_by(before));
            }
            if seen == before {
                break;
            }
        }
        Some(seen.max_abs() as f64)
    }

    /// Returns the most that an object reflects of all lights, without what it mirrors; `None` if there is no bound.
    fn most_reflected(&self, object: &Object) -> Option<Vector3> {
        if object.transform.is_none() && !object.shape.has_unit_normal() {
            return None;
        }
        let material = &self.materials[object.material as usize];
        let (diffuse, specular) = (absolute(material.diffuse), absolute(material.specular));
        let ambient = absolute(self.ambient_light).scaled_by(diffuse);
        self.lights.iter().try_fold(ambient, |sum, light| {
            let light = absolute(most_light(light, object, &self.geometry)?);
            Some(sum + light.scaled_by(diffuse + specular))
        })
    }
}

/// No cube map is brighter.
const WHITE: Vector3 = Vector3::splat(1.0);

fn absolute(color: Vector3) -> Vector3 {
    color.map(Real::abs)
}

/// Returns the light where an object may be nearest to it; `None` if that may be the place of the light.
fn most_light(light: &Light, object: &Object, geometry: &Geometry) -> Option<Vector3> {
    match *light {
        Light::Directional { color, .. } => Some(color),
        Light::Point { position, .. } | Light::ExtremePoint { position, .. } => {
            let nearest = nearest_point(position, object, geometry)?;
            (nearest != position).then(|| light.illuminate(nearest).intensity)
        }
    }
}

/// Returns the point of the object's box, or of the plane, that is nearest to `place`; `None` if the box would overflow.
fn nearest_point(place: Vector3, object: &Object, geometry: &Geometry) -> Option<Vector3> {
    if let Some(bounds) = &object.bounds {
        return Some(place.max(bounds.min).min(bounds.max));
    }
    let here = Ray { origin: place, direction: Vector3::ZERO };
    matches!(object.shape, Shape::Plane(_)).then(|| {
        let on_plane = object.surface_point(&geometry.meshes, &here, &SurfaceHit::at(0.0));
        place - on_plane.normal * (place - on_plane.point).dot(on_plane.normal)
    })
}
