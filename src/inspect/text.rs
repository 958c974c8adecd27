//! Inspected pixels as text for people.

use super::InspectedPixel;
use super::names::{Material, Object};
use super::numbers::{short, short3};
use super::recorder::{Light, Met, Shaded, Step, Way};
use crate::film::to_byte;
use crate::options::Options;
use crate::trace::RayKind;
use std::fmt;
use std::fmt::Write as _;
use vecmath::{Real, Vector3};

impl InspectedPixel {
    /// Returns the ray tree as text.
    pub fn text(&self, options: &Options) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text, options);
        text
    }

    fn write(&self, out: &mut String, options: &Options) -> fmt::Result {
        let ((x, y), (width, height)) = (self.pixel, (options.width, options.height));
        let color = self.shown.color;
        writeln!(out, "pixel {x} {y} of {width} x {height}: bytes {}, colour {}", bytes(color), short3(color))?;
        if options.normals.is_some() {
            writeln!(out, "  normal picture: bytes {}", bytes(self.shown.normal))?;
        }
        if options.depth.is_some() {
            writeln!(out, "  depth picture: byte {}", to_byte(self.shown.depth))?;
        }
        self.write_samples(out)?;
        let mut sum = Vector3::ZERO;
        for (number, step) in self.path.steps.iter().enumerate() {
            write_step(out, step, number, options.bounces)?;
            let light = step.light();
            let added = step.throughput.scaled_by(light);
            sum += added;
            if number > 0 {
                writeln!(out, "    times the throughput: {}", short3(added))?;
            }
        }
        writeln!(out, "  end: {}", self.path.end)?;
        if self.path.steps.len() > 1 {
            writeln!(out, "  sum: {}", short3(sum))?;
        }
        Ok(())
    }

    fn write_samples(&self, out: &mut String) -> fmt::Result {
        let (count, shown) = (self.samples.len(), self.samples[self.chosen]);
        if count == 1 {
            return Ok(());
        }
        let colors = || self.samples.iter().map(|sample| sample.color);
        let (low, high) = (colors().reduce(Vector3::min), colors().reduce(Vector3::max));
        let [low, high] = [low, high].map(|color| short3(color.unwrap_or_default()));
        writeln!(out, "  {count} samples, whose colours lie between {low} and {high}")?;
        let place = format!("{} {}", short(shown.place.0), short(shown.place.1));
        writeln!(out, "  sample {} of them, at {place}: colour {}", self.chosen, short3(shown.color))
    }
}

/// Writes a ray and what it meets. `number` counts the mirror rays from 1.
fn write_step(out: &mut String, step: &Step, number: usize, bounces: u32) -> fmt::Result {
    let (origin, direction) = (short3(step.ray.origin), short3(step.ray.direction));
    match step.kind {
        RayKind::Camera => writeln!(out, "  camera ray from {origin} along {direction}")?,
        RayKind::Mirror => {
            let throughput = short3(step.throughput);
            writeln!(out, "  mirror ray {number} of at most {bounces} from {origin} along {direction}")?;
            writeln!(out, "    throughput {throughput}: this share of what it sees reaches the eye")?;
        }
    }
    match &step.met {
        Met::Background(color) => writeln!(out, "    hits nothing, and sees the background: {}", short3(*color)),
        Met::Surface(surface) => write_surface(out, surface),
    }
}

fn write_surface(out: &mut String, surface: &Shaded) -> fmt::Result {
    writeln!(out, "    hits {} at t = {}", surface.object, short(surface.t))?;
    writeln!(out, "    point {}, normal {}", short3(surface.point), short3(surface.normal))?;
    writeln!(out, "    {}", surface.material)?;
    for light in &surface.lights {
        write_light(out, light)?;
    }
    writeln!(out, "    ambient light times diffuseColor: {}", short3(surface.ambient))?;
    writeln!(out, "    all lights together: {}", short3(surface.reflected))
}

fn write_light(out: &mut String, light: &Light) -> fmt::Result {
    let (normal, mirrored) = (short(light.normal_dot_light), short(light.mirrored_dot_light));
    let distance = match light.seen.distance {
        Real::INFINITY => "infinitely far".to_owned(),
        distance => format!("distance {}", short(distance)),
    };
    writeln!(out, "    {} {}", light.place.block, light.place.location)?;
    let intensity = short3(light.seen.intensity);
    writeln!(out, "      N.L {normal}, R.L {mirrored}, {distance}, intensity {intensity}")?;
    writeln!(out, "      diffuse {}, highlight {}", short3(light.diffuse), short3(light.highlight))?;
    match &light.shadow {
        Way::NotLookedAt => write!(out, "      no shadow ray, for want of -shadows")?,
        Way::LeftOut => write!(out, "      no shadow ray, because the light adds nothing")?,
        Way::Free => write!(out, "      nothing blocks it")?,
        Way::Blocked(object, t) => write!(out, "      blocked by {object} at t = {}", short(*t))?,
    }
    writeln!(out, ": adds {}", short3(light.added))
}

impl fmt::Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.place.block, self.place.location)?;
        let Some(triangle) = &self.triangle else { return Ok(()) };
        write!(f, " (triangle {} of {}", triangle.number, triangle.file.display())?;
        match triangle.line {
            Some(line) => write!(f, ", line {line})"),
            None => write!(f, ")"),
        }
    }
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (diffuse, specular) = (short3(self.values.diffuse), short3(self.values.specular));
        let (index, shininess) = (self.index, short(self.values.shininess));
        write!(f, "material {index}, {} {}: ", self.place.block, self.place.location)?;
        write!(f, "diffuseColor {diffuse}, specularColor {specular}, shininess {shininess}")
    }
}

fn bytes(color: Vector3) -> String {
    color.to_array().map(|component| to_byte(component).to_string()).join(" ")
}
