//! What the program says to mistakes that newcomers make in scenes: each message names what to do.

use crate::parse_errors::{refusal, with_material};
use crate::support::Folder;

/// Every scene has a camera, a material and a sphere, in which `from` is replaced by `to`.
pub fn broken(from: &str, to: &str) -> String {
    let sphere =
        "Group {\n  numObjects 1\n  MaterialIndex 0\n  Sphere {\n    center 0 0 0\n    radius 1\n  }\n}\n";
    let scene = with_material(sphere);
    assert_eq!(scene.matches(from).count(), 1, "{from}");
    scene.replace(from, to)
}

/// Runs a scene that must be refused with this message and hint, and with no other one.
pub fn says(scene: &str, message: &str, hint: &str) {
    let said = refusal(scene);
    assert!(said.starts_with(message), "{scene}\nexpected {message}\nfound    {said}");
    assert!(said.contains(hint), "{scene}\nexpected {hint}\nin       {said}");
    assert_eq!(said.matches("s.txt:").count(), 1, "{scene}\n{said}");
}

#[test]
fn too_many_and_too_few_numbers_are_counted() {
    for (from, to, message) in [
        ("center 0 0 0", "center 0 0 0 10", "s.txt:7:18: 'center' takes 3 numbers, and this is a 4th"),
        ("radius 1", "radius 1 2 3", "s.txt:8:14: 'radius' takes 1 number, and this is a 2nd"),
        (
            "center 0 0 0",
            "center 0 0",
            "s.txt:8:5: 'center' takes 3 numbers, and 'radius' stands in the place of the 3rd",
        ),
        (
            "center 0 0 0",
            "center 0",
            "s.txt:8:5: 'center' takes 3 numbers, and 'radius' stands in the place of the 2nd",
        ),
        ("numObjects 1", "numObjects 1 2", "s.txt:4:16: 'numObjects' takes 1 number, and this is a 2nd"),
        ("MaterialIndex 0", "MaterialIndex 0 1", "s.txt:5:19: 'MaterialIndex' takes 1 number, and this is a 2nd"),
        ("angle 90", "angle 90 60", "s.txt:1:70: 'angle' takes 1 number, and this is a 2nd"),
    ] {
        says(&broken(from, to), message, "");
    }
}

#[test]
fn a_colour_of_hexadecimal_digits_is_a_comment() {
    for (typed, numbers) in
        [("#336699", "0.2 0.4 0.6"), ("#f80", "1 0.533 0"), ("#4080FF // blue", "0.251 0.502 1")]
    {
        let background = format!("Background {{\n  color {typed}\n}}\nGroup {{ numObjects 0 }}");
        let hint = format!("write '{numbers}' instead of '{}'", &typed.split(' ').next().unwrap());
        says(&with_material(&background), "s.txt:4:9: '#' begins a comment, and 'color' takes 3 numbers", &hint);
    }
    for comment in ["# blue", "#33669g", "#\u{e9}\u{e9}\u{e9}", "# 336699"] {
        let background = format!("Background {{ color {comment}\n}}\nGroup {{ numObjects 0 }}");
        says(&with_material(&background), "s.txt:4:1: expected a number for 'color', found '}'", "");
    }
}

#[test]
fn the_punctuation_of_other_formats_is_named() {
    for (from, to, message) in [
        ("center 0 0 0", "center 0, 0 0", "s.txt:7:12: scenes have no commas: write '0 0 0' instead of '0, 0 0'"),
        (
            "center 0 0 0",
            "center 0.2, 0, 0.6;",
            "s.txt:7:12: scenes have no commas or semicolons: write '0.2 0 0.6' instead of '0.2, 0, 0.6;'",
        ),
        ("center 0 0 0", "center 0,\n0 0", "s.txt:7:12: scenes have no commas: write '0' instead of '0,'"),
        (
            "center 0 0 0",
            "center (0,0,0)",
            "s.txt:7:12: scenes have no commas or parentheses: write '0 0 0' instead of '(0,0,0)'",
        ),
        ("radius 1", "radius 1;", "s.txt:8:12: scenes have no semicolons: write '1' instead of '1;'"),
        ("radius 1", "radius 1,5", "s.txt:8:12: scenes have no commas: write '1.5' instead of '1,5'"),
        (
            "center 0 0 0",
            "center 0,5 -1 1,25",
            "s.txt:7:12: scenes have no commas: write '0.5 -1 1.25' instead of '0,5 -1 1,25'",
        ),
        ("center 0 0 0", "center 1,2,3", "s.txt:7:12: scenes have no commas: write '1 2 3' instead of '1,2,3'"),
        ("radius 1", "radius = 1", "s.txt:8:12: scenes have no equal signs: write '1' instead of '= 1'"),
        ("radius 1", "radius=1", "s.txt:8:5: scenes have no equal signs: write 'radius 1' instead of 'radius=1'"),
        ("radius 1", "radius: 1", "s.txt:8:5: scenes have no colons: write 'radius' instead of 'radius:'"),
        ("radius 1", "radius 1.0f", "s.txt:8:12: numbers have no suffix: write '1.0' instead of '1.0f'"),
        ("numObjects 1", "numObjects 1;", "s.txt:4:14: scenes have no semicolons"),
    ] {
        says(&broken(from, to), message, "");
    }
}

#[test]
fn a_comment_may_stand_right_behind_a_number() {
    let folder = Folder::new();
    let picture = |text: &str| {
        folder.write("s.txt", text);
        let run = folder.a2("s.txt -output o.png -size 9 9 -quiet");
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{text}");
        folder.picture("o.png")
    };
    let plain = picture(&broken("radius 1", "radius 1"));
    for (from, to) in [
        ("radius 1", "radius 1#c"),
        ("radius 1", "radius 1// c"),
        ("center 0 0 0", "center 0 0#{\n0//}"),
        ("numObjects 1", "numObjects 1#one"),
        ("MaterialIndex 0", "MaterialIndex 0// red"),
    ] {
        assert!(picture(&broken(from, to)) == plain, "{to}");
    }
    for (from, to, message) in [
        ("radius 1", "radius 1x#c", "s.txt:8:12: expected a number for 'radius', found '1x#c'"),
        ("radius 1", "radius 1/2", "s.txt:8:12: expected a number for 'radius', found '1/2'"),
        ("radius 1", "radius#c\n1", "s.txt:8:5: a comment begins with a space before '#': write 'radius #'"),
        ("Group {\n", "Group// all\n{", "s.txt:3:1: a comment begins with a space before '//': write 'Group //'"),
    ] {
        let said = refusal(&broken(from, to));
        assert!(said.starts_with(message), "{said}");
    }
}

#[test]
fn a_mistake_is_shown_once() {
    for mistake in ["30;", "\u{2212}30"] {
        let scene = with_material(&format!("Group {{ numObjects 1 MaterialIndex 0 Triangle {mistake} }} }}"));
        says(&scene, "s.txt:3:47: ", "instead of");
    }
}

#[test]
fn characters_that_look_like_ascii_are_named() {
    for (from, to, message, hint) in [
        (
            "radius 1",
            "radius \u{2212}1",
            "s.txt:8:12: '\u{2212}' (U+2212) is a minus sign of typesetting: type '-'",
            "write '-1'",
        ),
        ("Sphere {", "Sphere\u{ff5b}", "s.txt:6:9: '\u{ff5b}' (U+FF5B) is a full-width character: type '{'", ""),
        ("Sphere {", "Sphere \u{ff5b}", "s.txt:6:10: '\u{ff5b}' (U+FF5B) is a full-width character: type '{'", ""),
        (
            "radius 1",
            "radius \u{ff11}\u{ff10}",
            "s.txt:8:12: '\u{ff11}' (U+FF11) is a full-width character: type '1'",
            "write '10'",
        ),
        (
            "center 0 0 0",
            "center 0\u{ff0c} 0 0",
            "s.txt:7:13: '\u{ff0c}' (U+FF0C) is a full-width character, and scenes have no commas",
            "write '0 0 0' instead of '0\u{ff0c} 0 0'",
        ),
        (
            "center 0 0 0",
            "center 0.2\u{ff0c}0\u{ff0c}0.6\u{ff1b}",
            "s.txt:7:15: '\u{ff0c}' (U+FF0C) is a full-width character, and scenes have no commas",
            "write '0.2 0 0.6' instead of",
        ),
        (
            "radius 1",
            "radius\u{ff1a} 1",
            "s.txt:8:11: '\u{ff1a}' (U+FF1A) is a full-width character, and scenes have no colons",
            "write 'radius' instead of",
        ),
        (
            "radius 1",
            "radius \u{ff1d} 1",
            "s.txt:8:12: '\u{ff1d}' (U+FF1D) is a full-width character, and scenes have no equal signs",
            "write '1' instead of '\u{ff1d} 1'",
        ),
        (
            "numObjects 1",
            "numObjects \u{ff11}",
            "s.txt:4:14: '\u{ff11}' (U+FF11) is a full-width character: type '1'",
            "",
        ),
        (
            "radius 1",
            "r\u{430}dius 1",
            "s.txt:8:6: '\u{430}' (U+0430) stands in a word that has ASCII letters only",
            "",
        ),
    ] {
        says(&broken(from, to), message, hint);
    }
    says(
        &broken("radius 1\n  }", "radius 1\n  \u{ff5d}"),
        "s.txt:9:3: '\u{ff5d}' (U+FF5D) is a full-width character: type '}'",
        "",
    );
    // A full-width space is a space here.
    let folder = Folder::new();
    folder.write("s.txt", broken("radius 1", "radius\u{3000}1"));
    let run = folder.a2("s.txt -output o.png -size 2 2");
    let hint = "hint: s.txt:8:11: a full-width space (U+3000) stands here, which other programs may not take for one: type ' '\n";
    assert!(run.exit_code == 0 && run.stderr.starts_with(hint), "{}", run.stderr);
}

#[test]
fn words_of_other_formats_get_their_equivalent() {
    for (from, to, message, hint) in [
        (
            "Material { }",
            "Material { exponent 3 }",
            "s.txt:2:39: this scene format has no 'exponent'",
            "'shininess'",
        ),
        (
            "Material { }",
            "Material { reflectiveColor 1 1 1 }",
            "s.txt:2:39: this scene format has no 'reflectiveColor'",
            "'specularColor'",
        ),
        (
            "angle 90",
            "angle 90 width 100 height 100",
            "s.txt:1:70: this scene format has no 'width'",
            "'-size W H' on the command line",
        ),
        ("angle 90", "fov 90", "s.txt:1:61: this scene format has no 'fov'", "'angle'"),
        (
            "Sphere {",
            "Cylinder {",
            "s.txt:6:3: this scene format has no 'Cylinder'",
            "'TriangleMesh { obj_file NAME.obj }'",
        ),
    ] {
        let said = refusal(&broken(from, to));
        assert!(said.starts_with(message), "{said}");
        assert!(said.contains(hint), "{said}");
    }
}

#[test]
fn text_in_another_encoding_is_named_unless_it_is_a_comment() {
    let in_gbk = |text: &str| {
        let name = b"\xc7\xf2\xcc\xe5{";
        let (before, after) = text.split_once("NAME").unwrap();
        [before.as_bytes(), name, after.as_bytes()].concat()
    };
    let folder = Folder::new();
    folder.write("s.txt", in_gbk(&broken("Sphere {", "# NAME\n  Sphere {")));
    let run = folder.a2("-input s.txt -output o.png -size 2 2 -quiet");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    folder.write("s.txt", in_gbk(&broken("Sphere {", "TriangleMesh { obj_file NAME } Sphere {")));
    let run = folder.a2("-input s.txt -output o.png -size 2 2");
    let message = "error: s.txt:6:27: this is not UTF-8 text, but probably GBK: save the file as UTF-8\n";
    assert!(run.exit_code == 1 && run.stderr.starts_with(message), "{}", run.stderr);
    folder.write(
        "s.txt",
        broken("Sphere", "Sphere").encode_utf16().fold(vec![0xff, 0xfe], |mut bytes, unit| {
            bytes.extend(unit.to_le_bytes());
            bytes
        }),
    );
    let run = folder.a2("-input s.txt -output o.png -size 2 2");
    assert_eq!(run.stderr, "error: s.txt: this is UTF-16 text: save the file as UTF-8\n");
    for bytes_of in [u16::to_le_bytes, u16::to_be_bytes] {
        let without_mark: Vec<u8> = broken("radius 1", "radius 1").encode_utf16().flat_map(bytes_of).collect();
        folder.write("s.txt", without_mark);
        let run = folder.a2("-input s.txt -output o.png");
        assert_eq!(run.stderr, "error: s.txt: this is UTF-16 text: save the file as UTF-8\n");
    }
    // What old programs put at the end of a file.
    for end in ["\0", "\x1a", "\n\0\0 \x1a\r\n"] {
        folder.write("s.txt", broken("radius 1", "radius 1") + end);
        let run = folder.a2("-input s.txt -output o.png -size 2 2 -quiet");
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{end:?}");
    }
    folder.write("s.txt", "\0\0");
    assert!(folder.a2("-input s.txt -output o.png").stderr.contains("the scene has no 'PerspectiveCamera' block"));
}

#[test]
fn a_scene_or_cube_map_that_is_not_there_is_looked_for() {
    let folder = Folder::new();
    folder.write("scene01.txt", "").write("b.txt", "").write("maps/sky/up.png", "").write("maps/notes.txt", "");
    for (name, help) in [
        ("scene1.txt", "did you mean 'scene01.txt'?"),
        ("Scene01.txt", "did you mean 'scene01.txt'?"),
        ("teapot.txt", "this folder holds b.txt, s.txt, scene01.txt"),
        ("scenes/teapot.txt", "there is no folder 'scenes'"),
        ("maps/sky/teapot.txt", "'maps/sky' holds no .txt file"),
    ] {
        folder.write("s.txt", "");
        let run = folder.a2(&format!("-input {name} -output o.png"));
        let message = format!(
            "error: {name}: cannot read the scene: No such file or directory (os error 2)\nhelp: {help}\n"
        );
        if cfg!(target_os = "linux") {
            assert_eq!((run.exit_code, run.stderr), (1, message));
        }
    }
    for (name, hint) in [("maps/sk", "did you mean 'maps/sky'?"), ("maps/ocean", "'maps' holds sky")] {
        folder.write(
            "s.txt",
            with_material(&format!("Background {{\n  cubeMap {name} }} Group {{ numObjects 0 }}")),
        );
        let run = folder.a2("-input s.txt -output o.png");
        let message = format!("error: s.txt:4:11: the cube map folder '{name}' does not exist\n");
        assert!(
            run.stderr.starts_with(&message) && run.stderr.contains(&format!("help: {hint}")),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn all_mistakes_are_shown_at_once() {
    let scene = "PerspectiveCamera { center 0 0 10 direction 0 0 0 up 0 1 0 angle 90 }
Lights { numLights 1 PointLight { position 0, 5 5 color 1 1 1 } }
Background { cubeMap nowhere }
Materials { numMaterials 2 Material { difuseColor 1 1 1 } Material { shininess -3 } }
Group {
    numObjects 5
    MaterialIndex 0
    Sphere { center 0 0 0 radius abc }
    Transform { Scale 1 0 1 Sphere { center 0 0 0 radius 1 } }
    Transform { Rotate { 0 0 1 } Sphere { center 0 0 0 radius 1 } }
    TriangleMesh { obj_file none.obj }
    Plane { normal 0 1 0 offset 1 offset 2 }
}
";
    let said = refusal(scene);
    let places: Vec<&str> =
        said.lines().filter_map(|line| line.trim_start_matches("error: ").strip_prefix("s.txt:")).collect();
    let expected = [
        "1:35: 'direction' has no length",
        "2:44: scenes have no commas",
        "3:22: the cube map folder 'nowhere' does not exist",
        "4:39: 'Material' has no 'difuseColor'",
        "4:70: 'shininess' must be 0 or above",
        "8:34: expected a number for 'radius', found 'abc'",
        "9:17: this transformation squashes space flat",
        "10:32: 'Rotate' takes 4 numbers, and '}' stands in the place of the 4th",
        "11:29: cannot read the mesh 'none.obj'",
        "12:35: a second 'offset' in line 12",
    ];
    assert_eq!(places.len(), expected.len(), "{said}");
    for (place, expected) in places.iter().zip(expected) {
        assert!(place.starts_with(expected), "expected {expected}\nfound    {place}");
    }
    assert!(said.ends_with("\nerror: 10 mistakes or more: these are the first\n"), "{said}");
}
