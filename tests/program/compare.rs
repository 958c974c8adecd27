//! Tests of `-compare`: how much two pictures differ, and where.

use crate::support::{Folder, SCENE};
use image::{Rgb, RgbImage};
use serde_json::{Value, json};

fn flat(grey: u8) -> RgbImage {
    RgbImage::from_pixel(100, 100, Rgb([grey; 3]))
}

/// A folder with grey pictures: `a.png`, `b.png` one level brighter, `c.png` three; and `small.png`.
fn folder_with_pictures() -> Folder {
    let folder = Folder::new();
    for (name, grey) in [("a.png", 100), ("b.png", 101), ("c.png", 103)] {
        flat(grey).save(folder.path(name)).unwrap();
    }
    RgbImage::new(3, 4).save(folder.path("small.png")).unwrap();
    folder
}

#[test]
fn compare_prints_differences_and_sets_the_exit_code() {
    let folder = folder_with_pictures();
    folder.write("no.png", "no picture");
    for (arguments, exit_code, part) in [
        ("-compare a.png a.png", 0, "PSNR           inf"),
        ("-compare a.png b.png", 0, "worst channel  1 levels"),
        ("-compare a.png c.png -diff d.png", 1, "over 1 levels  10000 pixels, 100.0000%"),
        (
            "-compare a.png c.png",
            1,
            "regions        1 of pixels over 1 level:\n  x 0 to 99, y 0 to 99: 10000 pixels",
        ),
        ("-compare a.png c.png -tolerance 3 0", 0, "RMSE           3.0000"),
        ("-compare a.png b.png -tolerance 0 50", 1, "different"),
    ] {
        let run = folder.a2(arguments);
        assert_eq!(run.exit_code, exit_code, "{arguments}: {}{}", run.stdout, run.stderr);
        assert!(run.stdout.contains(part), "{arguments}: {}", run.stdout);
    }
    for (arguments, exit_code) in [
        ("-compare a.png small.png", 3),
        ("-compare a.png none.png", 2),
        ("-compare a.png no.png", 2),
        ("-compare none.png small.png", 2),
        ("-compare a.png b.png -report missing/c.json", 2),
        ("-compare a.png b.png -report a.png", 2),
        ("-compare a.png b.png -report d.png -diff d.png", 2),
    ] {
        let run = folder.a2(arguments);
        assert_eq!(run.exit_code, exit_code, "{arguments}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments}");
    }
    assert_eq!(folder.files(), ["a.png", "b.png", "c.png", "d.png", "no.png", "small.png"]);
}

#[test]
fn compare_says_where_pictures_differ() {
    let folder = folder_with_pictures();
    let mut changed = flat(100);
    (10..30).for_each(|x| changed.put_pixel(x, 5, Rgb([100, 90, 100])));
    changed.put_pixel(29, 5, Rgb([0, 100, 255]));
    changed.put_pixel(80, 60, Rgb([103, 100, 100]));
    changed.put_pixel(5, 90, Rgb([101, 100, 100]));
    changed.save(folder.path("d.png")).unwrap();
    let run = folder.a2("-compare a.png d.png -report c.json");
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    let lines = "worst pixel    x 29 from the left, y 5 from the top: A 100 100 100, B 0 100 255\n\
                 regions        2 of pixels over 1 level:\n\
                 \x20 x 10 to 29, y 5 to 5: 20 pixels, worst 155 levels\n\
                 \x20 x 80 to 80, y 60 to 60: 1 pixel, worst 3 levels\n";
    assert!(run.stdout.contains(lines), "{}", run.stdout);
    let report = folder.json("c.json");
    assert_eq!(
        report["worst_pixel"],
        json!({ "x": 29, "y": 5, "a": [100, 100, 100], "b": [0, 100, 255], "unit": "bytes" })
    );
    assert_eq!(
        report["regions"],
        json!([
            { "left": 10, "top": 5, "right": 29, "bottom": 5, "pixels": 20, "worst_levels": 155 },
            { "left": 80, "top": 60, "right": 80, "bottom": 60, "pixels": 1, "worst_levels": 3 },
        ])
    );
    assert_eq!(report["pixels_over_levels"], json!({ "0": 22, "1": 21, "8": 20 }));
    assert_eq!(
        (&report["verdict"], &report["width"], &report["worst_levels"]),
        (&json!("different"), &json!(100), &json!(155))
    );
}

#[test]
fn reports_on_equal_pictures_and_on_other_sizes_are_written_too() {
    let folder = folder_with_pictures();
    assert_eq!(folder.a2("-compare a.png a.png -report c.json").exit_code, 0);
    let same = folder.json("c.json");
    assert_eq!(
        (&same["verdict"], &same["worst_pixel"], &same["psnr_db"]),
        (&json!("alike"), &Value::Null, &Value::Null)
    );
    assert_eq!((&same["regions"], &same["rmse_levels"]), (&json!([]), &json!(0.0)));
    assert_eq!(folder.a2("-compare a.png small.png -report c.json").exit_code, 3);
    let sizes = folder.json("c.json");
    assert_eq!(
        (&sizes["verdict"], &sizes["size_of_a"], &sizes["size_of_b"]),
        (&json!("sizes differ"), &json!([100, 100]), &json!([3, 4]))
    );
}

#[test]
fn many_regions_are_cut_short() {
    let folder = Folder::new();
    flat(0).save(folder.path("a.png")).unwrap();
    let mut dots = flat(0);
    // Every third cell of 8 x 8 pixels, in both directions.
    (0..25).for_each(|dot| dots.put_pixel(24 * (dot % 5) + 1, 24 * (dot / 5) + 1, Rgb([9, 0, 0])));
    dots.save(folder.path("b.png")).unwrap();
    let run = folder.a2("-compare a.png b.png");
    assert!(run.stdout.contains("regions        25 of"), "{}", run.stdout);
    assert!(run.stdout.contains("  and 15 more: 15 pixels in all\n"), "{}", run.stdout);
    assert_eq!(run.stdout.matches(": 1 pixel, worst 9 levels").count(), 10);
}

#[test]
fn the_panel_of_differences_shows_both_pictures() {
    let folder = folder_with_pictures();
    assert_eq!(folder.a2("-compare a.png c.png -diff d.png").exit_code, 1);
    let panel = folder.picture("d.png");
    // Three pictures of 100 pixels, twice enlarged, with margins; text above, a legend below.
    assert_eq!(panel.width(), 3 * 200 + 4 * 10);
    let middles = [0, 1, 2].map(|index| panel.get_pixel(10 + index * 210 + 100, 30 + 100).0);
    assert_eq!(middles[..2], [[100; 3], [103; 3]]);
    assert!(middles[2].iter().any(|&channel| channel > 60), "{middles:?}");
    // Where nothing differs, the difference is black.
    assert_eq!(folder.a2("-compare a.png a.png -diff d.png").exit_code, 0);
    assert_eq!(folder.picture("d.png").get_pixel(10 + 2 * 210 + 100, 130).0, [0; 3]);
}

#[test]
fn pictures_of_numbers_are_compared_as_numbers_and_alpha_is_named() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    assert_eq!(folder.a2("-input s.txt -output a.pfm").exit_code, 0);
    assert_eq!(folder.a2("-input s.txt -output a.png").exit_code, 0);
    let mut bytes = std::fs::read(folder.path("a.pfm")).unwrap();
    let last = bytes.len() - 4;
    bytes[last..].copy_from_slice(&3.0f32.to_le_bytes());
    folder.write("b.pfm", &bytes);
    let alike = folder.a2("-compare a.pfm a.pfm -tolerance 0 0");
    assert_eq!((alike.exit_code, alike.stdout.contains("RMSE           0.0000")), (0, true), "{}", alike.stdout);
    // Truncation to bytes takes away less than a level.
    assert_eq!(folder.a2("-compare a.pfm a.png").exit_code, 0);
    let unlike = folder.a2("-compare a.pfm b.pfm -tolerance 8 0 -diff d.png");
    assert_eq!(unlike.exit_code, 1, "{}", unlike.stdout);
    assert!(unlike.stdout.contains("over 8 levels  1 pixels"), "{}", unlike.stdout);
    let worst = "worst pixel    x 99 from the left, y 0 from the top: A 0.00000 0.00000 0.00000, B 0.00000 0.00000 3.00000";
    assert!(unlike.stdout.contains(worst), "{}", unlike.stdout);
    // One pixel, which is 2 x 2 here, is not black in the third picture, and neither is the line around it.
    let panel = folder.picture("d.png");
    let outline = [120; 3];
    let differences = (0..200).flat_map(|y| (0..200).map(move |x| (430 + x, 30 + y)));
    let seen: Vec<_> =
        differences.map(|(x, y)| panel.get_pixel(x, y).0).filter(|color| *color != [0; 3]).collect();
    assert_eq!(seen.iter().filter(|color| **color != outline).count(), 4, "{seen:?}");

    let faint = image::RgbaImage::from_pixel(4, 4, image::Rgba([9, 9, 9, 128]));
    faint.save(folder.path("faint.png")).unwrap();
    image::RgbImage::from_pixel(4, 4, image::Rgb([9; 3])).save(folder.path("solid.png")).unwrap();
    let run = folder.a2("-compare faint.png solid.png -report c.json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("alpha          differs in 16 pixels, and is not compared"), "{}", run.stdout);
    assert_eq!(folder.json("c.json")["pixels_of_other_alpha"], 16);
}
