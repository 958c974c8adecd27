//! The grammar that all blocks share: `Name { key value ... }`, keys in any order, each at most once.

use super::description::At;
use super::lexer::{Lexer, Token, is_quote};
use crate::error::{Error, SourceText, Span, counted, cut_short};
use std::sync::Arc;
use vecmath::{Real, Vector3};

/// How often a key may stand in its block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Occurs {
    Once,
    AtMostOnce,
    AnyNumber,
}

/// A key of a block.
pub(super) type Key = (&'static str, Occurs);

/// Reads tokens and values.
pub(super) struct Fields<'a> {
    pub source: &'a Arc<SourceText>,
    pub lexer: Lexer<'a>,
    /// The place of the last name of a file or folder.
    pub last_name: Span,
    /// The names of the blocks that are open, the outermost first.
    pub open: Vec<Token<'a>>,
    /// Mistakes after which parsing went on.
    pub mistakes: Vec<Error>,
    /// Whether nothing can be said about the text behind the last mistake.
    pub is_lost: bool,
}

impl<'a> Fields<'a> {
    pub fn new(source: &'a Arc<SourceText>) -> Self {
        Self {
            source,
            lexer: Lexer::new(&source.text),
            last_name: Span::default(),
            open: Vec::new(),
            mistakes: Vec::new(),
            is_lost: false,
        }
    }

    pub fn error(&self, span: Span, message: impl Into<String>) -> Error {
        self.source.error(span, message)
    }

    pub fn line(&self, span: Span) -> usize {
        self.source.line_and_column(span.start).0
    }

    /// Returns the next token, or an error that says what was expected instead of the end of the file. `expected` is
    /// called only for the error, because formatting a text for every token would take longer than parsing.
    pub fn next(&mut self, expected: impl FnOnce(&Self) -> String) -> Result<Token<'a>, Error> {
        match self.lexer.next() {
            Some(token) => Ok(token),
            None => {
                let expected = expected(self);
                Err(self.end_of_file(&expected))
            }
        }
    }

    /// Reads the brace that opens a block. Where there is none, parsing goes on as if it stood there.
    pub fn open_brace(&mut self, block: Token<'a>) -> Result<(), Error> {
        let token = self.next(|_| format!("'{{' after '{}'", block.text))?;
        self.open.push(block);
        if token.text == "{" {
            return Ok(());
        }
        let error = self.mistyped(token).unwrap_or_else(|| {
            let message = format!("expected '{{' after '{}', found '{}'", block.text, cut_short(token.text));
            self.error(token.span, message)
        });
        if token.text.contains(char::is_alphanumeric) || token.text == "}" {
            self.lexer.put_back(token);
        }
        self.note(error)
    }

    /// Leaves the innermost block.
    pub fn close(&mut self) {
        self.open.pop();
    }

    /// Returns the next token of the innermost block.
    pub fn next_in_block(&mut self) -> Result<Token<'a>, Error> {
        self.next(|fields| fields.missing_brace(fields.source.text.len()))
    }

    /// Returns a block as messages name it.
    pub fn named(&self, block: Token) -> String {
        format!("the '{}' of line {}", block.text, self.line(block.span))
    }

    /// Makes the error for a file that ends too soon.
    fn end_of_file(&mut self, expected: &str) -> Error {
        self.is_lost = true;
        let error = self.error(self.lexer.end(), format!("expected {expected}, found the end of the file"));
        match self.open.as_slice() {
            [] | [_] => error,
            open if self.unended(self.source.text.len()).as_ref() != open.last() => error,
            open => {
                /// The innermost ones are named.
                const NAMED: usize = 8;
                let others = open.len().saturating_sub(NAMED);
                let named = open[others..].iter().map(|block| self.named(*block));
                let blocks: Vec<String> =
                    (others > 0).then(|| format!("{others} others")).into_iter().chain(named).collect();
                error.with_note(format!("these blocks have no '}}': {}", blocks.join(", ")))
            }
        }
    }

    /// Reads a word as the value of `key`. A brace is an error.
    pub fn word(&mut self, key: &str, expected: &str) -> Result<Token<'a>, Error> {
        let token = self.next(|_| format!("{expected} for '{key}'"))?;
        if matches!(token.text, "{" | "}") || token.text.chars().all(|c| matches!(c, '=' | ':')) {
            self.lexer.put_back(token);
            let message = format!("expected {expected} for '{key}', found '{}'", token.text);
            return Err(self.mistyped(token).unwrap_or_else(|| self.error(token.span, message)));
        }
        Ok(token)
    }

    /// Reads a finite decimal number. Unlike the starter's `scanf`, it refuses `nan`, `inf` and hexadecimal numbers,
    /// and numbers too large for an `f64`.
    pub fn number(&mut self, key: &str) -> Result<f64, Error> {
        self.numbers::<1>(key).map(|[number]| number)
    }

    /// Reads as many such numbers.
    pub fn numbers<const N: usize>(&mut self, key: &str) -> Result<[f64; N], Error> {
        let mut numbers = [0.0; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            let token = self.next(|_| format!("a number for '{key}'"))?;
            let parsed = |text: &str| text.parse().ok().filter(|value| f64::is_finite(*value));
            *number = match parsed(token.text).or_else(|| parsed(self.lexer.put_back_comment(token)?)) {
                Some(value) => value,
                None => return Err(self.no_number(token, key, index, N)),
            };
        }
        Ok(numbers)
    }

    pub fn vector3(&mut self, key: &str) -> Result<Vector3, Error> {
        self.numbers(key).map(|numbers| Vector3::from(numbers.map(|number| number as Real)))
    }

    /// Reads the name of a file or folder: a word, or anything in quotes in one line.
    pub fn path(&mut self, key: &str, expected: &str) -> Result<At<String>, Error> {
        let token = match self.lexer.quoted() {
            Some(token) => token,
            None => self.word(key, expected)?,
        };
        if token.text.is_empty() {
            return Err(self.error(token.span, format!("expected {expected} for '{key}', found an empty name")));
        }
        if self.source.text[token.span.start..].starts_with(is_quote)
            && token.text.len() == token.span.end - token.span.start
        {
            return Err(self.error(token.span, "this name has no closing quote in its line"));
        }
        self.last_name = token.span;
        Ok(At { value: token.text.to_owned(), span: token.span })
    }

    /// Reads a whole number from 0 to 2^31 - 1.
    pub fn count(&mut self, key: &str) -> Result<u32, Error> {
        let token = self.word(key, "a whole number")?;
        let parsed = |text: &str| text.parse::<u32>().ok().filter(|value| *value <= i32::MAX as u32);
        match parsed(token.text).or_else(|| parsed(self.lexer.put_back_comment(token)?)) {
            Some(value) => Ok(value),
            None => {
                self.lexer.put_back(token);
                let found = cut_short(token.text);
                let message = format!("expected a whole number from 0 to 2147483647 for '{key}', found '{found}'");
                Err(self.mistyped(token).unwrap_or_else(|| self.error(token.span, message)))
            }
        }
    }

    /// Reads `{ key value ... }`; calls `read` after each key to read its value. Mistakes in it are noted. Returns whether
    /// there are none.
    ///
    /// # Errors
    /// [`Error::Source`] for a mistake after which nothing can be said about the rest.
    pub fn block(
        &mut self,
        name: Token<'a>,
        keys: &[Key],
        mut read: impl FnMut(&mut Self, &'static str, Span) -> Result<(), Error>,
    ) -> Result<bool, Error> {
        let mistakes = self.mistakes.len();
        self.open_brace(name)?;
        let mut seen: Vec<(&str, Span)> = Vec::new();
        loop {
            let token = self.next_in_block()?;
            if token.text == "}" {
                break;
            }
            let Some(&(key, occurs)) = keys.iter().find(|(key, _)| *key == token.text) else {
                if self.ends_at_unknown_word(token, keys)? {
                    break;
                }
                continue;
            };
            let is_first = match occurs {
                Occurs::AnyNumber => Ok(()),
                Occurs::Once | Occurs::AtMostOnce => self.refuse_repetition(&mut seen, key, token.span),
            };
            if let Err(error) = is_first.and_then(|()| read(self, key, token.span)) {
                self.go_on_after(error, "", &|word| is_key(keys, word))?;
            }
        }
        self.close();
        let missing = |key: &&Key| key.1 == Occurs::Once && !seen.iter().any(|(name, _)| *name == key.0);
        // What is missing may be what is mistyped.
        if self.mistakes.len() == mistakes
            && let Some((key, _)) = keys.iter().find(missing)
        {
            self.note(self.error(name.span, format!("this '{}' has no '{key}'", name.text)))?;
        }
        Ok(self.mistakes.len() == mistakes)
    }

    /// Notes that `key` is at `span`; returns an error if it was seen before.
    pub fn refuse_repetition(
        &self,
        seen: &mut Vec<(&'static str, Span)>,
        key: &'static str,
        span: Span,
    ) -> Result<(), Error> {
        if let Some((_, first)) = seen.iter().find(|(name, _)| *name == key) {
            let (line, first_line) = (self.line(span), self.line(*first));
            let message = format!("a second '{key}' in line {line}: the first one is in line {first_line}");
            return Err(self.error(span, message));
        }
        seen.push((key, span));
        Ok(())
    }
}

/// Returns whether a word is one of these keys.
pub(super) fn is_key(keys: &[Key], word: &str) -> bool {
    keys.iter().any(|key| key.0 == word)
}

/// Checks `numLights` and similar counts against the number of items found.
pub(super) struct Count {
    said: u32,
    span: Span,
    /// The mistakes before the block: after one in it the count says nothing.
    mistakes: usize,
}

impl Count {
    pub fn new(fields: &Fields) -> Self {
        Self { said: 0, span: Span::default(), mistakes: fields.mistakes.len() }
    }

    /// Returns whether no mistake was made in the block.
    pub fn is_clear(&self, fields: &Fields) -> bool {
        fields.mistakes.len() == self.mistakes
    }

    pub fn read(&mut self, fields: &mut Fields, key: &str, span: Span) -> Result<(), Error> {
        self.span = span;
        self.said = fields.count(key)?;
        Ok(())
    }

    pub fn check(&self, fields: &mut Fields, key: &str, found: usize, item: &str) -> Result<(), Error> {
        if self.said as usize == found || !self.is_clear(fields) {
            return Ok(());
        }
        let (found, stand) = (counted(found, item), if found == 1 { "stands" } else { "stand" });
        let message = format!("'{key}' says {}, but {found} {stand} here", self.said);
        fields.note(fields.error(self.span, message))
    }
}
