//! [`OutputFile`]: a file that is being written.

use super::target::{Target, check_open, check_replaceable, identity, standard_output};
use super::temporary::Temporary;
use crate::error::Error;
use crate::input::is_standard;
use std::fs::{File, Permissions};
use std::io::{self, ErrorKind, IsTerminal as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::{SpooledTempFile, spooled_tempfile};

/// Bytes up to which what goes into a device or a pipe is kept in memory, and not on disk.
const IN_MEMORY: usize = 1 << 23;

/// A file that is being written, in any order. It appears under its name when it is finished; dropped before, it
/// disappears. Links are followed; a file that is replaced leaves its permissions to the new one.
///
/// What goes into a device or a pipe is kept in a file without a name until it is finished. So a failed run sends nothing,
/// and several pipes can be read in any order.
pub struct OutputFile {
    /// As the user calls it.
    name: PathBuf,
    /// What messages call it.
    what: &'static str,
    place: Place,
}

enum Place {
    File { temporary: Temporary, path: PathBuf, permissions: Option<Permissions> },
    Stream(SpooledTempFile),
}

impl OutputFile {
    /// Begins a file. Errors call it `what`.
    ///
    /// # Errors
    /// [`Error::File`] when the folder does not exist or cannot be written to.
    pub fn new(name: &Path, what: &'static str) -> Result<Self, Error> {
        let place = match Target::of(name)? {
            Target::Stream | Target::StandardOutput => Place::Stream(spooled_tempfile(IN_MEMORY)),
            Target::File { path, permissions } => {
                let temporary = Temporary::beside(&path).map_err(|error| no_new_file(name, what, &error))?;
                Place::File { temporary, path, permissions }
            }
        };
        Ok(Self { name: name.to_owned(), what, place })
    }

    /// Begins a file long before it is finished, and checks that it can get its name.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot.
    pub fn checked(name: &Path, what: &'static str) -> Result<Self, Error> {
        if is_standard(name) && io::stdout().is_terminal() {
            return Err(Error::file(name, "standard output is a terminal: lead it into a file or a pipe"));
        }
        let file = Self::new(name, "this file")?;
        match &file.place {
            Place::File { temporary, path, permissions: Some(permissions) } => {
                check_replaceable(name, path, permissions, temporary)?;
            }
            Place::Stream(_) => check_open(name)?,
            Place::File { .. } => {}
        }
        Ok(Self { what, ..file })
    }

    /// Returns how the user calls it.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Returns the path with all links resolved; `None` for what is written into.
    pub fn path(&self) -> Option<&Path> {
        match &self.place {
            Place::File { path, .. } => Some(path),
            Place::Stream(_) => None,
        }
    }

    /// Returns whether one of two files would be lost, or both go into one pipe. Several may write into a device.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self.path(), other.path()) {
            (Some(path), Some(other)) => path == other,
            _ if is_standard(&self.name) && is_standard(&other.name) => true,
            _ => identity(&self.name).is_some_and(|own| identity(&other.name) == Some(own)),
        }
    }

    /// Returns the message for an error of writing.
    pub fn refused(&self, error: &io::Error) -> Error {
        refused(&self.name, self.what, error)
    }

    /// Gives the complete file its name, or sends it.
    ///
    /// # Errors
    /// [`Error::File`] if the system refuses it.
    pub fn finish(self) -> Result<(), Error> {
        let Self { name, what, place } = self;
        let finished = match place {
            Place::Stream(mut spooled) => send(&mut spooled, &name),
            Place::File { temporary, path, permissions } => {
                let permitted = permissions.map_or(Ok(()), |some| temporary.file.set_permissions(some));
                permitted.and_then(|()| temporary.persist(&path))
            }
        };
        finished.map_err(|error| refused(&name, what, &error))
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.place {
            Place::File { temporary, .. } => temporary.file.write(bytes),
            Place::Stream(spooled) => spooled.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        match &mut self.place {
            Place::File { temporary, .. } => temporary.file.seek(place),
            Place::Stream(spooled) => spooled.seek(place),
        }
    }
}

fn send(spooled: &mut SpooledTempFile, name: &Path) -> io::Result<()> {
    let mut stream =
        if is_standard(name) { standard_output()? } else { File::options().append(true).open(name)? };
    spooled.seek(SeekFrom::Start(0))?;
    io::copy(spooled, &mut stream).map(|_| ())
}

/// Makes the error for a folder in which no file can be made.
fn no_new_file(name: &Path, what: &str, error: &io::Error) -> Error {
    match error.kind() {
        ErrorKind::PermissionDenied => {
            Error::io(name, &format!("write {what}, because no file can be made in its folder"), error)
        }
        _ => refused(name, what, error),
    }
}

fn refused(name: &Path, what: &str, error: &io::Error) -> Error {
    Error::io(name, &format!("write {what}"), error)
}
