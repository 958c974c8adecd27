//! Mesh files as people have them: every way to write one, and what is said about those that are none.

use crate::support::{Folder, Run, SCENE, TRIANGLE, middle};
use image::RgbImage;

/// Renders a scene with the mesh `m.obj`, white from both sides.
fn with_mesh(folder: &Folder, mesh: &[u8]) -> Run {
    let scene = SCENE.replace("color 0 0 0", "color 0 0 0 ambientLight 1 1 1");
    folder.write("s.txt", scene.replace(TRIANGLE, "TriangleMesh { obj_file m.obj }")).write("m.obj", mesh);
    folder.a2("-input s.txt -output o.png -size 60 60")
}

/// Renders a mesh that must be read without a word.
fn rendered(mesh: &[u8]) -> RgbImage {
    let folder = Folder::new();
    let run = with_mesh(&folder, mesh);
    let text = String::from_utf8_lossy(mesh);
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{text}");
    folder.picture("o.png")
}

/// Renders a mesh that may be warned about; returns the picture and the warnings.
fn warned(mesh: &str) -> (RgbImage, String) {
    let folder = Folder::new();
    let run = with_mesh(&folder, mesh.as_bytes());
    assert_eq!(run.exit_code, 0, "{mesh}: {}", run.stderr);
    (folder.picture("o.png"), run.stderr)
}

fn refusal(mesh: &[u8]) -> String {
    let run = with_mesh(&Folder::new(), mesh);
    assert_eq!(run.exit_code, 1, "{}: {}", String::from_utf8_lossy(mesh), run.stderr);
    run.stderr.strip_prefix("error: ").unwrap_or_else(|| panic!("{}", run.stderr)).to_owned()
}

/// A kite of two triangles.
const KITE: &str = "v -2 0 0\nv 0 -3 0\nv 2 0 0\nv 0 1.5 0\nf 1 2 3 4\n";

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
        // Lines that no picture shows.
        KITE.replace("f ", "vt 0.5\nvt\nvt 1.#INF 3.1+e2\nf "),
        KITE.replace("f ", "vn -nan(ind) -nan(ind) -nan(ind)\nvn 1\nf "),
        KITE.replace("f ", "g f\no v\ns 1\nusemtl f 1 2 3\nvp 1 2\ncstype bezier\nl 1 2\np 3\nf "),
        format!("v 1.#QNAN\n{KITE}").replace("v 1.#QNAN", "vx 1.#QNAN"),
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

#[test]
fn points_and_lines_are_counted_in_a_warning() {
    for (text, counts) in [
        ("v 0 0 0\nv 1 1 1\n", "2 vertices, 0 points, 0 lines, 0 curves and free-form surfaces"),
        (
            "v 0 0 0\nv 1 1 1\nl 1 2\nl 2 1\np 1 2 1\n",
            "2 vertices, 3 points, 2 lines, 0 curves and free-form surfaces",
        ),
        ("v 0 0 0\nsurf 0 1 0 1 1\n", "1 vertices, 0 points, 0 lines, 1 curves and free-form surfaces"),
    ] {
        let (picture, warning) = warned(text);
        assert_eq!(warning, format!("warning: m.obj: no picture shows this mesh: it has {counts}, and no face\n"));
        assert!(picture.pixels().all(|pixel| pixel.0 == [0, 0, 0]));
    }
}
