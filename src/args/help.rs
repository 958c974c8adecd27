//! The texts of `-h`, `-help` and `-version`, made of the table of flags when they are asked for.

use super::flags::{Flag, GROUPS, flags};
use crate::options::{MAX_BOUNCES, MAX_SAMPLES, MAX_SIDE, MAX_THREADS};
use crate::simd::InstructionSet;

/// Columns of a terminal.
const WIDTH: usize = 80;
/// Columns of a flag with its values.
const FLAG_WIDTH: usize = 28;

/// The flags to begin with.
const FIRST: [&str; 11] = [
    "output",
    "size",
    "bounces",
    "shadows",
    "jitter",
    "filter",
    "depth",
    "normals",
    "time-limit",
    "check",
    "compare",
];

/// What the program does.
pub const ABOUT: &str = "Renders a scene into PNG pictures of colour, depth and surface normals.";

/// The kinds of command lines.
pub const USAGE: [&str; 3] = [
    "a2 SCENE.txt -output PICTURE.png [flags]",
    "a2 -compare A.png B.png [flags]",
    "a2 -merge PICTURE.png PART.png...",
];

/// How flags are typed.
pub const TYPING: &str = "Flags have one dash or two, in any order. Of one given twice the last counts.";

/// Stands before [`ROBUST`].
pub const WITH_ROBUST: &str = "With -robust, and without losing a digit of what the default gets right:";

/// All differences of `-robust` from the starter.
pub const ROBUST: [&str; 5] = [
    "shadow and mirror rays start as far off a surface as its rounding asks for (-epsilon auto), not 0.01 along them",
    "a plane's normal is shaded and shown as a unit vector, whatever its length in the scene",
    "what is behind a light casts no shadow: the way to it is measured from where the shadow ray starts",
    "a surface stands in the way of a light behind it: shadow rays start on the side that is seen",
    "a mirror's smoothed normal sends no ray into the mirror: the normal of the face then takes its place",
];

/// The exit codes and what they mean.
pub const EXIT_CODES: [(u8, &str); 4] = [
    (0, "The pictures are written; with -compare: the pictures are alike."),
    (
        1,
        "A scene, mesh or picture is wrong, or a file cannot be read or written; with -compare: the pictures differ.",
    ),
    (2, "The command line makes no sense; with -compare: the pictures cannot be compared."),
    (
        3,
        "The pictures are written, but the target error or some pixels were not reached in time; with -compare: the sizes of the pictures differ.",
    ),
];

/// Command lines, after what each does.
pub const EXAMPLES: [(&str, &str); 6] = [
    ("A mirror bunny", "a2 data/scene06_bunny_1k.txt -output 06.png -size 300 300 -bounces 4"),
    ("Colour, depth and normals", "a2 s.txt -output c.png -depth 8 18 d.png -normals n.png"),
    ("The smoothest the course asks for", "a2 s.txt -output c.png -jitter -filter"),
    ("As good as it gets in ten seconds", "a2 s.txt -output c.png -time-limit 10"),
    ("Is the scene in order?", "a2 s.txt -check"),
    ("Is my picture the same?", "a2 -compare mine.png theirs.png -diff where.png"),
];

/// Returns the text of `-h`: a line for each flag to begin with, and the names of the others.
pub(super) fn screen() -> String {
    let mut text = head() + "\n";
    for flag in FIRST.iter().filter_map(|name| flags().find(|flag| flag.name == *name)) {
        text += &format!("  {:<FLAG_WIDTH$}{}\n", typed(flag), flag.summary);
    }
    text += "\n'a2 -help' tells everything, with examples, and has these flags, too:\n";
    for (group, flags) in GROUPS {
        let others = flags.iter().filter(|flag| !FIRST.contains(&flag.name));
        let names: String = others.map(|flag| format!(" -{}", flag.name)).collect();
        text += &wrapped(&format!("{group}:{names}"), 2, 6);
    }
    text
}

/// Returns the text of `-help`.
pub(super) fn page() -> String {
    let mut text = format!("{}{TYPING}\n", head());
    for (group, flags) in GROUPS {
        text += &format!("\n{group}:\n");
        for flag in *flags {
            text += &format!("  {}\n", typed(flag));
            text += &wrapped(&format!("{}. {}", flag.summary, flag.more), 6, 6);
        }
    }
    text += &format!("\n{WITH_ROBUST}\n");
    ROBUST.iter().for_each(|difference| text += &wrapped(&format!("- {difference}"), 2, 4));
    text += "\nExit codes:\n";
    EXIT_CODES.iter().for_each(|(code, meaning)| text += &wrapped(&format!("{code}  {meaning}"), 2, 5));
    text += "\nExamples:\n";
    EXAMPLES.iter().for_each(|(what, line)| text += &format!("  {what}:\n      {line}\n"));
    text
}

/// Returns the text of `-version`.
pub(super) fn version() -> String {
    let names = InstructionSet::NAMES.join(", ");
    let numbers = if cfg!(feature = "f32") { "f32" } else { "f64" };
    let exr = if cfg!(feature = "exr") { "yes" } else { "no" };
    format!(
        "a2 {}\n\
         commit            {}\n\
         target            {}\n\
         instruction sets  {names}; this processor runs {}\n\
         numbers           {numbers}\n\
         EXR pictures      {exr}\n\
         limits            pictures of {MAX_SIDE} x {MAX_SIDE} pixels, {MAX_BOUNCES} bounces,\n\
         {:18}{MAX_SAMPLES} samples a pixel, {MAX_THREADS} threads\n",
        env!("CARGO_PKG_VERSION"),
        env!("A2_COMMIT"),
        env!("A2_TARGET"),
        InstructionSet::detected(),
        "",
    )
}

fn head() -> String {
    format!("Usage: {}\n\n{ABOUT}\n", USAGE.join("\n       "))
}

fn typed(flag: &Flag) -> String {
    format!("-{} {}", flag.name, flag.values.join(" ")).trim_end().to_owned()
}

/// Returns a paragraph in lines of [`WIDTH`] columns, the first one indented by `first` columns and the others by `rest`.
fn wrapped(paragraph: &str, first: usize, rest: usize) -> String {
    let mut text = " ".repeat(first);
    let mut column = first;
    for (index, word) in paragraph.split_whitespace().enumerate() {
        if index > 0 && column + 1 + word.len() > WIDTH {
            text += &format!("\n{}", " ".repeat(rest));
            column = rest;
        } else if index > 0 {
            text.push(' ');
            column += 1;
        }
        text += word;
        column += word.len();
    }
    text + "\n"
}
