//! Text files that errors quote, and mistakes in them.

use super::Error;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A text file in memory, for errors to quote.
#[derive(Debug)]
pub struct SourceText {
    pub path: PathBuf,
    pub text: String,
}

/// A place in a [`SourceText`], in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    pub start: usize,
    pub end: usize,
}

impl SourceText {
    /// Returns line and column of a byte offset, both counted from 1, the column in characters.
    pub fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(offset)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }

    /// Returns `file:line:column` of a place. Slow, because it counts all lines before it: use it for messages only.
    pub fn location(&self, span: Span) -> String {
        let (line, column) = self.line_and_column(span.start);
        format!("{}:{line}:{column}", self.path.display())
    }

    /// Makes an error about `span` of this text.
    pub fn error(self: &Arc<Self>, span: Span, message: impl Into<String>) -> Error {
        Error::Source(SourceError { source_text: Arc::clone(self), span, message: message.into(), note: None })
    }
}

/// A mistake in a text file; displays as `file:line:column: message` with the line below it.
#[derive(Debug)]
pub struct SourceError {
    source_text: Arc<SourceText>,
    span: Span,
    message: String,
    pub(super) note: Option<String>,
}

/// Largest number of bytes of a line that an error shows on each side of the mistake.
const QUOTED_MARGIN: usize = 100;

impl SourceError {
    /// Returns `file:line:column` of the mistake.
    pub fn location(&self) -> String {
        self.source_text.location(self.span)
    }

    /// Returns what sorts mistakes by file and place.
    pub(super) fn place(&self) -> (&Path, usize) {
        (&self.source_text.path, self.span.start)
    }

    /// Returns the part of the line to show, and the place of the mistake in it. Long lines are cut, so that a file
    /// of one huge line gives a short message too.
    fn quoted(&self) -> (&str, Range<usize>) {
        let text = &self.source_text.text;
        let start = text.floor_char_boundary(self.span.start);
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |length| start + length);
        let from = text.ceil_char_boundary(line_start.max(start.saturating_sub(QUOTED_MARGIN)));
        let to = text.floor_char_boundary(line_end.min(start + QUOTED_MARGIN)).max(start);
        let end = text.ceil_char_boundary(self.span.end).clamp(start, to);
        (text[from..to].trim_end_matches('\r'), start - from..end - from)
    }
}

impl fmt::Display for SourceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rendered = self.rendered(&Renderer::plain());
        // `Error::report` begins so, too.
        f.write_str(rendered.strip_prefix("error: ").unwrap_or(&rendered))
    }
}

impl SourceError {
    /// Returns the message with `error: ` and the line of the text, in colours where the renderer has them.
    pub(super) fn rendered(&self, renderer: &Renderer) -> String {
        let title = format!("{}: {}", self.location(), self.message);
        let (line, mark) = self.quoted();
        let mark = mark.start.min(line.len())..mark.end.min(line.len());
        let (line_number, _) = self.source_text.line_and_column(self.span.start);
        let snippet = Snippet::source(line).line_start(line_number).annotation(AnnotationKind::Primary.span(mark));
        let mut report = Level::ERROR.primary_title(&title).element(snippet);
        if let Some(note) = &self.note {
            report = report.element(Level::HELP.message(note));
        }
        renderer.render(&[report])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Arc<SourceText> {
        Arc::new(SourceText { path: PathBuf::from("s.txt"), text: text.to_owned() })
    }

    #[test]
    fn columns_count_characters() {
        let text = source("a\nüü x\n");
        assert_eq!(text.line_and_column(text.text.find('x').unwrap()), (2, 4));
        assert_eq!(text.line_and_column(text.text.len()), (3, 1));
    }

    #[test]
    fn an_error_shows_and_marks_its_line() {
        let error = source("one\n  two three\n").error(Span { start: 6, end: 9 }, "wrong");
        let shown = error.to_string();
        assert!(shown.starts_with("s.txt:2:3: wrong\n"), "{shown}");
        assert!(shown.contains("2 |   two three"), "{shown}");
        assert!(shown.contains("^^^"), "{shown}");
    }

    #[test]
    fn a_huge_line_is_cut() {
        let text = source(&format!("{}!{}", "ä".repeat(5000), "b".repeat(5000)));
        let at = text.text.find('!').unwrap();
        let shown = text.error(Span { start: at, end: at + 3000 }, "here").to_string();
        assert!(shown.len() < 1000, "{}", shown.len());
    }
}
