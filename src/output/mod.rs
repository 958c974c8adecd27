//! Files that the program writes: where a name leads, what can be checked before rendering, and writing itself.
//!
//! A file appears under its name only when it is complete. Until then it has none, or where the system knows no files without
//! names, a temporary one in the same folder.

mod file;
mod nameless;
mod target;
mod temporary;

pub use file::OutputFile;
pub use temporary::{remove_unfinished, remove_unfinished_if_possible};

use crate::error::{Error, visible};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes to standard error, control characters as symbols. Errors of writing are ignored: where the terminal or a pipe is
/// closed, there is nobody to tell.
pub fn say(text: &str) {
    say_in_colors(&visible(text));
}

/// Writes to standard error what may hold control characters.
pub fn say_in_colors(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Writes to standard output, control characters as symbols.
///
/// # Errors
/// The operating system's; that nothing can be written there is one, which Rust's own functions ignore.
pub fn print(text: &str) -> io::Result<()> {
    if text.is_empty() { Ok(()) } else { target::standard_output()?.write_all(visible(text).as_bytes()) }
}

/// Writes a file by calling `write`. Errors call it `what`.
///
/// # Errors
/// As [`OutputFile`].
pub fn write_whole(
    path: &Path,
    what: &'static str,
    write: impl FnOnce(&mut BufWriter<&mut OutputFile>) -> io::Result<()>,
) -> Result<(), Error> {
    let mut file = OutputFile::new(path, what)?;
    let mut writer = BufWriter::with_capacity(1 << 16, &mut file);
    let written = write(&mut writer).and_then(|()| writer.flush());
    drop(writer);
    written.map_err(|error| file.refused(&error))?;
    file.finish()
}

/// Begins files before a long computation, each with its flag: checks that they can be written, and that no two of them are
/// one. Errors of writing call each a picture.
///
/// # Errors
/// [`Error::File`] for the first file that cannot be written, [`Error::Usage`] for one that two flags write.
pub fn begin<'a>(files: impl Iterator<Item = (&'static str, &'a Path)>) -> Result<Vec<OutputFile>, Error> {
    let (mut flags, mut begun) = (Vec::new(), Vec::<OutputFile>::new());
    for (flag, path) in files {
        let file = OutputFile::checked(path, "the picture")?;
        if let Some(index) = begun.iter().position(|before| before.is_same(&file)) {
            let (other, name, path) = (flags[index], begun[index].name().display(), path.display());
            let message =
                format!("-{other} {name} and -{flag} {path} are the same file: one of them would be lost");
            return Err(Error::Usage(message));
        }
        flags.push(flag);
        begun.push(file);
    }
    Ok(begun)
}

/// Checks that none of the files that will be written is one that is read.
///
/// # Errors
/// [`Error::File`] for the first file that would be written over.
pub fn check_inputs<'a>(outputs: &[OutputFile], inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Error> {
    for input in inputs {
        let Ok(path) = input.canonicalize() else { continue };
        if outputs.iter().any(|output| output.path() == Some(path.as_path())) {
            return Err(Error::file(input, "this file is read, so it must not be written over"));
        }
    }
    Ok(())
}
