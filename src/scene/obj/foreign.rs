//! What a file that is no OBJ file seems to be, by how it begins.

use super::statements::{Kind, Statements, separates};

/// What follows the first bytes of a file of each kind is no OBJ text.
const BINARY: &[(&[u8], &str)] = &[
    (b"\x1f\x8b", "compressed with gzip"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"BZh", "compressed with bzip2"),
    (b"\xfd7zXZ\0", "compressed with xz"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"Rar!", "a RAR archive"),
    (b"\x7fELF", "an ELF object file or program"),
    (b"\x4c\x01", "a compiled object file (COFF, 32 bit)"),
    (b"\x64\x86", "a compiled object file (COFF, 64 bit)"),
    (b"\xc4\x01", "a compiled object file (COFF, ARM)"),
    (b"\x64\xaa", "a compiled object file (COFF, ARM64)"),
    (b"\0\0\xff\xff", "a compiled object file (COFF)"),
    (b"\xcf\xfa\xed\xfe", "a compiled object file (Mach-O)"),
    (b"\xce\xfa\xed\xfe", "a compiled object file (Mach-O)"),
    (b"!<arch>", "a library of compiled object files"),
    (b"MZ", "a Windows program"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"glTF", "a binary glTF model (GLB)"),
    (b"Kaydara FBX Binary", "a binary FBX model"),
    (b"BLENDER", "a Blender file"),
    (b"PXR-USDC", "a binary USD model"),
    (b"SQLite format 3", "an SQLite database"),
    (b"\xff\xfe\0\0", "UTF-32 text, which is not read: save it as UTF-8"),
    (b"\0\0\xfe\xff", "UTF-32 text, which is not read: save it as UTF-8"),
];

/// How texts of other kinds begin, in small letters.
const TEXTS: &[(&str, &str)] = &[
    ("version https://git-lfs", "a Git LFS pointer, which stands for the file: 'git lfs pull' fetches it"),
    ("<!doctype html", "an HTML page"),
    ("<html", "an HTML page"),
    ("<?xml", "an XML document"),
    ("<<<<<<<", "a file with a merge conflict that nobody has resolved"),
    ("<", "an HTML or XML document"),
    ("{\\rtf", "an RTF document"),
    ("{", "JSON, as glTF models are"),
    ("[", "JSON"),
    ("; fbx", "an FBX model"),
    ("#vrml", "a VRML model"),
    ("#usda", "a USD model"),
    ("xof ", "a DirectX model"),
    ("perspectivecamera", "a scene, not a mesh"),
];

/// First words of texts of other kinds, in small letters.
const FIRST_WORDS: &[(&str, &str)] = &[
    ("ply", "a PLY model"),
    ("off", "an OFF model"),
    ("coff", "an OFF model"),
    ("noff", "an OFF model"),
    ("stoff", "an OFF model"),
    ("solid", "an STL model"),
    ("newmtl", "a material library (MTL), not a mesh"),
];

/// Says what a file seems to be, if that is not an OBJ file; `text` is its decoded content.
pub(super) fn kind_of(bytes: &[u8], text: &str) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("empty");
    }
    let start = text.trim_start_matches(separates);
    if start.is_empty() {
        return Some("empty but for white space");
    }
    if is_binary_stl(bytes) {
        return Some("a binary STL model");
    }
    if let Some((_, what)) = BINARY.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(what);
    }
    // A mesh may hold lines of other kinds, and begin with one.
    let behind_comments = Statements::new(text).next().map_or("", |statement| &text[statement.keyword.start..]);
    let what = kind_of_text(start).or_else(|| kind_of_text(behind_comments))?;
    (!Statements::new(text).any(|statement| statement.kind == Kind::Vertex)).then_some(what)
}

/// Says what a text seems to be by how it begins.
fn kind_of_text(text: &str) -> Option<&'static str> {
    let end = text.char_indices().nth(40).map_or(text.len(), |(at, _)| at);
    let start = text[..end].to_lowercase();
    let first_word = start.split_whitespace().next();
    let by_word = FIRST_WORDS.iter().find(|(word, _)| Some(*word) == first_word);
    let by_start = || TEXTS.iter().find(|(beginning, _)| start.starts_with(beginning));
    by_word.or_else(by_start).map(|(_, what)| *what).or_else(|| is_path(text).then_some(PATH))
}

/// Where links are not supported, git stores a link as a file that holds the name of its target.
const PATH: &str = "only a path, and seems to be a symbolic link that was stored as text";

/// Whether a text is one short line that looks like the path of a file.
fn is_path(text: &str) -> bool {
    let line = text.trim_matches(separates);
    let is_one_word = !line.contains(separates);
    let is_name = line.len() <= 1000 && !line.contains(['\n', '\r', '#']) && !line.contains("://");
    let is_relative = ["./", "../", ".\\", "..\\"].iter().any(|start| line.starts_with(start));
    let looks_so = line.contains(['/', '\\']) || line.to_lowercase().ends_with(".obj");
    is_name && looks_so && (is_one_word || is_relative)
}

/// A head of 80 bytes, the number of triangles, and 50 bytes for each of them.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let Some((head, triangles)) = bytes.split_at_checked(84) else { return false };
    let count = u32::from_le_bytes([head[80], head[81], head[82], head[83]]);
    count > 0 && triangles.len() as u64 == 50 * u64::from(count)
}

/// Whether the beginning of a file holds bytes that no text has.
pub(super) fn is_binary(text: &str) -> bool {
    let strange = |c: char| c == char::REPLACEMENT_CHARACTER || (c.is_control() && !c.is_whitespace());
    let (looked_at, strange) =
        text.chars().take(1000).fold((0, 0), |(all, odd), c| (all + 1, odd + usize::from(strange(c))));
    10 * strange > looked_at
}
