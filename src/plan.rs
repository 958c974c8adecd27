//! [`Plan`]: which parts of a scene and which rays the wanted pictures need, before anything is loaded or traced.
//!
//! A scene pays only for what it needs. What is left out here can change no byte of any picture.

use crate::error::counted;
use crate::material::Material;
use crate::options::{Epsilon, Options};
use crate::scene_file::{At, Description, LeafShape};
use crate::simd::InstructionSet;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use vecmath::Real;

/// The work to do. Everything that is not named here is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub color: bool,
    pub depth: bool,
    pub normals: bool,
    /// Indices of the lights that can change a colour.
    pub lights: Vec<usize>,
    pub shadows: bool,
    /// Where shadow and mirror rays start.
    pub epsilon: Epsilon,
    /// Do without the starter's shortcuts where they give wrong pictures.
    pub robust: bool,
    /// Render one ray at a time, by the definition.
    pub plain: bool,
    /// Largest number of mirror rays along a path; 0 if no material in use is a mirror.
    pub bounces: u32,
    /// Whether the cube map may be seen.
    pub cube_map: bool,
    /// Upper bound of reflected light in any component, if one is known.
    pub radiance_bound: Option<Real>,
    /// Keep where in the scene file everything stands.
    pub places: bool,
    /// The instruction set that rays are computed with.
    pub simd: InstructionSet,
    /// What is left out and why, a sentence each.
    pub left_out: Vec<String>,
}

impl Plan {
    pub fn new(options: &Options, description: &Description) -> Self {
        let mut left_out = Vec::new();
        let mut leave_out = |unless: bool, why: &str| {
            if !unless {
                left_out.push(why.to_owned());
            }
            unless
        };
        let color = leave_out(options.wants_colors(), "shading: no colour picture is asked for");
        let depth = leave_out(options.depth.is_some(), "depths: no depth picture is asked for");
        let normals = leave_out(options.normals.is_some(), "the normal picture: it is not asked for");
        let materials: Vec<_> =
            materials_in_use(description).into_iter().map(|material| &material.value).collect();
        let mut plan = Self {
            color,
            depth,
            normals,
            lights: Vec::new(),
            shadows: false,
            epsilon: options.epsilon,
            robust: options.robust,
            plain: options.plain,
            bounces: 0,
            cube_map: false,
            radiance_bound: None,
            places: !options.pixels.is_empty(),
            simd: options.simd,
            left_out,
        };
        if color {
            plan.choose_lights(description, &materials);
            plan.choose_rays(options, description, &materials);
        }
        plan
    }

    /// Keeps the lights that can change a colour. A light adds exactly zero if no material in use reflects its colour.
    fn choose_lights(&mut self, description: &Description, materials: &[&Material]) {
        for (index, light) in description.lights.iter().enumerate() {
            let light = &light.value;
            if materials.iter().any(|material| material.reflects(light.color())) {
                self.lights.push(index);
            } else {
                self.left_out.push(format!("light {}: no material in use answers its colour", index + 1));
            }
        }
    }

    /// Finds out which shadow and mirror rays are needed.
    fn choose_rays(&mut self, options: &Options, description: &Description, materials: &[&Material]) {
        let has_mirror = materials.iter().any(|material| material.is_mirror());
        self.shadows = options.shadows && !self.lights.is_empty();
        self.bounces = if has_mirror { options.bounces } else { 0 };
        self.cube_map = description.background.cube_map.is_some();
        let mut note = |condition: bool, why: &str| {
            if condition {
                self.left_out.push(why.to_owned());
            }
        };
        note(!options.shadows, "shadow rays: -shadows is not given");
        note(options.shadows && self.lights.is_empty(), "shadow rays: no light matters");
        note(options.bounces == 0, "mirror rays: -bounces is 0");
        note(
            options.bounces > 0 && !has_mirror,
            "mirror rays: no material in use is a mirror (specular longer than 0.1)",
        );
        self.radiance_bound = radiance_bound(description, &self.lights, materials, self.robust);
    }

    /// Returns whether any picture shows the normals of surfaces, by itself or in its colours.
    pub fn shows_normals(&self) -> bool {
        self.color || self.normals
    }

    /// Returns the plan as text for the user.
    pub fn explain(&self, options: &Options) -> String {
        let mut text = String::new();
        let pictures = [(self.color, "colour"), (self.normals, "normals"), (self.depth, "depth")];
        let pictures: Vec<&str> = pictures.iter().filter(|picture| picture.0).map(|picture| picture.1).collect();
        let samples = match options.measure.is_adaptive() {
            true => "as many samples as it takes".to_owned(),
            false => {
                format!("{} a pixel", counted(options.samples_a_pixel() as usize, "sample"))
            }
        };
        let _ = writeln!(
            text,
            "plan: {} x {} pixels of {}, {samples}",
            options.width,
            options.height,
            pictures.join(", ")
        );
        if self.color {
            let _ = writeln!(
                text,
                "plan: {}, shadow rays {}, {}, cube map {}",
                counted(self.lights.len(), "light"),
                if self.shadows { "on" } else { "off" },
                counted(self.bounces as usize, "bounce"),
                if self.cube_map { "decoded face by face when a ray reaches it" } else { "none" }
            );
        }
        if self.shadows || self.bounces > 0 {
            let _ = match self.epsilon {
                Epsilon::Along(epsilon) => {
                    writeln!(text, "plan: shadow and mirror rays start {epsilon} along them")
                }
                Epsilon::Auto => {
                    writeln!(text, "plan: shadow and mirror rays start beyond the rounding of each hit")
                }
            };
        }
        let _ = writeln!(text, "plan: rays are culled with {} instructions", self.simd);
        for reason in &self.left_out {
            let _ = writeln!(text, "left out: {reason}");
        }
        text
    }
}

/// Returns the materials that any object has, in the order of the file.
pub fn materials_in_use(description: &Description) -> Vec<&At<Material>> {
    let mut indices = BTreeSet::new();
    description.root.visit_leaves(&mut |leaf| {
        indices.insert(leaf.material);
    });
    indices.into_iter().map(|index| &description.materials[index as usize]).collect()
}

/// Returns an upper bound of the colour that any ray sees before mirrors are followed, in any component.
///
/// There is none with a point light, because its light grows without limit near its position. There is none if a
/// plane's normal is not a unit vector, because mirrored directions then grow.
fn radiance_bound(
    description: &Description,
    lights: &[usize],
    materials: &[&Material],
    robust: bool,
) -> Option<Real> {
    let mut unit_normals = true;
    description.root.visit_leaves(&mut |leaf| {
        // -robust makes every normal a unit vector.
        if let (LeafShape::Shape(shape), false) = (&leaf.shape, robust) {
            unit_normals &= shape.has_unit_normal();
        }
    });
    if !unit_normals {
        return None;
    }
    let mut light_sum = 0.0;
    for &index in lights {
        light_sum += description.lights[index].value.max_radiance()?;
    }
    let ambient = if description.lights.is_empty() { 1.0 } else { description.background.ambient_light.max_abs() };
    let reflected = materials.iter().fold(0.0, |bound: Real, material| {
        let (diffuse, specular) = (material.diffuse.max_abs(), material.specular.max_abs());
        bound.max(light_sum * (diffuse + specular) + ambient * diffuse)
    });
    let background = match description.background.cube_map {
        Some(_) => 1.0,
        None => description.background.color.max_abs(),
    };
    // Doubled, because unit vectors have length 1 only up to rounding, and shininess amplifies the difference.
    let bound = 2.0 * reflected.max(background);
    bound.is_finite().then_some(bound)
}
