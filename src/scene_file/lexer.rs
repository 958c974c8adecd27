//! Splits text into tokens: words and braces, each with its place.
//!
//! White space separates words; a brace is always a token by itself. A word that begins with `#` or `//` begins a
//! comment, which ends with its line. (This is an extension: the starter's grammar has no comments.)

use crate::error::Span;

/// A word or a brace, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Token<'a> {
    pub text: &'a str,
    pub span: Span,
}

/// Iterates over the tokens of a text.
#[derive(Debug)]
pub struct Lexer<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a str) -> Self {
        // Some editors on Windows write a byte order mark first.
        let at = if text.starts_with('\u{feff}') { 3 } else { 0 };
        Self { text, at }
    }

    /// Returns the place after the last character of the text.
    pub fn end(&self) -> Span {
        let end = self.text.trim_end().len();
        Span { start: end, end }
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let trimmed = rest.trim_start();
            self.at += rest.len() - trimmed.len();
            if !(trimmed.starts_with('#') || trimmed.starts_with("//")) {
                return;
            }
            self.at += trimmed.find('\n').unwrap_or(trimmed.len());
        }
    }
}

impl<'a> Iterator for Lexer<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        self.skip_blanks_and_comments();
        let rest = &self.text[self.at..];
        let is_brace = |c: char| c == '{' || c == '}';
        let length = match rest.chars().next()? {
            c if is_brace(c) => 1,
            _ => rest.find(|c: char| c.is_whitespace() || is_brace(c)).unwrap_or(rest.len()),
        };
        let start = self.at;
        self.at += length;
        Some(Token { text: &rest[..length], span: Span { start, end: self.at } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<&str> {
        Lexer::new(text).map(|token| token.text).collect()
    }

    #[test]
    fn braces_end_words() {
        assert_eq!(words("shininess 30}Group{"), ["shininess", "30", "}", "Group", "{"]);
    }

    #[test]
    fn comments_run_to_the_end_of_the_line() {
        assert_eq!(words("a # b {\nc // d\ne"), ["a", "c", "e"]);
        assert_eq!(words("#"), Vec::<&str>::new());
    }

    #[test]
    fn paths_may_hold_comment_signs() {
        assert_eq!(words("dir//file#1.obj"), ["dir//file#1.obj"]);
    }

    #[test]
    fn spans_count_bytes() {
        let token = Lexer::new("\u{feff}é wort").nth(1).unwrap();
        assert_eq!((token.text, token.span), ("wort", Span { start: 6, end: 10 }));
    }
}
