//! Writes files so that they appear under their names only when they are complete.

use super::png;
use crate::error::Error;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Writes a picture as an 8 bit RGB PNG. `bytes` has three bytes a pixel, or one for a grey picture, rows from the
/// top.
///
/// # Errors
/// [`Error::File`] when the folder does not exist or cannot be written to, or the disk is full.
pub fn write_png(path: &Path, width: u32, height: u32, bytes: &[u8]) -> Result<(), Error> {
    write_whole(path, "the picture", |file| {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        png::write(&mut writer, width, height, bytes)?;
        writer.flush()
    })
}

/// Writes a file by calling `write`. It appears under its name only when it is complete. Errors call it `what`.
///
/// # Errors
/// As [`write_png`].
pub fn write_whole(
    path: &Path,
    what: &str,
    write: impl FnOnce(&mut std::fs::File) -> io::Result<()>,
) -> Result<(), Error> {
    let refused = |error: io::Error| Error::io(path, &format!("write {what}"), &error);
    let mut file = temporary_beside(path)?;
    write(file.as_file_mut()).map_err(refused)?;
    file.persist(path).map_err(|error| refused(error.error))?;
    Ok(())
}

/// Checks before a long computation that [`write_png`] can write to `path`.
///
/// # Errors
/// As [`write_png`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Err(Error::file(path, "this is a folder"));
    }
    temporary_beside(path).map(drop)
}

/// Makes a temporary file in the same folder, so that renaming it stays on one disk. It is deleted unless it is
/// renamed.
fn temporary_beside(path: &Path) -> Result<NamedTempFile, Error> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Error::file(path, format!("the folder '{}' does not exist", folder.display())));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".a2-").suffix(".part");
    #[cfg(unix)]
    {
        // Temporary files are private by default; pictures are not. The umask still applies.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| Error::io(path, "write the picture", &error))
}
