//! Splits text into tokens: words and braces, each with its place.
//!
//! White space separates words; a brace is always a token by itself. A word that begins with `#` or `//` begins a
//! comment, which ends with its line, and so do these signs behind a number. Names of files may hold them. (This is an
//! extension: the starter's grammar has no comments.)

use crate::error::Span;

/// A word or a brace, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Token<'a> {
    pub text: &'a str,
    pub span: Span,
}

/// Iterates over the tokens of a text.
#[derive(Clone, Debug)]
pub struct Lexer<'a> {
    text: &'a str,
    at: usize,
    /// The first white space outside of ASCII.
    pub foreign_space: Option<usize>,
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a str) -> Self {
        // Some editors on Windows write a byte order mark first.
        let at = if text.starts_with('\u{feff}') { 3 } else { 0 };
        Self { text, at, foreign_space: None }
    }

    /// Returns the place after the last character of the text.
    pub fn end(&self) -> Span {
        let end = self.text.trim_end().len();
        Span { start: end, end }
    }

    /// Goes back to the comment that begins within this token, if one does. Returns what stands before it.
    pub fn put_back_comment(&mut self, token: Token<'a>) -> Option<&'a str> {
        let word = before_comment(token.text)?;
        self.at = token.span.start + word.len();
        Some(word)
    }

    /// Goes back, so that this token comes next again.
    pub fn put_back(&mut self, token: Token) {
        self.at = token.span.start;
    }

    /// Reads a name in quotes, if one stands here: up to the next such quote in the same line. Its place includes the
    /// quotes.
    pub fn quoted(&mut self) -> Option<Token<'a>> {
        self.skip_blanks_and_comments();
        let rest = &self.text[self.at..];
        let quote = rest.chars().next().filter(|&c| is_quote(c))?;
        let line = &rest[1..rest.find('\n').unwrap_or(rest.len())];
        let length = line.find(quote)?;
        let start = self.at;
        self.at += length + 2;
        Some(Token { text: &line[..length], span: Span { start, end: self.at } })
    }

    fn skip_blanks_and_comments(&mut self) {
        let bytes = self.text.as_bytes();
        loop {
            while bytes.get(self.at).is_some_and(|&byte| is_blank(byte)) {
                self.at += 1;
            }
            let rest = &self.text[self.at..];
            let is_foreign =
                bytes.get(self.at).is_some_and(|&byte| byte >= 128) && rest.starts_with(char::is_whitespace);
            if is_foreign {
                self.foreign_space.get_or_insert(self.at);
            }
            self.at += match bytes.get(self.at) {
                Some(b'#') => rest.find('\n').unwrap_or(rest.len()),
                Some(b'/') if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
                _ if is_foreign => rest.len() - rest.trim_start().len(),
                _ => return,
            };
        }
    }

    /// The length in bytes of the word or brace that begins here; `None` at the end.
    fn token_length(&self) -> Option<usize> {
        let rest = &self.text[self.at..];
        if is_brace(*rest.as_bytes().first()?) {
            return Some(1);
        }
        // Nearly all words are ASCII, and bytes are read several times faster than characters.
        match rest.bytes().position(|byte| is_blank(byte) || is_brace(byte) || byte >= 128) {
            Some(length) if rest.as_bytes()[length] < 128 => Some(length),
            Some(_) => rest.find(|c: char| c.is_whitespace() || matches!(c, '{' | '}')).or(Some(rest.len())),
            None => Some(rest.len()),
        }
    }
}

/// Returns whether a byte is ASCII white space.
fn is_blank(byte: u8) -> bool {
    matches!(byte, b'\t'..=b'\r' | b' ')
}

fn is_brace(byte: u8) -> bool {
    matches!(byte, b'{' | b'}')
}

/// Returns what stands before the sign of a comment within a word.
pub fn before_comment(word: &str) -> Option<&str> {
    let end = word.find('#').into_iter().chain(word.find("//")).min()?;
    Some(&word[..end])
}

/// Whether a character opens and closes a name.
pub fn is_quote(c: char) -> bool {
    matches!(c, '"' | '\'')
}

impl<'a> Iterator for Lexer<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        self.skip_blanks_and_comments();
        let (start, length) = (self.at, self.token_length()?);
        self.at += length;
        Some(Token { text: &self.text[start..self.at], span: Span { start, end: self.at } })
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
    fn all_white_space_of_unicode_separates() {
        assert_eq!(words("a\u{a0}ä\u{2003}{\u{b}b\u{3000}# ä\n\u{85}ö}"), ["a", "ä", "{", "b", "ö", "}"]);
    }

    #[test]
    fn paths_may_hold_comment_signs() {
        assert_eq!(words("dir//file#1.obj"), ["dir//file#1.obj"]);
    }

    #[test]
    fn names_in_quotes_may_hold_anything() {
        for (text, name) in [("  \"a b # {}\" c", "a b # {}"), ("# x\n'say \"a\"'", "say \"a\""), ("\"\"", "")] {
            assert_eq!(Lexer::new(text).quoted().unwrap().text, name, "{text}");
        }
        let mut lexer = Lexer::new("'é' f");
        assert_eq!(lexer.quoted().unwrap().span, Span { start: 0, end: 4 });
        assert_eq!(lexer.quoted(), None);
        assert_eq!(lexer.next().unwrap().text, "f");
        assert_eq!(Lexer::new("\"a\nb\"").quoted(), None);
    }

    #[test]
    fn spans_count_bytes() {
        let token = Lexer::new("\u{feff}é wort").nth(1).unwrap();
        assert_eq!((token.text, token.span), ("wort", Span { start: 6, end: 10 }));
    }
}
