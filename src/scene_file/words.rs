//! Which words stand in which block, and what is meant by words of other formats.

use super::lights::light_names;
use super::shapes::shape_names;
use super::transforms::STEP_NAMES;

/// The blocks of a scene.
pub(super) const BLOCKS: [&str; 5] = ["PerspectiveCamera", "Lights", "Background", "Materials", "Group"];
/// Objects that contain other objects.
const CONTAINERS: [&str; 2] = ["Group", "Transform"];
/// The words of a group beside its objects.
pub(super) const GROUP_WORDS: [&str; 2] = ["numObjects", "MaterialIndex"];
/// The blocks of materials, of which one is the older name of the other.
pub(super) const MATERIAL_NAMES: [&str; 2] = ["Material", "PhongMaterial"];

pub(super) fn object_names() -> impl Iterator<Item = &'static str> + Clone {
    shape_names().chain(CONTAINERS)
}

pub(super) fn is_object(word: &str) -> bool {
    object_names().any(|name| name == word)
}

/// Returns whether a word begins something that may stand in this block, besides numbers: only for blocks that hold
/// blocks.
pub(super) fn belongs_into(block: &str, word: &str) -> bool {
    match block {
        "Lights" => word == "numLights" || light_names().any(|name| name == word),
        "Materials" => word == "numMaterials" || MATERIAL_NAMES.contains(&word),
        "Group" => GROUP_WORDS.contains(&word) || is_object(word),
        "Transform" => STEP_NAMES.contains(&word) || is_object(word),
        _ => false,
    }
}

/// Words of related formats (later versions of the course, other courses, what people guess), and what to do here.
const FOREIGN_WORDS: &[(&[&str], &str)] = &[
    (&["exponent", "specularExponent", "phongExponent"], "the exponent of a highlight is 'shininess'"),
    (
        &["reflectiveColor", "reflectance", "reflectivity"],
        "a mirror is a material with a 'specularColor' longer than 0.1",
    ),
    (&["diffuse", "kd", "albedo"], "the colour of a material is 'diffuseColor'"),
    (&["specular", "ks"], "the colour of highlights and mirrors is 'specularColor'"),
    (&["ambient", "ambientColor", "AmbientLight"], "ambient light is 'ambientLight r g b' in 'Background'"),
    (&["backgroundColor"], "the colour of the background is 'color r g b' in 'Background'"),
    (
        &["width", "height", "resolution", "imageSize"],
        "the size of the picture is '-size W H' on the command line",
    ),
    (&["fov", "fieldOfView"], "the field of view is 'angle', in degrees from bottom to top"),
    (&["eye", "origin", "lookFrom"], "the place of the camera is 'center'"),
    (&["lookAt", "target", "look_at"], "the camera looks along 'direction': the point looked at minus 'center'"),
    (
        &["SimpleCamera", "Camera", "OrthographicCamera", "OrthogonalCamera"],
        "the only camera is 'PerspectiveCamera { center direction up angle }'",
    ),
    (&["SpotLight", "AreaLight"], "lights are 'DirectionalLight' and 'PointLight'"),
    (&["attenuation"], "light fades with 'falloff' times the distance squared"),
    (&["intensity", "emissionColor"], "the strength of a light is in its 'color'"),
    (
        &["refractionIndex", "indexOfRefraction", "transparentColor", "Glass"],
        "nothing is transparent here: leave it out",
    ),
    (
        &["texture", "Checkerboard", "Noise", "Marble", "Wood"],
        "a material has one colour: use several objects with a material each",
    ),
    (&["Cube", "Box", "Cone", "Cylinder", "Torus"], "make it a mesh: 'TriangleMesh { obj_file NAME.obj }'"),
    (&["Mesh"], "a mesh is 'TriangleMesh { obj_file NAME.obj }'"),
    (&["file", "filename", "obj", "path"], "the file of a mesh is 'obj_file'"),
];

/// Returns what to do in place of a word of another format.
pub(super) fn equivalent(word: &str) -> Option<&'static str> {
    FOREIGN_WORDS.iter().find(|(words, _)| words.contains(&word)).map(|(_, advice)| *advice)
}
