//! The grammar that all blocks share: `Name { key value ... }`, keys in any order, each at most once.

use super::description::At;
use super::lexer::{Lexer, Token, is_quote};
use crate::error::{Error, SourceText, Span, cut_short, probably_meant};
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

/// Words of related formats (later versions of the course, other courses). They get an error message of their own.
const FOREIGN_WORDS: &[&str] = &[
    "OrthographicCamera",
    "OrthogonalCamera",
    "SpotLight",
    "AreaLight",
    "AmbientLight",
    "refractionIndex",
    "indexOfRefraction",
    "transparentColor",
    "reflectiveColor",
    "exponent",
    "texture",
    "Checkerboard",
    "Noise",
    "Marble",
    "Wood",
    "Glass",
    "Cone",
    "Cylinder",
    "Torus",
    "Cube",
    "Box",
    "SimpleCamera",
    "fov",
    "emissionColor",
];

/// The longest name in bytes that a hint shows.
const LONGEST_NAME: usize = 200;

/// Reads tokens and values.
pub(super) struct Fields<'a> {
    pub source: &'a Arc<SourceText>,
    pub lexer: Lexer<'a>,
    /// The place of the last name of a file or folder.
    last_name: Span,
}

impl<'a> Fields<'a> {
    pub fn new(source: &'a Arc<SourceText>) -> Self {
        Self { source, lexer: Lexer::new(&source.text), last_name: Span::default() }
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
        self.lexer.next().ok_or_else(|| {
            let end = self.lexer.end();
            self.error(end, format!("expected {}, found the end of the file", expected(self)))
        })
    }

    pub fn open_brace(&mut self, block: &str) -> Result<(), Error> {
        let token = self.next(|_| format!("'{{' after '{block}'"))?;
        if token.text == "{" {
            return Ok(());
        }
        let message = format!("expected '{{' after '{block}', found '{}'", cut_short(token.text));
        Err(self.error(token.span, message))
    }

    /// Reads a word as the value of `key`. A brace is an error.
    pub fn word(&mut self, key: &str, expected: &str) -> Result<Token<'a>, Error> {
        let token = self.next(|_| format!("{expected} for '{key}'"))?;
        if matches!(token.text, "{" | "}") {
            let message = format!("expected {expected} for '{key}', found '{}'", cut_short(token.text));
            return Err(self.error(token.span, message));
        }
        Ok(token)
    }

    /// Reads a finite decimal number. Unlike the starter's `scanf`, it refuses `nan`, `inf` and hexadecimal numbers,
    /// and numbers too large for an `f64`.
    pub fn number(&mut self, key: &str) -> Result<f64, Error> {
        let token = self.word(key, "a number")?;
        let starts_like_a_number =
            token.text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
        match token.text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) if starts_like_a_number && token.text.contains(|c: char| c.is_ascii_digit()) => {
                Err(self.error(token.span, format!("the number for '{key}' is too large (at most 1.79e308)")))
            }
            Ok(_) => {
                let message = format!("expected a finite number for '{key}', found '{}'", cut_short(token.text));
                Err(self.error(token.span, message))
            }
            Err(_) => {
                let message = format!("expected a number for '{key}', found '{}'", cut_short(token.text));
                Err(self.error(token.span, message))
            }
        }
    }

    pub fn vector3(&mut self, key: &str) -> Result<Vector3, Error> {
        let mut component = || self.number(key).map(|number| number as Real);
        Ok(Vector3::new(component()?, component()?, component()?))
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
        match token.text.parse::<u32>() {
            Ok(value) if value <= i32::MAX as u32 => Ok(value),
            _ => {
                let message = format!(
                    "expected a whole number from 0 to 2147483647 for '{key}', found '{}'",
                    cut_short(token.text)
                );
                Err(self.error(token.span, message))
            }
        }
    }

    /// Reads `{ key value ... }`; calls `read` after each key to read its value.
    ///
    /// # Errors
    /// [`Error::Source`] for an unknown, repeated or missing key, and the errors of `read`.
    pub fn block(
        &mut self,
        name: Token<'a>,
        keys: &[Key],
        mut read: impl FnMut(&mut Self, &'static str, Span) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.open_brace(name.text)?;
        let mut seen: Vec<(&str, Span)> = Vec::new();
        loop {
            let token =
                self.next(|fields| format!("'}}' to end '{}' of line {}", name.text, fields.line(name.span)))?;
            if token.text == "}" {
                break;
            }
            let Some(&(key, occurs)) = keys.iter().find(|(key, _)| *key == token.text) else {
                let error = self.unknown_word(token, &format!("'{}'", name.text), keys.iter().map(|key| key.0));
                return Err(match self.split_name(token) {
                    Some(whole) => error.with_note(format!("a name with spaces stands in quotes: \"{whole}\"")),
                    None => error,
                });
            };
            if occurs != Occurs::AnyNumber {
                self.refuse_repetition(&mut seen, key, token.span)?;
            }
            read(self, key, token.span)?;
        }
        let missing = |key: &&Key| key.1 == Occurs::Once && !seen.iter().any(|(name, _)| *name == key.0);
        match keys.iter().find(missing) {
            Some((key, _)) => Err(self.error(name.span, format!("this '{}' has no '{key}'", name.text))),
            None => Ok(()),
        }
    }

    /// The name that was probably meant where `token` stands right behind a name without quotes.
    fn split_name(&self, token: Token<'a>) -> Option<&'a str> {
        let text = &self.source.text;
        let (start, end) = (self.last_name.start, self.last_name.end);
        let between = text.get(end..token.span.start)?;
        if end == 0 || between.contains(|c| c != ' ' && c != '\t') || text[start..].starts_with(is_quote) {
            return None;
        }
        let rest = &text[start..];
        let whole = rest[..rest.find(['}', '\n']).unwrap_or(rest.len())].trim_end();
        (whole.len() <= LONGEST_NAME).then_some(whole)
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

    /// Makes the error for a word that is unknown in `place`.
    pub fn unknown_word<'k>(
        &self,
        token: Token<'a>,
        place: &str,
        known: impl Iterator<Item = &'k str> + Clone,
    ) -> Error {
        if FOREIGN_WORDS.contains(&token.text) {
            let message = format!("this scene format has no '{}'", token.text);
            return self.error(token.span, message).with_note(format!("{place} knows {}", listed(known)));
        }
        if matches!(token.text, "{" | "}") {
            let message = format!("'{}' does not belong here: {place} knows {}", token.text, listed(known));
            return self.error(token.span, message);
        }
        let error = self.error(token.span, format!("{place} has no '{}'", cut_short(token.text)));
        match probably_meant(token.text, known.clone()) {
            Some(word) => error.with_note(format!("did you mean '{word}'?")),
            None => error.with_note(format!("it knows {}", listed(known))),
        }
    }
}

fn listed<'k>(words: impl Iterator<Item = &'k str>) -> String {
    words.collect::<Vec<_>>().join(", ")
}

/// Checks `numLights` and similar counts against the number of items found.
#[derive(Default)]
pub(super) struct Count {
    said: u32,
    span: Span,
}

impl Count {
    pub fn read(&mut self, fields: &mut Fields, key: &str, span: Span) -> Result<(), Error> {
        self.said = fields.count(key)?;
        self.span = span;
        Ok(())
    }

    pub fn check(&self, fields: &Fields, key: &str, found: usize, item: &str) -> Result<(), Error> {
        if self.said as usize == found {
            return Ok(());
        }
        let plural = if found == 1 { "" } else { "s" };
        let message = format!("'{key}' says {}, but {found} {item}{plural} stand here", self.said);
        Err(fields.error(self.span, message.replace("1 object stand ", "1 object stands ")))
    }
}
