//! Files that the program writes: where a name leads, what can be checked before rendering, and writing itself.
//!
//! A file appears under its name only when it is complete. Until then it has a temporary name in the same folder.

mod target;
mod temporary;

pub use target::Target;
pub use temporary::remove_unfinished;

use crate::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use temporary::Temporary;

/// Writes to standard error. Errors of writing are ignored: where the terminal or a pipe is closed, there is nobody to
/// tell.
pub fn say(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Writes a file by calling `write`. Errors call it `what`. Links are followed; a file that is replaced leaves its
/// permissions to the new one; devices and pipes are written into.
///
/// # Errors
/// [`Error::File`] when the folder does not exist or cannot be written to, or the disk is full.
pub fn write_whole(
    path: &Path,
    what: &str,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), Error> {
    let refused = |error: io::Error| Error::io(path, &format!("write {what}"), &error);
    let write = |file: &mut File| {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        write(&mut writer)?;
        writer.flush()
    };
    match Target::of(path)? {
        Target::Stream(path) => {
            let mut stream = File::options().append(true).open(path).map_err(refused)?;
            write(&mut stream).map_err(refused)
        }
        Target::File { path: file, permissions } => {
            let mut temporary = Temporary::beside(&file).map_err(refused)?;
            write(&mut temporary.file).map_err(refused)?;
            if let Some(permissions) = permissions {
                temporary.file.set_permissions(permissions).map_err(refused)?;
            }
            temporary.persist(&file).map_err(refused)
        }
    }
}

/// Returns whether a name leads to a device or a pipe, in which a writer cannot go back.
pub fn leads_to_stream(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::Stream(_)))
}

/// Checks before a long computation that these files can be written, and that no two of them are one.
///
/// # Errors
/// [`Error::File`] for the first file that cannot be written, or that has two names here.
pub fn check<'a>(paths: impl Iterator<Item = &'a Path>) -> Result<(), Error> {
    let mut checked: Vec<(&Path, Target)> = Vec::new();
    for path in paths {
        let target = Target::of(path)?;
        if let Some((before, _)) = checked.iter().find(|(_, other)| other.is_same_file(&target)) {
            let message = format!("this is the same file as '{}': one of them would be lost", before.display());
            return Err(Error::file(path, message));
        }
        target.check(path)?;
        checked.push((path, target));
    }
    Ok(())
}

/// Checks that none of the files that will be written is one that is read.
///
/// # Errors
/// [`Error::File`] for the first file that would be written over.
pub fn check_inputs<'a>(
    outputs: impl Iterator<Item = &'a Path> + Clone,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Error> {
    for input in inputs {
        let Ok(path) = input.canonicalize() else { continue };
        let leads_there =
            |output| matches!(Target::of(output), Ok(Target::File { path: output, .. }) if output == path);
        if outputs.clone().any(leads_there) {
            return Err(Error::file(input, "this file is read, so it must not be written over"));
        }
    }
    Ok(())
}
