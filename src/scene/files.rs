//! The hash of a scene: of its text and of the files that it names.

use super::named_files::found;
use crate::cube_map::face_paths;
use crate::error::Remarks;
use crate::scene_file::{At, Description, LeafShape};
use siphasher::sip128::{Hasher128 as _, SipHasher24};
use std::fs::File;
use std::hash::Hasher as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Returns a hash of a scene's text and of the content of all files that it names: the same on every machine. Of a device
/// or a pipe only the name counts.
pub fn hash_of_files(description: &Description) -> u128 {
    let mut hasher = SipHasher24::new();
    add(&mut hasher, description.source.text.as_bytes());
    let folder = description.source.path.parent().unwrap_or(Path::new(""));
    // The hints come when the scene is loaded.
    let found = |name: &At<String>| found(&description.source, folder, name, &mut Remarks::default());
    let mut files: Vec<PathBuf> = Vec::new();
    description.root.visit_leaves(&mut |leaf| {
        if let LeafShape::Mesh(name) = &leaf.shape {
            files.push(found(name));
        }
    });
    files.sort_unstable();
    files.dedup();
    files.extend(description.background.cube_map.iter().flat_map(|name| face_paths(&found(name))));
    files.iter().for_each(|path| add_file(&mut hasher, path));
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
