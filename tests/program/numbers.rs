//! Tests of pictures of numbers (`.pfm`, `.exr`), of errors against a reference, and of equal bytes with every
//! instruction set.

use crate::support::{Folder, project};
use serde_json::Value;

/// Reads the text header of a PFM file, and its numbers in their order in the file: rows from the bottom.
fn read_pfm(folder: &Folder, name: &str) -> (String, Vec<f32>) {
    let bytes = std::fs::read(folder.path(name)).unwrap();
    let ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
    let head = ends.take(3).last().unwrap();
    let numbers = bytes[head..].as_chunks().0.iter().map(|number| f32::from_le_bytes(*number)).collect();
    (String::from_utf8(bytes[..head].to_vec()).unwrap(), numbers)
}

fn write_pfm(folder: &Folder, name: &str, head: &str, numbers: &[f32]) {
    let mut bytes = head.as_bytes().to_vec();
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    folder.write(name, bytes);
}

/// Renders a mirror, shadows and a cube map in 40 x 30 pixels.
fn render(folder: &Folder, flags: &str) {
    let scene = project("data/scene06_bunny_1k.txt");
    let arguments = format!("-input {} -size 40 30 -bounces 4 -shadows {flags}", scene.display());
    let run = folder.a2(&arguments);
    assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
}

#[test]
fn the_bytes_of_a_png_are_the_truncated_numbers_of_a_pfm() {
    let folder = Folder::new();
    for flags in ["", "-jitter -filter"] {
        render(&folder, &format!("{flags} -output o.png"));
        render(&folder, &format!("{flags} -output o.pfm"));
        let (head, numbers) = read_pfm(&folder, "o.pfm");
        assert_eq!((head.as_str(), numbers.len()), ("PF\n40 30\n-1.0\n", 40 * 30 * 3));
        let rows = numbers.chunks(3 * 40).rev().flatten();
        let bytes: Vec<u8> =
            rows.map(|&number| (f64::from(number) * 255.0).trunc().clamp(0.0, 255.0) as u8).collect();
        let picture = folder.picture("o.png").into_raw();
        // A colour is rounded to f32 in the file, which may lift it over a whole level.
        let near_a_level = |index: usize| {
            let (row, column) = (index / 120, index % 120);
            let levels = f64::from(numbers[(29 - row) * 120 + column]) * 255.0;
            (levels - levels.round()).abs() < 1e-4
        };
        let differing = (0..bytes.len()).filter(|&at| bytes[at] != picture[at]);
        let unexplained: Vec<_> =
            differing.filter(|&at| bytes[at].abs_diff(picture[at]) > 1 || !near_a_level(at)).collect();
        assert!(unexplained.is_empty(), "{flags}: {unexplained:?}");
        assert!(bytes.iter().collect::<std::collections::BTreeSet<_>>().len() > 100, "{flags}: a flat picture");
    }
}

#[cfg(feature = "exr")]
#[test]
fn an_exr_holds_the_numbers_of_a_pfm() {
    let folder = Folder::new();
    render(&folder, "-output o.pfm");
    render(&folder, "-output o.exr");
    let exr = image::open(folder.path("o.exr")).unwrap().into_rgb32f();
    assert_eq!(exr.dimensions(), (40, 30));
    let (_, numbers) = read_pfm(&folder, "o.pfm");
    let rows = numbers.chunks(3 * 40).rev().flatten();
    assert!(exr.iter().map(|number| number.to_bits()).eq(rows.map(|number| number.to_bits())));
}

#[cfg(not(feature = "exr"))]
#[test]
fn without_exr_support_the_format_is_refused_by_name() {
    let folder = Folder::new();
    for flags in ["-output o.exr", "-output o.png -reference r.exr"] {
        let run = folder.a2(&format!("-input s.txt {flags}"));
        assert_eq!(run.exit_code, 2);
        assert!(run.stderr.contains("this build has no EXR support"), "{}", run.stderr);
    }
}

/// Returns the true error of the scene's picture against a reference, from a report.
fn true_error(folder: &Folder, reference: &str) -> Value {
    render(folder, &format!("-output again.png -reference {reference} -report r.json"));
    folder.json("r.json")["true_error"].clone()
}

fn number(error: &Value, key: &str) -> f64 {
    error[key].as_f64().unwrap_or_else(|| panic!("{key}: {error}"))
}

#[test]
fn a_picture_has_no_error_against_itself() {
    let folder = Folder::new();
    let formats = if cfg!(feature = "exr") { ["png", "pfm", "exr"].as_slice() } else { &["png", "pfm"] };
    for format in formats {
        render(&folder, &format!("-output reference.{format}"));
        let error = true_error(&folder, &format!("reference.{format}"));
        for key in ["rmse_levels", "rmse_linear", "relative_mse", "worst_levels", "share_over_1_level"] {
            assert_eq!(number(&error, key), 0.0, "{format}: {key}");
        }
        assert_eq!(error["psnr_db"], Value::Null, "{format}: infinite");
        // It compares bytes. A number that is rounded to f32 in the file may make the next byte.
        let least = if *format == "png" { 1.0 } else { 0.9999 };
        assert!((least..=1.0).contains(&number(&error, "ssim")), "{format}: {error}");
    }
}

#[test]
fn a_shifted_reference_has_the_error_of_its_shift() {
    let folder = Folder::new();
    // Bytes above 128 become ten levels darker, the others ten levels brighter.
    render(&folder, "-output plain.png");
    let mut shifted = folder.picture("plain.png");
    shifted.iter_mut().for_each(|byte| *byte = if *byte > 128 { *byte - 10 } else { *byte + 10 });
    shifted.save(folder.path("shifted.png")).unwrap();
    let error = true_error(&folder, "shifted.png");
    assert!(
        (number(&error, "rmse_levels") - 10.0).abs() < 1e-4
            && (number(&error, "worst_levels") - 10.0).abs() < 1e-4
    );
    assert!((number(&error, "psnr_db") - 20.0 * 25.5_f64.log10()).abs() < 1e-4);
    assert!(number(&error, "share_over_1_level") == 1.0 && number(&error, "ssim") < 1.0, "{error}");

    // One number of one pixel: column 7 of the third row from the bottom, a quarter off.
    render(&folder, "-output plain.pfm");
    let (head, mut numbers) = read_pfm(&folder, "plain.pfm");
    let at = (2 * 40 + 7) * 3 + 1;
    numbers[at] += if numbers[at] > 0.5 { -0.25 } else { 0.25 };
    write_pfm(&folder, "shifted.pfm", &head, &numbers);
    let error = true_error(&folder, "shifted.pfm");
    let values = f64::from(40 * 30 * 3_u32);
    assert!((number(&error, "rmse_linear") - 0.25 / values.sqrt()).abs() < 1e-7, "{error}");
    assert!((number(&error, "rmse_levels") - 63.75 / values.sqrt()).abs() < 1e-4, "{error}");
    assert!((number(&error, "worst_levels") - 63.75).abs() < 1e-3, "{error}");
    assert_eq!(error["worst_pixel"], serde_json::json!([7, 27]));
    assert!((number(&error, "share_over_1_level") - 1.0 / 1200.0).abs() < 1e-9, "{error}");
}

#[test]
fn a_reference_of_another_size_is_refused() {
    let folder = Folder::new();
    render(&folder, "-output small.png");
    let scene = project("data/scene01_plane.txt");
    let run = folder.a2(&format!("-input {} -size 9 9 -output o.png -reference small.png", scene.display()));
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("small.png") && run.stderr.contains("40 x 30"), "{}", run.stderr);
    assert!(!folder.path("o.png").exists());
}

/// Returns the names of the instruction sets from the program's own error message.
pub fn instruction_sets(folder: &Folder) -> Vec<String> {
    let run = folder.a2("-input s.txt -output o.png -simd nonsense");
    let names = run.stderr.split_once("expected ").and_then(|(_, rest)| rest.split_once(", found 'nonsense'"));
    let names = names.unwrap_or_else(|| panic!("{}", run.stderr)).0.trim_start_matches("one of ");
    names.replace(" or ", ", ").split(", ").map(str::to_owned).collect()
}

#[test]
fn every_instruction_set_and_the_plain_definition_give_the_same_bytes() {
    let folder = Folder::new();
    let sets = instruction_sets(&folder);
    assert!(!sets.is_empty());
    let mut ways = vec!["-plain".to_owned()];
    for name in sets {
        let run = folder.a2(&format!(
            "-input {} -output o.png -size 2 2 -simd {name}",
            project("data/scene02_cube.txt").display()
        ));
        match run.exit_code {
            0 => ways.push(format!("-simd {name}")),
            code => {
                assert!(code == 2 && run.stderr.contains(&format!("no {name}")), "{}", run.stderr);
                eprintln!("skipped: {}", run.stderr);
            }
        }
    }
    assert!(ways.len() > 1, "this processor has none of its instruction sets");
    for flags in ["", "-robust", "-jitter -filter"] {
        let bytes = |way: &str| {
            render(&folder, &format!("{flags} {way} -output c.png -normals n.png -depth 8 18 d.png"));
            render(&folder, &format!("{flags} {way} -output c.pfm"));
            ["c.png", "n.png", "d.png", "c.pfm"].map(|name| std::fs::read(folder.path(name)).unwrap())
        };
        let best = bytes("");
        for way in &ways {
            assert!(bytes(way) == best, "{flags} {way}");
        }
    }
}
