//! [`Geometry`]: the objects of a scene with the trees over them.

use super::object_tree::ObjectTree;
use crate::bvh::{Bvh, TriangleBlock, build_triangle_bvh};
use crate::objects::{Mesh, Object};
use crate::simd::InstructionSet;

/// Everything that rays can hit. Its queries are in [`queries`](super::queries).
#[derive(Debug)]
pub struct Geometry {
    /// In the order of the file: if a ray hits two objects at the same t, the first one counts.
    pub objects: Vec<Object>,
    /// Each mesh file once, however many objects are instances of it.
    pub meshes: Vec<Mesh>,
    mesh_trees: Vec<Option<Bvh<TriangleBlock>>>,
    pub object_tree: ObjectTree,
    /// The instruction set that queries use.
    pub instruction_set: InstructionSet,
}

impl Geometry {
    /// Builds the trees. Objects that are meshes must have an index into `meshes`.
    pub fn new(objects: Vec<Object>, meshes: Vec<Mesh>, instruction_set: InstructionSet) -> Self {
        let mesh_trees = meshes.iter().map(build_mesh_tree).collect();
        let object_tree = ObjectTree::build(&objects);
        Self { objects, meshes, mesh_trees, object_tree, instruction_set }
    }

    /// Returns a mesh and its tree. The tree is `None` if all triangles must be tested.
    pub fn mesh_and_tree(&self, index: u32) -> (&Mesh, Option<&Bvh<TriangleBlock>>) {
        (&self.meshes[index as usize], self.mesh_trees[index as usize].as_ref())
    }
}

/// Builds the tree of a mesh. `None` for a mesh without triangles, or with a coordinate that is not finite.
pub fn build_mesh_tree(mesh: &Mesh) -> Option<Bvh<TriangleBlock>> {
    build_triangle_bvh(mesh.bounds(), mesh.triangle_count(), |triangle| mesh.corners(triangle))
}
