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
    fn one_thing_has_no_plural() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "light")), ["0 lights", "1 light", "2 lights"]);
    }
}
