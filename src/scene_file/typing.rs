//! Words that were typed with other characters than the grammar has: commas, equal signs, and characters of a Chinese
//! keyboard that look like ASCII.

use super::lexer::is_quote;
use crate::error::{Span, cut_short};

/// What is wrong with a word, and where.
pub(super) struct Mistyped {
    pub span: Span,
    pub message: String,
}

/// A character that stands for one of ASCII, and what it is called.
fn look_alike(c: char) -> Option<(char, &'static str)> {
    /// The distance of full-width characters from those of ASCII.
    const FULL_WIDTH: u32 = 0xfee0;
    let typed = match c {
        '\u{ff01}'..='\u{ff5e}' => {
            return Some((char::from_u32(c as u32 - FULL_WIDTH)?, "a full-width character"));
        }
        '\u{2212}' => ('-', "a minus sign of typesetting"),
        '\u{2010}'..='\u{2015}' => ('-', "a dash"),
        '\u{201c}' | '\u{201d}' | '\u{201e}' => ('"', "a curly quote"),
        '\u{2018}' | '\u{2019}' => ('\'', "a curly quote"),
        '\u{3002}' => ('.', "a Chinese full stop"),
        '\u{3001}' => (',', "a Chinese comma"),
        '\u{300a}' | '\u{3008}' => ('<', "a Chinese bracket"),
        '\u{300b}' | '\u{3009}' => ('>', "a Chinese bracket"),
        _ => return None,
    };
    Some(typed)
}

/// Returns what to say about a word of the grammar that holds a character outside of ASCII.
pub(super) fn foreign_character(word: &str, span: Span) -> Option<Mistyped> {
    let (at, found) = word.char_indices().find(|(_, c)| !c.is_ascii())?;
    let span = Span { start: span.start + at, end: span.start + at + found.len_utf8() };
    let code = format!("U+{:04X}", found as u32);
    let message = match look_alike(found) {
        Some((typed, kind)) => match PUNCTUATION.iter().find(|known| known.0 == typed && !is_quote(typed)) {
            Some((_, name)) => format!("'{found}' ({code}) is {kind}, and scenes have no {name}"),
            None => format!("'{found}' ({code}) is {kind}: type '{typed}'"),
        },
        None if found.is_alphanumeric() => {
            format!("'{found}' ({code}) stands in a word that has ASCII letters only")
        }
        None => format!("there is a character that scenes do not have here: {code}"),
    };
    Some(Mistyped { span, message })
}

/// Returns a word with ASCII in the place of what looks like it.
pub(super) fn in_ascii(word: &str) -> String {
    word.chars().map(|c| look_alike(c).map_or(c, |typed| typed.0)).collect()
}

/// Characters that other formats set around words and numbers, and what they are called.
const PUNCTUATION: [(char, &str); 12] = [
    (',', "commas"),
    (';', "semicolons"),
    ('=', "equal signs"),
    (':', "colons"),
    ('(', "parentheses"),
    (')', "parentheses"),
    ('[', "brackets"),
    (']', "brackets"),
    ('<', "angle brackets"),
    ('>', "angle brackets"),
    ('"', "quotes around words"),
    ('\'', "quotes around words"),
];

fn is_punctuation(c: char) -> bool {
    PUNCTUATION.iter().any(|known| known.0 == c)
}

/// Iterates over the parts of a text that stand between punctuation and white space.
fn parts(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| is_punctuation(c) || c.is_whitespace()).filter(|part| !part.is_empty())
}

/// Returns a text with ASCII in the place of what looks like it, and without punctuation.
pub(super) fn cleaned(text: &str) -> String {
    parts(&in_ascii(text)).collect::<Vec<_>>().join(" ")
}

/// Returns how many numbers a word holds, if it holds nothing else besides characters that are mistyped.
pub(super) fn numbers_in(word: &str) -> Option<usize> {
    let ascii = in_ascii(word);
    parts(&ascii).all(is_number).then(|| parts(&ascii).count())
}

/// Returns the numbers from 0 to 1 of a colour as `#336699` or `#369`: red, green and blue.
pub(super) fn hexadecimal_color(word: &str) -> Option<String> {
    let digits = word.strip_prefix('#').filter(|digits| [3, 6].contains(&digits.len()))?;
    let width = digits.len() / 3;
    let most = if width == 1 { 15.0 } else { 255.0 };
    let number = |part: usize| {
        let value = u8::from_str_radix(digits.get(part * width..(part + 1) * width)?, 16).ok()?;
        Some(((f64::from(value) / most * 1000.0).round() / 1000.0).to_string())
    };
    Some([number(0)?, number(1)?, number(2)?].join(" "))
}

/// Returns what to say about a text with punctuation, if without it it is made of parts that are all `right`.
pub(super) fn punctuated(word: &str, right: impl Fn(&str) -> bool) -> Option<String> {
    let mut kinds: Vec<&str> =
        PUNCTUATION.iter().filter(|known| word.contains(known.0)).map(|known| known.1).collect();
    kinds.dedup();
    let parts: Vec<&str> = parts(word).collect();
    if kinds.is_empty() || !parts.iter().all(|part| right(part)) {
        return None;
    }
    let (word, kind) = (cut_short(word), kinds.join(" or "));
    Some(match parts.is_empty() {
        true => format!("scenes have no {kind}: leave out '{word}'"),
        false => {
            format!("scenes have no {kind}: write '{}' instead of '{word}'", cut_short(&parts.join(" ")))
        }
    })
}

/// Returns a number with a decimal point where it has a comma between two digits.
pub(super) fn with_decimal_point(word: &str) -> Option<String> {
    if let Some((whole, fraction)) = word.split_once(',') {
        let is_between =
            whole.ends_with(|c: char| c.is_ascii_digit()) && fraction.starts_with(|c: char| c.is_ascii_digit());
        return Some(format!("{whole}.{fraction}")).filter(|number| is_between && is_number(number));
    }
    is_number(word).then(|| word.to_owned())
}

/// Returns whether a word is a finite number as scenes have it.
pub(super) fn is_number(word: &str) -> bool {
    word.parse().is_ok_and(f64::is_finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_look_like_ascii_are_named() {
        let said = |word: &str| foreign_character(word, Span { start: 10, end: 10 + word.len() }).unwrap();
        for (word, message, start) in [
            ("\u{2212}1", "'\u{2212}' (U+2212) is a minus sign of typesetting: type '-'", 10),
            ("1\u{ff10}", "'\u{ff10}' (U+FF10) is a full-width character: type '0'", 11),
            ("Sphere\u{ff5b}", "'\u{ff5b}' (U+FF5B) is a full-width character: type '{'", 16),
            ("\u{441}enter", "'\u{441}' (U+0441) stands in a word that has ASCII letters only", 10),
            ("a\u{200b}b", "there is a character that scenes do not have here: U+200B", 11),
        ] {
            assert_eq!((said(word).message.as_str(), said(word).span.start), (message, start), "{word}");
        }
        assert!(foreign_character("1,", Span::default()).is_none());
        assert_eq!(in_ascii("\u{ff0d}\u{ff11}\u{3002}5"), "-1.5");
    }

    #[test]
    fn punctuation_is_named_where_it_is_all_that_is_wrong() {
        for (word, message) in [
            ("0,", "no commas: write '0' instead of '0,'"),
            ("(1,2,3)", "no commas or parentheses: write '1 2 3' instead of '(1,2,3)'"),
            ("30;", "no semicolons: write '30' instead of '30;'"),
            ("=", "no equal signs: leave out '='"),
            ("0.2, 0, 0.6;", "no commas or semicolons: write '0.2 0 0.6' instead of '0.2, 0, 0.6;'"),
            ("=1", "no equal signs: write '1' instead of '=1'"),
        ] {
            assert_eq!(punctuated(word, is_number), Some(format!("scenes have {message}")), "{word}");
        }
        assert_eq!(punctuated("one,", is_number), None);
        assert_eq!(punctuated("1/2", is_number), None);
    }
}
