//! `scripts/report.py` writes one page that needs nothing else.

use crate::grading::write_submission;
use crate::support::{Folder, batch, project};
use std::path::Path;
use std::process::Command;

const SIZE: u32 = 64;

/// Returns how often a text stands in another.
fn count(page: &str, text: &str) -> usize {
    page.matches(text).count()
}

/// Runs the script for a program, with the pictures in `sample_out/` of the folder as references.
fn report(folder: &Folder, program: &Path, exit_code: i32) -> String {
    let run = folder.run(
        Command::new("python3")
            .arg(project("scripts/report.py"))
            .arg("out.html")
            .arg(program)
            .args(["--starter", ".", "--size", &SIZE.to_string()])
            .env("A2_JUDGE", env!("CARGO_BIN_EXE_a2")),
    );
    assert_eq!(run.exit_code, exit_code, "{}", run.stderr);
    assert_eq!(run.stderr.matches("the program failed, exit code 1\n").count(), 7 * exit_code as usize);
    std::fs::read_to_string(folder.path("out.html")).unwrap()
}

#[test]
#[cfg(unix)]
fn a_report_holds_every_picture_and_asks_for_no_other_file() {
    let folder = Folder::new();
    std::os::unix::fs::symlink(project("data"), folder.path("data")).unwrap();
    std::fs::create_dir(folder.path("sample_out")).unwrap();
    let scenes = batch::scenes();
    for scene in &scenes {
        scene.render(&project("data"), SIZE, &folder);
        for name in scene.pictures() {
            std::fs::rename(folder.path(&name), folder.path("sample_out").join(name)).unwrap();
        }
    }
    // One reference differs.
    std::fs::copy(folder.path("sample_out/a01.png"), folder.path("sample_out/a02.png")).unwrap();

    let page = report(&folder, Path::new(env!("CARGO_BIN_EXE_a2")), 0);
    assert!(page.contains("default-src 'none'"));
    assert!(page.contains(".panel { overflow-x: auto; }"));
    assert_eq!(count(&page, "<div class=\"panel\" tabindex=\"0\"><img "), 1);
    let sources = count(&page, " src=");
    assert_eq!(count(&page, " src=\"data:image/"), sources);
    // For each picture itself and its reference, and a panel for the one that differs; per scene four kinds of anti-aliasing,
    // whole and magnified, and a curve.
    assert_eq!(sources, 21 * 2 + 1 + 7 * (4 * 2 + 1));
    assert_eq!(count(&page, "class=\"slider\""), 21);
    assert_eq!(count(&page, "No pixel differs."), 20);
    assert_eq!(count(&page, "data:image/svg+xml"), 7);
    for link in ["http:", "https:", "url(", "<link", "@import"] {
        assert_eq!(count(&page, link), 0, "{link}");
    }
    for scene in &scenes {
        let command = format!("a2 -input data/{}.txt -size {SIZE} {SIZE} ", scene.name);
        assert_eq!(count(&page, &command), 1, "{command}");
    }

    // Pictures of another size are shown, and cannot be compared. Of a flag given twice, the last one counts.
    write_submission(&folder, "small", &format!("exec {} \"$@\" -size 9 8", env!("CARGO_BIN_EXE_a2")));
    let page = report(&folder, Path::new("./small"), 0);
    assert_eq!((count(&page, "the other picture 9 x 8"), count(&page, "class=\"slider\"")), (21, 0));

    // A program that renders nothing has a page that says so.
    let page = report(&folder, Path::new("/bin/false"), 1);
    assert_eq!((count(&page, " src="), count(&page, "the program has not written it")), (0, 21));
    assert_eq!(count(&page, "no curve: the program failed"), 7);
}
