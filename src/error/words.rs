//! Words and numbers as messages show them.

use std::borrow::Cow;

/// The longest word that a message shows whole, in characters. Names and numbers are shorter.
const LONGEST_WORD: usize = 300;

/// Returns `word` as a message shows it: a file may hold words of any length.
pub fn cut_short(word: &str) -> Cow<'_, str> {
    match word.char_indices().nth(LONGEST_WORD) {
        None => Cow::Borrowed(word),
        Some((end, _)) => Cow::Owned(format!("{}...", &word[..end])),
    }
}

/// Returns a text as a terminal may show it: a control character, which the name of a file may hold, as its symbol. Ends of lines
/// and tabs stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    /// Unicode has pictures of the first 32 characters, and of the last one of ASCII.
    const PICTURES: u32 = 0x2400;
    let symbol = |c: char| match u32::from(c) {
        code @ 0..0x20 => char::from_u32(PICTURES + code),
        0x7f => Some('\u{2421}'),
        _ => None,
    };
    let shown = |c| if is_hidden(c) { symbol(c).unwrap_or(char::REPLACEMENT_CHARACTER) } else { c };
    Cow::Owned(text.chars().map(shown).collect())
}

/// Returns the word of `known` that `word` is probably a typing mistake of.
pub fn probably_meant<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A longer word is no typing mistake, and the time for its distance grows with the length.
    if word.chars().nth(LONGEST_WORD).is_some() {
        return None;
    }
    known
        .into_iter()
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase());
            (distance, candidate)
        })
        .filter(|&(distance, candidate)| distance <= candidate.len() / 3)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Returns a number of things, as in `1 light` and `2 lights`.
pub fn counted(count: usize, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// Returns a number as a person would write it: very large and very small ones with an exponent.
pub fn shown_number(number: f64) -> String {
    match number.abs() {
        0.0 | 1e-6..1e15 => number.to_string(),
        _ => format!("{number:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_near_words_are_suggested() {
        assert_eq!(probably_meant("raduis", ["radius", "center"]), Some("radius"));
        assert_eq!(probably_meant("banana", ["radius", "center"]), None);
    }

    #[test]
    fn words_of_any_length_end_soon() {
        let word = "ä".repeat(50_000_000);
        assert_eq!(probably_meant(&word, ["radius", "center"]), None);
        assert_eq!(cut_short(&word), format!("{}...", "ä".repeat(LONGEST_WORD)));
        assert_eq!(cut_short("short"), "short");
    }

    #[test]
    fn control_characters_are_seen() {
        assert_eq!(visible("\x1b[31ma\tb\n\x7f\u{9b}"), "␛[31ma\tb\n␡\u{fffd}");
        assert!(matches!(visible("été\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, -0.5, 123_456.75, 1e-320, -1e40, f64::INFINITY].map(shown_number);
        assert_eq!(shown, ["0", "-0.5", "123456.75", "1e-320", "-1e40", "inf"]);
    }

    #[test]
    fn one_thing_has_no_plural() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "light")), ["0 lights", "1 light", "2 lights"]);
    }
}
