//! Parses just enough of Rust's syntax to find out which modules a file imports.

use std::collections::BTreeSet;

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Replaces comments and the contents of strings by spaces. Lines keep their numbers.
pub fn blanked(source: &str) -> String {
    let mut bytes = source.as_bytes().to_vec();
    let mut at = 0;
    while at < bytes.len() {
        let end = at + length_of_comment_or_literal(&bytes, at);
        let is_code = end == at;
        bytes[at..end].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
        at = if is_code { at + 1 } else { end };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns the length of the comment, string or character that begins here; 0 if none does.
fn length_of_comment_or_literal(bytes: &[u8], at: usize) -> usize {
    let rest = &bytes[at..];
    let after = |end: &[u8], from: usize| {
        let found = rest[from..].windows(end.len()).position(|window| window == end);
        found.map_or(rest.len(), |position| from + position + end.len())
    };
    let is_raw = rest[0] == b'r' && (at == 0 || !is_word(bytes[at - 1]) || bytes[at - 1] == b'b');
    match rest {
        [b'/', b'/', ..] => after(b"\n", 2) - 1,
        [b'/', b'*', ..] => block_comment(rest),
        [b'r', quoted @ ..] if is_raw => {
            let hashes = quoted.iter().take_while(|byte| **byte == b'#').count();
            let end = [b"\"".as_slice(), &vec![b'#'; hashes]].concat();
            if quoted.get(hashes) == Some(&b'"') { after(&end, hashes + 2) } else { 0 }
        }
        [b'"', ..] => 1 + string_length(&rest[1..]),
        [b'\'', b'\\', ..] => after(b"'", 3),
        // A character, not a lifetime: one UTF-8 sequence and a quote.
        [b'\'', first, ..] => {
            let width = [1, 1, 2, 3, 4][(first.leading_ones() as usize).min(4)];
            if rest.get(1 + width) == Some(&b'\'') { width + 2 } else { 0 }
        }
        _ => 0,
    }
}

/// Returns the length of a string up to and including its closing quote.
fn string_length(bytes: &[u8]) -> usize {
    let mut at = 0;
    while at < bytes.len() && bytes[at] != b'"' {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(bytes.len())
}

/// Returns the length of a block comment, with nested ones.
fn block_comment(bytes: &[u8]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < bytes.len() {
        match &bytes[at..] {
            [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
            [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            return at;
        }
    }
    at
}

/// Removes the test modules from a blanked text. Returns the rest, and the names of test modules with files of their
/// own.
pub fn without_tests(text: &str) -> (String, Vec<String>) {
    let (mut text, mut files, mut from) = (text.to_owned(), Vec::new(), 0);
    while let Some(found) = text[from..].find("#[cfg(test)]") {
        let start = from + found;
        from = start + "#[cfg(test)]".len();
        let item = &text[from..];
        let end = item.find(['{', ';']).unwrap_or(item.len());
        let Some(name) = item[..end].trim().trim_start_matches("pub ").strip_prefix("mod ") else { continue };
        if item[end..].starts_with(';') {
            files.push(name.trim().to_owned());
            continue;
        }
        let end = from + end + braces(&item[end..]);
        let blank: String = text[start..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
        text.replace_range(start..end, &blank);
    }
    (text, files)
}

/// Returns the length of a block from its opening brace up to and including the closing one.
fn braces(text: &str) -> usize {
    let mut depth = 0;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    text.len()
}

/// Returns the top modules that a blanked text names, each with its line.
///
/// A path begins with `crate::`, with as many `super::` as the file's module is `depth` deep, or with `a2::`; in the
/// root (`lib.rs`) also with the name of one of its `modules`. What belongs to the root itself is in the module
/// `lib`.
pub fn imports(text: &str, depth: usize, is_root: bool, modules: &BTreeSet<String>) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let word = rest.bytes().take_while(|byte| is_word(*byte)).count();
        if word == 0 {
            at += rest.chars().next().map_or(1, char::len_utf8);
            continue;
        }
        let is_inside_a_path = text[..at].trim_end().ends_with("::");
        let tail = path_tail(rest, &rest[..word], depth);
        let line = 1 + text[..at].matches('\n').count();
        if let (Some(tail), false) = (tail, is_inside_a_path) {
            let named = first_words(tail).into_iter();
            let named = named.map(|name| if modules.contains(name) { name.to_owned() } else { "lib".to_owned() });
            found.extend(named.map(|name| (line, name)));
        } else if is_root && !is_inside_a_path && modules.contains(&rest[..word]) && rest[word..].starts_with("::")
        {
            found.push((line, rest[..word].to_owned()));
        }
        at += word;
    }
    found
}

/// Returns what follows the words that lead to the root, if `rest` begins with such words.
fn path_tail<'a>(rest: &'a str, word: &str, depth: usize) -> Option<&'a str> {
    match word {
        "crate" | "a2" => rest[word.len()..].strip_prefix("::"),
        "super" => (0..depth).try_fold(rest, |rest, _| rest.strip_prefix("super::")),
        _ => None,
    }
}

/// Returns the first word of a path, or of each path of a group in braces.
fn first_words(tail: &str) -> Vec<&str> {
    let word = |text: &'_ str| text.bytes().take_while(|byte| is_word(*byte)).count();
    if !tail.starts_with('{') {
        return vec![&tail[..word(tail)]];
    }
    let group = &tail[1..braces(tail) - 1];
    let (mut words, mut depth, mut start) = (Vec::new(), 0, true);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => start = true,
            c if start && !c.is_whitespace() => {
                words.push(&group[at..at + word(&group[at..])]);
                start = false;
            }
            _ => {}
        }
    }
    words
}

#[test]
fn comments_and_strings_are_no_code() {
    let text = "a // crate::b\n/* c /* d */ e */ f \"g \\\" h\" r#\"i \" j\"# 'k' '\\'' l<'m> \"\u{e9}\" n";
    let words: Vec<String> = blanked(text).split_whitespace().map(str::to_owned).collect();
    assert_eq!(words, ["a", "f", "l<'m>", "n"]);
    assert_eq!(blanked(text).lines().count(), 2);
}

#[test]
fn modules_for_tests_are_left_out() {
    let text =
        "a\n#[cfg(test)]\nmod tests {\n fn f() { b }\n}\nc\n#[cfg(test)]\nmod more;\n#[cfg(test)]\nfn d() {}";
    let (kept, files) = without_tests(text);
    assert_eq!(kept.split_whitespace().next(), Some("a"));
    assert!(!kept.contains('b') && kept.contains("\nc\n") && kept.contains("fn d"));
    assert_eq!((kept.lines().count(), files), (text.lines().count(), vec!["more".to_owned()]));
}
