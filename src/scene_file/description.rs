//! [`Description`]: the content of a scene file, with places in the text.
//!
//! Plain data. Lights, materials and shapes are complete; meshes are not loaded, and transforms are not multiplied.

use crate::error::{SourceText, Span};
use crate::light::Light;
use crate::material::Material;
use crate::objects::Shape;
use std::sync::Arc;
use vecmath::Vector3;

/// A value and its place in the scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<T> {
    pub value: T,
    pub span: Span,
}

/// A whole scene file.
#[derive(Debug)]
pub struct Description {
    pub source: Arc<SourceText>,
    pub camera: CameraBlock,
    /// Empty if the file has no lights.
    pub lights: Vec<At<Light>>,
    pub background: BackgroundBlock,
    pub materials: Vec<At<Material>>,
    /// The tree of objects.
    pub root: Node,
    /// What may surprise in the text, a sentence each.
    pub hints: Vec<String>,
}

/// `PerspectiveCamera { center direction up angle }`
#[derive(Clone, Debug)]
pub struct CameraBlock {
    pub center: At<Vector3>,
    pub direction: At<Vector3>,
    pub up: At<Vector3>,
    pub angle_degrees: At<f64>,
}

/// `Background { color ambientLight cubeMap }`
#[derive(Clone, Debug)]
pub struct BackgroundBlock {
    pub color: Vector3,
    pub ambient_light: Vector3,
    pub cube_map: Option<At<String>>,
}

/// An object, or several.
#[derive(Debug)]
pub enum Node {
    /// Members in the order of the file.
    Group(Vec<Node>),
    Transform {
        /// In the order of the file. The first step is applied last.
        steps: Vec<At<TransformStep>>,
        child: Box<Node>,
    },
    Leaf(Leaf),
}

impl Node {
    /// Calls `visit` with each leaf, in the order of the file.
    pub fn visit_leaves<'a>(&'a self, visit: &mut impl FnMut(&'a Leaf)) {
        match self {
            Self::Group(members) => members.iter().for_each(|member| member.visit_leaves(visit)),
            Self::Transform { child, .. } => child.visit_leaves(visit),
            Self::Leaf(leaf) => visit(leaf),
        }
    }
}

/// The shape of an object.
#[derive(Debug)]
pub enum LeafShape {
    /// A shape that the text describes completely.
    Shape(Shape),
    /// The OBJ file of a mesh.
    Mesh(At<String>),
}

/// An object with a surface.
#[derive(Debug)]
pub struct Leaf {
    pub shape: LeafShape,
    /// Place of the object's name.
    pub span: Span,
    /// The last `MaterialIndex` before the object.
    pub material: u32,
}

impl Default for BackgroundBlock {
    fn default() -> Self {
        Self { color: Vector3::splat(0.5), ambient_light: Vector3::ZERO, cube_map: None }
    }
}

/// A camera for scenes whose own one is not known.
impl Default for CameraBlock {
    fn default() -> Self {
        fn at<T>(value: T) -> At<T> {
            At { value, span: Span::default() }
        }
        Self {
            center: at(Vector3::ZERO),
            direction: at(Vector3::new(0.0, 0.0, -1.0)),
            up: at(Vector3::new(0.0, 1.0, 0.0)),
            angle_degrees: at(30.0),
        }
    }
}

/// One line of a `Transform`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformStep {
    Translate(Vector3),
    Scale(Vector3),
    Rotate {
        axis: Vector3,
        degrees: f64,
    },
    /// Sixteen numbers, column by column.
    Matrix4f([f64; 16]),
}
