//! The path of a file or folder from its name in a scene, also where that was written on a system that takes `A` for `a` and `\` for
//! `/`.

use crate::error::probably_meant;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Most names of a folder that a message lists.
const MOST_NAMES: usize = 8;

/// What people set around names in place of quotes.
const FOREIGN_QUOTES: [char; 10] =
    ['\u{201c}', '\u{201d}', '\u{201e}', '\u{2018}', '\u{2019}', '\u{ab}', '\u{bb}', '`', '<', '>'];

/// What there is for a name.
#[derive(Debug, PartialEq)]
pub enum FilePath {
    /// The file itself, or nothing that is like it: whoever reads it will see.
    AsWritten,
    /// A file whose name differs in upper and lower case or in slashes only, as it would be written.
    Respelt(String),
    /// A file with a similar name, as it would be written.
    Similar(String),
}

/// What a name is the name of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    File,
    Folder,
}

/// Looks for the file `name` in `folder`.
pub fn find(folder: &Path, name: &str) -> FilePath {
    KnownFolders::default().look_for(folder, name, |part, names| {
        // A link of this very name leads nowhere.
        let others = names.iter().map(String::as_str).filter(|name| *name != part);
        probably_meant(part, others).map(str::to_owned)
    })
}

/// The names in folders. Each folder is read once: a scene may name thousands of files that are not there.
#[derive(Default)]
pub struct KnownFolders(HashMap<PathBuf, Vec<String>>);

impl KnownFolders {
    /// Returns the name of the file `name` in `folder` if it differs in upper and lower case or in slashes only.
    pub fn respelt(&mut self, folder: &Path, name: &str) -> Option<String> {
        // Names that are only similar take long to find.
        match self.look_for(folder, name, |_, _| None) {
            FilePath::Respelt(name) => Some(name),
            FilePath::AsWritten | FilePath::Similar(_) => None,
        }
    }

    /// Looks for a file. `similar` chooses one of the names of a folder in place of a part that is not there.
    fn look_for(
        &mut self,
        folder: &Path,
        name: &str,
        similar: impl Fn(&str, &[String]) -> Option<String>,
    ) -> FilePath {
        match std::fs::metadata(folder.join(name)) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            _ => return FilePath::AsWritten,
        }
        let name = name.replace('\\', "/");
        let mut found = PathBuf::from(if name.starts_with('/') { "/" } else { "" });
        let mut parts = name.split('/').filter(|part| !part.is_empty());
        while let Some(part) = parts.next() {
            let here = folder.join(&found);
            if here.join(part).exists() {
                found.push(part);
                continue;
            }
            let names = self.0.entry(here.clone()).or_insert_with(|| names_in(&here));
            if let Some(same) = names.iter().find(|name| differ_in_case(name, part) && here.join(name).exists()) {
                found.push(same);
                continue;
            }
            let Some(similar) = similar(part, names) else {
                return FilePath::AsWritten;
            };
            found.push(similar);
            found.extend(parts);
            return FilePath::Similar(written(&found));
        }
        FilePath::Respelt(written(&found))
    }
}

/// Returns whether two names are the same but for upper and lower case.
fn differ_in_case(a: &str, b: &str) -> bool {
    if a.is_ascii() && b.is_ascii() { a.eq_ignore_ascii_case(b) } else { a.to_lowercase() == b.to_lowercase() }
}

/// Says what there is in place of the file or folder `name` in `folder`, which is missing: one that may be meant, or
/// those of its kind beside it.
pub fn what_is_there(folder: &Path, name: &str, kind: Kind) -> String {
    let whole = folder.join(name);
    if let Some(link) = whole.ancestors().find(|path| path.is_symlink() && !path.exists())
        && let Ok(target) = link.read_link()
    {
        return format!("'{}' is a link to '{}', which is not there", written(link), written(&target));
    }
    let bare = without_foreign_quotes(name);
    if bare != name {
        let signs: Vec<String> =
            name.chars().filter(|c| FOREIGN_QUOTES.contains(c)).map(|c| format!("'{c}'")).collect();
        return format!("{} would be part of the name: write \"{bare}\"", signs.join(" and "));
    }
    if let FilePath::Similar(similar) | FilePath::Respelt(similar) = find(folder, name) {
        return format!("did you mean '{similar}'?");
    }
    let name = name.replace('\\', "/");
    let (inner, name) = name.rsplit_once('/').unwrap_or(("", &name));
    let (inner, name) = (folder.join(inner), Path::new(name));
    let shown = if inner.as_os_str().is_empty() { "this folder".into() } else { format!("'{}'", written(&inner)) };
    if !inner.as_os_str().is_empty() && !inner.is_dir() {
        return format!("there is no folder {shown}");
    }
    let is_like = |other: &String| match kind {
        Kind::File => Path::new(other).extension() == name.extension() && !inner.join(other).is_dir(),
        Kind::Folder => inner.join(other).is_dir(),
    };
    let like: Vec<String> = names_in(&inner).into_iter().filter(is_like).collect();
    let rest = like.len().saturating_sub(MOST_NAMES);
    let others = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    match (like.is_empty(), kind, name.extension()) {
        (true, Kind::Folder, _) => format!("{shown} holds no folder"),
        (true, Kind::File, Some(extension)) => format!("{shown} holds no .{} file", extension.to_string_lossy()),
        (true, Kind::File, None) => format!("{shown} holds no file without an extension"),
        (false, ..) => format!("{shown} holds {}{others}", like[..like.len() - rest].join(", ")),
    }
}

/// Returns a name without the signs around it that only look like quotes, and with spaces as they are: `my\ mesh.obj` is how
/// shells have them.
pub fn without_foreign_quotes(name: &str) -> String {
    name.trim_matches(FOREIGN_QUOTES).replace("\\ ", " ")
}

fn written(path: &Path) -> String {
    path.display().to_string()
}

/// The names in a folder, sorted, so that the same one is found on every machine.
fn names_in(folder: &Path) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn names_are_found_however_they_are_spelt() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("Models")).unwrap();
        for name in ["Models/Bunny.obj", "Models/bunny.OBJ", "été.obj"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let respelt = |name: &str| FilePath::Respelt(name.to_owned());
        let similar = |name: &str| FilePath::Similar(name.to_owned());
        for (name, expected) in [
            ("Models/bunny.OBJ", FilePath::AsWritten),
            ("models/BUNNY.OBJ", respelt("Models/Bunny.obj")),
            ("models\\Bunny.obj", respelt("Models/Bunny.obj")),
            ("./models//bunny.obj", respelt("./Models/Bunny.obj")),
            ("ÉTÉ.obj", respelt("été.obj")),
            ("Models/buny.obj", similar("Models/Bunny.obj")),
            ("Model/Bunny.obj", similar("Models/Bunny.obj")),
            ("dragon.obj", FilePath::AsWritten),
            ("x/y/z", FilePath::AsWritten),
        ] {
            assert_eq!(find(folder.path(), name), expected, "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_nowhere_and_foreign_quotes_are_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("p.obj"), "").unwrap();
        for link in ["dangling.obj", "Other.obj"] {
            std::os::unix::fs::symlink("gone.obj", folder.path().join(link)).unwrap();
        }
        let said = |name: &str| what_is_there(folder.path(), name, Kind::File);
        assert!(said("dangling.obj").ends_with("dangling.obj' is a link to 'gone.obj', which is not there"));
        assert!(said("dangling.obj/p.obj").ends_with("dangling.obj' is a link to 'gone.obj', which is not there"));
        assert_eq!(find(folder.path(), "other.OBJ"), FilePath::Similar("Other.obj".to_owned()));
        assert_eq!(
            said("\u{201c}p.obj\u{201d}"),
            "'\u{201c}' and '\u{201d}' would be part of the name: write \"p.obj\""
        );
        assert_eq!(said("<p.obj>"), "'<' and '>' would be part of the name: write \"p.obj\"");
    }
}
