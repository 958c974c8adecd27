//! [`Target`]: where the name of a file leads.

use super::temporary::{Temporary, folder_of};
use crate::error::Error;
use crate::input::is_standard;
use std::fs::{self, File, Permissions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Where the name of a file leads.
#[derive(Debug)]
pub enum Target {
    /// A regular file, or a name under which there is nothing yet. Links are resolved.
    File {
        path: PathBuf,
        /// Those of the file that is replaced.
        permissions: Option<Permissions>,
    },
    /// The name `-`.
    StandardOutput,
    /// A device, a pipe, or a file that is open already (`/dev/stdout`). It is written into.
    Stream,
}

impl Target {
    /// Follows the links of a name.
    ///
    /// # Errors
    /// [`Error::File`] for a folder, a name in a folder that does not exist, and what the system refuses.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let refused = |error: io::Error| Error::io(path, "write this file", &error);
        if is_standard(path) {
            return Ok(Self::StandardOutput);
        }
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => Err(Error::file(path, "this is a folder")),
            Ok(metadata) if metadata.is_file() && !leads_to_open_file(path) => {
                let permissions = Some(metadata.permissions());
                Ok(Self::File { path: path.canonicalize().map_err(refused)?, permissions })
            }
            Ok(_) => Ok(Self::Stream),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Ok(Self::File { path: new_file(path)?, permissions: None })
            }
            Err(error) if error.kind() == ErrorKind::PermissionDenied && path.is_symlink() => {
                Err(Error::io(path, "follow this link", &error))
            }
            Err(error) => Err(refused(error)),
        }
    }
}

/// Checks that a file can be replaced by a temporary one, without changing it. `name` is how the user calls it.
///
/// # Errors
/// [`Error::File`] if it cannot.
pub fn check_replaceable(
    name: &Path,
    path: &Path,
    permissions: &Permissions,
    temporary: &Temporary,
) -> Result<(), Error> {
    let refused = |error: io::Error| Error::io(name, "write this file", &error);
    if permissions.readonly() {
        return Err(Error::file(name, "this file is read-only"));
    }
    File::options().write(true).open(path).map_err(refused)?;
    if is_anothers(path, temporary).map_err(refused)? {
        let message = "this file is another user's, and its folder lets only the owner replace it";
        return Err(Error::file(name, message));
    }
    Ok(())
}

/// Returns standard output as a file, without the buffer that Rust keeps for it.
#[cfg(unix)]
pub fn standard_output() -> io::Result<File> {
    use std::os::fd::AsFd;
    Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
}

/// Returns standard output as a file, without the buffer that Rust keeps for it.
#[cfg(windows)]
pub fn standard_output() -> io::Result<File> {
    use std::os::windows::io::AsHandle;
    Ok(io::stdout().as_handle().try_clone_to_owned()?.into())
}

/// Checks that a device or an open file can be written into. A pipe cannot be opened before somebody reads it.
///
/// # Errors
/// [`Error::File`] if it cannot.
pub fn check_open(name: &Path) -> Result<(), Error> {
    let is_pipe = fs::metadata(name).map_or(true, |metadata| !metadata.is_file() && !is_device(&metadata));
    let opened = if is_pipe { Ok(()) } else { File::options().append(true).open(name).map(|_| ()) };
    opened.map_err(|error| Error::io(name, "write this file", &error))
}

/// Returns what tells a pipe or a file from others; `None` for a device.
#[cfg(unix)]
pub fn identity(name: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let of_output = || standard_output().and_then(|output| output.metadata());
    let metadata = if is_standard(name) { of_output() } else { fs::metadata(name) };
    metadata.ok().filter(|metadata| !is_device(metadata)).map(|metadata| (metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
pub fn identity(_: &Path) -> Option<(u64, u64)> {
    None
}

#[cfg(unix)]
fn is_device(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_device(_: &fs::Metadata) -> bool {
    false
}

/// Returns whether a name, or a link that it leads to, stands for a file that this process has open. Replacing the file would not
/// reach whoever opened it.
fn leads_to_open_file(path: &Path) -> bool {
    let next = |path: &PathBuf| fs::read_link(path).ok().map(|link| folder_of(path).join(link));
    let is_open = |path: &PathBuf| {
        ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"].iter().any(|open| path.starts_with(open))
    };
    std::iter::successors(Some(path.to_owned()), next).any(|path| is_open(&path))
}

/// Follows the links of a name under which there is nothing yet.
fn new_file(path: &Path) -> Result<PathBuf, Error> {
    let is_folder_name = path.as_os_str().as_encoded_bytes().ends_with(b"/");
    let mut end = path.to_owned();
    // A circle of links is an error of its own, and never comes here.
    while let Ok(link) = fs::read_link(&end) {
        end = folder_of(&end).join(link);
    }
    let folder = folder_of(&end);
    let found = folder.canonicalize().ok().filter(|found| found.is_dir());
    match (found, end.file_name()) {
        (Some(found), Some(name)) if !is_folder_name => Ok(found.join(name)),
        (Some(_), _) => Err(Error::file(path, "this is the name of a folder, not of a file")),
        (None, _) => Err(Error::file(path, format!("the folder '{}' does not exist", folder.display()))),
    }
}

/// Returns whether a file belongs to another user, in a folder where only the owner may replace it (a sticky one, as
/// `/tmp` is).
#[cfg(unix)]
fn is_anothers(path: &Path, temporary: &Temporary) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let user = temporary.file.metadata()?.uid();
    let (file, folder) = (fs::metadata(path)?, fs::metadata(folder_of(path))?);
    Ok(folder.mode() & STICKY != 0 && user != 0 && user != file.uid() && user != folder.uid())
}

#[cfg(not(unix))]
fn is_anothers(_: &Path, _: &Temporary) -> io::Result<bool> {
    Ok(false)
}
