//! Finds what a scene holds twice: objects that no ray can tell from an earlier one, and mesh files with equal bytes.

use crate::input::read_whole;
use crate::objects::{ExtremeSphere, Object, Shape, Sphere};
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use vecmath::Real;

/// Removes each object that is equal to an earlier one in shape and place, and returns how many there were. A ray hits both
/// at the same t, and the first one counts. So no picture changes, whatever their materials are.
pub(super) fn remove_copies(objects: &mut Vec<Object>) -> usize {
    let hashed = |(index, object): (usize, &Object)| (hash(&numbers(object)), index as u32);
    let mut order: Vec<(u64, u32)> = objects.par_iter().enumerate().map(hashed).collect();
    order.par_sort_unstable();
    let mut is_copy = vec![false; objects.len()];
    for alike in order.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
        let first = numbers(&objects[alike[0].1 as usize]);
        for (_, index) in &alike[1..] {
            is_copy[*index as usize] = numbers(&objects[*index as usize]) == first;
        }
    }
    let before = objects.len();
    let mut is_copy = is_copy.into_iter();
    objects.retain(|_| is_copy.next() != Some(true));
    before - objects.len()
}

/// Returns the bits of all numbers that decide what hits an object.
fn numbers(object: &Object) -> [u64; 22] {
    let (kind, shape): (u64, &[Real]) = match &object.shape {
        Shape::Sphere(Sphere { center: c, radius }) => (0, &[c.x, c.y, c.z, *radius]),
        Shape::ExtremeSphere(ExtremeSphere(Sphere { center: c, radius })) => (1, &[c.x, c.y, c.z, *radius]),
        Shape::Plane(plane) => {
            let n = plane.normal;
            (2, &[n.x, n.y, n.z, plane.offset])
        }
        Shape::Triangle(triangle) => {
            let [a, b, c] = triangle.corners;
            (3, &[a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z])
        }
        Shape::Mesh(mesh) => (4 + u64::from(*mesh), &[]),
    };
    let mut bits = [0; 22];
    bits[0] = kind;
    for (bits, number) in bits[1..].iter_mut().zip(shape) {
        *bits = number.to_bits().into();
    }
    if let Some(transform) = &object.transform {
        let columns = transform.world_from_object().columns;
        let matrix = columns.into_iter().flat_map(|column| [column.x, column.y, column.z]);
        bits[10..].iter_mut().zip(matrix).for_each(|(bits, number)| *bits = number.to_bits().into());
    }
    bits
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// The mesh files that were read, by a hash of their ends.
#[derive(Default)]
pub(super) struct KnownFiles(HashMap<u64, (PathBuf, u32)>);

impl KnownFiles {
    /// Returns the index of an earlier file with these bytes. If there is none, the file is known from now on by `index`.
    ///
    /// The bytes of earlier files are not kept: one with the same length and ends is read once more. A device or a pipe
    /// cannot be.
    pub(super) fn find_or_add(&mut self, path: &Path, bytes: &[u8], index: u32) -> Option<u32> {
        const END: usize = 4096;
        let ends = [&bytes[..bytes.len().min(END)], &bytes[bytes.len().saturating_sub(END)..]];
        if !path.is_file() {
            return None;
        }
        let (earlier, known) =
            self.0.entry(hash(&(bytes.len(), ends))).or_insert_with(|| (path.to_owned(), index));
        let is_copy =
            *known != index && read_whole(earlier, bytes.len() as u64).is_ok_and(|earlier| earlier == bytes);
        is_copy.then_some(*known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::{Plane, Transform, Triangle};
    use vecmath::{Matrix4, Vector3};

    #[test]
    fn objects_at_one_place_are_copies_whatever_their_material() {
        let sphere = |radius| Shape::Sphere(Sphere { center: Vector3::ZERO, radius });
        let triangle =
            Shape::Triangle(Triangle::new([Vector3::ZERO, Vector3::new(1.0, 0.0, 0.0), Vector3::splat(1.0)]));
        let shapes = [
            sphere(1.0),
            sphere(2.0),
            Shape::Plane(Plane::new(Vector3::splat(1.0), 1.0)),
            triangle,
            Shape::Mesh(0),
        ];
        let moved = |x| Transform::new(&Matrix4::translation(Vector3::new(x, 0.0, 0.0))).unwrap();
        let mut objects = Vec::new();
        for material in 0..3 {
            for shape in &shapes {
                for transform in [None, Some(moved(1.0)), Some(moved(2.0))] {
                    objects.push(Object::new(shape.clone(), transform.map(Box::new), material, None));
                }
            }
        }
        assert_eq!(remove_copies(&mut objects), 30);
        assert!(objects.len() == 15 && objects.iter().all(|object| object.material == 0));
        assert_eq!(remove_copies(&mut objects), 0);
    }
}
