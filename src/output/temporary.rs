//! [`Temporary`]: a file that is not complete yet.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempPath;

/// The paths of the temporary files that exist.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and calls `end`, which ends the process. No temporary file can be made meanwhile.
pub fn remove_unfinished(end: impl FnOnce()) {
    let mut unfinished = unfinished();
    for path in unfinished.drain(..) {
        // It may have got its name just now, or the disk is gone: nothing more can be done.
        let _ = std::fs::remove_file(path);
    }
    end();
}

/// A file with a temporary name. It is removed unless it is renamed.
pub(super) struct Temporary {
    pub file: File,
    path: TempPath,
    /// Dropped after the path, which removes the file.
    _listed: Listed,
}

/// A path in [`UNFINISHED`].
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

impl Temporary {
    /// Makes a temporary file in the folder of `path`, so that renaming it stays on one disk.
    pub fn beside(path: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".a2-").suffix(".part");
        #[cfg(unix)]
        {
            // Temporary files are private by default; pictures are not. The umask still applies.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        // Locked while the file is made: a signal must not come between that and the list.
        let mut unfinished = unfinished();
        // Its own message names the temporary file, which says nothing to the user.
        let file = builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()))?;
        let (file, path) = file.into_parts();
        let listed = Listed(path.to_path_buf());
        unfinished.push(listed.0.clone());
        Ok(Self { file, path, _listed: listed })
    }

    /// Gives the complete file its name, in place of a file that has it.
    pub fn persist(self, path: &Path) -> io::Result<()> {
        self.path.persist(path).map_err(|error| error.error)
    }
}
