//! What a file that is no OBJ file seems to be.

use super::statements::{Kind, Statements};
use crate::file_kind::{kind_of_start, kind_of_text};

/// Says what a file seems to be, if that is not an OBJ file; `text` is its decoded content.
pub(super) fn kind_of(bytes: &[u8], text: &str) -> Option<&'static str> {
    if let Some(what) = kind_of_start(bytes, text) {
        return Some(what);
    }
    // A mesh may hold lines of other kinds, and begin with one.
    let behind_comments = Statements::new(text).next().map_or("", |statement| &text[statement.keyword.start..]);
    let what = kind_of_text(text).or_else(|| kind_of_text(behind_comments))?;
    (!Statements::new(text).any(|statement| statement.kind == Kind::Vertex)).then_some(what)
}
