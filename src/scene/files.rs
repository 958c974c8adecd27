//! The files that a scene names, and the hash of its text and of them.

use super::named_files::found;
use crate::cube_map::face_paths;
use crate::error::Remarks;
use crate::file_path::KnownFolders;
use crate::scene_file::{At, Description, LeafShape};
use siphasher::sip128::{Hasher128 as _, SipHasher24};
use std::fs::File;
use std::hash::Hasher as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Returns the paths of all files that a scene names, each once: meshes, and the six faces of its cube map. They may be missing.
pub fn named_files(description: &Description) -> Vec<PathBuf> {
    let folder = description.source.path.parent().unwrap_or(Path::new(""));
    let mut folders = KnownFolders::default();
    // The hints come when the scene is loaded.
    let mut found =
        |name: &At<String>| found(&description.source, folder, name, &mut folders, &mut Remarks::default());
    let mut meshes: Vec<&At<String>> = Vec::new();
    description.root.visit_leaves(&mut |leaf| {
        if let LeafShape::Mesh(name) = &leaf.shape {
            meshes.push(name);
        }
    });
    meshes.sort_unstable_by_key(|name| &name.value);
    meshes.dedup_by_key(|name| &name.value);
    let mut files: Vec<PathBuf> = meshes.into_iter().map(&mut found).collect();
    files.sort_unstable();
    files.dedup();
    files.extend(description.background.cube_map.iter().flat_map(|name| face_paths(&found(name))));
    files
}

/// Returns a hash of a scene's text and of the content of the files that it names: the same on every machine. Of a device
/// or a pipe only the name counts.
pub fn hash_of_files(description: &Description, named: &[PathBuf]) -> u128 {
    let mut hasher = SipHasher24::new();
    add(&mut hasher, description.source.text.as_bytes());
    named.iter().for_each(|path| add_file(&mut hasher, path));
    let hash = hasher.finish128();
    u128::from(hash.h1) << 64 | u128::from(hash.h2)
}

fn add(hasher: &mut SipHasher24, bytes: &[u8]) {
    hasher.write(bytes);
    hasher.write(&(bytes.len() as u64).to_le_bytes());
}

/// Adds the content of a file. An error is none here: it comes again when the scene is loaded.
fn add_file(hasher: &mut SipHasher24, path: &Path) {
    let Some(mut file) = path.is_file().then(|| File::open(path).ok()).flatten() else {
        return add(hasher, path.as_os_str().as_encoded_bytes());
    };
    let (mut bytes, mut length) = (vec![0; 1 << 16], 0_u64);
    while let Ok(count @ 1..) = file.read(&mut bytes) {
        hasher.write(&bytes[..count]);
        length += count as u64;
    }
    hasher.write(&length.to_le_bytes());
}
