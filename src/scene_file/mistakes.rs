//! What is said about mistakes in a scene file, and how parsing goes on after one.

use super::fields::{Fields, Key, is_key};
use super::lexer::{Lexer, Token, before_comment, is_quote};
use super::typing::{
    cleaned, foreign_character, hexadecimal_color, in_ascii, is_number, numbers_in, punctuated, with_decimal_point,
};
use super::words::{BLOCKS, belongs_into, equivalent};
use crate::error::{Error, MOST_SHOWN, Span, counted, cut_short, probably_meant};
use crate::file_path::without_foreign_quotes;

/// The longest name in bytes that a hint shows.
const LONGEST_NAME: usize = 200;

impl<'a> Fields<'a> {
    /// Keeps a mistake, so that others can be found, too. What is said already is not said again.
    ///
    /// # Errors
    /// The mistake itself, if nothing can be said about what comes after it, or if there are enough.
    pub fn note(&mut self, error: Error) -> Result<(), Error> {
        let said = error.to_string();
        if self.mistakes.iter().any(|known| known.to_string() == said) {
            return Ok(());
        }
        self.is_lost |= self.mistakes.len() + 1 == MOST_SHOWN;
        if self.is_lost {
            return Err(error);
        }
        self.mistakes.push(error);
        Ok(())
    }

    /// Marks an error as one after which nothing can be said about the rest of the file.
    pub fn lost(&mut self, error: Error) -> Error {
        self.is_lost = true;
        error
    }

    /// Notes a mistake, and skips what it leaves over in the innermost block: `wrong` is the word that was read last.
    pub fn go_on_after(
        &mut self,
        error: Error,
        wrong: &str,
        is_known: &dyn Fn(&str) -> bool,
    ) -> Result<(), Error> {
        self.note(error)?;
        let mut depth = depth_behind(wrong);
        while let Some(token) = self.lexer.next() {
            let is_known = |word| is_known(word) || self.belongs_around(word);
            if depth == 0 && (token.text == "}" || is_known(token.text)) {
                self.lexer.put_back(token);
                break;
            }
            depth = (depth + depth_behind(token.text)).max(0);
        }
        Ok(())
    }

    /// Returns the hint about white space outside of ASCII, if there is any.
    pub fn foreign_space(&self) -> Option<String> {
        let at = self.lexer.foreign_space?;
        let found = self.source.text[at..].chars().next()?;
        let name = if found == '\u{3000}' { "full-width space" } else { "space" };
        let place = self.source.location(Span { start: at, end: at });
        Some(format!(
            "{place}: a {name} (U+{:04X}) stands here, which other programs may not take for one: type ' '",
            found as u32
        ))
    }

    /// Skips what may be a list of numbers, and a brace behind it.
    pub fn skip_numbers(&mut self) {
        while let Some(token) = self.lexer.next() {
            if token.text == "}" {
                break;
            }
            if token.text == "{" || token.text.starts_with(|c: char| c.is_ascii_alphabetic()) {
                self.lexer.put_back(token);
                break;
            }
        }
    }

    /// Returns whether a word may stand in a block around the innermost one.
    fn belongs_around(&self, word: &str) -> bool {
        let Some((_, around)) = self.open.split_last() else { return false };
        BLOCKS.contains(&word) || around.iter().any(|block| belongs_into(block.text, word))
    }

    /// Notes the mistake that an unknown word in the innermost block is. Returns whether the block ends before it,
    /// because its brace is missing.
    pub fn ends_at_unknown_word(&mut self, token: Token<'a>, keys: &[Key]) -> Result<bool, Error> {
        let known = || keys.iter().map(|key| key.0);
        if self.ends_before(token, &|word| is_key(keys, word))? {
            return Ok(true);
        }
        let place = format!("'{}'", self.open.last().map_or("", |block| block.text));
        let error = if self.belongs_around(token.text) {
            self.error(token.span, format!("'{}' does not belong into {place}", token.text))
        } else {
            self.unknown_word(token, &place, known())
        };
        let error = match self.split_name(token) {
            Some(whole) => error.with_note(format!("a name with spaces stands in quotes: \"{whole}\"")),
            None => error,
        };
        self.go_on_after(error, token.text, &|word| is_key(keys, word))?;
        Ok(false)
    }

    /// Returns whether the innermost block ends before a word that stands in one around it, because its brace is missing,
    /// or with a character that looks like one. That mistake is then noted, and the word is read again.
    pub fn ends_before(&mut self, token: Token<'a>, is_known: &dyn Fn(&str) -> bool) -> Result<bool, Error> {
        if let (Some(error), "}") = (self.foreign(token), in_ascii(token.text).as_str()) {
            self.note(error)?;
            return Ok(true);
        }
        if !self.belongs_around(token.text) || self.block_goes_on(is_known) {
            return Ok(false);
        }
        self.lexer.put_back(token);
        let message = format!("expected {}, found '{}'", self.missing_brace(token.span.start), token.text);
        self.note(self.error(token.span, message))?;
        Ok(true)
    }

    /// Returns whether a word of the innermost block, or its end, comes before the next block.
    fn block_goes_on(&self, is_known: &dyn Fn(&str) -> bool) -> bool {
        let ends = |token: &Token| matches!(token.text, "{" | "}") || is_known(token.text);
        self.lexer.clone().find(ends).is_some_and(|token| token.text != "{")
    }

    /// Makes the error for a word that is unknown in `place`.
    pub fn unknown_word<'k>(
        &self,
        token: Token<'a>,
        place: &str,
        known: impl Iterator<Item = &'k str> + Clone,
    ) -> Error {
        if matches!(token.text, "{" | "}") {
            let message = format!("'{}' does not belong here: {place} knows {}", token.text, listed(known));
            return self.error(token.span, message);
        }
        if let Some(error) = self.foreign(token) {
            return error;
        }
        if let Some(word) = before_comment(token.text).filter(|word| known.clone().any(|known| known == *word)) {
            let sign = if token.text[word.len()..].starts_with('#') { "#" } else { "//" };
            let message = format!("a comment begins with a space before '{sign}': write '{word} {sign}'");
            return self.error(token.span, message);
        }
        if let Some(message) = self.one_too_many(token) {
            return self.error(token.span, message);
        }
        if let Some(message) =
            punctuated(token.text, |part| is_number(part) || known.clone().any(|word| word == part))
        {
            return self.error(token.span, message);
        }
        if let Some(advice) = equivalent(token.text) {
            let message = format!("this scene format has no '{}'", token.text);
            return self.error(token.span, message).with_note(advice);
        }
        let error = self.error(token.span, format!("{place} has no '{}'", cut_short(token.text)));
        match probably_meant(token.text, known.clone()) {
            Some(word) => error.with_note(format!("did you mean '{word}'?")),
            None => error.with_note(format!("it knows {}", listed(known))),
        }
    }

    /// Makes the error for a number that follows all numbers of a key.
    fn one_too_many(&self, token: Token) -> Option<String> {
        if !is_number(token.text) {
            return None;
        }
        let before = Lexer::new(&self.source.text).take_while(|other| other.span.start < token.span.start);
        let (mut key, mut numbers) = (None, 0);
        for other in before {
            (key, numbers) = if is_number(other.text) { (key, numbers + 1) } else { (Some(other.text), 0) };
        }
        let key = key.filter(|key| numbers > 0 && !matches!(*key, "{" | "}"))?;
        Some(format!("'{}' takes {}, and this is {}", cut_short(key), counted(numbers, "number"), nth(numbers)))
    }

    /// Makes the error for a word in the place of a number: the one with this `index` of the `count` numbers of `key`.
    pub fn no_number(&mut self, token: Token<'a>, key: &str, index: usize, count: usize) -> Error {
        self.lexer.put_back(token);
        if let Some(error) = self.decimal_commas(count - index) {
            return error;
        }
        if let Some(error) = self.mistyped(token) {
            let numbers = self.numbers_in_line(count - index);
            return numbers.and_then(|numbers| self.mistyped(numbers)).unwrap_or(error);
        }
        if count == 3
            && index == 0
            && let Some(error) = self.color_in_comment(token, key)
        {
            return error;
        }
        let (found, is_a_word) =
            (cut_short(token.text), !token.text.starts_with(|c: char| "+-.0123456789".contains(c)));
        let message = match token.text.parse::<f64>() {
            Ok(_) if !is_a_word && token.text.contains(|c: char| c.is_ascii_digit()) => {
                format!("the number for '{key}' is too large (at most 1.79e308)")
            }
            Ok(_) => format!("expected a finite number for '{key}', found '{found}'"),
            Err(_) if index > 0 && is_a_word => {
                format!(
                    "'{key}' takes {count} numbers, and '{found}' stands in the place of the {}",
                    ordinal(index + 1)
                )
            }
            Err(_) => format!("expected a number for '{key}', found '{found}'"),
        };
        self.error(token.span, message)
    }

    /// Makes the error for `count` numbers with a comma in the place of a decimal point, in one line.
    fn decimal_commas(&self, count: usize) -> Option<Error> {
        let tokens: Vec<Token> = self.lexer.clone().take(count).collect();
        let (first, last) = (tokens.first()?.span, tokens.last()?.span);
        let text = self.source.text.get(first.start..last.end)?;
        let right = tokens.iter().map(|token| with_decimal_point(token.text)).collect::<Option<Vec<_>>>()?;
        if tokens.len() < count || text.contains('\n') || !text.contains(',') {
            return None;
        }
        let span = Span { start: first.start, end: last.end };
        let message =
            format!("scenes have no commas: write '{}' instead of '{}'", right.join(" "), cut_short(text));
        Some(self.error(span, message))
    }

    /// Makes the error for a colour as `#336699` between `key` and the word `next`.
    fn color_in_comment(&self, next: Token, key: &str) -> Option<Error> {
        let text = &self.source.text[..next.span.start];
        let after_key = Lexer::new(text).last()?.span.end;
        let typed = text[after_key..].split_whitespace().next()?;
        let numbers = hexadecimal_color(typed)?;
        let start = after_key + text[after_key..].find(typed)?;
        let message = format!("'#' begins a comment, and '{key}' takes 3 numbers");
        let error = self.error(Span { start, end: start + typed.len() }, message);
        Some(error.with_note(format!("write '{numbers}' instead of '{typed}'")))
    }

    /// Reads up to `count` numbers in one line, also mistyped ones, so that one message can be about all.
    fn numbers_in_line(&mut self, count: usize) -> Option<Token<'a>> {
        let text = &self.source.text;
        let mut all: Option<Span> = None;
        let mut found = 0;
        while found < count {
            let Some(token) = self.lexer.next() else { break };
            let start = all.map_or(token.span.start, |all| all.start);
            match numbers_in(token.text) {
                Some(more) if !text[start..token.span.end].contains(['\n', '#', '/']) => {
                    found += more;
                    all = Some(Span { start, end: token.span.end });
                }
                _ => {
                    self.lexer.put_back(token);
                    break;
                }
            }
        }
        all.map(|span| Token { text: &text[span.start..span.end], span })
    }

    /// Makes the error for a number, or what stands in its place, that is typed with the wrong characters.
    pub fn mistyped(&self, token: Token) -> Option<Error> {
        if let Some(error) = self.foreign(token) {
            return Some(error);
        }
        if let Some(number) = token.text.strip_suffix(['f', 'F']).filter(|number| is_number(number)) {
            let message = format!("numbers have no suffix: write '{number}' instead of '{}'", token.text);
            return Some(self.error(token.span, message));
        }
        punctuated(token.text, is_number).map(|message| self.error(token.span, message))
    }

    /// Makes the error for a word with a character that only looks like one of ASCII.
    fn foreign(&self, token: Token) -> Option<Error> {
        let mistyped = foreign_character(token.text, token.span)?;
        let error = self.error(mistyped.span, mistyped.message);
        let right = cleaned(token.text);
        let is_whole = right.is_ascii() && right.len() <= LONGEST_NAME && token.text.chars().count() > 1;
        Some(match is_whole {
            true if right.is_empty() => error.with_note(format!("leave out '{}'", token.text)),
            true => error.with_note(format!("write '{right}' instead of '{}'", token.text)),
            false => error,
        })
    }

    /// The name that was probably meant where `token` stands right behind a name without quotes.
    fn split_name(&self, token: Token<'a>) -> Option<String> {
        let text = &self.source.text;
        let (start, end) = (self.last_name.start, self.last_name.end);
        let between = text.get(end..token.span.start)?;
        if end == 0 || between.contains(|c| c != ' ' && c != '\t') || text[start..].starts_with(is_quote) {
            return None;
        }
        let rest = &text[start..];
        let whole = rest[..rest.find(['}', '\n']).unwrap_or(rest.len())].trim_end();
        (whole.len() <= LONGEST_NAME).then(|| without_foreign_quotes(whole))
    }
}

/// Returns how many blocks a word opens or, below 0, closes: also with characters that look like braces.
fn depth_behind(word: &str) -> i32 {
    let step = |c| match c {
        '{' | '\u{ff5b}' => 1,
        '}' | '\u{ff5d}' => -1,
        _ => 0,
    };
    word.chars().map(step).sum()
}

/// Returns `a 4th` for 3 numbers before.
fn nth(before: usize) -> String {
    let article = if before + 1 == 8 { "an" } else { "a" };
    format!("{article} {}", ordinal(before + 1))
}

fn ordinal(number: usize) -> String {
    let ending = match (number % 100, number % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

pub(super) fn listed<'k>(words: impl Iterator<Item = &'k str>) -> String {
    words.collect::<Vec<_>>().join(", ")
}
