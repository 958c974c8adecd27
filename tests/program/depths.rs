//! `-depth auto` and `-depth-background`.

use crate::measuring::succeeds;
use crate::support::{Folder, SCENE, TRIANGLE, middle, project};

#[test]
fn an_empty_range_is_a_warning_and_the_widest_one_is_grey() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (range, shown) in [("7 7", "7 7"), ("1e-320 1e-320", "1e-320 1e-320"), ("-1e300 -1e300", "-1e300 -1e300")]
    {
        let run = folder.a2(&format!("-input s.txt -quiet -depth {range} d.png"));
        let expected = format!("warning: the range of -depth {shown} is empty, so that its picture is black");
        assert!(run.exit_code == 0 && run.stderr.starts_with(&expected), "{}", run.stderr);
    }
    for range in ["-1e308 1e308", "1e308 -1e308"].into_iter().filter(|_| cfg!(not(feature = "f32"))) {
        let run = folder.a2(&format!("-input s.txt -depth {range} d.png"));
        assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
        let picture = folder.picture("d.png");
        assert_eq!((middle(&picture), picture.get_pixel(0, 0).0), ([127; 3], [0; 3]), "{range}");
    }
}

#[test]
fn the_range_found_gives_the_same_picture_when_it_is_typed() {
    let folder = Folder::new();
    for (scene, flags) in [
        ("scene01_plane", ""),
        ("scene05_bunny_200", "-jitter"),
        ("scene07_arch", "-filter"),
        ("scene02_cube", "-plain"),
    ] {
        let line = format!("-input {} -size 60 40 {flags}", project(&format!("data/{scene}.txt")).display());
        let run = succeeds(&folder, &format!("{line} -depth auto a.png"));
        let (_, typed) = run.stderr.split_once('(').unwrap_or_else(|| panic!("{}", run.stderr));
        let typed = typed.strip_suffix(" gives the same picture)\n").unwrap();
        let again = succeeds(&folder, &format!("{line} {typed} b.png"));
        assert_eq!(again.stderr, "");
        assert!(folder.picture("a.png") == folder.picture("b.png"), "{scene}: {typed}");
        // All levels are used: a range that fits has both ends in the picture.
        let levels = || {
            folder.picture("a.png").pixels().map(|pixel| pixel.0[0]).filter(|&level| level > 0).collect::<Vec<_>>()
        };
        assert!(levels().iter().min() < Some(&10) && levels().iter().max() > Some(&240), "{scene}: {typed}");
    }
}

#[test]
fn a_range_that_is_found_is_reported() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let run = succeeds(&folder, "-input s.txt -size 21 21 -depth auto d.png -output o.png -report r.json");
    assert!(run.stderr.starts_with("depths: 10 to "), "{}", run.stderr);
    assert_eq!(folder.json("r.json")["depth_range"][0], 10.0);
    assert_eq!(succeeds(&folder, "-input s.txt -depth auto d.png -quiet").stderr, "");
    folder.write("s.txt", SCENE.replace("direction 0 0 -1 up", "direction 0 0 1 up"));
    assert_eq!(succeeds(&folder, "-input s.txt -depth auto d.png").stderr, "depths: nothing is hit\n");
}

#[test]
fn nothing_hit_has_the_colour_that_is_asked_for() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "Triangle { vertex0 -9 -9 -90 vertex1 9 -9 0 vertex2 0 9 0 }"));
    for flags in ["", "-plain", "-jitter", "-filter"] {
        let line = format!("-input s.txt -size 40 40 {flags}");
        succeeds(&folder, &format!("{line} -depth 10 15 a.png"));
        succeeds(&folder, &format!("{line} -depth 10 15 b.png -depth-background 0 0.2 1"));
        let (usual, colored) = (folder.picture("a.png"), folder.picture("b.png"));
        let (mut background, mut surface, mut mixed) = (0, 0, 0);
        for (usual, colored) in usual.pixels().zip(colored.pixels()) {
            let (level, [red, green, blue]) = (usual.0[0], colored.0);
            assert_eq!(red, level, "{flags}: the background adds no red");
            match (green - level, blue - level) {
                (51, 255) => background += 1,
                (0, 0) => surface += 1,
                // At the edge the background has its share.
                (green, blue) => {
                    assert!(green.abs_diff(blue / 5) <= 1, "{flags}: {usual:?} {colored:?}");
                    mixed += 1;
                }
            }
        }
        assert!(background > 100 && surface > 100, "{flags}: {background} {surface}");
        assert_eq!(mixed > 20, flags.contains("jitter") || flags.contains("filter"), "{flags}: {mixed}");
    }
}

#[test]
fn a_curve_leaves_the_depths_their_background() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let depth = "-depth auto d.png -depth-background 1 0 0";
    for flags in ["", "-plain"] {
        let line = format!("-input s.txt -size 20 20 -samples 2 {flags}");
        succeeds(&folder, &format!("{line} {depth} -output o.png -convergence c.csv -quiet"));
        let with_curve = folder.picture("d.png");
        succeeds(&folder, &format!("{line} {depth} -quiet"));
        assert!(with_curve == folder.picture("d.png"), "{flags}");
        assert_eq!(with_curve.get_pixel(0, 0).0, [255, 0, 0]);
    }
}

#[test]
fn mistakes_with_depths_are_told() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for (flags, part) in [
        (
            "-output o.png -depth-background 0 0 1",
            "-depth-background: is about the picture of depths: give -depth too",
        ),
        ("-depth 8 9 d.png -depth-background 0 0 255", "expected three numbers from 0 to 1, found '255'"),
        ("-depth auto", "-depth needs 3 values: -depth MIN MAX FILE, or -depth auto FILE"),
        ("-depth auto d.jpg", "ends in .png, found 'd.jpg'"),
        (
            "-depth 8 auto d.png",
            "expected two finite numbers and a file name, or auto and a file name, found 'auto'",
        ),
    ] {
        let run = folder.a2(&format!("-input s.txt {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}");
        assert!(run.stderr.contains(part), "{flags}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["s.txt"]);
}
