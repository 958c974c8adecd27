//! Files that appear whole or not at all.

use super::png;
use crate::error::Error;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Writes a picture as 8 bit RGB. `bytes` are three a pixel, or one a pixel for a grey picture, rows from the top.
///
/// The file appears under its name only when it is complete.
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

/// Has `write` fill a file that appears under its name only when it is complete; errors call it `what`.
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

/// Finds out whether [`write_png`] could write to `path`, before a long computation and not after.
///
/// # Errors
/// As [`write_png`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Err(Error::file(path, "this is a folder"));
    }
    temporary_beside(path).map(drop)
}

/// A file in the same folder (so that renaming stays within a disk) that goes away unless it is renamed.
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
        // Temporary files are private by default, pictures are not; the process's umask applies.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| Error::io(path, "write the picture", &error))
}
