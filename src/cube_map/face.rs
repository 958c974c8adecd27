//! [`Face`]: one side of a cube map, decoded when the first ray reaches it.

use super::named;
use super::spot::{PADDING, Spot};
use crate::file_path::{self, Kind, KnownFolders};
use crate::picture_file::{self, PictureFile};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The picture of one side. It is decoded when the first ray reaches it.
#[derive(Debug)]
pub(super) struct Face {
    pub path: PathBuf,
    pub width: i32,
    pub height: i32,
    /// Bytes that the whole picture takes while it is decoded.
    pub decoded_bytes: u64,
    /// The upper half, three bytes a texel: above a floor no ray sees more of most faces. `None` if only the whole picture can be
    /// decoded.
    pub upper: OnceLock<Option<Vec<u8>>>,
    /// Three bytes a texel, rows from the top, and [`PADDING`]; or the message why the picture could not be decoded.
    pub texels: OnceLock<Result<Vec<u8>, String>>,
}

/// Returns the path of the picture of one side in a folder, also where its name has other capitals.
pub(super) fn path_of(folder: &Path, name: &str) -> PathBuf {
    let name = format!("{name}.png");
    let spelling = KnownFolders::default().respelt(folder, &name);
    folder.join(spelling.unwrap_or(name))
}

impl Face {
    /// Opens the picture of one side in a folder. Reads only its size.
    pub fn open(folder: &Path, name: &str) -> Result<Self, String> {
        let path = path_of(folder, name);
        match PictureFile::open(&path) {
            Ok(picture) => Ok(Self {
                width: picture.width as i32,
                height: picture.height as i32,
                decoded_bytes: picture.decoded_bytes(),
                upper: OnceLock::new(),
                texels: OnceLock::new(),
                path,
            }),
            Err(message) if path.exists() => Err(named(&path, &message)),
            Err(message) => {
                let other = ["jpg", "jpeg", "bmp", "tga"].map(|extension| path.with_extension(extension));
                if let Some(other) = other.iter().find(|other| other.exists()) {
                    return Err(named(other, "a face must be a PNG picture"));
                }
                let there = file_path::what_is_there(folder, &format!("{name}.png"), Kind::File);
                Err(named(&path, &format!("{message}; {there}")))
            }
        }
    }

    /// See [`CubeMap::bytes`](super::CubeMap::bytes).
    pub fn bytes(&self, spot: &Spot) -> &[u8] {
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

    pub fn decode(&self) -> Result<Vec<u8>, String> {
        let picture = PictureFile::open(&self.path)?;
        if (picture.width as i32, picture.height as i32) != (self.width, self.height) {
            return Err("the file changed while it was used".to_owned());
        }
        let mut texels = picture.decode()?.into_rgb8().into_raw();
        texels.extend([0; PADDING]);
        Ok(texels)
    }
}
