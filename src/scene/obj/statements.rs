//! OBJ text to statements: one at a time, words with their places, and of those that no picture shows only the kind.
//!
//! ```text
//! v x y z ...               a vertex; what stands behind z (w, colours) is of no use
//! f i j k ...   fo i j k    a face
//! # ...                     a comment, also behind numbers
//! v 1 2 \                   goes on in the next line
//! ```
//!
//! Only vertices and faces go on behind a `\`. A comment or a name that ends in one (`# C:\models\`) swallows nothing.

use crate::error::Span;
use std::borrow::Cow;

/// What a statement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Face,
    Points,
    Line,
    /// A curve or a free-form surface.
    Curved,
    /// The name of another file to read.
    Call,
    /// Probably a vertex or a face with a slip in its keyword: a number with a keyword that OBJ does not have. Also the
    /// marks of a merge conflict.
    Slip,
    /// Everything else: comments, names, groups, materials, normals, texture coordinates.
    Other,
}

/// Keywords of what shows in no picture, and those of material files, which are found in meshes, too.
const NOT_SHOWN: [&str; 52] = [
    "vn",
    "vt",
    "vp",
    "vw",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "csh",
    "cstype",
    "deg",
    "bmat",
    "step",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "res",
    "newmtl",
    "Ka",
    "Kd",
    "Ks",
    "Ke",
    "Ns",
    "Ni",
    "Tr",
    "Tf",
    "d",
    "illum",
    "map_Ka",
    "map_Kd",
    "map_Ks",
    "VN",
    "VT",
    "VP",
    "t",
    "c",
];

/// The marks of a merge conflict.
const CONFLICT: [&str; 3] = ["<<<<<<<", "=======", ">>>>>>>"];

impl Kind {
    /// What a statement with this keyword is about. A slip is one only with a number.
    pub fn of(keyword: &[u8]) -> Self {
        match keyword {
            b"v" => Self::Vertex,
            b"f" | b"fo" => Self::Face,
            b"p" => Self::Points,
            b"l" => Self::Line,
            b"curv" | b"curv2" | b"surf" | b"bzp" | b"bsp" | b"cdc" | b"cdp" => Self::Curved,
            b"call" => Self::Call,
            _ if NOT_SHOWN.iter().any(|known| known.as_bytes() == keyword) => Self::Other,
            _ => Self::Slip,
        }
    }
}

/// A statement and its text.
#[derive(Debug)]
pub(super) struct Statement<'a> {
    pub kind: Kind,
    /// The place of its first word.
    pub keyword: Span,
    line: Line<'a>,
    /// Where its other words begin in the line.
    rest: usize,
}

/// A line without its comment, or several lines joined.
#[derive(Debug)]
struct Line<'a> {
    text: Cow<'a, str>,
    /// Where the line begins in the file.
    start: usize,
    /// Where further lines begin, in this text and in the file.
    joints: Vec<(usize, usize)>,
}

/// Whether a character separates words: white space, also of no width, a byte order mark where files were joined, and the
/// NUL and Ctrl-Z that some programs put at the end of a file.
pub(super) fn separates(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\0' | '\u{1a}' | '\u{200b}' | '\u{2060}' | '\u{feff}')
}

impl Line<'_> {
    /// The place in the file of a part of the text, as far as it stands in one line of the file.
    fn span(&self, from: usize, to: usize) -> Span {
        let next = self.joints.partition_point(|&(at, _)| at <= from);
        let start = match self.joints[..next].last() {
            Some(&(at, in_file)) => in_file + from - at,
            None => self.start + from,
        };
        let to = self.joints.get(next).map_or(to, |&(at, _)| at.min(to));
        Span { start, end: start + to - from }
    }
}

impl Statement<'_> {
    /// The words behind the keyword, with their places.
    pub fn words(&self) -> impl Iterator<Item = (&str, Span)> {
        let mut at = self.rest;
        std::iter::from_fn(move || {
            let (from, to) = word_behind(&self.line.text, at)?;
            at = to;
            Some((&self.line.text[from..to], self.line.span(from, to)))
        })
    }
}

/// What stands behind `1.#` where some programs write numbers that are none.
const NO_NUMBERS: [&str; 4] = ["INF", "IND", "QNAN", "SNAN"];

/// Where a comment begins: at a `#`, but not in `1.#INF`.
fn comment_start(line: &str) -> Option<usize> {
    let is_number =
        |&at: &usize| line[..at].ends_with('.') && NO_NUMBERS.iter().any(|name| line[at + 1..].starts_with(name));
    line.match_indices('#').map(|(at, _)| at).find(|at| !is_number(at))
}

/// Start and end of the first word of `text` behind `at`.
fn word_behind(text: &str, at: usize) -> Option<(usize, usize)> {
    let from = at + text[at..].find(|c| !separates(c))?;
    let to = text[from..].find(separates).map_or(text.len(), |length| from + length);
    Some((from, to))
}

/// Whether a line whose keyword, unknown, ends at `at` is a slip: it has a number, or is the mark of a merge conflict.
fn is_slip(keyword: &str, text: &str, at: usize) -> bool {
    let is_of_number = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.');
    let is_shape = keyword.starts_with(['v', 'V', 'f', 'F']) || is_of_number(keyword.as_bytes()[0]);
    is_shape && keyword.contains(|c: char| c.is_ascii_digit())
        || word_behind(text, at).is_some_and(|(from, _)| is_of_number(text.as_bytes()[from]))
        || CONFLICT.iter().any(|mark| keyword.starts_with(mark))
}

/// Hands out the statements of a text one by one.
#[derive(Debug)]
pub(super) struct Statements<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Statements<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    /// The next line of the file, where it begins, and whether it goes on in the line behind it.
    fn next_line(&mut self) -> Option<(&'a str, usize, bool)> {
        let start = self.at;
        let rest = self.text.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.find('\n').unwrap_or(rest.len());
        self.at = start + length + 1;
        let line = &rest[..length];
        Some(match (comment_start(line), line.trim_end().strip_suffix('\\')) {
            (Some(comment), _) => (&line[..comment], start, false),
            (None, Some(line)) => (line, start, true),
            (None, None) => (line, start, false),
        })
    }

    /// Appends to `line` the lines behind it, up to the first one that does not go on.
    fn join(&mut self, line: &mut Line<'a>) {
        while let Some((next, start, goes_on)) = self.next_line() {
            line.joints.push((line.text.len(), start));
            line.text.to_mut().push_str(next);
            if !goes_on {
                return;
            }
        }
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        loop {
            let (text, start, goes_on) = self.next_line()?;
            let Some((from, rest)) = word_behind(text, 0) else { continue };
            let keyword = &text[from..rest];
            let kind = match Kind::of(keyword.as_bytes()) {
                Kind::Slip if !is_slip(keyword, text, rest) => Kind::Other,
                kind => kind,
            };
            let mut line = Line { text: Cow::Borrowed(text), start, joints: Vec::new() };
            let keyword = line.span(from, rest);
            if goes_on && matches!(kind, Kind::Vertex | Kind::Face) {
                self.join(&mut line);
            }
            return Some(Statement { kind, keyword, line, rest });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statements(text: &str) -> Vec<(Kind, Vec<String>)> {
        let words = |statement: &Statement| statement.words().map(|(word, _)| word.to_owned()).collect();
        Statements::new(text).map(|statement| (statement.kind, words(&statement))).collect()
    }

    #[test]
    fn lines_are_joined_and_comments_are_cut() {
        for (text, kind, words) in [
            ("v 1 2 3 # 4", Kind::Vertex, "1 2 3"),
            ("f 1 2 3#4", Kind::Face, "1 2 3"),
            ("\tfo 1\t2 3\r\n", Kind::Face, "1 2 3"),
            ("f 1 2 3 \\\n4", Kind::Face, "1 2 3 4"),
            ("f 1 2 \\ \r\n 3 \\\r\n4", Kind::Face, "1 2 3 4"),
            ("v 0.\\\n5 1\\\n\\\n2 3", Kind::Vertex, "0.5 12 3"),
            ("f 1 2 # \\\n", Kind::Face, "1 2"),
            ("v 1.#INF 1.#IND#3 4", Kind::Vertex, "1.#INF 1.#IND"),
            ("v 1 2 3.#4", Kind::Vertex, "1 2 3."),
            ("f 1 2 3\\", Kind::Face, "1 2 3"),
            ("v\\\n 1 2 3", Kind::Vertex, "1 2 3"),
            ("\u{feff}v 1 2 3\0\0\u{1a}", Kind::Vertex, "1 2 3"),
            ("v 1\u{a0}2 3", Kind::Vertex, "1 2 3"),
        ] {
            let words = words.split(' ').map(str::to_owned).collect();
            assert_eq!(statements(text), [(kind, words)], "{text:?}");
        }
    }

    #[test]
    fn what_is_not_shown_swallows_no_line() {
        for text in ["# C:\\models\\", "mtllib C:\\", "vn 0 0 \\", "g a \\"] {
            let kinds: Vec<_> =
                statements(&format!("{text}\nf 1 2 3")).into_iter().map(|statement| statement.0).collect();
            assert_eq!(kinds.last(), Some(&Kind::Face), "{text}");
        }
        assert_eq!(statements("\\\nf"), [(Kind::Face, vec![])]);
    }

    #[test]
    fn words_keep_their_places_when_lines_are_joined() {
        let text = "# é\nv 1 \\\n2\\\n5 x3";
        let statement = Statements::new(text).last().unwrap();
        let places: Vec<_> = statement.words().map(|(word, span)| (word, &text[span.start..span.end])).collect();
        assert_eq!(places, [("1", "1"), ("25", "2"), ("x3", "x3")]);
        assert_eq!(&text[statement.keyword.start..statement.keyword.end], "v");
    }
}
