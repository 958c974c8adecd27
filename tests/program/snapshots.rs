//! Snapshot tests of the texts for the user: `-h`, `-help`, `-explain`, `-stats`.
//!
//! Texts must equal the files in `tests/snapshots/`. After a change that is meant, run the tests with
//! `A2_WRITE_SNAPSHOTS=1`, which writes the files (and fails), look at the difference, and run the tests again.

use crate::numbers::instruction_sets;
use crate::support::{Folder, project};
use std::path::Path;

/// Replaces numbers by `#`, whatever their width; words that contain digits stay.
fn masked(text: &str) -> String {
    let mut masked = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let follows_a_word = masked.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let length = if first.is_ascii_digit() && !follows_a_word { number_length(rest) } else { 0 };
        if length > 0 {
            // Tables align their numbers with spaces, whose number depends on the width.
            let padded = masked.trim_end_matches(' ').len();
            masked.truncate(masked.len().min(padded + 2));
            masked.push('#');
            rest = &rest[length..];
        } else {
            masked.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    masked
}

/// Returns the length of the number that a text begins with: 12, 1.5, 2.3e-4.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    if bytes.get(end) == Some(&b'e') {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
        if digits(end + 1 + sign) > end + 1 + sign {
            end = digits(end + 1 + sign);
        }
    }
    end
}

/// Compares a text with the file `tests/snapshots/NAME.txt`.
fn holds(name: &str, text: &str) {
    holds_at(&project("tests/snapshots").join(format!("{name}.txt")), text);
}

/// Compares a text with a file.
pub fn holds_at(path: &Path, text: &str) {
    if std::env::var_os("A2_WRITE_SNAPSHOTS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        panic!("{} is written: look at it, and run again without A2_WRITE_SNAPSHOTS", path.display());
    }
    let snapshot = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    if snapshot == text {
        return;
    }
    let differing: Vec<String> = (0..snapshot.lines().count().max(text.lines().count()))
        .map(|line| (snapshot.lines().nth(line).unwrap_or_default(), text.lines().nth(line).unwrap_or_default()))
        .filter(|(expected, found)| expected != found)
        .map(|(expected, found)| format!("- {expected}\n+ {found}"))
        .collect();
    panic!(
        "the text differs from {}:\n{}\n(A2_WRITE_SNAPSHOTS=1 writes it anew)",
        path.display(),
        differing.join("\n")
    );
}

/// Returns the messages of a run of a scene that uses everything, with the numbers masked.
fn said(flags: &str) -> String {
    let folder = Folder::new();
    let set = instruction_sets(&folder).swap_remove(0);
    let scene = project("data/scene07_arch.txt");
    let output = "-size 20 20 -output o.png -depth 8 18 d.png";
    let run = folder.a2(&format!("-input {} {output} -threads 1 -simd {set} {flags}", scene.display()));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let data = format!("{}/", project("data").display());
    masked(&run.stderr.replace(&set, "SIMD").replace(&data, ""))
}

#[test]
fn help() {
    holds("help", &Folder::new().a2("-help").stdout);
}

#[test]
fn help_on_a_screen() {
    holds("help_screen", &Folder::new().a2("-h").stdout);
}

#[test]
fn explain() {
    holds("explain", &said("-bounces 4 -shadows -explain"));
}

#[test]
fn explain_of_a_plan_that_leaves_much_out() {
    holds("explain_little", &said("-explain"));
}

/// Peak memory is only known on Linux.
#[cfg(target_os = "linux")]
#[test]
fn stats() {
    let folder = Folder::new();
    let scene = project("data/scene07_arch.txt");
    let reference = folder.path("r.png");
    let run = folder.a2(&format!("-input {} -size 20 20 -output r.png", scene.display()));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    holds("stats", &said(&format!("-bounces 4 -shadows -jitter -stats -reference {}", reference.display())));
}

#[test]
fn numbers_are_masked_and_words_are_not() {
    let text = "build  0.0001   12.5\nRMSE 2.3e-4, sse2: 8 (a 1 to 2) 3.\nover 1 level: 5%";
    assert_eq!(masked(text), "build  #  #\nRMSE #, sse2: # (a # to #) #.\nover # level: #%");
}
