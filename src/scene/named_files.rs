//! The files that a scene names: found under another spelling, or not there.

use crate::cube_map::CubeMap;
use crate::error::{Error, Remarks, SourceText, cut_short};
use crate::file_path::{self, Kind, KnownFolders};
use crate::scene_file::At;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Opens the cube map in the folder of this name.
///
/// # Errors
/// [`Error::Source`] at the name if it cannot be opened.
pub(super) fn cube_map(
    source: &Arc<SourceText>,
    folder: &Path,
    name: &At<String>,
    remarks: &mut Remarks,
) -> Result<CubeMap, Error> {
    let path = found(source, folder, name, &mut KnownFolders::default(), remarks);
    let opened = CubeMap::open(&path).inspect(|map| {
        let place = || source.location(name.span);
        let hints = map
            .respelt_files()
            .map(|(found, name)| format!("{}: there is no '{name}': '{}' is read", place(), found.display()));
        remarks.hints.extend(hints);
    });
    opened.map_err(|message| {
        let error = source.error(name.span, message);
        if path.exists() {
            error
        } else {
            error.with_note(file_path::what_is_there(folder, &name.value, Kind::Folder))
        }
    })
}

/// Makes the error for a mesh that cannot be read.
pub(super) fn unreadable(source: &Arc<SourceText>, folder: &Path, name: &At<String>, error: &io::Error) -> Error {
    let path = folder.join(&name.value).display().to_string();
    let refusal = source.error(name.span, format!("cannot read the mesh '{}': {error}", cut_short(&path)));
    match error.kind() {
        ErrorKind::NotFound => refusal.with_note(file_path::what_is_there(folder, &name.value, Kind::File)),
        _ => refusal,
    }
}

/// Returns the path of a file or folder; a hint says so if it is found under another spelling.
pub(super) fn found(
    source: &SourceText,
    folder: &Path,
    name: &At<String>,
    folders: &mut KnownFolders,
    remarks: &mut Remarks,
) -> PathBuf {
    let Some(spelling) = folders.respelt(folder, &name.value) else {
        return folder.join(&name.value);
    };
    remarks.hints.push(format!(
        "{}: there is no '{}': '{spelling}' is read",
        source.location(name.span),
        name.value
    ));
    folder.join(spelling)
}
