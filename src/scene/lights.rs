//! The lights of a scene, kept within the range of numbers.

use crate::error::Remarks;
use crate::light::Light;
use crate::material::Material;
use crate::plan::Plan;
use crate::scene_file::Description;
use vecmath::{Real, Vector3};

/// Returns the lights of the plan and the ambient light. `is_usual` says that no size in the scene is unusual.
pub(super) fn lights(
    description: &Description,
    plan: &Plan,
    is_usual: bool,
    remarks: &mut Remarks,
) -> (Vec<Light>, Vector3) {
    let mut lights = Vec::new();
    let brightest = brightest(description);
    for (index, light) in description.lights.iter().enumerate() {
        if light.value.is_infinite() {
            remarks.warnings.push(format!(
                "{}: this PointLight has no falloff, so its light is infinite",
                description.source.location(light.span)
            ));
        }
        if plan.lights.contains(&index) {
            let within_range = light.value.clone().within_range(is_usual, brightest);
            if within_range.color().max_abs() < light.value.color().max_abs() {
                let place = description.source.location(light.span);
                remarks
                    .warnings
                    .push(format!("{place}: this light is brighter than numbers go: {brightest:.1e} is used"));
            }
            lights.push(within_range);
        }
    }
    if description.lights.is_empty() {
        let path = description.source.path.display();
        remarks.hints.push(format!("{path}: the scene has no lights: ambient light becomes 1 1 1"));
        return (lights, Vector3::splat(1.0));
    }
    (lights, description.background.ambient_light.map(|c| c.clamp(-brightest, brightest)))
}

/// Returns how bright light may be, so that what all lights together give to a surface is finite. Infinity would be NaN
/// where the light is behind the surface.
fn brightest(description: &Description) -> Real {
    let reflected = |material: &Material| material.diffuse.max_abs().max(material.specular.max_abs());
    let most = description.materials.iter().map(|material| reflected(&material.value)).fold(1.0, Real::max);
    Real::MAX / 8.0 / most / (description.lights.len() as Real + 1.0)
}
