//! Inspected pixels as JSON for programs.

use super::InspectedPixel;
use super::names::{Material, Object};
use super::recorder::{Light, Met, Shaded, Step, Way};
use crate::film::to_byte;
use crate::options::Options;
use crate::scene::Place;
use crate::trace::RayKind;
use serde_json::{Value, json};
use vecmath::Vector3;

impl InspectedPixel {
    /// Returns the ray tree as JSON. Numbers that are not finite are null.
    pub fn json(&self, options: &Options) -> Value {
        let bytes = |color: Vector3| color.to_array().map(to_byte);
        let sample = |sample: &super::InspectedSample| json!({ "x": sample.place.0, "y": sample.place.1, "color": array(sample.color) });
        json!({
            "x": self.pixel.0,
            "y": self.pixel.1,
            "color": array(self.shown.color),
            "bytes": bytes(self.shown.color),
            "normal_bytes": options.normals.as_ref().map(|_| bytes(self.shown.normal)),
            "depth_byte": options.depth.as_ref().map(|_| to_byte(self.shown.depth)),
            "samples": self.samples.iter().map(sample).collect::<Vec<_>>(),
            "sample": self.chosen,
            "path": self.path.steps.iter().map(step_json).collect::<Vec<_>>(),
            "end": self.path.end,
        })
    }
}

fn array(vector: Vector3) -> Value {
    json!(vector.to_array())
}

fn step_json(step: &Step) -> Value {
    let kind = match step.kind {
        RayKind::Camera => "camera",
        RayKind::Mirror => "mirror",
    };
    let (background, surface) = match &step.met {
        Met::Background(color) => (Some(array(*color)), None),
        Met::Surface(surface) => (None, Some(surface_json(surface))),
    };
    json!({
        "ray": kind,
        "origin": array(step.ray.origin),
        "direction": array(step.ray.direction),
        "throughput": array(step.throughput),
        "background": background,
        "surface": surface,
    })
}

fn surface_json(surface: &Shaded) -> Value {
    json!({
        "object": object_json(&surface.object),
        "t": surface.t,
        "point": array(surface.point),
        "normal": array(surface.normal),
        "material": material_json(&surface.material),
        "lights": surface.lights.iter().map(light_json).collect::<Vec<_>>(),
        "ambient": array(surface.ambient),
        "reflected": array(surface.reflected),
    })
}

fn object_json(object: &Object) -> Value {
    let mut value = place_json(&object.place);
    let triangle = object.triangle.as_ref();
    value["triangle"] = json!(triangle.map(
        |triangle| json!({ "file": triangle.file.display().to_string(), "number": triangle.number, "line": triangle.line })
    ));
    value
}

fn place_json(place: &Place) -> Value {
    json!({ "block": place.block, "location": place.location, "line": place.line })
}

fn material_json(material: &Material) -> Value {
    let mut value = place_json(&material.place);
    value["index"] = material.index.into();
    value["diffuseColor"] = array(material.values.diffuse);
    value["specularColor"] = array(material.values.specular);
    value["shininess"] = material.values.shininess.into();
    value["is_mirror"] = material.is_mirror.into();
    value
}

fn light_json(light: &Light) -> Value {
    let (shadow, blocker) = match &light.shadow {
        Way::NotLookedAt => ("not looked at", None),
        Way::LeftOut => ("left out", None),
        Way::Free => ("free", None),
        Way::Blocked(object, t) => ("blocked", Some((object, t))),
    };
    let blocker = blocker.map(|(object, t)| json!({ "object": object_json(object), "t": t }));
    let mut value = place_json(&light.place);
    value["to_light"] = array(light.seen.to_light);
    value["distance"] = light.seen.distance.into();
    value["intensity"] = array(light.seen.intensity);
    value["normal_dot_light"] = light.normal_dot_light.into();
    value["mirrored_dot_light"] = light.mirrored_dot_light.into();
    value["diffuse"] = array(light.diffuse);
    value["highlight"] = array(light.highlight);
    value["shadow"] = shadow.into();
    value["blocked_by"] = json!(blocker);
    value["added"] = array(light.added);
    value
}
