//! The flags and values as typed: `clap` splits the line, and its errors are put into this program's words.

use super::flags::{Flag, flags};
use crate::error::{Error, counted, probably_meant};
use crate::input::is_standard;
use crate::options::has_extension;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The name of the argument for a scene without `-input`.
const SCENE: &str = "SCENE";

/// Stands before a value that begins with a dash and a digit, so that clap does not take it for flags.
const VALUE: char = '\u{1}';

/// Turns `-input` into `--input`, as clap expects it, and marks what is not a flag though it begins with a dash: no flag
/// begins with a digit or a full stop. Words and a single dash stay as they are.
pub(super) fn with_two_dashes(typed: OsString) -> OsString {
    let Some(text) = typed.to_str() else {
        return typed;
    };
    match text.strip_prefix('-') {
        Some(number) if number.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => {
            format!("{VALUE}{text}").into()
        }
        Some("V") => "--version".into(),
        Some(name) if name.starts_with(|c: char| c.is_ascii_alphabetic()) => format!("--{name}").into(),
        _ => typed,
    }
}

/// Makes the clap command of the flags that stand in `argv`: making all of them would take a tenth of a short run. If a
/// flag is given twice, the last one counts.
pub(super) fn command(argv: &[OsString]) -> clap::Command {
    let names = argv.iter().filter_map(|word| word.to_str()?.strip_prefix("--")?.split('=').next());
    let names: Vec<&str> = names.collect();
    let is_typed = |flag: &&Flag| names.contains(&flag.name);
    let arg = |flag: &Flag| {
        let arg = Arg::new(flag.name).long(flag.name);
        if flag.values.is_empty() {
            // Counted, because a repeated switch is not an error.
            arg.action(ArgAction::Count)
        } else {
            let count = flag.values.len();
            let arg = match flag.values[count - 1].ends_with("...") {
                true => arg.num_args(count..),
                false => arg.num_args(count),
            };
            arg.action(if flag.name == "pixel" { ArgAction::Append } else { ArgAction::Set })
                .value_parser(clap::value_parser!(OsString))
        }
    };
    clap::Command::new("a2")
        .no_binary_name(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .args_override_self(true)
        .arg(Arg::new(SCENE).action(ArgAction::Append).value_parser(clap::value_parser!(OsString)))
        .args(flags().filter(is_typed).map(arg))
}

/// Puts an error of clap into this program's words.
pub(super) fn explained(error: &clap::Error) -> String {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => texts.first().cloned(),
        _ => None,
    };
    let word = context(ContextKind::InvalidArg).unwrap_or_default().replace(VALUE, "");
    let name = word.trim_start_matches('-').split([' ', '=']).next().unwrap_or_default();
    let name = name.trim_end_matches("...");
    let known = flags().find(|flag| flag.name == name);
    match (error.kind(), known) {
        (ErrorKind::WrongNumberOfValues | ErrorKind::TooFewValues | ErrorKind::InvalidValue, Some(flag)) => {
            let values = counted(flag.values.len(), "value");
            let or_auto = if name == "depth" { ", or -depth auto FILE" } else { "" };
            format!("-{name} needs {values}: -{name} {}{or_auto}", flag.values.join(" "))
        }
        (ErrorKind::TooManyValues, Some(_)) => format!("-{name} takes no value"),
        (ErrorKind::UnknownArgument, _) if word.starts_with('-') => {
            let meant = probably_meant(name, flags().map(|flag| flag.name));
            let hint = meant.map_or(String::new(), |flag| format!(" (did you mean -{flag}?)"));
            // `--` is as good as `-`.
            let shown = word.strip_prefix('-').filter(|word| word.starts_with('-')).unwrap_or(&word);
            let shown = if shown.starts_with("--") { &word } else { shown };
            format!("unknown flag {}{hint}", shown.split_once('=').map_or(shown, |(flag, _)| flag))
        }
        (ErrorKind::UnknownArgument, _) => format!("'{word}' belongs to no flag"),
        _ => error.to_string().trim_start_matches("error: ").trim_end().to_owned(),
    }
}

pub(super) fn usage_error(flag: &str, message: impl std::fmt::Display) -> Error {
    Error::Usage(format!("-{flag}: {message}"))
}

/// Returns a value without its mark.
fn as_typed(value: &OsString) -> &OsStr {
    value.to_str().and_then(|text| text.strip_prefix(VALUE)).map_or(value, OsStr::new)
}

/// The flags and values as typed.
pub(super) struct Typed<'a>(pub(super) &'a ArgMatches);

impl Typed<'_> {
    pub(super) fn has(&self, flag: &str) -> bool {
        // Flags that are not typed are not known to clap.
        let is_known = self.0.try_contains_id(flag).unwrap_or(false);
        is_known && self.0.value_source(flag) == Some(clap::parser::ValueSource::CommandLine)
    }

    pub(super) fn values(&self, flag: &str) -> Vec<&OsStr> {
        let values = self.0.try_get_many::<OsString>(flag).ok().flatten();
        values.map(|values| values.map(as_typed).collect()).unwrap_or_default()
    }

    pub(super) fn path(&self, flag: &str) -> Option<PathBuf> {
        self.values(flag).first().map(PathBuf::from)
    }

    /// Returns the scene: the value of `-input`, or a word that belongs to no flag.
    pub(super) fn scene(&self) -> Result<Option<PathBuf>, Error> {
        let mut scenes = self.values("input").into_iter().chain(self.values(SCENE));
        let scene = scenes.next();
        match scenes.find(|other| Some(*other) != scene) {
            None => Ok(scene.map(PathBuf::from)),
            Some(other) => {
                let (scene, other) = (scene.unwrap_or(other).to_string_lossy(), other.to_string_lossy());
                Err(Error::Usage(format!("'{other}' belongs to no flag: the scene is '{scene}'")))
            }
        }
    }

    /// Refuses a scene, and all flags but `flag` and those that go with it. `takes` says what its values are.
    pub(super) fn refuse_others(&self, flag: &str, go_with_it: &[&str], takes: &str) -> Result<(), Error> {
        let is_other = |other: &&Flag| other.name != flag && !go_with_it.contains(&other.name);
        if let Some(other) = flags().filter(is_other).find(|other| self.has(other.name)) {
            return Err(usage_error(other.name, format!("does not go with -{flag}")));
        }
        match self.scene()? {
            None => Ok(()),
            Some(scene) => {
                let scene = scene.display();
                Err(Error::Usage(format!("'{scene}' belongs to no flag: -{flag} takes {takes}")))
            }
        }
    }

    /// Returns the path of a picture to write; its name must end in `.png`.
    pub(super) fn png_path(&self, flag: &str) -> Result<Option<PathBuf>, Error> {
        self.path(flag).map(|path| must_be_png(flag, path)).transpose()
    }

    /// Parses the `index`th value of a flag as a `T`. `accepts` says whether it is in range.
    pub(super) fn number<T: FromStr>(
        &self,
        flag: &str,
        index: usize,
        expected: &str,
        accepts: impl Fn(&T) -> bool,
    ) -> Result<Option<T>, Error> {
        let Some(value) = self.values(flag).get(index).copied() else {
            return Ok(None);
        };
        match value.to_str().and_then(|text| text.parse().ok()).filter(accepts) {
            Some(number) => Ok(Some(number)),
            None => {
                let message = format!("expected {expected}, found '{}'", value.to_string_lossy());
                Err(usage_error(flag, message))
            }
        }
    }
}

pub(super) fn must_be_png(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    // The verdict of a comparison goes to standard output.
    if is_standard(&path) && flag != "diff" || has_extension(&path, "png") {
        return Ok(path);
    }
    Err(unlike(flag, &["png"], &path))
}

/// Checks the name of the colour picture, which may also hold numbers instead of bytes.
pub(super) fn must_be_a_picture(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    const EXTENSIONS: &[&str] = if cfg!(feature = "exr") { &["png", "pfm", "exr"] } else { &["png", "pfm"] };
    if is_standard(&path) || EXTENSIONS.iter().any(|extension| has_extension(&path, extension)) {
        return Ok(path);
    }
    must_be_supported(flag, path).and_then(|path| Err(unlike(flag, EXTENSIONS, &path)))
}

/// Makes the error for a file whose name ends in none of these.
pub(super) fn unlike(flag: &str, extensions: &[&str], path: &Path) -> Error {
    let name = path.display();
    usage_error(flag, format!("expected a file name that ends in .{}, found '{name}'", extensions.join(", .")))
}

/// Refuses EXR pictures where the program is built without the feature `exr`.
pub(super) fn must_be_supported(flag: &str, path: PathBuf) -> Result<PathBuf, Error> {
    if cfg!(feature = "exr") || !has_extension(&path, "exr") {
        return Ok(path);
    }
    let message = format!("this build has no EXR support: give a .pfm instead of '{}'", path.display());
    Err(usage_error(flag, message))
}
