//! Hints for a person at a terminal: what in a scene or a picture is probably not meant.
//!
//! Warnings say that a picture may be wrong, and are always shown. What is hinted at here is right by the rules, and
//! often meant. Each kind of hint is given once.

use crate::error::shown_number;
use crate::material::Material;
use crate::options::Options;
use crate::plan::{Plan, materials_in_use};
use crate::ray_counts::RayCounts;
use crate::render::has_hit_between;
use crate::scene::Scene;
use crate::scene_file::{At, Description};
use vecmath::{Real, Vector3};

/// Returns the hints about a scene, a sentence each.
pub fn about_scene(description: &Description, plan: &Plan, options: &Options) -> Vec<String> {
    let materials = materials_in_use(description);
    let hints = [
        mirror_without_bounces(description, &materials, plan, options),
        colors_out_of_range(description, &materials),
    ];
    hints.into_iter().flatten().collect()
}

/// Returns the warning about a range of depths in which everything is black.
pub fn about_depths(options: &Options) -> Option<String> {
    let empty = options.depth.as_ref().filter(|depth| !depth.is_auto && depth.min == depth.max)?;
    let end = shown_number(empty.min);
    Some(format!("the range of -depth {end} {end} is empty, so that its picture is black: -depth auto finds one"))
}

fn mirror_without_bounces(
    description: &Description,
    materials: &[&At<Material>],
    plan: &Plan,
    options: &Options,
) -> Option<String> {
    let is_asked_for = options.bounces_are_given || !plan.color;
    let mirror = materials.iter().find(|material| !is_asked_for && material.value.is_mirror())?;
    let place = description.source.location(mirror.span);
    Some(format!(
        "{place}: this material is a mirror (its specularColor is longer than 0.1): give -bounces 4 to see what it \
         mirrors, or -bounces 0 if it need not"
    ))
}

fn colors_out_of_range(description: &Description, materials: &[&At<Material>]) -> Option<String> {
    let place = |span| description.source.location(span);
    let in_file = || description.source.path.display().to_string();
    let of_materials = materials.iter().flat_map(|material| {
        let Material { diffuse, specular, .. } = material.value;
        [(diffuse, "diffuseColor"), (specular, "specularColor")]
            .map(|(color, name)| (color, name, Some(material.span)))
    });
    let background = &description.background;
    let of_background = [(background.color, "color", None), (background.ambient_light, "ambientLight", None)];
    // Lights may be as bright as they like.
    let is_negative = |color: &Vector3| color.to_array().iter().any(|c| *c < 0.0);
    let lights = description.lights.iter().map(|light| (light.value.color(), "color", Some(light.span)));
    let negative_lights = lights.filter(|(color, ..)| is_negative(color));
    let mut colors = of_materials.chain(of_background).chain(negative_lights);
    let is_outside = |color: &Vector3| color.to_array().iter().any(|c| !(0.0..=1.0).contains(c));
    let (color, name, span) = colors.find(|(color, ..)| is_outside(color))?;
    let [red, green, blue] = color.to_array();
    let is_byte = |c: &Real| (0.0..=255.0).contains(c) && c.fract() == 0.0;
    let advice = if color.max_abs() >= 10.0 && color.to_array().iter().all(is_byte) {
        let [red, green, blue] = color.to_array().map(|c| (c / 255.0 * 1000.0).round() / 1000.0);
        format!(" (divided by 255 it is {red} {green} {blue})")
    } else {
        String::new()
    };
    let place = span.map_or_else(in_file, place);
    Some(format!("{place}: {name} {red} {green} {blue}: colours are 0 to 1{advice}"))
}

/// Returns the hints about whole pictures, for which these rays were traced.
pub fn about_pictures(options: &Options, scene: &Scene, counts: &RayCounts) -> Vec<String> {
    if counts.camera > 0 && counts.camera_hits == 0 {
        return vec!["no ray from the camera hits anything: do its center and direction fit the scene?".into()];
    }
    let depth = options.depth.as_ref().filter(|depth| depth.min != depth.max && !depth.is_auto);
    let range = depth.map(|depth| (depth.min, depth.max));
    let range = range.filter(|&range| counts.camera_hits > 0 && !has_hit_between(scene, options, range));
    let sentence = |(min, max)| {
        let [min, max] = [min, max].map(shown_number);
        format!("nothing that is hit lies between {min} and {max}: -depth auto finds the range")
    };
    range.map(sentence).into_iter().collect()
}
