//! What the fuzz targets do, a function for each: it takes any bytes, and panics where the program breaks a promise.
//!
//! `cargo test` includes this folder too, and gives the functions the files in `fuzz/seeds/`.

mod argv;
mod grammar;
mod obj;
mod pictures;
mod render;
mod scene;

use a2::args::{Request, parse};
use a2::error::{Error, MOST_SHOWN};
use a2::options::Options;
use std::ffi::OsString;
use std::path::Path;

/// A function of bytes, and of a folder in which it may write, which [`lay_out`] has filled. Returns whether the program
/// accepts the bytes.
pub type Target = fn(&[u8], &Path) -> bool;

/// All targets by their names.
pub const TARGETS: [(&str, Target); 9] = [
    ("scene", scene::text),
    ("scene_structured", scene::structured),
    ("obj", obj::mesh),
    ("png", pictures::png),
    ("pfm", pictures::pfm),
    ("exr", pictures::exr),
    ("argv", argv::words),
    ("compare", pictures::compare),
    ("render", render::render),
];

/// Writes the files that all inputs of a target share.
pub fn lay_out(folder: &Path) {
    grammar::write_meshes(folder);
    pictures::write_cube_map(&folder.join(grammar::CUBE_MAP));
    pictures::write_cube_map(&folder.join(pictures::FACES));
}

/// Parses a command line that renders; its words are separated by blanks.
fn options(line: &str) -> Options {
    match parse(line.split_whitespace().map(OsString::from)) {
        Ok(Request::Render(options)) => *options,
        other => panic!("{line}: {other:?}"),
    }
}

/// Checks that an error is about this file and says something. Returns false: the file was not accepted.
fn must_be_clear(error: &Error, file: &Path) -> bool {
    let (message, file) = (error.to_string(), file.display().to_string());
    let rest = message.strip_prefix(&file).unwrap_or_else(|| panic!("not about {file}: {message}"));
    assert!(rest.starts_with(':') && rest.len() > 8, "{message}");
    assert!(message.len() < 2000, "{} bytes: {message}", message.len());
    false
}

/// Checks the same, and that the error stands at a place in this text. Several mistakes are checked one by one.
fn must_have_a_place(error: &Error, file: &Path, text: &str) -> bool {
    if let Error::Several(errors) = error {
        assert!((2..=MOST_SHOWN).contains(&errors.len()), "{} mistakes", errors.len());
        return errors.iter().fold(false, |is_right, error| is_right | must_have_a_place(error, file, text));
    }
    must_be_clear(error, file);
    let Error::Source(error) = error else { panic!("no place: {error}") };
    let location = error.location();
    let mut numbers = location.rsplitn(3, ':').map(str::parse::<usize>);
    let (Some(Ok(column)), Some(Ok(line))) = (numbers.next(), numbers.next()) else { panic!("{location}") };
    let width = text.split('\n').nth(line.wrapping_sub(1)).map(|line| line.chars().count());
    assert!(width.is_some_and(|width| (1..=width + 1).contains(&column)), "{location} is outside of the text");
    false
}
