//! Whole files, and all readers against a naive one.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::cell::Cell;
use vecmath::Vector3;

fn parsed(bytes: &[u8]) -> Result<ObjFile, Error> {
    parse_mesh(Path::new("m.obj"), bytes)
}

fn mesh(text: &str) -> Mesh {
    parsed(text.as_bytes()).unwrap().mesh
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn every_way_to_write_a_face_is_read() {
    for (faces, count) in [
        ("f 1 2 3\n", 1),
        ("f 1 2 3", 1),
        ("f 1 2 3\r\nf 1 3 4\r\n", 2),
        ("f 1 2 3 4\n", 2),
        ("f -4 -3 -2 -1\n", 2),
        ("f -4 2 -2 4\n", 2),
        ("vt 0 0\nvt 1 0\nf 1/1 2/2 3/1\n", 1),
        ("vn 0 0 1\nf 1//1 2//1 3//1\n", 1),
        ("vt 0\nvn -nan(ind) 0\nf 1/7/9 2/x/ 3/-1/1/1\n", 1),
        ("g a\nf 1 2 3\ng b\no c\nusemtl d\ns 1\nf 1 3 4\n", 2),
        ("l 1 2\np 1\n  f 1 2 3\n# f 9 9 9\n", 1),
        ("f\nf 1\nf 1 2\nf 1 2 3\n", 1),
        ("l 1 2\n", 0),
    ] {
        assert_eq!(mesh(&format!("{SQUARE}{faces}")).triangle_count(), count, "{faces:?}");
    }
}

#[test]
fn groups_and_texture_seams_do_not_tear_the_surface() {
    let roof = "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 -1 0\nvt 0 0\nvt 1 1\n";
    for last in ["f 1/2 4/2 2/2\n", "f -4/-1 4/2 -3/-1\n"] {
        let mesh = mesh(&format!("{roof}g one\nf 1/1 2/1 3/1\ng two\n{last}"));
        let normal = mesh.normal(0, [1.0, 0.0, 0.0]);
        let half = (0.5 as vecmath::Real).sqrt();
        assert!((normal - Vector3::new(-half, half, 0.0)).max_abs() < 1e-6, "{normal:?}");
    }
}

#[test]
fn coinciding_vertices_stay_apart() {
    let mesh = mesh("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 0 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 4 5 6\n");
    assert_eq!(mesh.normal(0, [1.0, 0.0, 0.0]), Vector3::new(0.0, 1.0, 0.0));
}

#[test]
fn a_vertex_that_no_face_uses_may_be_anywhere() {
    for faces in ["f 1 2 3\n", "f -5 2 3\nf 4 1\n"] {
        assert_eq!(mesh(&format!("{SQUARE}v nan inf 0\n{faces}")).triangle_count(), 1);
    }
}

#[test]
fn mistakes_are_found_with_line_and_column() {
    for (text, start) in [
        ("v 0 0 0\nv 1 x 0\n", "m.obj:2:5: expected a finite coordinate, found 'x'"),
        ("v 0 0\n", "m.obj:1:1: a vertex needs three coordinates, this one has 2"),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "m.obj:2:5: expected a finite coordinate, found 'nan'"),
        ("v inf 0 0\nv 1 nan 0\nv 0 1 0\nf 3 -2 3\n", "m.obj:2:5: expected a finite coordinate, found 'nan'"),
        ("v 0 0 1e39\nf 1 1 1\n", "m.obj:1:7: the coordinate '1e39' is too large (at most 3.4e38)"),
        ("v 3.1+e2 0 0\n", "m.obj:1:3: expected a finite coordinate, found '3.1+e2'"),
        ("v 0 0 0\nf 1 1 7\n", "m.obj:2:7: there is no vertex 7: the file has 1"),
        ("f 3 3 2\nv 0 0 0\nf 1 9 9\n", "m.obj:1:3: there is no vertex 3: the file has 1"),
        ("v 0 0 0\nf 1 1 0\n", "m.obj:2:7: there is no vertex 0"),
        ("v 0 0 0\nf 1/1 1 99999999999999999999/2\n", "m.obj:2:9: there is no vertex 99999999999999999999: the"),
        ("f -1 -1 -1\nv 0 0 0\n", "m.obj:1:3: there is no vertex -1: 0 stand before this face"),
        ("v 0 0 0\nf -9223372036854775808 1 1\n", "m.obj:2:3: there is no vertex -9223372036854775808"),
        ("v 0 0 0\nf 1 b 1\n", "m.obj:2:5: expected a vertex number, found 'b'"),
        ("v 0 0 0\nf 1 1.0 1\n", "m.obj:2:5: expected a vertex number, found '1.0'"),
        ("v 0 0 0\nf 1 1 \\\n  /2\n", "m.obj:3:3: expected a vertex number, found '/2'"),
        ("# é\rv 0 0 0 # é\rf 1 é 1\r", "m.obj:3:5: expected a vertex number, found 'é'"),
        ("\u{feff}v 0 x 0", "m.obj:1:5: expected a finite coordinate, found 'x'"),
    ] {
        let message = parsed(text.as_bytes()).unwrap_err().to_string();
        assert!(message.starts_with(start), "{text:?}: {message}");
    }
}

/// Positions of the corners of all triangles.
type Corners = Vec<[[f32; 3]; 3]>;

fn corners_of(faces: &Faces) -> Corners {
    faces.triangles.iter().map(|triangle| triangle.map(|corner| faces.positions[corner as usize])).collect()
}

/// Reads what the strategies below write, in the simplest way: vertices, then fans.
fn naive(text: &str) -> Option<Corners> {
    let lines = || text.lines().map(|line| line.split('#').next().unwrap().split_whitespace().collect::<Vec<_>>());
    let mut positions = Vec::new();
    for line in lines().filter(|line| line.first() == Some(&"v")) {
        positions
            .push([line.get(1)?, line.get(2)?, line.get(3)?].map(|word| word.parse::<f32>().unwrap_or(f32::NAN)));
    }
    let (mut vertices, mut all) = (0, Vec::new());
    for line in lines() {
        match line.first() {
            Some(&"v") => vertices += 1,
            Some(&("f" | "fo")) => {
                let corner = |word: &&str| {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number < 0 { vertices + number } else { number - 1 };
                    positions.get(usize::try_from(index).ok()?).copied()
                };
                let corners: Vec<[f32; 3]> = line[1..].iter().map(corner).collect::<Option<_>>()?;
                all.extend((2..corners.len()).map(|third| [corners[0], corners[third - 1], corners[third]]));
            }
            _ => {}
        }
    }
    all.as_flattened().as_flattened().iter().all(|coordinate| coordinate.is_finite()).then_some(all)
}

/// Words of a line, a blank between each two; `count` of them.
fn words(words: &'static [&'static str], count: std::ops::Range<usize>) -> impl Strategy<Value = String> {
    prop::collection::vec(prop::sample::select(words), count).prop_map(|words| words.join(" "))
}

/// Coordinates, what may stand behind them, and corners: mostly plain ones.
const COORDINATES: &[&str] = &["0", "1", "-2.5", "3.", ".5", "1e-3", "+7", "0.1234567", "-0", "1E2"];
const BEHIND: &[&str] = &["", "", "", "\r", "\t", " # c", " # f 1 2 3", "#"];
const PLAIN: &[&str] = &["1", "2", "3", "4/1", "5//2", "6/7/8", "7/x/", "8"];
const ANY: &[&str] =
    &["1", "2/-1", "3", "4", "5//-7", "6", "7", "8", "-1", "-2//3", "-8", "1", "2", "3", "4", "0", "99"];
const OTHER: &[&str] = &[
    "vn 0 0 nan",
    "vt",
    "g \u{e9}",
    "",
    "# v 1 2 3",
    "usemtl f 1 2 3",
    "l 1 2",
    "p 1 x\t2",
    "s off",
    "L 1",
    "#p 1",
];
/// Lines with other words, of which some must be reported.
const RARE: &[&str] = &[
    "p 1 2 # 3",
    "l#1",
    "p\u{a0}1",
    "F 1 2 3",
    "f1 2 3",
    "V",
    "surf 0 1 0 1 1 1",
    "curv2 1 2",
    "call m.obj",
    "bsp 1",
];

fn line() -> impl Strategy<Value = String> {
    let behind = || prop::sample::select(BEHIND);
    let vertex = (words(COORDINATES, 3..4), prop::sample::select(&["", "", " 1 0 0", " 1 x"][..]), behind());
    let keyword = prop::sample::select(&["f", "f", "f", "fo"][..]);
    let face = |corners, count| (keyword.clone(), words(corners, count), behind());
    let written = |(keyword, corners, behind)| format!("{keyword} {corners}{behind}");
    prop_oneof![
        8 => vertex.prop_map(|(numbers, colours, behind)| format!("v {numbers}{colours}{behind}")),
        8 => face(PLAIN, 3..4).prop_map(written),
        4 => face(PLAIN, 4..8).prop_map(written),
        1 => face(ANY, 0..6).prop_map(written),
        2 => words(OTHER, 1..2),
        1 => prop_oneof![19 => words(OTHER, 1..2), 1 => words(RARE, 1..2)],
    ]
}

#[test]
fn all_readers_read_the_same() {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let config = Config { cases: 3000, failure_persistence: None, ..Config::default() };
    let text = prop::collection::vec(line(), 0..40).prop_map(|lines| {
        let start: String = (0..8).map(|i| format!("v {i} 0.{i} -{i}e-1\n")).collect();
        start + &lines.join("\n")
    });
    let (plain_files, other_files) = (Cell::new(0), Cell::new(0));
    TestRunner::new_with_rng(config, rng)
        .run(&text, |text| {
            let source = source_text(Path::new("m.obj"), text.as_bytes());
            let clean = Clean::new(&source);
            let is_silent = clean.as_ref().is_ok_and(|clean| clean.warnings(&source).is_empty());
            let clean = clean.and_then(|clean| clean.read(&source));
            let expected = naive(&text);
            prop_assert_eq!(clean.as_ref().ok().map(corners_of), expected.clone(), "{}", text);
            if let Some(plain) = plain::read(text.as_bytes()) {
                let clean = clean.as_ref().unwrap();
                prop_assert_eq!(Some(corners_of(&plain)), expected, "{}", text);
                prop_assert_eq!((plain.polygons, plain.vertices), (clean.polygons.clone(), clean.vertices));
                prop_assert_eq!((plain.points, plain.lines), (clean.points, clean.lines), "{}", text);
                prop_assert!(is_silent, "{}", text);
                plain_files.set(plain_files.get() + 1);
            } else if clean.is_ok() {
                other_files.set(other_files.get() + 1);
            }
            Ok(())
        })
        .unwrap();
    assert!(plain_files.get() > 300 && other_files.get() > 300, "{plain_files:?} {other_files:?}");
}
