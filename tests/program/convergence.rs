//! Tests of `-convergence`: the table, the figure and the page.

use crate::measuring::succeeds;
use crate::support::{Folder, SCENE};
use std::collections::BTreeMap;

/// Reads the rows of a table as maps from the names in its first line.
fn table(folder: &Folder, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows = lines.map(|line| {
        let values: Vec<&str> = line.split(',').collect();
        assert_eq!(values.len(), names.len(), "{line}");
        names.iter().map(|name| (*name).to_owned()).zip(values.into_iter().map(str::to_owned)).collect()
    });
    rows.collect()
}

#[test]
fn convergence_is_a_table_of_error_against_samples_and_time() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let flags = "-input s.txt -size 40 40 -sampler independent";
    succeeds(&folder, &format!("{flags} -samples 4096 -seed 9 -output reference.pfm"));
    succeeds(
        &folder,
        &format!("{flags} -samples 64 -output o.png -reference reference.pfm -convergence c.csv -quiet"),
    );
    let rows = table(&folder, "c.csv");
    let names = "sampler samples seconds cpu_seconds rays estimated_rmse_levels estimated_low_95 estimated_high_95
        estimated_rmse_linear true_rmse_levels true_rmse_linear true_ssim target_levels camera_rays_a_pixel";
    let expected: std::collections::BTreeSet<&str> = names.split_whitespace().collect();
    assert!(rows[0].keys().map(String::as_str).eq(expected), "{:?}", rows[0]);
    let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().ok();
    let (adaptive, rows): (Vec<_>, Vec<_>) = rows.into_iter().partition(|row| row["sampler"] == "adaptive");
    // A named sampler is the only one, also where samples are taken where they are needed.
    assert!(adaptive.len() >= 3);
    for row in &adaptive {
        assert!(number(row, "estimated_rmse_levels") <= number(row, "target_levels"), "{row:?}");
        // 576 of 1,600 pixels show nothing but background: they count as one sample, which takes no ray of their own.
        let samples = number(row, "samples").unwrap();
        assert!(number(row, "camera_rays_a_pixel") > Some(samples - 0.36) && samples > 1.0, "{row:?}");
    }
    let column = |name: &str| rows.iter().map(|row| number(row, name)).collect::<Vec<_>>();
    assert_eq!(column("samples"), [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0].map(Some));
    assert!(rows.iter().all(|row| row["sampler"] == "independent"));
    for row in &rows {
        // 576 pixels lie in five tiles that show nothing but background: one ray a tile is enough.
        assert_eq!(number(row, "rays"), number(row, "samples").map(|samples| samples * 1024.0 + 5.0));
        assert!(number(row, "seconds") > Some(0.0) && number(row, "cpu_seconds").is_some());
    }
    // One sample says nothing about its error.
    assert_eq!(column("estimated_rmse_levels")[0], None);
    let last = &rows[6];
    let [low, estimated, high] =
        ["estimated_low_95", "estimated_rmse_levels", "estimated_high_95"].map(|name| number(last, name).unwrap());
    assert!(low < estimated && estimated < high);
    // The error of independent samples shrinks with the square root of their number: eight times from 1 to 64.
    let [one, sixty_four] = [&rows[0], last].map(|row| number(row, "true_rmse_levels").unwrap());
    assert!((4.0..16.0).contains(&(one / sixty_four)), "{one} {sixty_four}");
    assert!((0.7..1.4).contains(&(estimated / sixty_four)), "{estimated} {sixty_four}");
    assert!(number(last, "true_ssim") > number(&rows[0], "true_ssim"));
}

/// Returns the names of the elements of an XML text. Panics where it is not well-formed.
fn elements(xml: &str) -> Vec<&str> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let mut rest = xml;
    while let Some((text, after)) = rest.split_once('<') {
        assert!(!text.contains('>') && (text.trim().is_empty() || !open.is_empty()), "{text}");
        let entities = text.split('&').skip(1);
        entities.for_each(|rest| assert!(["amp;", "lt;", "gt;", "quot;"].iter().any(|e| rest.starts_with(e))));
        let (tag, after) = after.split_once('>').expect("a tag has an end");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else {
            let name = tag.split([' ', '/']).next().unwrap();
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            found.push(name);
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
        rest = after;
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?}");
    found
}

#[test]
fn convergence_is_a_figure_of_all_samplers() {
    let folder = Folder::new();
    folder.write("in/a <&\" b.txt", SCENE);
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_a2"));
    command.args(["-input", "in/a <&\" b.txt"]);
    let run = folder.run(command.args("-size 30 30 -output o.png -convergence c.svg -samples 8".split(' ')));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert!(lines[0].starts_with("An error of ") && lines[1].starts_with("A quarter of that error "), "{lines:?}");
    let svg = std::fs::read_to_string(folder.path("c.svg")).unwrap();
    let found = elements(&svg);
    let dots = found.iter().filter(|&&name| name == "circle").count();
    // 2, 4 and 8 samples of three samplers in two panels, and some targets.
    assert!(dots >= 2 * 3 * 3 + 2 && found.contains(&"polyline"), "{dots}");
    for name in ["independent", "stratified", "sobol", "adaptive"] {
        assert!(svg.contains(&format!(">{name}: slope ")), "{name}");
    }
    for words in lines.into_iter().chain([">a &lt;&amp;&quot; b.txt, 30 x 30", "slope −1/2"]) {
        assert!(svg.contains(words), "{words}");
    }
    // The picture is the one that is asked for without the curves.
    folder.write("s.txt", SCENE);
    succeeds(&folder, "-input s.txt -size 30 30 -samples 8 -output p.png -stats");
    assert_eq!(folder.picture("o.png"), folder.picture("p.png"));
}

#[test]
fn convergence_is_a_page_that_needs_no_other_file() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    succeeds(&folder, "-input s.txt -size 30 30 -samples 1024 -sampler sobol -seed 9 -output truth.pfm");
    let flags = "-size 30 30 -samples 8 -sampler sobol -reference truth.pfm -quiet";
    let run = succeeds(&folder, &format!("-input s.txt {flags} -output o.png -convergence c.html"));
    assert_eq!(run.stderr, "");
    let page = std::fs::read_to_string(folder.path("c.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>\n<html lang=\"en\">") && page.ends_with("</html>\n"));
    assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http").count());
    assert_eq!(page.matches("src=").count(), page.matches("src=\"data:image/png;base64,iVBOR").count());
    // The picture and its error map.
    assert_eq!(page.matches("<img ").count(), 2);
    assert!(page.contains("Pixels that no sample reached: 0%"));
    let (_, figure) = page.split_once("<svg").unwrap();
    elements(&format!("<svg{}</svg>", figure.split_once("</svg>").unwrap().0));
    assert!(
        !page.contains("stratified:") && page.contains("sobol: slope") && page.contains("rings: its estimate")
    );
}

/// The curves need colours, but no file of them.
#[test]
fn convergence_needs_no_other_picture() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    let flags = "-input s.txt -size 30 30 -samples 8 -seed 3";
    succeeds(&folder, &format!("{flags} -convergence with.csv -output o.png"));
    for (name, other) in [("c.csv", ""), ("n.csv", "-normals n.png"), ("r.csv", "-reference o.png")] {
        succeeds(&folder, &format!("{flags} -convergence {name} {other}"));
        for (with, without) in table(&folder, "with.csv").iter().zip(&table(&folder, name)) {
            for column in ["sampler", "samples", "rays", "estimated_rmse_levels"] {
                assert_eq!(with[column], without[column], "{name}: {column}");
            }
            assert_eq!(without["true_rmse_levels"].is_empty(), name != "r.csv", "{name}");
        }
        assert!(table(&folder, name).len() > 3 * 4, "{name}");
    }
    succeeds(&folder, &format!("{flags} -convergence c.svg -quiet"));
    assert!(elements(&std::fs::read_to_string(folder.path("c.svg")).unwrap()).contains(&"polyline"));
    succeeds(&folder, &format!("{flags} -convergence c.html -quiet"));
    let page = std::fs::read_to_string(folder.path("c.html")).unwrap();
    assert_eq!(page.matches("<img ").count(), 2);
    let files = ["c.csv", "c.html", "c.svg", "n.csv", "n.png", "o.png", "r.csv", "s.txt", "with.csv"];
    assert_eq!(folder.files(), files);
}

/// One sample says nothing of its error.
#[test]
fn convergence_of_one_sample_has_no_curves() {
    let folder = Folder::new();
    folder.write("s.txt", SCENE);
    for name in ["c.svg", "c.html", "c.csv"] {
        let run =
            succeeds(&folder, &format!("-input s.txt -size 9 9 -samples 1 -output o.png -convergence {name}"));
        assert!(run.stderr.starts_with("No error above 0 is known here"), "{}", run.stderr);
    }
    let found = std::fs::read_to_string(folder.path("c.svg")).unwrap();
    assert!(!elements(&found).contains(&"circle"));
    assert_eq!(table(&folder, "c.csv").len(), 3);
}
