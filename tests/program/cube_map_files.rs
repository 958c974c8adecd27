//! Tests of cube maps as people have them: faces that are missing, broken, or spelt otherwise.

use crate::picture_files::{FACES, SCENE, chunk, fails, png};
use crate::support::{Folder, Run};

#[test]
fn a_cube_map_that_cannot_be_opened_is_named_at_its_place() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let message = |run: Run| {
        assert!(run.stderr.starts_with("error: s.txt:2:22: "), "{}", run.stderr);
        run.stderr
    };
    let run = "-input s.txt -output o.png -size 3 3";
    assert!(message(fails(&folder, run)).contains("the cube map folder 'map' does not exist"));
    for name in FACES {
        folder.write(&format!("map/{name}.png"), png());
    }
    assert_eq!(folder.a2(run).exit_code, 0);

    let jpeg = b"\xff\xd8\xff\xe0\0\x10JFIF\0\x01\x01\0\0\x01\0\x01\0\0";
    folder.write("map/right.png", jpeg);
    assert!(
        message(fails(&folder, run)).contains("right.png': this is no PNG picture: the file is a JPEG picture")
    );
    folder.write("map/right.png", b"BM\x46\0\0\0\0\0\0\0\x36\0\0\0");
    assert!(
        message(fails(&folder, run)).contains("right.png': this is no PNG picture: the file is a BMP picture")
    );

    std::fs::remove_file(folder.path("map/right.png")).unwrap();
    assert!(message(fails(&folder, run)).contains("right.png': cannot read the picture: "));
    folder.write("map/right.jpg", jpeg);
    assert!(message(fails(&folder, run)).contains("right.jpg': a face must be a PNG picture"));
}

/// What is broken is seen when a ray reaches the face, long after the scene was read.
#[test]
fn a_broken_face_is_shown_at_the_place_of_its_cube_map() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let whole = png();
    let head = chunk(b"IHDR", &[0, 0, 0, 9, 0, 0, 0, 7, 8, 2, 0, 0, 0]);
    let end = chunk(b"IEND", &[]);
    let with = |data: &[u8]| [&whole[..8], &head, &chunk(b"IDAT", data), &end].concat();
    let mut flipped = whole.clone();
    flipped[whole.len() - 20] ^= 1;
    let broken = [
        whole[..whole.len() - 20].to_vec(),
        flipped,
        with(b"no zlib"),
        // Stored bytes: a row with the unknown filter 9.
        with(&[&[0x78, 1, 1, 28, 0, 227, 255, 9][..], &[0; 27], &[0, 0x9c, 0, 10]].concat()),
    ];
    for name in FACES {
        folder.write(&format!("map/{name}.png"), png());
    }
    for (index, bytes) in broken.iter().enumerate() {
        folder.write("map/right.png", bytes);
        for run in ["s.txt -output o.png -size 3 3", "s.txt -check", "s.txt -output o.png -plain"] {
            let said = fails(&folder, run).stderr;
            let start = "error: s.txt:2:22: cube map face 'map/right.png': cannot read this picture: ";
            assert!(said.starts_with(start) && said.contains("2 | Background { cubeMap map }"), "{index}: {said}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_face_whose_name_has_other_capitals_is_read_with_a_hint() {
    let folder = Folder::new();
    for name in FACES {
        folder.write(&format!("map/{name}.png"), png());
    }
    folder.write("s.txt", SCENE);
    folder.a2("s.txt -output a.png");
    std::fs::rename(folder.path("map/right.png"), folder.path("map/Right.PNG")).unwrap();
    let run = folder.a2("s.txt -output b.png");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let hint = "hint: s.txt:2:22: there is no 'right.png': 'map/Right.PNG' is read\n";
    assert!(run.stderr.starts_with(hint), "{}", run.stderr);
    assert_eq!(folder.a2("-compare a.png b.png -tolerance 0 0").exit_code, 0);
    // It is an input like any other.
    let run = fails(&folder, "s.txt -output map/Right.PNG");
    assert!(run.stderr.contains("map/Right.PNG"), "{}", run.stderr);
    // A part is only a part of the picture with this face.
    assert_eq!(folder.a2("s.txt -output p.png -tile 1/1").exit_code, 0);
    assert_eq!(
        folder.a2("s.txt -output p.png -tile 1/1 -skip-done").stderr,
        "nothing is rendered: the pictures are done\n"
    );
    folder.write("map/Right.PNG", [&png()[..8 + 25], &chunk(b"tEXt", b"a\0b"), &png()[8 + 25..]].concat());
    assert!(!folder.a2("s.txt -output p.png -tile 1/1 -skip-done").stderr.contains("nothing"), "the face changed");
    std::fs::rename(folder.path("map/Right.PNG"), folder.path("map/rigth.png")).unwrap();
    let said = fails(&folder, "s.txt -output b.png").stderr;
    assert!(
        said.contains("right.png': cannot read the picture: ") && said.contains("did you mean 'rigth.png'?"),
        "{said}"
    );
}

/// A device has no size and never ends.
#[test]
fn a_folder_whose_name_is_nearly_right_is_found_or_suggested() {
    let folder = Folder::new();
    for face in FACES {
        folder.write(&format!("Sky/Day/{face}.png"), png());
    }
    for name in ["sky/day", "Sky\\Day"] {
        folder.write("s.txt", SCENE.replace("map", name));
        let run = folder.a2("-input s.txt -output o.png -size 9 9");
        assert_eq!(run.exit_code, 0, "{name}: {}", run.stderr);
        let expected = format!("s.txt:2:22: there is no '{name}': 'Sky/Day' is read");
        // Where capitals do not count, the file system finds it.
        assert!(run.stderr.contains(&expected) || !cfg!(target_os = "linux"), "{}", run.stderr);
    }
    folder.write("s.txt", SCENE.replace("map", "Sky/Dax"));
    let run = fails(&folder, "-input s.txt -output o.png");
    assert!(run.stderr.contains("did you mean 'Sky/Day'?"), "{}", run.stderr);
}
