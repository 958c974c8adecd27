//! [`Geometry`]: the objects of a scene with the trees over them.

use super::object_tree::ObjectTree;
use crate::bvh::{Bvh, TriangleBlock, build_triangle_bvh};
use crate::objects::{Mesh, Object, Shape};
use crate::simd::InstructionSet;
use rayon::ThreadPoolBuilder;
use std::sync::OnceLock;

/// The tree of a mesh; `None` if all triangles must be tested.
type MeshTree = Option<Bvh<TriangleBlock>>;

/// Everything that rays can hit. Its queries are in [`queries`](super::queries).
#[derive(Debug)]
pub struct Geometry {
    /// In the order of the file: if a ray hits two objects at the same t, the first one counts.
    pub objects: Vec<Object>,
    /// Each mesh file once, however many objects are instances of it.
    pub meshes: Vec<Mesh>,
    /// Built at once where rays are expected, and otherwise by the first ray that meets the mesh's box.
    mesh_trees: Vec<OnceLock<MeshTree>>,
    pub object_tree: ObjectTree,
    /// The instruction set that queries use.
    pub instruction_set: InstructionSet,
}

impl Geometry {
    /// Builds the trees. Objects that are meshes must have an index into `meshes`.
    pub fn new(objects: Vec<Object>, meshes: Vec<Mesh>, instruction_set: InstructionSet) -> Self {
        Self::for_rays_at(|_| true, objects, meshes, instruction_set)
    }

    /// Builds the tree over the objects, and the trees of the meshes of which rays are expected to meet an instance.
    pub fn for_rays_at(
        is_expected: impl Fn(&Object) -> bool,
        objects: Vec<Object>,
        meshes: Vec<Mesh>,
        instruction_set: InstructionSet,
    ) -> Self {
        let mesh_trees: Vec<OnceLock<MeshTree>> = meshes.iter().map(|_| OnceLock::new()).collect();
        for object in &objects {
            if let Shape::Mesh(mesh) = object.shape
                && mesh_trees[mesh as usize].get().is_none()
                && is_expected(object)
            {
                mesh_trees[mesh as usize].get_or_init(|| build_mesh_tree(&meshes[mesh as usize]));
            }
        }
        let object_tree = ObjectTree::build(&objects);
        Self { objects, meshes, mesh_trees, object_tree, instruction_set }
    }

    /// Returns a mesh and its tree. The tree is `None` if all triangles must be tested.
    #[inline]
    pub fn mesh_and_tree(&self, index: u32) -> (&Mesh, Option<&Bvh<TriangleBlock>>) {
        let mesh = &self.meshes[index as usize];
        (mesh, self.mesh_trees[index as usize].get_or_init(|| build_amid_rendering(mesh)).as_ref())
    }

    /// Returns whether no ray has met the box of a mesh, so that its tree was not built.
    pub fn is_unmet(&self, mesh: u32) -> bool {
        self.mesh_trees[mesh as usize].get().is_none()
    }
}

/// Builds the tree of a mesh. `None` for a mesh without triangles, or with a coordinate that is not finite.
pub fn build_mesh_tree(mesh: &Mesh) -> MeshTree {
    build_triangle_bvh(mesh.bounds(), mesh.triangle_count(), |triangle| mesh.corners(triangle))
}

/// Builds the tree of a mesh in threads of its own. A worker thread that waits for parts of its work takes up other work:
/// here a tile, whose rays may wait for this very tree, for ever.
#[cold]
fn build_amid_rendering(mesh: &Mesh) -> MeshTree {
    let workers = rayon::current_num_threads();
    let build = || {
        let alone = || ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        let pool = ThreadPoolBuilder::new().num_threads(workers).build().or_else(|_| alone());
        pool.map_or(None, |pool| pool.install(|| build_mesh_tree(mesh)))
    };
    std::thread::scope(|scope| match std::thread::Builder::new().spawn_scoped(scope, build) {
        Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        // Without threads, every triangle is tested, which is slow and right.
        Err(_) => None,
    })
}
