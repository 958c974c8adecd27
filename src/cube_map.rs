//! [`CubeMap`]: six pictures around the scene.

use crate::error::Error;
use crate::picture_file::{self, PictureFile};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use vecmath::{Real, Vector3};

/// File names of the faces, in the order of [`CubeMap::faces`]: +x, -x, +y, -y, +z, -z.
const FACE_NAMES: [&str; 6] = ["right", "left", "up", "down", "front", "back"];

/// 1/255 in two parts: the first lacks the lowest eight bits, so that its product with a byte is exact.
const SHARE_HIGH: Real = Real::from_bits((1.0 as Real / 255.0).to_bits() & !0xff);
const SHARE_LOW: Real = (1.0 - 255.0 * SHARE_HIGH) / 255.0;

/// Returns byte / 255 to the last bit, without a division. A product with 1/255 would differ in the last bit, which
/// truncation to bytes would show.
#[inline(always)]
fn share(byte: u8) -> Real {
    // By way of `i32`, from which processors convert.
    let byte = i32::from(byte) as Real;
    byte * SHARE_HIGH + byte * SHARE_LOW
}

/// Bytes behind the last texel, so that eight bytes can be read from every texel on.
const PADDING: usize = 8;

/// A folder with a picture for each side of a cube.
#[derive(Debug)]
pub struct CubeMap {
    faces: [Face; 6],
}

/// The picture of one side. It is decoded when the first ray reaches it.
#[derive(Debug)]
struct Face {
    path: PathBuf,
    width: i32,
    height: i32,
    /// The upper half, three bytes a texel: above a floor no ray sees more of most faces. `None` if only the whole picture can be
    /// decoded.
    upper: OnceLock<Option<Vec<u8>>>,
    /// Three bytes a texel, rows from the top, and [`PADDING`]; or the message why the picture could not be decoded.
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

    /// Returns the files of the faces.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.faces.iter().map(|face| face.path.as_path())
    }

    /// Returns the number of faces of which anything has been decoded so far.
    pub fn decoded_faces(&self) -> usize {
        self.faces.iter().filter(|face| face.texels.get().is_some() || face.upper.get().is_some()).count()
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
    pub face: u32,
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
            face: axis + u32::from(!is_positive),
            u: if is_turned { 1.0 - u } else { u },
            v: if is_positive { v } else { 1.0 - v },
        }
    }
}

/// Where the four texels around a place lie in the bytes of a face.
#[derive(Clone, Copy)]
pub(crate) struct Spot {
    /// Offsets of the left texels of both rows.
    pub upper: u32,
    pub lower: u32,
    /// Bits from a left texel to its right neighbour: 0 at the border, where a texel is its own neighbour.
    pub step: u32,
    /// Weights of the right texels and of the lower texels.
    pub right: Real,
    pub below: Real,
}

impl Spot {
    /// Finds the spot of a place in a face of this size, without branches.
    #[inline(always)]
    pub fn of(place: &Place, (width, height): (i32, i32)) -> Self {
        let (x, y) = (place.u * width as Real, (1.0 - place.v) * height as Real);
        let ((column, left_of_x), (row, above_y)) = (floored(x), floored(y));
        let last = (width - 1, height - 1);
        // Of NaN nothing is known.
        let (left, upper) = (column.max(0).min(last.0), row.max(0).min(last.1));
        let lower = (upper + 1).min(last.1);
        Self {
            upper: 3 * (upper * width + left) as u32,
            lower: 3 * (lower * width + left) as u32,
            step: if left < last.0 { 24 } else { 0 },
            right: x - left_of_x,
            below: y - above_y,
        }
    }
}

/// Returns the largest whole number up to `x`, which is at least 0 and far below 2^31: as an integer and as it is. A
/// conversion of the language would look for numbers beyond the integers, and take three times as long.
#[inline(always)]
fn floored(x: Real) -> (i32, Real) {
    /// From here on all numbers are whole, and so are sums.
    const WHOLE: Real = 1.0 / Real::EPSILON;
    let nearest = x + WHOLE;
    let floor = if nearest - WHOLE > x { nearest - 1.0 } else { nearest };
    (floor.to_bits().wrapping_sub(WHOLE.to_bits()) as i32, floor - WHOLE)
}

/// Four texels, a byte for red, green and blue each, red lowest: upper left, upper right, lower left, lower right. What
/// stands above is of no interest.
#[derive(Clone, Copy, Default)]
pub(crate) struct Texels(pub [u32; 4]);

impl Texels {
    /// Reads the texels at a spot of a face; `None` from a face that could not be decoded.
    #[inline(always)]
    pub fn read(bytes: &[u8], spot: &Spot) -> Option<Self> {
        // Both texels of a row at once.
        let row = |offset: u32| {
            let (start, end) = (offset as usize, offset as usize + PADDING);
            let row = u64::from_le_bytes(*bytes.get(start..end)?.first_chunk()?);
            Some([row as u32, (row >> (spot.step % 64)) as u32])
        };
        let ([a, b], [c, d]) = (row(spot.upper)?, row(spot.lower)?);
        Some(Self([a, b, c, d]))
    }

    /// Interpolates bilinearly. Four equal texels give their own value to the bit, which v(1 - w) + vw would not.
    #[inline(always)]
    pub fn blend(self, right: Real, below: Real) -> Vector3 {
        let color =
            |texel: u32| Vector3::new(share(texel as u8), share((texel >> 8) as u8), share((texel >> 16) as u8));
        let between = |from: Vector3, to: Vector3, share: Real| from + (to - from) * share;
        let [upper_left, upper_right, lower_left, lower_right] = self.0.map(color);
        let upper = between(upper_left, upper_right, right);
        let lower = between(lower_left, lower_right, right);
        between(upper, lower, below)
    }
}

impl Face {
    /// Opens the picture of one side in a folder. Reads only its size.
    fn open(folder: &Path, name: &str) -> Result<Self, String> {
        let path = folder.join(format!("{name}.png"));
        let other = ["jpg", "jpeg", "bmp"].map(|extension| path.with_extension(extension));
        match PictureFile::open(&path) {
            Ok(PictureFile { width, height, .. }) => Ok(Self {
                width: width as i32,
                height: height as i32,
                upper: OnceLock::new(),
                texels: OnceLock::new(),
                path,
            }),
            Err(message) => Err(match other.iter().find(|other| !path.exists() && other.exists()) {
                Some(other) => format!("cube map face '{}': a face must be a PNG picture", other.display()),
                None => format!("cube map face '{}': {message}", path.display()),
            }),
        }
    }

    /// See [`CubeMap::bytes`].
    fn bytes(&self, spot: &Spot) -> &[u8] {
        if self.texels.get().is_none() {
            // A look-up reads two texels of each row.
            let rows = self.height / 2 + 2;
            let is_above = spot.lower as usize + PADDING <= 3 * self.width as usize * rows as usize;
            let size = (self.width as u32, self.height as u32);
            let decode = || picture_file::first_rows(&self.path, size, rows as u32);
            if is_above && let Some(upper) = self.upper.get_or_init(decode) {
                return upper;
            }
        }
        self.texels.get_or_init(|| self.decode()).as_ref().map_or(&[], Vec::as_slice)
    }

    fn decode(&self) -> Result<Vec<u8>, String> {
        let picture = PictureFile::open(&self.path)?;
        if (picture.width as i32, picture.height as i32) != (self.width, self.height) {
            return Err("the file changed while it was used".to_owned());
        }
        let mut texels = picture.decode()?.into_rgb8().into_raw();
        texels.extend([0; PADDING]);
        Ok(texels)
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
    fn shares_are_quotients_to_the_bit() {
        for byte in 0..=255 {
            assert_eq!(share(byte), Real::from(byte) / 255.0, "{byte}");
        }
    }

    #[test]
    fn numbers_are_rounded_down() {
        for x in [0.0, 0.25, 0.5, 0.75, 1.0 - Real::EPSILON, 1.0, 1.5, 2.5, 4095.5, 65_535.75, 65_536.0] {
            assert_eq!(floored(x), (x as i32, x.floor()), "{x}");
        }
    }

    #[test]
    fn the_border_is_clamped() {
        assert_eq!(bytes(1.0, -1.0, 1.0), [0.0, 100.0, 100.0]);
    }
}
