//! What a file of another kind than the wanted one seems to be, by how it begins.

/// How PNG and EXR files begin.
pub const PNG_MARK: &[u8] = b"\x89PNG\r\n\x1a\n";
pub const EXR_MARK: &[u8] = b"\x76\x2f\x31\x01";

/// How binary files of each kind begin.
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
    (PNG_MARK, "a PNG picture"),
    (b"\x89PNG", COPIED_AS_TEXT),
    (b"\xc2\x89PNG", COPIED_AS_TEXT),
    (b"\xef\xbf\xbdPNG", COPIED_AS_TEXT),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (EXR_MARK, "an OpenEXR picture"),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
    (b"\xff\x0a", "a JPEG XL picture"),
    (b"8BPS", "a Photoshop picture"),
    (b"gimp xcf", "a GIMP picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"\0\0\x01\0", "an ICO picture"),
    (b"DDS ", "a DDS picture"),
    (b"qoif", "a QOI picture"),
    (b"#?RADIANCE", "a Radiance HDR picture"),
    (b"\xabKTX ", "a KTX picture"),
    (b"%PDF", "a PDF document"),
    (b"%!PS", "a PostScript document"),
    (b"glTF", "a binary glTF model (GLB)"),
    (b"Kaydara FBX Binary", "a binary FBX model"),
    (b"BLENDER", "a Blender file"),
    (b"PXR-USDC", "a binary USD model"),
    (b"SQLite format 3", "an SQLite database"),
    (b"\xff\xfe\0\0", "UTF-32 text, which is not read: save it as UTF-8"),
    (b"\0\0\xfe\xff", "UTF-32 text, which is not read: save it as UTF-8"),
];

const COPIED_AS_TEXT: &str =
    "a PNG picture whose first bytes have changed, as when a file is copied as text: copy it again as binary";

/// What stands at a place behind the start of a file of each kind.
const BEHIND_THE_START: &[(usize, &[u8], &str)] = &[
    (8, b"WEBP", "a WebP picture"),
    (4, b"ftypavi", "an AVIF picture"),
    (4, b"ftyphe", "an HEIC picture"),
    (4, b"ftypmif1", "an HEIC picture"),
    (4, b"ftyp", "an MP4 film"),
    (257, b"ustar", "a tar archive"),
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
    ("perspectivecamera", "a scene"),
];

/// First words of texts of other kinds, in small letters.
const FIRST_WORDS: &[(&str, &str)] = &[
    ("ply", "a PLY model"),
    ("off", "an OFF model"),
    ("coff", "an OFF model"),
    ("noff", "an OFF model"),
    ("stoff", "an OFF model"),
    ("solid", "an STL model"),
    ("pf", "a PFM picture"),
    ("p3", "a PPM picture"),
    ("p5", "a PGM picture"),
    ("p6", "a PPM picture"),
    ("newmtl", "a material library (MTL)"),
];

/// Says what a file seems to be by its first bytes; `text` is its decoded content, or the beginning.
pub fn kind_of_start(bytes: &[u8], text: &str) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("empty");
    }
    if text.trim_start_matches(is_blank).is_empty() {
        return Some("empty but for white space");
    }
    if is_binary_stl(bytes) {
        return Some("a binary STL model");
    }
    if let Some((_, what)) = BINARY.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(what);
    }
    let stands_at = |at: usize, magic: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(magic));
    if let Some((.., what)) = BEHIND_THE_START.iter().find(|(at, magic, _)| stands_at(*at, magic)) {
        return Some(what);
    }
    // The size comes next, then four zeros.
    (bytes.starts_with(b"BM") && stands_at(6, &[0; 4])).then_some("a BMP picture")
}

/// Says what a text seems to be by how it begins.
pub fn kind_of_text(text: &str) -> Option<&'static str> {
    let text = text.trim_start_matches(is_blank);
    let beginning = |length| text[..text.floor_char_boundary(length)].to_lowercase();
    if text.starts_with('<') && beginning(1000).contains("<svg") {
        return Some("an SVG drawing");
    }
    let start = beginning(40);
    let first_word = start.split_whitespace().next();
    let by_word = FIRST_WORDS.iter().find(|(word, _)| Some(*word) == first_word);
    let by_start = || TEXTS.iter().find(|(beginning, _)| start.starts_with(beginning));
    by_word.or_else(by_start).map(|(_, what)| *what).or_else(|| is_path(text).then_some(PATH))
}

/// Says what a file that is to be a picture seems to be.
pub fn kind_of_picture(bytes: &[u8]) -> Option<&'static str> {
    const LOOKED_AT: usize = 1000;
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LOOKED_AT)]);
    let what = kind_of_start(bytes, &text).or_else(|| kind_of_text(&text));
    what.or_else(|| is_tga(bytes).then_some("a TGA picture"))
}

/// Whether a character stands between words, or is one of those that programs put at the ends of a file.
fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\0' | '\u{1a}' | '\u{feff}')
}

/// Where links are not supported, git stores a link as a file that holds the name of its target.
const PATH: &str = "only a path, and seems to be a symbolic link that was stored as text";

/// Whether a text is one short line that looks like the path of a file.
fn is_path(text: &str) -> bool {
    let line = text.trim_matches(is_blank);
    let is_one_word = !line.contains(is_blank);
    let is_name = line.len() <= 1000 && !line.contains(['\n', '\r', '#']) && !line.contains("://");
    let is_relative = ["./", "../", ".\\", "..\\"].iter().any(|start| line.starts_with(start));
    let has_extension = || [".obj", ".png"].iter().any(|end| line.to_lowercase().ends_with(end));
    let looks_so = line.contains(['/', '\\']) || has_extension();
    is_name && looks_so && (is_one_word || is_relative)
}

/// The head has no mark, but few values are allowed: of the palette, the type, and the bits of a pixel.
fn is_tga(bytes: &[u8]) -> bool {
    let Some(head) = bytes.get(..18) else { return false };
    let is_known = match head[1] {
        0 => matches!(head[2], 2 | 3 | 10 | 11) && head[3..8] == [0; 5],
        1 => matches!(head[2], 1 | 9),
        _ => false,
    };
    is_known && matches!(head[16], 8 | 15 | 16 | 24 | 32) && head[12..14] != [0; 2] && head[14..16] != [0; 2]
}

/// A head of 80 bytes, the number of triangles, and 50 bytes for each of them.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let Some((head, triangles)) = bytes.split_at_checked(84) else { return false };
    let count = u32::from_le_bytes([head[80], head[81], head[82], head[83]]);
    count > 0 && triangles.len() as u64 == 50 * u64::from(count)
}

/// Recognises UTF-16 without a mark: most of what scenes and meshes consist of is ASCII, so every other byte is 0. No byte of UTF-8 is.
pub fn utf16_is_big_endian(bytes: &[u8]) -> Option<bool> {
    const LOOKED_AT: usize = 512;
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    if !start.contains(&0) {
        return None;
    }
    let pairs = start.as_chunks::<2>().0;
    let count = |of_zeros: [bool; 2]| pairs.iter().filter(|pair| pair.map(|byte| byte == 0) == of_zeros).count();
    let (big, little) = (count([true, false]), count([false, true]));
    // Of other letters, as in comments, few have a byte of 0. Zeros may stand at the end of a file.
    (pairs.len() > 1 && 2 * big.max(little) >= pairs.len() && big.max(little) > 4 * big.min(little))
        .then_some(big > little)
}

/// Whether the beginning of a file holds bytes that no text has.
pub fn is_binary(text: &str) -> bool {
    let strange = |c: char| c == char::REPLACEMENT_CHARACTER || (c.is_control() && !c.is_whitespace());
    let (looked_at, strange) =
        text.chars().take(1000).fold((0, 0), |(all, odd), c| (all + 1, odd + usize::from(strange(c))));
    10 * strange > looked_at
}
