//! [`CubeMap`]: six pictures around the scene.

mod face;
mod spot;

pub(crate) use spot::{Place, Spot, Texels};

use face::Face;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use vecmath::Vector3;

/// File names of the faces, in the order of [`CubeMap::faces`]: +x, -x, +y, -y, +z, -z.
const FACE_NAMES: [&str; 6] = ["right", "left", "up", "down", "front", "back"];

/// A folder with a picture for each side of a cube.
#[derive(Debug)]
pub struct CubeMap {
    faces: [Face; 6],
}

/// Returns the paths of the six pictures in a folder, also of those that are spelt otherwise.
pub fn face_paths(folder: &Path) -> [PathBuf; 6] {
    FACE_NAMES.map(|name| face::path_of(folder, name))
}

/// Says which face a message is about.
fn named(face: &Path, message: &str) -> String {
    format!("cube map face '{}': {message}", face.display())
}

impl CubeMap {
    /// Opens the six pictures of a folder. Reads only their sizes.
    ///
    /// # Errors
    /// The message for a folder that is missing, or for a face that is missing or is not a picture.
    pub fn open(folder: &Path) -> Result<Self, String> {
        if !folder.is_dir() {
            return Err(format!("the cube map folder '{}' does not exist", folder.display()));
        }
        let [right, left, up, down, front, back] = FACE_NAMES.map(|name| Face::open(folder, name));
        Ok(Self { faces: [right?, left?, up?, down?, front?, back?] })
    }

    /// Returns the bytes of memory that the faces take if rays reach all of them: whole, beside their upper halves, which may have
    /// been decoded before.
    pub fn decoded_bytes(&self) -> u64 {
        self.faces.iter().map(|face| face.decoded_bytes).sum::<u64>() / 2 * 3
    }

    /// Returns the colour in a direction (of any length but zero), bilinearly interpolated.
    pub fn color(&self, direction: Vector3) -> Vector3 {
        let place = Place::of(direction.normalized());
        let spot = Spot::of(&place, self.size(place.face));
        Texels::read(self.bytes(place.face, &spot), &spot).unwrap_or_default().blend(spot.right, spot.below)
    }

    /// Returns width and height of a face in texels.
    #[inline(always)]
    pub(crate) fn size(&self, face: u32) -> (i32, i32) {
        let face = &self.faces[face as usize % 6];
        (face.width, face.height)
    }

    /// Returns the size of all faces, if they have one in common.
    pub(crate) fn common_size(&self) -> Option<(i32, i32)> {
        (1..6).all(|face| self.size(face) == self.size(0)).then(|| self.size(0))
    }

    /// Returns the bytes of a face among which are those of a spot, for [`Texels::read`]. Decodes them if they are not decoded
    /// yet; a face that cannot be decoded is empty.
    pub(crate) fn bytes(&self, face: u32, spot: &Spot) -> &[u8] {
        self.faces[face as usize % 6].bytes(spot)
    }

    /// Decodes what these directions reach of the faces, in parallel.
    pub fn decode(&self, directions: &[Vector3]) {
        // Of each face the lowest spot.
        let mut lowest: [Option<Spot>; 6] = [None; 6];
        for direction in directions {
            let place = Place::of(direction.normalized());
            let spot = Spot::of(&place, self.size(place.face));
            let lowest = &mut lowest[place.face as usize];
            *lowest = lowest.filter(|lowest| lowest.lower >= spot.lower).or(Some(spot));
        }
        self.faces.par_iter().zip(lowest).with_max_len(1).for_each(|(face, lowest)| {
            lowest.inspect(|spot| _ = face.bytes(spot));
        });
    }

    /// Returns the number of faces of which anything has been decoded so far.
    pub fn decoded_faces(&self) -> usize {
        self.faces.iter().filter(|face| face.texels.get().is_some() || face.upper.get().is_some()).count()
    }

    /// Returns the message about the first face that rays reached and that could not be decoded. Such a face is black.
    pub fn broken_face(&self) -> Option<String> {
        self.faces.iter().find_map(|face| Some(named(&face.path, face.texels.get()?.as_ref().err()?)))
    }

    /// Returns the files that were found under another spelling than theirs, each with that one.
    pub fn respelt_files(&self) -> impl Iterator<Item = (&Path, String)> {
        let name = |index: usize| format!("{}.png", FACE_NAMES[index]);
        let named = self.faces.iter().enumerate().map(move |(index, face)| (face.path.as_path(), name(index)));
        named.filter(|(path, name)| path.file_name().is_some_and(|found| found != name.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::spot::PADDING;
    use super::*;
    use std::sync::OnceLock;
    use vecmath::Real;

    /// Faces of 2 x 2 texels whose colours tell face and texel apart: red = 10 * face, green = column, blue = row.
    fn sample() -> CubeMap {
        let face = |index: usize| {
            let texel = |i: usize| [10 * index as u8, 100 * (i % 2) as u8, 100 * (i / 2) as u8];
            Face {
                path: PathBuf::new(),
                width: 2,
                height: 2,
                decoded_bytes: 12,
                upper: OnceLock::new(),
                texels: OnceLock::from(Ok((0..4).flat_map(texel).chain([0; PADDING]).collect())),
            }
        };
        CubeMap { faces: [0, 1, 2, 3, 4, 5].map(face) }
    }

    fn bytes(x: Real, y: Real, z: Real) -> [Real; 3] {
        (sample().color(Vector3::new(x, y, z)) * 255.0).to_array().map(Real::round)
    }

    #[test]
    fn the_largest_component_chooses_the_face_and_x_wins_ties() {
        for (direction, face) in [
            ([1.0, 0.0, 0.0], 0.0),
            ([-2.0, 0.0, 0.0], 1.0),
            ([0.0, 3.0, 1.0], 2.0),
            ([0.0, -1.0, 0.0], 3.0),
            ([0.0, 0.0, 0.1], 4.0),
            ([0.0, 0.0, -5.0], 5.0),
            ([1.0, 1.0, 1.0], 0.0),
            ([0.0, -1.0, 1.0], 3.0),
        ] {
            let [x, y, z] = direction;
            assert_eq!(bytes(x, y, z)[0], 10.0 * face, "{direction:?}");
        }
    }

    #[test]
    fn texels_lie_where_the_starter_puts_them() {
        // u = 0.25 and v = 0.75: halfway between columns 0 and 1, and between rows 0 and 1.
        assert_eq!(bytes(1.0, 0.5, -0.5), [0.0, 50.0, 50.0]);
        assert_eq!(bytes(1.0, 0.9999999, -0.9999999), [0.0, 0.0, 0.0]);
        assert_eq!(bytes(1.0, -0.5, 0.5), [0.0, 100.0, 100.0]);
        // On the face behind the eye the starter's picture is mirrored: towards +x the column falls.
        assert_eq!(bytes(0.5, 0.0, -1.0)[1], 50.0);
        assert_eq!(bytes(-0.5, 0.0, -1.0)[1], 100.0);
    }

    /// Upward directions need upper halves only; then one that looks down needs a whole face.
    #[test]
    fn upper_halves_show_what_whole_faces_show() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tex/courtyard");
        let (halves, whole) = (CubeMap::open(&folder).unwrap(), CubeMap::open(&folder).unwrap());
        whole.faces.iter().for_each(|face| assert!(face.texels.get_or_init(|| face.decode()).is_ok()));
        let is_whole = |face: usize| halves.faces[face].texels.get().is_some();
        for step in 0..4000 {
            let (angle, height) = (step as f64 * 0.1, step as Real * 0.0003);
            let direction = Vector3::new(libm::cos(angle) as Real, height, libm::sin(angle) as Real);
            assert_eq!(halves.color(direction), whole.color(direction), "{direction:?}");
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(is_whole), [false, false, true, false, false, false]);
        for height in [-0.01, -0.9] {
            let direction = Vector3::new(1.0, height, 0.2);
            assert_eq!(halves.color(direction), whole.color(direction), "{direction:?}");
        }
        assert!(is_whole(0) && !is_whole(1));
    }

    #[test]
    fn the_border_is_clamped() {
        assert_eq!(bytes(1.0, -1.0, 1.0), [0.0, 100.0, 100.0]);
    }
}
