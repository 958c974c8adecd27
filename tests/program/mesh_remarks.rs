//! Tests of the warnings about what a mesh file holds besides faces, and about its vertices.

use crate::meshes::{KITE, refusal, rendered, warned};

/// The warnings about the kite with further lines, which do not change the picture.
fn warnings(lines: &str) -> String {
    let (picture, warnings) = warned(&format!("{KITE}{lines}"));
    assert_eq!(picture, rendered(KITE.as_bytes()), "{lines}");
    warnings
}

#[test]
fn curves_and_surfaces_beside_faces_are_named_in_one_warning() {
    let all = "curv 0 1 1 2\ncurv2 1 2\nsurf 0 1 0 1 1 2 3 4\nbzp 1\nbsp 1\ncdc 1\ncdp 1\ncall m2.obj\n";
    for (lines, place, left_out) in [
        ("curv 0 1 1 2\n", "6:1", "curv 1"),
        ("l 1 2\n  surf 0 1 0 1 1 2 3 4\ncurv 0 1 1 2\nsurf 0\n", "7:3", "surf 2, curv 1"),
        ("call other.obj\n", "6:1", "call 1"),
        (all, "6:1", "curv 1, curv2 1, surf 1, bzp 1, bsp 1, cdc 1, cdp 1, call 1"),
    ] {
        let expected = format!(
            "warning: m.obj:{place}: only faces are shown, and what else the file describes is left out: {left_out}\n"
        );
        assert_eq!(warnings(lines), expected, "{lines}");
    }
    let (_, warnings) = warned("v 0 0 0\ncall other.obj\nbsp 1\n");
    let expected = "warning: m.obj: no picture shows this mesh, for it has no face (vertices 1, points 0, lines 0, curves \
                    and surfaces 1)\nwarning: m.obj:2:1: only faces are shown, and what else the file describes is left \
                    out: call 1, bsp 1\n";
    assert_eq!(warnings, expected);
}

#[test]
fn slips_of_keywords_are_found() {
    for (lines, place, word, others) in [
        ("F 1 2 3\n", "6:1", "F", ""),
        ("f1 2 3\n", "6:1", "f1", ""),
        ("# F 1 2 3\n V -1 0 0\nF 1/1 2/2 3/3\n", "7:2", "V", " (and one more like it)"),
        ("v2 3 4 5\nv-1 0 0\nV.5 1 1\nf-1 -2 -3\n", "6:1", "v2", " (and 3 more like it)"),
        ("FO 1 2 3\n", "6:1", "FO", ""),
        ("f: 1 3 4\n", "6:1", "f:", ""),
        ("f,1,3,4\nface 1 2 3\n", "6:1", "f,1,3,4", " (and one more like it)"),
        ("f/1 3 4\n", "6:1", "f/1", ""),
        ("quad 1 2 3 4\nvx 1 2 3\n", "6:1", "quad", " (and one more like it)"),
        ("1 3 4\n  (f 1 3 4)\n", "6:1", "1", " (and one more like it)"),
        ("\u{ff46} 1 3 4\n\u{432} 1 3 4\n", "6:1", "\u{ff46}", " (and one more like it)"),
        ("<<<<<<< HEAD\n=======\n>>>>>>> other\n", "6:1", "<<<<<<<", " (and 2 more like it)"),
        ("=======\n", "6:1", "=======", ""),
    ] {
        let expected = format!(
            "warning: m.obj:{place}: '{word}' is no keyword as 'v' and 'f' are, and this line is left out{others}\n"
        );
        assert_eq!(warnings(lines), expected, "{lines}");
    }
    for lines in [
        "F\n",
        "V ray\n",
        "VN 0 0 1\n",
        "face of a cube\n",
        "csh -echo 1\n",
        "Kd 0.8 0.8 0.8\n",
        "vw 0 0 1\n",
        "made on Monday\n",
    ] {
        assert_eq!(warnings(lines), "", "{lines}");
    }
    // What is missing may be what was left out.
    let commas = KITE.replace(' ', ",").replace("f,1,2,3,4", "f 1 2 3 4");
    for (text, keyword) in [(KITE.replace('v', "V"), "V"), (commas, "v,-2,0,0")] {
        let message = refusal(text.as_bytes());
        let slip = format!(
            "m.obj:1:1: '{keyword}' is no keyword as 'v' and 'f' are, and this line is left out (and 3 more"
        );
        assert!(message.contains("there is no vertex 1: ") && message.contains(&slip), "{message}");
    }
    // A space of no width is read as one.
    assert_eq!(warned(&KITE.replace("f ", "\u{200b}f\u{2060} ")), (rendered(KITE.as_bytes()), String::new()));
}

#[test]
fn where_no_line_is_read_the_message_says_why() {
    for (text, place, help) in [
        ("g a\nV 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n", "2:1", "vertices are written 'v 1 2 3', faces 'f 1 2 3'"),
        ("# all\ncall other.obj\n", "2:1", "'call' names another file, which is not read"),
    ] {
        let message = refusal(text.as_bytes());
        let start = format!("m.obj:{place}: this is no OBJ mesh: no line is a vertex ('v') or a face ('f')\n");
        assert!(message.starts_with(&start) && message.contains(help), "{message}");
    }
}

/// The kite, moved.
fn kite_at(x: f64, y: f64, z: f64) -> String {
    let corners = [[-2.0, 0.0], [0.0, -3.0], [2.0, 0.0], [0.0, 1.5]];
    let vertices: String = corners.iter().map(|[u, v]| format!("v {} {} {z}\n", u + x, v + y)).collect();
    vertices + "f 1 2 3 4\n"
}

#[test]
fn a_small_mesh_far_away_is_rounded_with_a_warning() {
    let far = kite_at(500_123.25, 4_649_776.5, 30.0);
    let expected = "warning: m.obj: coordinates that go up to 4649778.0 are rounded to steps of 0.5, and triangles there are only \
                    4.0e0 long: subtract 500123.25 4649776.0 30.0 from its vertices, and either from camera and lights, \
                    too, or move the mesh back by Translate 500123.25 4649776.0 30.0\n";
    for text in [far.clone(), far.replace("1 2 3 4", "-4 -3 -2 -1"), far.replace('\n', " # a comment\n")] {
        let (_, warnings) = warned(&text);
        assert_eq!(warnings, expected, "{text}");
    }
    // Neighbours of 240,000 are 1/64 apart, of 280,000 twice as much; edges of the kite are 4 long. Beside it stand others.
    let others = "v 90000 0 0\nv 90000 9 0\nv 90000 0 9\n".to_owned() + &"f 1 2 3\n".repeat(7);
    for (text, is_warned) in [
        (kite_at(240_000.0, 0.0, 0.0), false),
        (kite_at(0.0, -280_000.0, 0.0), true),
        (others.clone() + &kite_at(280_000.0, 0.0, 0.0).replace("1 2 3 4", "4 5 6 7"), false),
        (
            others.replace("f 1 2 3\nf 1 2 3\n", "f 1 2 3\n")
                + &kite_at(280_000.0, 0.0, 0.0).replace("1 2 3 4", "4 5 6 7"),
            true,
        ),
        (kite_at(0.0, 0.0, 4_649_776.0), false),
        (KITE.replace("f 1", "v 4649776 0 0\nf 1"), false),
        (KITE.replace("v 0 1.5 0", "v 0 9999999 0"), false),
        ("v 1e-30 0 0\nv 0 1e-30 0\nv 0 0 0\nf 1 2 3\n".to_owned(), false),
        ("v 1e38 0 0\nv 3e38 1e38 0\nv 3.4e38 0 0\nf 1 2 3\n".to_owned(), false),
    ] {
        let (_, warnings) = warned(&text);
        assert_eq!(warnings.contains("are rounded to steps of"), is_warned, "{text}{warnings}");
    }
}

#[test]
fn parts_of_a_mesh_that_are_far_apart_are_better_files_of_their_own() {
    let (_, warnings) = warned(&(KITE.to_owned() + &kite_at(1e6, 0.0, 0.0).replace("1 2 3 4", "5 6 7 8")));
    let expected = "warning: m.obj: coordinates that go up to 1000002.0 are rounded to steps of 0.0625, and triangles there are \
                    only 4.0e0 long: give parts that are far apart files of their own, near the origin, and move them by \
                    Translate\n";
    assert_eq!(warnings, expected);
}

#[test]
fn a_mesh_without_area_is_empty_with_a_warning() {
    let expected = "warning: m.obj: no picture shows this mesh, for none of its triangles has an area\n";
    for text in [
        "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n",
        "v 0 0 0\nv 1 1 1\nv 2 2 2\nf -3 -2 -1\nf 1 1 2\n",
        "v 4649776 9 9\nv 4649776 9 9\nf 1 2 1\nf 1 1 1 1\n",
    ] {
        let (picture, warnings) = warned(text);
        assert_eq!(warnings, expected, "{text}");
        assert!(picture.pixels().all(|pixel| pixel.0 == [0, 0, 0]));
    }
    let lines = "f 1 1 2\nf 1 2 1 2\n";
    assert_eq!(warnings(lines), "");
}
