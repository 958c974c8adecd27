//! [`Temporary`]: a file that is not complete yet.

use super::nameless;
use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use tempfile::{Builder, TempPath};

/// The paths of the temporary files that have names.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and calls `end`, which ends the process. No temporary file can be made meanwhile.
pub fn remove_unfinished(end: impl FnOnce()) {
    let mut unfinished = unfinished();
    remove(&mut unfinished);
    end();
}

/// Does the same where a thread may have stopped while it made a temporary file, and then leaves the files as they are.
/// Takes no memory.
pub fn remove_unfinished_if_possible(end: impl FnOnce()) {
    let unfinished = match UNFINISHED.try_lock() {
        Ok(unfinished) => Some(unfinished),
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    };
    unfinished.into_iter().for_each(|mut unfinished| remove(&mut unfinished));
    end();
}

fn remove(unfinished: &mut Vec<PathBuf>) {
    for path in unfinished.drain(..) {
        // It may have got its name just now, or the disk is gone: nothing more can be done.
        let _ = std::fs::remove_file(path);
    }
}

/// A file that has no name, or a temporary one. It disappears unless it is given a name.
pub(super) struct Temporary {
    pub file: File,
    /// `None`: the file system keeps files without names. Such a file disappears whatever ends the process.
    named: Option<Named>,
}

/// A temporary name. The file is removed unless it is renamed.
struct Named {
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
    /// Makes a temporary file in the folder of `path`, so that naming it stays on one disk.
    pub fn beside(path: &Path) -> io::Result<Self> {
        match nameless::file_in(folder_of(path)) {
            Some(file) => Ok(Self { file, named: None }),
            None => Self::with_name(path),
        }
    }

    fn with_name(path: &Path) -> io::Result<Self> {
        let (file, named) = Named::beside(path, |name| File::options().write(true).create_new(true).open(name))?;
        Ok(Self { file, named: Some(named) })
    }

    /// Gives the complete file its name, in place of a file that has it.
    pub fn persist(self, path: &Path) -> io::Result<()> {
        let named = match self.named {
            Some(named) => named,
            None if nameless::name(&self.file, path).is_ok() => return Ok(()),
            // Only a file with a name can replace another one.
            None => match Named::beside(path, |name| nameless::name(&self.file, name)) {
                Ok(((), named)) => named,
                Err(_) => return copied(self.file, path)?.persist(path),
            },
        };
        named.path.persist(path).map_err(|error| error.error)
    }
}

/// Copies a file that cannot be named, though the system keeps such files, into one with a name.
fn copied(mut file: File, path: &Path) -> io::Result<Temporary> {
    let mut copy = Temporary::with_name(path)?;
    file.seek(SeekFrom::Start(0))?;
    let from: &mut dyn Read = &mut file;
    io::copy(from, &mut copy.file)?;
    copy.file.set_permissions(file.metadata()?.permissions())?;
    Ok(copy)
}

impl Named {
    /// Calls `make` with names in the folder of `path` until one is free.
    fn beside<T>(path: &Path, mut make: impl FnMut(&Path) -> io::Result<T>) -> io::Result<(T, Self)> {
        // Locked while the file is made: a signal must not come between that and the list.
        let mut unfinished = unfinished();
        let mut cause = None;
        let make = |name: &Path| make(name).inspect_err(|error| cause = error.raw_os_error());
        let made = Builder::new().prefix(".a2-").suffix(".part").make_in(folder_of(path), make);
        // Its own message names the temporary file, which says nothing to the user.
        let (made, path) = made.map_err(|error| cause.map_or(error, io::Error::from_raw_os_error))?.into_parts();
        let listed = Listed(path.to_path_buf());
        unfinished.push(listed.0.clone());
        Ok((made, Self { path, _listed: listed }))
    }
}

/// Returns the folder of a file's path.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    /// Nothing is seen before a file has its name, and nothing but its name is left.
    #[test]
    fn files_with_and_without_names_appear_in_place_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        let names = || std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        let mut nameless = 0;
        for round in 0..4 {
            let make = if round % 2 == 0 { Temporary::beside } else { Temporary::with_name };
            let mut file = make(&path).unwrap();
            nameless += u32::from(file.named.is_none());
            file.file.write_all(&[round; 9]).unwrap();
            assert_eq!(names().count(), usize::from(round > 0) + usize::from(file.named.is_some()));
            file.persist(&path).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), [round; 9]);
            assert!(names().eq(["f"]));
            drop(make(&path).unwrap());
            assert!(names().eq(["f"]) && unfinished().iter().all(|other| !other.starts_with(folder.path())));
        }
        // Where tests run, temporary folders may lie on a file system without such files.
        assert!(nameless == 2 || nameless == 0);
        let file = Temporary::beside(&path).unwrap();
        if file.named.is_none() {
            (&file.file).write_all(b"copied").unwrap();
            copied(file.file, &path).unwrap().persist(&path).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), b"copied");
            assert!(names().eq(["f"]));
        }
    }
}
