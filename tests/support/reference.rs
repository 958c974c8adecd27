//! A second renderer, written directly from the starter's formulas: recursion, a loop over all objects, textbook
//! intersections. It has no tree and no plan, and shares only the parser and the vectors with the program.
//!
//! It is slow, and only as exact as textbook formulas are. Its pictures are compared like the course's.

use a2::light::Light;
use a2::material::Material;
use a2::objects::{Plane, Shape, Sphere, Triangle};
use a2::scene_file::{Description, LeafShape, Node, TransformStep};
use image::{Rgb, RgbImage};
use std::collections::HashMap;
use std::path::Path;
use vecmath::{Matrix4, Vector3};

/// The flags that the reference has.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flags {
    pub width: u32,
    pub height: u32,
    pub bounces: u32,
    pub shadows: bool,
    pub filter: bool,
}

struct Hit {
    t: f64,
    normal: Vector3,
    material: u32,
}

type ObjMesh = (Vec<Vector3>, Vec<[usize; 3]>, Vec<Vector3>);

pub struct Reference<'a> {
    description: &'a Description,
    meshes: HashMap<String, ObjMesh>,
}

/// Renders the colour picture of a scene without a cube map.
pub fn render(scene: &Path, flags: Flags) -> RgbImage {
    let description = a2::scene_file::parse_file(scene).unwrap().whole().unwrap();
    assert!(description.background.cube_map.is_none(), "the reference has no cube maps");
    let mut reference = Reference { description: &description, meshes: HashMap::new() };
    reference.load_meshes(&description.root, scene.parent().unwrap());
    let finer = if flags.filter { 3 } else { 1 };
    let color = |x: u32, y: u32| reference.pixel(x, y, finer * flags.width, finer * flags.height, flags);
    RgbImage::from_fn(flags.width, flags.height, |x, row| {
        let y = flags.height - 1 - row;
        let mut sum = Vector3::ZERO;
        if flags.filter {
            for (i, weight) in [1.0, 2.0, 1.0, 2.0, 4.0, 2.0, 1.0, 2.0, 1.0].into_iter().enumerate() {
                sum += color(3 * x + i as u32 % 3, 3 * y + i as u32 / 3) * (weight / 16.0);
            }
        } else {
            sum = color(x, y);
        }
        Rgb(sum.to_array().map(|c| (c * 255.0).trunc().clamp(0.0, 255.0) as u8))
    })
}

impl Reference<'_> {
    fn load_meshes(&mut self, node: &Node, folder: &Path) {
        match node {
            Node::Group(members) => members.iter().for_each(|member| self.load_meshes(member, folder)),
            Node::Transform { child, .. } => self.load_meshes(child, folder),
            Node::Leaf(leaf) => {
                if let LeafShape::Mesh(obj_file) = &leaf.shape {
                    let text = std::fs::read_to_string(folder.join(&obj_file.value)).unwrap();
                    self.meshes.insert(obj_file.value.clone(), read_obj(&text));
                }
            }
        }
    }

    fn pixel(&self, x: u32, y: u32, width: u32, height: u32, flags: Flags) -> Vector3 {
        let camera = &self.description.camera;
        let direction = camera.direction.value.normalized();
        let up = camera.up.value;
        let horizontal = direction.cross(up).normalized();
        let ndc = |pixel: u32, count: u32| {
            if count == 1 { 0.0 } else { 2.0 * f64::from(pixel) / f64::from(count - 1) - 1.0 }
        };
        let distance = 1.0 / (camera.angle_degrees.value.to_radians() / 2.0).tan();
        let ray = direction * distance + horizontal * ndc(x, width) + up * ndc(y, height);
        self.trace(camera.center.value, ray.normalized(), flags.bounces, flags)
    }

    fn trace(&self, origin: Vector3, direction: Vector3, bounces: u32, flags: Flags) -> Vector3 {
        let Some(hit) = self.closest(&self.description.root, origin, direction) else {
            return self.description.background.color;
        };
        let material = &self.description.materials[hit.material as usize].value;
        let point = origin + direction * hit.t;
        let mirrored = direction - hit.normal * (2.0 * direction.dot(hit.normal));
        let mut color = Vector3::ZERO;
        for light in &self.description.lights {
            color += self.lit(&light.value, material, point, hit.normal, mirrored, flags);
        }
        if material.specular.length() > 0.1 && bounces > 0 {
            let seen = self.trace(point + mirrored * 0.01, mirrored, bounces - 1, flags);
            color += material.specular.scaled_by(seen);
        }
        let lightless = self.description.lights.is_empty();
        let ambient = if lightless { Vector3::splat(1.0) } else { self.description.background.ambient_light };
        color + ambient.scaled_by(material.diffuse)
    }

    fn lit(
        &self,
        light: &Light,
        material: &Material,
        point: Vector3,
        normal: Vector3,
        mirrored: Vector3,
        flags: Flags,
    ) -> Vector3 {
        let (to_light, distance, intensity) = match light {
            Light::Directional { to_light, color } => (*to_light, f64::INFINITY, *color),
            Light::Point { position, color, falloff } | Light::ExtremePoint { position, color, falloff, .. } => {
                let offset = *position - point;
                let squared = offset.length_squared();
                (offset.normalized(), squared.sqrt(), *color * (1.0 / (falloff * squared)))
            }
        };
        if flags.shadows {
            let blocker = self.closest(&self.description.root, point + to_light * 0.01, to_light);
            if blocker.is_some_and(|hit| hit.t <= distance) {
                return Vector3::ZERO;
            }
        }
        let diffuse = normal.dot(to_light).max(0.0);
        let highlight = mirrored.dot(to_light).max(0.0).powf(material.shininess);
        (material.diffuse * diffuse + material.specular * highlight).scaled_by(intensity)
    }

    fn closest(&self, node: &Node, origin: Vector3, direction: Vector3) -> Option<Hit> {
        match node {
            Node::Group(members) => {
                let hits = members.iter().filter_map(|member| self.closest(member, origin, direction));
                hits.reduce(|nearest, hit| if hit.t < nearest.t { hit } else { nearest })
            }
            Node::Transform { steps, child } => {
                let mut matrix = Matrix4::IDENTITY;
                for step in steps {
                    matrix = match step.value {
                        TransformStep::Translate(offset) => matrix * Matrix4::translation(offset),
                        TransformStep::Scale(factors) => matrix * Matrix4::scaling(factors),
                        TransformStep::Rotate { axis, degrees } => {
                            matrix * Matrix4::rotation(axis.normalized(), degrees.to_radians())
                        }
                        TransformStep::Matrix4f(numbers) => Matrix4::from_column_major(numbers) * matrix,
                    };
                }
                let inverse = matrix.affine_inverse().unwrap();
                let moved = (inverse.transform_point(origin), inverse.transform_direction(direction));
                let mut hit = self.closest(child, moved.0, moved.1)?;
                hit.normal = (inverse.linear().transposed() * hit.normal).normalized();
                Some(hit)
            }
            Node::Leaf(leaf) => {
                let (t, normal) = self.shape(&leaf.shape, origin, direction)?;
                Some(Hit { t, normal, material: leaf.material })
            }
        }
    }

    fn shape(&self, shape: &LeafShape, origin: Vector3, direction: Vector3) -> Option<(f64, Vector3)> {
        match shape {
            LeafShape::Shape(Shape::Sphere(Sphere { center, radius })) => {
                let offset = origin - *center;
                let (a, b) = (direction.length_squared(), offset.dot(direction));
                let root = (b * b - a * (offset.length_squared() - radius * radius)).sqrt();
                let t = [(-b - root) / a, (-b + root) / a].into_iter().find(|&t| t > 0.0)?;
                Some((t, (offset + direction * t).normalized()))
            }
            LeafShape::Shape(Shape::Plane(Plane { normal, offset, .. })) => {
                let t = (offset - normal.dot(origin)) / normal.dot(direction);
                (t > 0.0 && t < f64::from(f32::MAX)).then_some((t, *normal))
            }
            LeafShape::Shape(Shape::Triangle(Triangle { corners, .. })) => {
                let (t, _) = triangle(*corners, origin, direction)?;
                let [a, b, c] = *corners;
                Some((t, (b - a).cross(c - a).normalized()))
            }
            LeafShape::Shape(Shape::ExtremeSphere(_) | Shape::Mesh(_)) => {
                unreachable!("not in the text of a scene")
            }
            LeafShape::Mesh(obj_file) => {
                let (vertices, faces, normals) = &self.meshes[&obj_file.value];
                let mut nearest: Option<(f64, Vector3)> = None;
                for face in faces {
                    let corners = face.map(|corner| vertices[corner]);
                    let Some((t, weights)) = triangle(corners, origin, direction) else { continue };
                    if nearest.is_none_or(|(nearest, _)| t < nearest) {
                        let normal = (0..3).fold(Vector3::ZERO, |sum, i| sum + normals[face[i]] * weights[i]);
                        nearest = Some((t, normal.normalized()));
                    }
                }
                nearest
            }
        }
    }
}

/// Solves origin + t direction = a + v (b - a) + w (c - a) by Cramer's rule.
fn triangle([a, b, c]: [Vector3; 3], origin: Vector3, direction: Vector3) -> Option<(f64, [f64; 3])> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    let from_a = origin - a;
    let v = from_a.dot(across) / determinant;
    let around = from_a.cross(ab);
    let w = direction.dot(around) / determinant;
    let t = ac.dot(around) / determinant;
    (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && t > 0.0).then_some((t, [1.0 - v - w, v, w]))
}

/// Reads lines `v x y z` and `f i j k`.
fn read_obj(text: &str) -> ObjMesh {
    let lines_of = |keyword: &'static str| {
        text.lines().filter(move |line| line.split_whitespace().next() == Some(keyword)).map(|line| {
            let numbers: Vec<f64> = line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
            [numbers[0], numbers[1], numbers[2]]
        })
    };
    let vertices: Vec<Vector3> = lines_of("v").map(Vector3::from).collect();
    let faces: Vec<[usize; 3]> = lines_of("f").map(|face| face.map(|index| index as usize - 1)).collect();
    let mut normals = vec![Vector3::ZERO; vertices.len()];
    for face in &faces {
        let [a, b, c] = face.map(|corner| vertices[corner]);
        face.iter().for_each(|&corner| normals[corner] += (b - a).cross(c - a).normalized());
    }
    let normals = normals.into_iter().map(Vector3::normalized).collect();
    (vertices, faces, normals)
}
