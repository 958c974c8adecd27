//! [`Error`]: everything that can go wrong, with its message for the user and its exit code.

mod remarks;
mod source;
mod words;

pub use remarks::Remarks;
pub use source::{SourceError, SourceText, Span};
pub use words::{counted, cut_short, probably_meant, shown_number, visible};

use annotate_snippets::Renderer;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Most mistakes of a file that are shown at once.
pub const MOST_SHOWN: usize = 10;
/// The word that a report begins with, bold and red on a terminal.
const STYLED_ERROR: &str = "\x1b[1m\x1b[91merror\x1b[0m";

/// Everything that can go wrong.
#[derive(Debug)]
pub enum Error {
    /// A wrong command line.
    Usage(String),
    /// A mistake at a known place in a scene or mesh file.
    Source(SourceError),
    /// Several mistakes, two or more.
    Several(Vec<Error>),
    /// A file that could not be read or written, or that has the wrong content.
    File { path: PathBuf, message: String },
    /// Anything else that the program refuses.
    Refused(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) => write!(f, "{}\nhint: 'a2 -h' lists the flags", visible(message)),
            Self::Source(error) => error.fmt(f),
            Self::Several(errors) => {
                errors.iter().try_for_each(|error| write!(f, "{error}\n\nerror: "))?;
                f.write_str(&number_of(errors))
            }
            Self::File { path, message } => {
                let path = path.to_string_lossy();
                // No line begins within the name.
                write!(f, "{}: {}", visible(&path).replace('\n', "\u{240a}"), visible(message))
            }
            Self::Refused(message) => f.write_str(&visible(message)),
        }
    }
}

impl std::error::Error for Error {}

impl Error {
    /// Makes an error about a whole file.
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        Self::File { path: path.to_owned(), message: message.into() }
    }

    /// Makes an error of the operating system, which refused to do `action` with a file.
    pub fn io(path: &Path, action: &str, error: &io::Error) -> Self {
        /// `EMFILE`, which has no name in Rust.
        const TOO_MANY_FILES: i32 = 24;
        let is_limit = cfg!(unix) && error.raw_os_error() == Some(TOO_MANY_FILES);
        let limit = if is_limit { ": 'ulimit -n' shows how many this process may have" } else { "" };
        Self::file(path, format!("cannot {action}: {error}{limit}"))
    }

    /// Makes one error of several mistakes, in the order of their places, and of the first [`MOST_SHOWN`] where there are
    /// more. There must be one at least.
    pub fn all(mut errors: Vec<Self>) -> Self {
        errors.sort_by(|a, b| a.place().cmp(&b.place()));
        errors.truncate(MOST_SHOWN);
        match errors.len() {
            1 => errors.swap_remove(0),
            _ => Self::Several(errors),
        }
    }

    fn place(&self) -> Option<(&Path, usize)> {
        match self {
            Self::Source(error) => Some(error.place()),
            _ => None,
        }
    }

    /// Returns the error as the user reads it, beginning with `error: `; with colours for a terminal, if wanted.
    pub fn report(&self, with_colors: bool) -> String {
        if !with_colors {
            return format!("error: {self}");
        }
        match self {
            Self::Source(error) => error.rendered(&Renderer::styled()),
            Self::Several(errors) => {
                let shown: String = errors.iter().map(|error| error.report(true) + "\n\n").collect();
                format!("{shown}{STYLED_ERROR}: {}", number_of(errors))
            }
            _ => format!("{STYLED_ERROR}: {self}"),
        }
    }

    /// Adds a hint below a source error; other errors stay as they are.
    #[must_use]
    pub fn with_note(mut self, text: impl Into<String>) -> Self {
        if let Self::Source(error) = &mut self {
            error.note = Some(text.into());
        }
        self
    }

    /// Returns the process exit code: 2 for a wrong command line, otherwise 1.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            _ => 1,
        }
    }
}

/// Returns the last line about several mistakes.
fn number_of(errors: &[Error]) -> String {
    match errors.len() {
        count if count < MOST_SHOWN => format!("{count} mistakes"),
        _ => format!("{MOST_SHOWN} mistakes or more: these are the first"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn several_mistakes_stand_in_the_order_of_the_file() {
        let text = Arc::new(SourceText { path: PathBuf::from("s.txt"), text: "one two\nthree".to_owned() });
        let at = |start, message: &str| text.error(Span { start, end: start + 3 }, message);
        let error = Error::all(vec![at(8, "b"), at(4, "a")]);
        let shown = error.to_string();
        assert!(shown.starts_with("s.txt:1:5: a\n") && shown.contains("\n\nerror: s.txt:2:1: b\n"), "{shown}");
        assert!(shown.ends_with("\n\nerror: 2 mistakes"), "{shown}");
        assert_eq!(Error::all(vec![at(4, "a")]).to_string(), at(4, "a").to_string());
        let many = Error::all((0..13).map(|_| at(4, "a")).collect()).to_string();
        assert_eq!(many.matches("s.txt:1:5: a").count(), MOST_SHOWN);
        assert!(many.ends_with("10 mistakes or more: these are the first"), "{many}");
    }

    #[test]
    fn colors_change_nothing_else() {
        let text = Arc::new(SourceText { path: PathBuf::from("s.txt"), text: "one two".to_owned() });
        let error = || text.error(Span { start: 4, end: 7 }, "wrong").with_note("right");
        for error in [error(), Error::all(vec![error(), error()]), Error::Usage("which scene?".into())] {
            let (plain, colored) = (error.report(false), error.report(true));
            let without: String =
                colored.split('\x1b').map(|part| part.split_once('m').map_or(part, |part| part.1)).collect();
            assert_eq!(without, plain);
            assert!(colored.contains("\x1b[") && !plain.contains('\x1b'), "{colored}");
        }
    }
}
