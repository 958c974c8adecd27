//! [`Tally`]: is told what queries test. [`TestCounts`] count it, for `-cost`.

use crate::bvh::Node;
use crate::objects::{Object, PreparedRay, Shape};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::AddAssign;
use vecmath::Real;

/// Is told what a query tests. `()` does nothing with it, and costs nothing.
pub trait Tally {
    /// The boxes of a node are tested.
    fn node(&self, _node: &Node) {}
    /// An object is tested for a hit before `t_max`.
    fn object(&self, _object: &Object, _ray: &PreparedRay, _t_max: Real, _is_hit: bool) {}
    /// So many triangles of a mesh are tested roughly, all at once, or will be tested exactly.
    fn triangles(&self, _count: u32) {}
    /// A triangle of a mesh is tested exactly.
    fn exact_triangle(&self) {}
}

impl Tally for () {}

/// What queries have tested.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TestCounts {
    /// Boxes around objects, and in the trees of objects and of triangles.
    pub boxes: u64,
    /// Triangles, of meshes and others. Those in a leaf that a ray has reached are tested roughly, eight at once.
    pub triangles: u64,
    /// Those of them that were tested exactly, because the rough test could not rule them out.
    pub exact_triangles: u64,
    /// By the kind of the object.
    pub objects: BTreeMap<&'static str, ObjectCounts>,
}

/// How often objects of one kind were tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectCounts {
    /// By rays that enter the box around the object, if it has one.
    pub tested: u64,
    /// The tests that found a hit: for a closest hit one that is nearer than all before.
    pub hit: u64,
}

impl AddAssign for TestCounts {
    fn add_assign(&mut self, other: Self) {
        self.boxes += other.boxes;
        self.triangles += other.triangles;
        self.exact_triangles += other.exact_triangles;
        for (kind, other) in other.objects {
            let counts = self.objects.entry(kind).or_default();
            counts.tested += other.tested;
            counts.hit += other.hit;
        }
    }
}

impl Tally for RefCell<TestCounts> {
    fn node(&self, node: &Node) {
        self.borrow_mut().boxes += u64::from(node.box_count());
    }

    fn object(&self, object: &Object, ray: &PreparedRay, t_max: Real, is_hit: bool) {
        let mut counts = self.borrow_mut();
        counts.boxes += u64::from(object.bounds.is_some());
        if object.entry(ray, t_max).is_none() {
            return;
        }
        if matches!(object.shape, Shape::Triangle(_)) {
            counts.triangles += 1;
            counts.exact_triangles += 1;
        }
        let of_kind = counts.objects.entry(object.shape.kind()).or_default();
        of_kind.tested += 1;
        of_kind.hit += u64::from(is_hit);
    }

    fn triangles(&self, count: u32) {
        self.borrow_mut().triangles += u64::from(count);
    }

    fn exact_triangle(&self) {
        self.borrow_mut().exact_triangles += 1;
    }
}
