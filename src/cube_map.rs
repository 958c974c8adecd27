//! [`CubeMap`]: six pictures around the scene.

use crate::error::Error;
use crate::picture_file::PictureFile;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use vecmath::{Real, Vector3};

/// File names of the faces, in the order of [`CubeMap::faces`]: +x, -x, +y, -y, +z, -z.
const FACE_NAMES: [&str; 6] = ["right", "left", "up", "down", "front", "back"];

/// byte / 255 for each byte. A product with 1/255 would differ in the last bit, which truncation to bytes would show.
static SHARE: [Real; 256] = {
    let mut share = [0.0; 256];
    let mut byte = 0;
    while byte < 256 {
        share[byte] = byte as Real / 255.0;
        byte += 1;
    }
    share
};

/// A folder with a picture for each side of a cube.
#[derive(Debug)]
pub struct CubeMap {
    faces: [Face; 6],
}

/// The picture of one side. It is decoded when the first ray reaches it.
#[derive(Debug)]
struct Face {
    path: PathBuf,
    width: usize,
    height: usize,
    /// Three bytes a texel, rows from the top; or the message why the picture could not be decoded.
    texels: OnceLock<Result<Vec<u8>, String>>,
}

/// Returns the paths of the six pictures in a folder.
pub fn face_paths(folder: &Path) -> [PathBuf; 6] {
    FACE_NAMES.map(|name| folder.join(format!("{name}.png")))
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

    /// Returns the colour in a direction (of any length but zero), bilinearly interpolated.
    pub fn color(&self, direction: Vector3) -> Vector3 {
        self.texels(&Place::of(direction.normalized())).blend()
    }

    /// Returns the four texels around a place. Decodes the face if it is not decoded yet.
    #[inline]
    pub(crate) fn texels(&self, place: &Place) -> Texels {
        self.faces[place.face % 6].texels(place.u, place.v)
    }

    /// Decodes the faces that these directions reach, in parallel.
    pub fn decode(&self, directions: &[Vector3]) {
        let mut is_reached = [false; 6];
        directions.iter().for_each(|&direction| is_reached[Place::of(direction.normalized()).face] = true);
        self.faces.par_iter().zip(is_reached).with_max_len(1).filter(|reached| reached.1).for_each(|(face, _)| {
            face.texels.get_or_init(|| face.decode());
        });
    }

    /// Returns the files of the faces.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.faces.iter().map(|face| face.path.as_path())
    }

    /// Returns the number of faces that have been decoded so far.
    pub fn decoded_faces(&self) -> usize {
        self.faces.iter().filter(|face| face.texels.get().is_some()).count()
    }

    /// Checks that the faces that rays reached could be decoded. A face that could not is black.
    ///
    /// # Errors
    /// [`Error::File`] for the first face that could not be decoded.
    pub fn check_decoded_faces(&self) -> Result<(), Error> {
        for face in &self.faces {
            if let Some(Err(message)) = face.texels.get() {
                return Err(Error::file(&face.path, message));
            }
        }
        Ok(())
    }
}

/// The place of the cube map that a ray sees when it leaves the scene.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub face: usize,
    /// From 0 to 1, v from the bottom.
    pub u: Real,
    pub v: Real,
}

impl Place {
    /// Finds the place in a direction, which must be a unit vector. The orientation of each face is the starter's.
    /// There are no branches, so that loops over directions vectorise.
    #[inline(always)]
    pub fn of(d: Vector3) -> Self {
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        let x_wins = (x >= y) & (x >= z);
        let y_wins = !x_wins & (y >= z);
        let largest = if x_wins {
            d.x
        } else if y_wins {
            d.y
        } else {
            d.z
        };
        let across = if x_wins { d.z } else { d.x };
        let upward = if y_wins { d.z } else { d.y };
        let (u, v) = ((across / largest + 1.0) / 2.0, (upward / largest + 1.0) / 2.0);
        let is_positive = largest > 0.0;
        let axis = if x_wins {
            0
        } else if y_wins {
            2
        } else {
            4
        };
        let is_turned = if is_positive { !x_wins & !y_wins } else { y_wins };
        Self {
            face: axis + usize::from(!is_positive),
            u: if is_turned { 1.0 - u } else { u },
            v: if is_positive { v } else { 1.0 - v },
        }
    }
}

/// The four texels around a place.
pub(crate) struct Texels {
    /// Upper left, upper right, lower left, lower right.
    pub texels: [Vector3; 4],
    /// Weights of the right texels and of the lower texels.
    pub right: Real,
    pub below: Real,
}

impl Texels {
    /// Interpolates bilinearly. Four equal texels give their own value to the bit, which v(1 - w) + vw would not.
    #[inline(always)]
    pub fn blend(&self) -> Vector3 {
        let between = |from: Vector3, to: Vector3, share: Real| from + (to - from) * share;
        let [upper_left, upper_right, lower_left, lower_right] = self.texels;
        let upper = between(upper_left, upper_right, self.right);
        let lower = between(lower_left, lower_right, self.right);
        between(upper, lower, self.below)
    }
}

impl Face {
    /// Opens the picture of one side in a folder. Reads only its size.
    fn open(folder: &Path, name: &str) -> Result<Self, String> {
        let path = folder.join(format!("{name}.png"));
        let other = ["jpg", "jpeg", "bmp"].map(|extension| path.with_extension(extension));
        match PictureFile::open(&path) {
            Ok(PictureFile { width, height, .. }) => {
                Ok(Self { width: width as usize, height: height as usize, texels: OnceLock::new(), path })
            }
            Err(message) => Err(match other.iter().find(|other| !path.exists() && other.exists()) {
                Some(other) => format!("cube map face '{}': a face must be a PNG picture", other.display()),
                None => format!("cube map face '{}': {message}", path.display()),
            }),
        }
    }

    /// Returns the four texels around (u, v), both from 0 to 1, v from the bottom. Black if the picture cannot be
    /// decoded.
    #[inline]
    fn texels(&self, u: Real, v: Real) -> Texels {
        let Ok(texels) = self.texels.get_or_init(|| self.decode()) else {
            return Texels { texels: [Vector3::ZERO; 4], right: 0.0, below: 0.0 };
        };
        let (x, y) = (u * self.width as Real, (1.0 - v) * self.height as Real);
        // A conversion to `u32` is faster than one to `usize`.
        let (column, row) = (x as u32, y as u32);
        let (right, below) = (x - column as Real, y - row as Real);
        let (column, row) = (column as usize, row as usize);
        let (left_of, right_of) = (column.min(self.width - 1), (column + 1).min(self.width - 1));
        let (upper, lower) = (row.min(self.height - 1) * self.width, (row + 1).min(self.height - 1) * self.width);
        let (texels, _) = texels.as_chunks::<3>();
        let texel = |index: usize| Vector3::from(texels[index].map(|channel| SHARE[channel as usize]));
        let texels =
            [texel(upper + left_of), texel(upper + right_of), texel(lower + left_of), texel(lower + right_of)];
        Texels { texels, right, below }
    }

    fn decode(&self) -> Result<Vec<u8>, String> {
        let picture = PictureFile::open(&self.path)?;
        if (picture.width as usize, picture.height as usize) != (self.width, self.height) {
            return Err("the file changed while it was used".to_owned());
        }
        Ok(picture.decode()?.into_rgb8().into_raw())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of 2 x 2 texels whose colours tell face and texel apart: red = 10 * face, green = column, blue = row.
    fn sample() -> CubeMap {
        let face = |index: usize| {
            let texel = |i: usize| [10 * index as u8, 100 * (i % 2) as u8, 100 * (i / 2) as u8];
            Face {
                path: PathBuf::new(),
                width: 2,
                height: 2,
                texels: OnceLock::from(Ok((0..4).flat_map(texel).collect())),
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

    #[test]
    fn the_border_is_clamped() {
        assert_eq!(bytes(1.0, -1.0, 1.0), [0.0, 100.0, 100.0]);
    }
}
