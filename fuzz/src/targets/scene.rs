//! Scenes: their text, and what becomes of it.

use super::{grammar, must_have_a_place, options};
use a2::error::{Error, SourceText};
use a2::memory::Budget;
use a2::options::Options;
use a2::plan::Plan;
use a2::scene::Scene;
use a2::scene_file::parse;
use arbitrary::Unstructured;
use std::path::Path;

const FILE: &str = "scene.txt";

/// What pictures of every kind need.
pub const ALL: &str = "-input s.txt -output o.png -normals n.png -depth 0 9 d.png -shadows -bounces 3";

/// Parses the text of a scene, and plans pictures of it.
pub fn text(data: &[u8], _: &Path) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let path = Path::new(FILE);
    match parse(SourceText { path: path.to_owned(), text: text.to_owned() }).whole() {
        Ok(description) => {
            for line in ["-input s.txt -normals n.png", ALL] {
                let options = options(line);
                let plan = Plan::new(&options, &description);
                assert!(plan.lights.len() <= description.lights.len() && plan.bounces <= options.bounces);
                assert!(plan.explain(&options).starts_with("plan: 100 x 100 pixels of "));
            }
            true
        }
        Err(error) => must_have_a_place(&error, path, text),
    }
}

/// Makes a scene of the bytes, and compiles it.
pub fn structured(data: &[u8], folder: &Path) -> bool {
    let Ok(text) = grammar::scene(&mut Unstructured::new(data), grammar::Numbers::Any) else { return false };
    [ALL, "-input s.txt -output o.png -robust"].into_iter().all(|line| {
        match compiled(&text, folder, &options(line)) {
            Ok((scene, plan)) => {
                let written =
                    ["Sphere", "Plane", "Triangle {", "TriangleMesh"].map(|name| text.matches(name).count());
                assert!(scene.geometry.objects.len() <= written.iter().sum());
                assert_eq!(scene.lights.len(), plan.lights.len());
                true
            }
            Err(error) => must_have_a_place(&error, &folder.join(FILE), &text),
        }
    })
}

/// Parses and compiles a scene in this folder.
///
/// # Errors
/// The error of the first stage that refuses the scene.
pub fn compiled(text: &str, folder: &Path, options: &Options) -> Result<(Scene, Plan), Error> {
    let description = parse(SourceText { path: folder.join(FILE), text: text.to_owned() }).whole()?;
    let plan = Plan::new(options, &description);
    let compiled = a2::scene::compile(&description, &plan, &mut Budget::default())?;
    Ok((compiled.scene, plan))
}
