//! Tests of mesh files as people have them: every way to write one, and the messages for files that are none.

use crate::support::{Folder, Run, SCENE, TRIANGLE, middle};
use image::RgbImage;

/// Renders a scene with the mesh `m.obj`, white from both sides.
fn with_mesh(folder: &Folder, mesh: &[u8]) -> Run {
    let scene = SCENE.replace("color 0 0 0", "color 0 0 0 ambientLight 1 1 1");
    folder.write("s.txt", scene.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }")).write("m.obj", mesh);
    folder.a2("-input s.txt -output o.png -size 60 60")
}

/// Renders a mesh that must be read without a word.
pub fn rendered(mesh: &[u8]) -> RgbImage {
    let folder = Folder::new();
    let run = with_mesh(&folder, mesh);
    let text = String::from_utf8_lossy(mesh);
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{text}");
    folder.picture("o.png")
}

/// Renders a mesh that may be warned about; returns the picture and the warnings.
pub fn warned(mesh: &str) -> (RgbImage, String) {
    let folder = Folder::new();
    let run = with_mesh(&folder, mesh.as_bytes());
    assert_eq!(run.exit_code, 0, "{mesh}: {}", run.stderr);
    (folder.picture("o.png"), run.stderr)
}

pub fn refusal(mesh: &[u8]) -> String {
    let run = with_mesh(&Folder::new(), mesh);
    assert_eq!(run.exit_code, 1, "{}: {}", String::from_utf8_lossy(mesh), run.stderr);
    run.stderr.strip_prefix("error: ").unwrap_or_else(|| panic!("{}", run.stderr)).to_owned()
}

/// A kite of two triangles.
pub const KITE: &str = "v -2 0 0\nv 0 -3 0\nv 2 0 0\nv 0 1.5 0\nf 1 2 3 4\n";

fn utf16(text: &str, bytes_of: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(bytes_of).collect()
}

#[test]
fn every_way_to_write_a_mesh_shows_the_same() {
    let expected = rendered(KITE.as_bytes());
    assert_eq!(middle(&expected), [255, 255, 255]);
    for text in [
        // Marks, ends of lines, ends of files.
        format!("\u{feff}{KITE}"),
        KITE.replace('\n', "\r"),
        format!("# made by hand\r{KITE}"),
        KITE.replace('\n', "\r\n"),
        KITE.replace(' ', "\t \t"),
        KITE.trim_end().to_owned(),
        format!("{KITE}\0\0\0\0"),
        format!("{KITE}\u{1a}"),
        format!("{}\u{1a}", KITE.trim_end()),
        format!("{KITE}\r\n\u{1a}\r\n"),
        // Comments.
        KITE.replace('\n', " # here\n"),
        KITE.replace("4\n", "4#here"),
        format!("# C:\\models\\\n{KITE}"),
        format!("mtllib C:\\models\\\n{KITE}"),
        // Lines that go on.
        KITE.replace("3 4", "3\\\n 4"),
        KITE.replace("3 4", "\\\r\n  3 \\\r\n4 \\\r\n"),
        KITE.replace("1.5", "1\\\n.\\\n5"),
        KITE.replace("f 1", "f\\\n 1"),
        // Vertices with more than three numbers.
        KITE.replace(" 0\n", " 0 1 0 0\n"),
        KITE.replace(" 0\n", " 0 1 0 0 0.5\n"),
        KITE.replace("-3 0\n", "-3 0 0.1 0.2 0.3\n"),
        KITE.replace(" 0\n", " 0 0.5\n"),
        KITE.replace("-3 0\n", "-3 0 0\n"),
        KITE.replace(" 0\n", " 0 1.#QNAN nan(ind) x\n"),
        // Faces.
        KITE.replace("f ", "fo "),
        KITE.replace("f 1 2 3 4", "f -4 -3 3 -1"),
        KITE.replace("f 1 2 3 4", "f 1/1 2/2 3/3 4/4"),
        KITE.replace("f 1 2 3 4", "f 1// 2//x 3/-9/1.5 4/1/1/1"),
        format!("f 1 2 3 4\n{}", KITE.replace("f 1 2 3 4", "")),
        KITE.replace("3 4", "3/\\\n 4"),
        KITE.replace("3 4", "3/\u{a0}4"),
        KITE.replace("4\n", "4/1# 1 2\n"),
        KITE.replace("4\n", "4\rg 1 2\n"),
        // Lines that no picture shows.
        KITE.replace("f ", "vt 0.5\nvt\nvt 1.#INF 3.1+e2\nf "),
        KITE.replace("f ", "vn -nan(ind) -nan(ind) -nan(ind)\nvn 1\nf "),
        KITE.replace("f ", "g f\no v\ns 1\nusemtl f 1 2 3\nvp 1 2\ncstype bezier\nl 1 2\np 3\nf "),
        format!("vn 1.#QNAN\n{KITE}"),
    ] {
        assert_eq!(rendered(text.as_bytes()), expected, "{text:?}");
    }
}

#[test]
fn every_encoding_shows_the_same() {
    let expected = rendered(KITE.as_bytes());
    let named = format!("# é, von Hand\r\no Würfel\r\n{KITE}");
    let marked = format!("\u{feff}{named}");
    for bytes in [
        utf16(&marked, u16::to_le_bytes),
        utf16(&marked, u16::to_be_bytes),
        utf16(KITE, u16::to_le_bytes),
        utf16(KITE, u16::to_be_bytes),
        named.chars().map(|c| c as u8).collect(),
        [KITE.as_bytes(), b"# \xff\xfe\xb2\n"].concat(),
        KITE.replace("0\n", "0 # \u{e9}\n").chars().map(|c| c as u8).collect(),
    ] {
        assert_eq!(rendered(&bytes), expected, "{}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn mistakes_are_found_with_line_and_column() {
    for (from, to, expected) in [
        ("0 1.5", "0 3.1+e2", "m.obj:4:5: expected a finite coordinate, found '3.1+e2'"),
        ("0 1.5", "1.#QNAN 1", "m.obj:4:3: expected a finite coordinate, found '1.#QNAN'"),
        ("0 1.5", "0 -nan(ind)", "m.obj:4:5: expected a finite coordinate, found '-nan(ind)'"),
        ("0 1.5", "0 nan", "m.obj:4:5: expected a finite coordinate, found 'nan'"),
        ("0 1.5", "0 1,5", "m.obj:4:5: expected a finite coordinate, found '1,5'"),
        ("v 0 1.5 0", "v 0 1.5 # 0", "m.obj:4:1: a vertex needs three coordinates, this one has 2"),
        ("f 1 2 3 4", "f 1 2 3 0", "m.obj:5:9: there is no vertex 0: the file has 4, numbered from 1"),
        ("f 1 2 3 4", "f 1 2 \\\n 3 5/1/1", "m.obj:6:4: there is no vertex 5: the file has 4"),
        ("f 1 2 3 4", "f 2147483649 2 3", "m.obj:5:3: there is no vertex 2147483649: the file has 4"),
        ("f 1 2 3 4", "f 18446744073709551617 2 3", "m.obj:5:3: there is no vertex 18446744073709551617"),
        ("f 1 2 3 4", "f -5 2 3", "m.obj:5:3: there is no vertex -5: 4 stand before this face"),
        ("f 1 2 3 4", "f 1 2 -9223372036854775808", "m.obj:5:7: there is no vertex -9223372036854775808"),
        ("v -2 0 0", "f -1 -2 -3\nv -2 0 0", "m.obj:1:3: there is no vertex -1: 0 stand before this face"),
        ("f 1 2 3 4", "f 1 2 nan(ind)", "m.obj:5:7: expected a vertex number, found 'nan(ind)'"),
        ("f 1 2 3 4", "f 1 2 3,4", "m.obj:5:7: expected a vertex number, found '3,4'"),
        ("f 1 2 3 4", "f 1 2 /3", "m.obj:5:7: expected a vertex number, found '/3'"),
    ] {
        let text = KITE.replace(from, to);
        for bytes in
            [text.clone().into_bytes(), utf16(&text, u16::to_le_bytes), text.replace('\n', "\r").into_bytes()]
        {
            let message = refusal(&bytes);
            assert!(message.starts_with(expected), "{text}\nexpected {expected}\nfound    {message}");
        }
        let shown = format!("{} | ", expected.split(':').nth(1).unwrap());
        assert!(refusal(text.as_bytes()).contains(&shown), "{text}");
    }
}

#[test]
fn degenerate_faces_are_left_out_with_one_warning() {
    let expected = rendered(KITE.as_bytes());
    for (faces, warning) in [
        ("f\n", "m.obj:6:1: this face has fewer than three corners and is left out\n"),
        ("f 1/1\n", "m.obj:6:1: this face has fewer than three corners and is left out\n"),
        (
            "\n f 1 2\nf",
            "m.obj:7:2: this face has fewer than three corners and is left out (and one more like it)\n",
        ),
        (
            "f\nf\nfo 1\nf 2 3\n",
            "m.obj:6:1: this face has fewer than three corners and is left out (and 3 more like it)\n",
        ),
    ] {
        let (picture, warnings) = warned(&format!("{KITE}{faces}"));
        assert_eq!((picture == expected, warnings), (true, format!("warning: {warning}")), "{faces}");
    }
}

/// Whether the mesh stands before the middle of each of 15 x 15 squares of the picture; those of the upper row first.
fn covered(picture: &RgbImage) -> Vec<String> {
    let is_lit = |row: u32, column: u32| picture.get_pixel(4 * column + 2, 4 * row + 2).0 != [0, 0, 0];
    let symbol = |row, column| if is_lit(row, column) { '#' } else { '.' };
    (0..15).map(|row| (0..15).map(|column| symbol(row, column)).collect()).collect()
}

#[test]
fn concave_faces_stay_inside_their_outline() {
    // The picture shows -10 to 10: a square of it is 4/3 wide. A U that is open above, and an arrow head.
    let u = "v -8.67 -8.67 0\nv 8.67 -8.67 0\nv 8.67 8.67 0\nv 4.67 8.67 0\nv 4.67 -4.67 0\nv -4.67 -4.67 0\nv -4.67 8.67 0\nv -8.67 8.67 0\n";
    let (side, base, none) = (".###.......###.", ".#############.", "...............");
    let rows: Vec<_> = (0..15)
        .map(|row| match row {
            0 | 14 => none,
            11.. => base,
            _ => side,
        })
        .collect();
    for faces in [
        "f 1 2 3 4 5 6 7 8\n",
        "f 8 7 6 5 4 3 2 1\n",
        "f 4 5 6 7 8 1 2 3\n",
        "f -3 -2 -1 1/1 2/1 3/1 4/1 5/1 # U\n",
    ] {
        assert_eq!(covered(&rendered(format!("{u}{faces}").as_bytes())), rows, "{faces}");
    }
    let head = "v -8 -8 0\nv 0 -4 0\nv 8 -8 0\nv 0 8 0\n";
    for face in ["f 1 2 3 4\n", "f 2 3 4 1\n", "f 3 4 1 2\n", "f 4 3 2 1\n"] {
        let picture = rendered(format!("{head}{face}").as_bytes());
        let is_lit = |x: i32, y: i32| picture.get_pixel((30 + 3 * x) as u32, (30 - 3 * y) as u32).0 == [255; 3];
        assert!(is_lit(0, 0) && is_lit(-6, -6) && is_lit(6, -6), "{face}");
        assert!(!is_lit(0, -6) && !is_lit(-4, -7) && !is_lit(4, -7), "{face}");
    }
}

#[test]
fn faces_that_cross_themselves_become_fans_with_one_warning() {
    let corners = "v -8 -8 0\nv 8 8 0\nv 8 -8 0\nv -8 8 0\nv 0 0 20\n";
    let (picture, warning) = warned(&format!("{corners}f 1 3 2 4\n\nf 1 2 3 4\nf 1 2 3 4 # again\n"));
    let expected = "warning: m.obj:8:1: this polygon crosses or touches itself (and one more like it): it becomes a fan of \
                    triangles around its first corner\n";
    assert_eq!(warning, expected);
    assert_eq!(picture, rendered(format!("{corners}f 1 3 2 4\n").as_bytes()));
    let (_, warning) = warned(&format!("{corners}f 1 5 3 2 -1 4\n"));
    assert!(
        warning.starts_with("warning: m.obj:6:1: this polygon is far from flat: it becomes a fan"),
        "{warning}"
    );
}

#[test]
fn what_is_no_mesh_is_named() {
    let stl = [&[b' '; 80][..], &2u32.to_le_bytes(), &[7; 100]].concat();
    for (bytes, what) in [
        (&b""[..], "the file is empty"),
        (b" \r\n\t\n\0\0", "the file is empty but for white space"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n", "a Git LFS pointer"),
        (b"\n  <!doctype HTML>\n<p>\nf 1 2 3", "an HTML page"),
        (b"<html><body>404", "an HTML page"),
        (b"<?xml version=\"1.0\"?><COLLADA>", "an XML document"),
        (b"ply\nformat ascii 1.0\nelement vertex 8\n", "a PLY model"),
        (b"solid cube\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "an STL model"),
        (&stl, "a binary STL model"),
        (b"OFF\n3 1 0\n0 0 0\n", "an OFF model"),
        (b"\x1f\x8b\x08\0\0\0\0\0", "compressed with gzip"),
        (b"PK\x03\x04\x14\0", "a ZIP archive"),
        (b"\x7fELF\x02\x01\x01\0\0\0", "an ELF object file"),
        (b"\x64\x86\x03\0\0\0\0\0", "a compiled object file (COFF"),
        (b"\x4c\x01\x03\0\0\0\0\0", "a compiled object file (COFF"),
        (b"{\"asset\": {\"version\": \"2.0\"}}", "JSON, as glTF models are"),
        (b"glTF\x02\0\0\0", "a binary glTF model"),
        (b"Kaydara FBX Binary  \0\x1a\0", "a binary FBX model"),
        (b"; FBX 7.3.0 project file\n", "an FBX model"),
        (b"\x89PNG\r\n\x1a\n\0\0", "a PNG picture"),
        (b"\xff\xd8\xff\xe0\0\x10JFIF", "a JPEG picture"),
        (b"newmtl red\nKd 1 0 0\n", "a material library (MTL)"),
        (
            b"# Blender MTL File: 'a.blend'\r\n# Material Count: 1\r\n\r\nnewmtl red\nKd 1 0 0\nd 1\n",
            "a material library (MTL)",
        ),
        (b"#\r\tnewmtl red\rKd 1 0 0\r", "a material library (MTL)"),
        (b"# made by hand\nOFF\n3 1 0\n", "an OFF model"),
        (b"../models/bunny.obj", "only a path, and seems to be a symbolic link that was stored as text"),
        (b"bunny_1k.OBJ\n", "only a path, and seems to be a symbolic link"),
        (b"../my models/bunny.obj", "only a path, and seems to be a symbolic link"),
        (b"..\\shared\\mesh", "only a path, and seems to be a symbolic link"),
        (SCENE.as_bytes(), "a scene"),
        (b"\x01\x02\x03\x04\x05\xf0\xf1\x06\x07\nf 1 2 x\n", "the file is binary"),
        (b"\x01\x02\x03\x04\x05\xf0\xf1\x06\x07\nl \x01\x02\np 1\n\x03", "the file is binary"),
        (b"\x01\x02\x03\x04\x05\xf0\xf1\x06\x07\nf\n\x03\x04", "the file is binary"),
    ] {
        let message = refusal(bytes);
        let start = "m.obj: this is no OBJ mesh: the file is ";
        assert!(message.starts_with(start) && message.contains(what), "{what}: {message}");
    }
    for (text, place) in [
        ("# an empty scene\n", "m.obj:1:1"),
        ("\n  Hello\nvn 0 0 1\n", "m.obj:2:3"),
        ("l 1 2\np 1\n", "m.obj:1:1"),
        ("https://example.org/bunny.obj\n", "m.obj:1:1"),
        ("bunny.obj\nteapot.obj\n", "m.obj:1:1"),
    ] {
        let message = refusal(text.as_bytes());
        let expected = format!("{place}: this is no OBJ mesh: no line is a vertex ('v') or a face ('f')");
        assert!(message.starts_with(&expected), "{message}");
    }
}

#[test]
fn a_mesh_may_begin_like_another_file() {
    let expected = rendered(KITE.as_bytes());
    // The second one of each is read another way, for its face has indices that count backwards.
    for start in ["newmtl red\nKd 1 0 0\n", "# c\nnewmtl red\n", "solid kite\n", "<kite>\n", "[1]\n", "off\n"] {
        for text in [KITE.to_owned(), KITE.replace("1 2 3 4", "-4 -3 -2 -1")] {
            assert_eq!(rendered(format!("{start}{text}").as_bytes()), expected, "{start}{text}");
        }
    }
    let message = refusal(format!("newmtl red\n{}", KITE.replace("3 4", "3 99")).as_bytes());
    assert!(message.starts_with("m.obj:6:9: there is no vertex 99: the file has 4"), "{message}");
    let message = refusal(format!("newmtl red\n{KITE}f 1 2 x\n").as_bytes());
    assert!(message.starts_with("m.obj:7:7: expected a vertex number, found 'x'"), "{message}");
}

#[test]
fn points_and_lines_are_counted_in_a_warning() {
    for (text, counts) in [
        ("v 0 0 0\nv 1 1 1\n", "vertices 2, points 0, lines 0, curves and surfaces 0"),
        ("v 0 0 0\nv 1 1 1\nl 1 2\nl 2 1\np 1 2 1\n", "vertices 2, points 3, lines 2, curves and surfaces 0"),
        ("v 0 0 0\nsurf 0 1 0 1 1\n", "vertices 1, points 0, lines 0, curves and surfaces 1"),
    ] {
        let (picture, warning) = warned(text);
        let expected = format!("warning: m.obj: no picture shows this mesh, for it has no face ({counts})\n");
        assert_eq!(warning, expected);
        assert!(picture.pixels().all(|pixel| pixel.0 == [0, 0, 0]));
    }
}
