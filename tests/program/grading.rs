//! Tests of `scripts/grade.py`: broken submissions each get their row, and nothing passes that renders nothing.

use crate::support::{Folder, Run, project};
use serde_json::Value;
use std::process::Command;

const A2: &str = env!("CARGO_BIN_EXE_a2");

/// Writes a submission: a shell script that is given the course's flags.
pub fn write_submission(folder: &Folder, name: &str, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    folder.write(name, format!("#!/bin/sh\n{script}\n"));
    std::fs::set_permissions(folder.path(name), std::fs::Permissions::from_mode(0o755)).unwrap();
}

fn python(folder: &Folder, script: &str, arguments: &[&str]) -> Run {
    let mut command = Command::new("python3");
    folder.run(command.arg(project(script)).args(arguments).env("A2_JUDGE", A2).env_remove("A2"))
}

/// Grades submissions at 40 x 40 pixels, and returns what is printed and the results.
fn grade(folder: &Folder, arguments: &[&str]) -> (Run, Vec<Value>) {
    let options = ["--size", "40", "--json", "grades.json"];
    let run = python(folder, "scripts/grade.py", &[&options, arguments].concat());
    let text =
        std::fs::read(folder.path("grades.json")).unwrap_or_else(|_| panic!("{}{}", run.stdout, run.stderr));
    let results: Value = serde_json::from_slice(&text).unwrap();
    (run, results["submissions"].as_array().unwrap().clone())
}

fn statuses(submission: &Value) -> Vec<&str> {
    submission["scenes"].as_array().unwrap().iter().map(|row| row["status"].as_str().unwrap()).collect()
}

/// All notes on a scene.
fn notes(submission: &Value, scene: usize) -> String {
    let notes = submission["scenes"][scene]["notes"].as_array().unwrap();
    notes.iter().map(|note| format!("{}\n", note.as_str().unwrap())).collect()
}

/// A loop over the arguments of a submission that does something with each picture, whose name is in `$picture`.
fn for_each_picture(action: &str) -> String {
    let names = "-output|-normals) picture=$2 ;; -depth) picture=$4 ;; *) picture= ;;";
    format!("while [ $# -gt 0 ]; do case $1 in {names} esac; shift; [ -z \"$picture\" ] || {{ {action}; }}; done")
}

/// A submission that does all but one flag.
fn without(flag: &str) -> String {
    format!("for word; do shift; [ \"$word\" = {flag} ] || set -- \"$@\" \"$word\"; done; exec {A2} \"$@\"")
}

/// A submission that renders another scene than the one that is asked for: `edit` changes the copy in `data`.
fn editing(edit: &str) -> String {
    let copy = "scene=$2; shift 2; cp -r \"$(dirname \"$scene\")\" data";
    format!("{copy}; {edit}; exec {A2} -input \"data/$(basename \"$scene\")\" \"$@\"")
}

#[test]
fn broken_submissions_get_their_rows() {
    let folder = Folder::new();
    for side in [40, 10] {
        image::RgbImage::new(side, side).save(folder.path(&format!("black{side}.png"))).unwrap();
    }
    // Its third and fourth argument are -size and the width.
    let black =
        format!("black={}$4.png; {}", folder.path("black").display(), for_each_picture("cp $black \"$picture\""));
    let half =
        format!("{A2} \"$@\"; {}", for_each_picture("head -c 90 \"$picture\" > half; mv half \"$picture\""));
    for (name, script) in [
        ("nothing", "exit 0"),
        ("black", &*black),
        ("wrong_size", &format!("exec {A2} \"$@\" -size 7 5")),
        ("crash", "kill -SEGV $$"),
        ("half", &*half),
        ("no_shadows", &*without("-shadows")),
        ("right", &format!("exec {A2} \"$@\"")),
    ] {
        write_submission(&folder, name, script);
    }
    let names = ["nothing", "black", "wrong_size", "crash", "half", "no_shadows", "right"];
    let (run, found) = grade(&folder, &[&names[..], &["--csv", "grades.csv", "--html", "grades.html"]].concat());
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    let all = |status| vec![status; 8];
    let without_shadows = vec!["ok", "ok", "ok", "ok", "ok", "ok", "differs", "ok"];
    let expected = [
        (all("missing"), 0.0),
        (all("differs"), 0.0),
        (all("wrong size"), 0.0),
        (all("crashed"), 0.0),
        (all("unreadable"), 0.0),
        (without_shadows, 4.5),
        (all("ok"), 5.0),
    ];
    assert_eq!(found.len(), names.len());
    for ((submission, name), (rows, credit)) in found.iter().zip(names).zip(expected) {
        assert_eq!((submission["name"].as_str().unwrap(), statuses(submission)), (name, rows), "{}", run.stdout);
        assert_eq!(submission["credit"], credit, "{name}");
    }
    assert!(notes(&found[2], 0).contains("a01.png is 7 x 5 pixels, not 40 x 40"), "{}", notes(&found[2], 0));
    assert!(notes(&found[3], 4).contains("SIGSEGV"), "{}", notes(&found[3], 4));
    assert!(notes(&found[4], 0).contains("a01.png: cannot read this picture"), "{}", notes(&found[4], 0));
    assert_eq!(notes(&found[5], 6), "as if without -shadows: 0 pixels differ in a07.png\n");
    let csv = std::fs::read_to_string(folder.path("grades.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 8 * names.len());
    let row = csv.lines().find(|line| line.starts_with("no_shadows,07,differs,0.0,0.5,")).unwrap();
    assert!(row.ends_with("as if without -shadows: 0 pixels differ in a07.png"), "{row}");
    let page = std::fs::read_to_string(folder.path("grades.html")).unwrap();
    // The pictures that differ: one without shadows; of the black ones all that are not black.
    let panels = page.matches("<img ").count();
    assert_eq!(page.matches("data:image/png;base64,").count(), panels);
    assert_eq!(panels, 1 + 22, "{}", run.stdout);
    assert_eq!(page.matches("<div class=\"panel\" tabindex=\"0\"><img ").count(), panels);
    assert!(page.contains(".panel { overflow-x: auto; }"));
    assert!(!page.contains("http"), "the page asks for something");
}

#[test]
fn a_submission_that_hangs_is_ended_with_all_its_processes() {
    let folder = Folder::new();
    let child = folder.path("child");
    write_submission(&folder, "hang", &format!("sleep 600 & echo $! > {}; sleep 600", child.display()));
    write_submission(&folder, "leaves", &format!("sleep 600 & exec {A2} \"$@\""));
    let (run, found) = grade(&folder, &["hang", "leaves", "--scenes", "01", "--time-limit", "5"]);
    assert_eq!([&found[0], &found[1]].map(statuses), [["timed out"], ["ok"]], "{}", run.stdout);
    assert_eq!(notes(&found[0], 0), "after 5 s\n");
    let seconds = found[0]["scenes"][0]["run"]["seconds"].as_f64().unwrap();
    assert!((5.0..60.0).contains(&seconds), "{seconds}");
    #[cfg(target_os = "linux")]
    assert!(has_ended(&std::fs::read_to_string(child).unwrap()));
}

/// The memory of a run is that of the program: the grader itself takes more than the small one.
#[test]
fn the_memory_of_a_program_is_its_own() {
    let folder = Folder::new();
    write_submission(&folder, "small", "kill -SEGV $$");
    write_submission(&folder, "large", "exec python3 -c 'bytearray(100 << 20)'");
    write_submission(&folder, "deaf", "trap '' TERM; while :; do :; done");
    let (_, found) = grade(&folder, &["small", "large", "deaf", "--scenes", "01", "--time-limit", "5"]);
    assert_eq!([&found[0], &found[1], &found[2]].map(statuses), [["crashed"], ["missing"], ["timed out"]]);
    let megabytes = |index: usize| &found[index]["scenes"][0]["run"]["megabytes"];
    let [small, large] = [0, 1].map(|index| megabytes(index).as_f64().unwrap());
    assert!((0.1..6.0).contains(&small), "{small}");
    assert!((100.0..130.0).contains(&large), "{large}");
    // What had to be killed has not been measured.
    assert!(megabytes(2).is_null());
}

#[test]
fn results_on_standard_output_stand_alone() {
    let folder = Folder::new();
    write_submission(&folder, "nothing", "exit 0");
    let printed = |flags: &str| {
        let words: Vec<&str> = flags.split(' ').collect();
        python(
            &folder,
            "scripts/grade.py",
            &[&["nothing", "--scenes", "03,01", "--size", "40"], &words[..]].concat(),
        )
    };
    let json: Value = serde_json::from_str(&printed("--json -").stdout).unwrap();
    assert_eq!(statuses(&json["submissions"][0]), ["missing"; 2]);
    let csv = printed("--csv - --pictures").stdout;
    let rows: Vec<&str> = csv.lines().map(|line| line.split(',').nth(1).unwrap()).collect();
    assert_eq!(rows, ["scene", "03", "01"], "{csv}");
    let both = printed("--json - --csv -");
    assert_eq!((both.exit_code, both.stdout.as_str()), (2, ""));
    assert!(both.stderr.contains("only one kind of results"), "{}", both.stderr);
    assert_eq!(folder.files(), ["nothing"]);
}

/// Whether a process is gone, or dead and not yet buried.
#[cfg(target_os = "linux")]
fn has_ended(process: &str) -> bool {
    let state = std::fs::read_to_string(format!("/proc/{}/stat", process.trim())).unwrap_or(") Z".into());
    state.contains(") Z") || state.contains(") X")
}

#[cfg(target_os = "linux")]
#[test]
fn a_grader_that_is_ended_ends_what_it_has_started() {
    let folder = Folder::new();
    let child = folder.path("child");
    write_submission(&folder, "hang", &format!("echo $$ > part; mv part {}; sleep 600", child.display()));
    let mut command = Command::new("python3");
    command.arg(project("scripts/grade.py")).args(["hang", "--scenes", "01", "--size", "40"]);
    let grader = command.env("A2_JUDGE", A2).current_dir(folder.path("")).stderr(std::process::Stdio::piped());
    let grader = grader.spawn().unwrap();
    let has_begun = (0..3000).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        child.exists()
    });
    let ended = Command::new("kill").arg(grader.id().to_string()).status().unwrap();
    let output = grader.wait_with_output().unwrap();
    assert!(has_begun && ended.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "error: interrupted\n");
    assert_eq!(output.status.code(), Some(2));
    assert!(has_ended(&std::fs::read_to_string(child).unwrap()));
}

#[test]
fn a_lack_of_memory_an_exit_code_and_alpha_are_named() {
    let folder = Folder::new();
    write_submission(&folder, "greedy", "exec python3 -c 'bytearray(1 << 30)'");
    let faint = folder.path("faint.png");
    image::RgbaImage::from_pixel(40, 40, image::Rgba([0, 0, 0, 9])).save(&faint).unwrap();
    let copy = format!("cp {} \"$picture\"", faint.display());
    write_submission(&folder, "faint", &for_each_picture(&copy));
    write_submission(&folder, "refuses", &format!("{A2} \"$@\"; echo 'no <b>luck</b>' >&2; exit 7"));
    let arguments =
        ["greedy", "refuses", "faint", "--scenes", "03", "--memory-limit", "400", "--html", "grades.html"];
    let (run, found) = grade(&folder, &arguments);
    let expected = [["failed"], ["failed"], ["differs"]];
    assert_eq!([&found[0], &found[1], &found[2]].map(statuses), expected, "{}", run.stdout);
    let alpha = "a03n.png: alpha differs in 1600 pixels, and is not compared";
    assert!(notes(&found[2], 0).contains(alpha), "{}", notes(&found[2], 0));
    assert!(notes(&found[0], 0).contains("MemoryError") || !cfg!(target_os = "linux"), "{}", notes(&found[0], 0));
    assert_eq!(notes(&found[1], 0), "exit code 7\nits pictures are right\nsays: no <b>luck</b>\n");
    let page = std::fs::read_to_string(folder.path("grades.html")).unwrap();
    assert!(page.contains("no &lt;b&gt;luck") && !page.contains("<b>luck"));
}

/// Each feature is missing where it shows, and is named.
#[test]
fn missing_features_are_named() {
    let folder = Folder::new();
    write_submission(&folder, "no_mirrors", &format!("exec {A2} \"$@\" -bounces 0"));
    write_submission(&folder, "acne", &format!("exec {A2} \"$@\" -epsilon 0"));
    write_submission(&folder, "no_highlights", &editing("sed -i 's/shininess .*/shininess 1e12/' data/*.txt"));
    write_submission(&folder, "no_ambient", &editing("sed -i 's/ambientLight .*/ambientLight 0 0 0/' data/*.txt"));
    let split =
        "$1 == \"v\" { v[++n] = $0 } $1 == \"f\" { for (i = 2; i < 5; i++) print v[$i]; print \"f -3 -2 -1\" }";
    let mesh = "data/models/bunny_200.obj";
    write_submission(&folder, "flat", &editing(&format!("awk '{split}' {mesh} > flat; mv flat {mesh}")));
    let darker = "sed -i 's/ambientLight .*/ambientLight 0 0 0/; s/shininess .*/shininess 1e12/' data/*.txt";
    write_submission(&folder, "two", &editing(darker));
    for (name, scene, expected) in [
        ("no_mirrors", "06", "as if without mirrors (-bounces 0): 0 pixels differ in a06.png"),
        (
            "acne",
            "07",
            "as if without an offset of shadow and mirror rays (-epsilon 0): 0 pixels differ in a07.png",
        ),
        ("no_highlights", "01", "as if without highlights: 0 pixels differ in a01.png"),
        ("no_ambient", "04", "as if without ambient light: 0 pixels differ in a04.png"),
        ("two", "01", "as if without highlights and ambient light: 0 pixels differ in a01.png"),
        ("flat", "05", "as if without smooth normals: 0 pixels differ in a05.png, a05n.png"),
    ] {
        let (run, found) = grade(&folder, &[name, "--scenes", scene]);
        assert_eq!(statuses(&found[0]), ["differs"], "{name}: {}{}", run.stdout, run.stderr);
        assert_eq!(notes(&found[0], 0).trim(), expected, "{name}");
        // That a picture without an offset has false shadows is no news.
        assert_eq!(run.stderr, "", "{name}");
    }
}

#[test]
fn missing_antialiasing_is_named() {
    let folder = Folder::new();
    // Offsets from -1/2 to 1/2 pixel of the grid of 120 x 120, instead of 0 to 1: the camera of scene 01, turned by half
    // such a pixel.
    let (depth, shift) = (1.0 / 15_f64.to_radians().tan(), 1.0 / 119.0);
    let angle = 2.0 * (1.0 / (depth * depth + 2.0 * shift * shift).sqrt()).atan().to_degrees();
    let camera = format!("s/direction .*/direction -{shift} -{shift} -{depth}/; s/angle .*/angle {angle}/");
    for (name, script, status, note) in [
        ("right", format!("exec {A2} \"$@\""), "ok", None),
        ("centred", editing(&format!("sed -i '{camera}' data/scene01*")), "ok", None),
        ("no_jitter", without("-jitter"), "differs", Some("as if without -jitter: 0 pixels differ")),
        (
            "aliased",
            format!("exec {A2} \"$1\" \"$2\" $3 $4 $5 $6 \"$7\""),
            "differs",
            Some("as if without -jitter and -filter: 0 pixels differ"),
        ),
    ] {
        write_submission(&folder, name, &script);
        let (run, found) = grade(&folder, &[name, "--scenes", "aa", "--size", "160"]);
        assert_eq!(statuses(&found[0]), [status], "{name}: {}{}", run.stdout, run.stderr);
        let notes = notes(&found[0], 0);
        assert!(notes.starts_with("error ") && notes.contains("without anti-aliasing"), "{notes}");
        assert_eq!(notes.lines().nth(1), note, "{name}");
    }
}

#[test]
fn folders_of_pictures_are_graded_and_errors_are_clear() {
    let folder = Folder::new();
    let run = folder.run(
        Command::new(project("scripts/render_all.sh"))
            .arg("one/pictures")
            .env("A2", A2)
            .env("SIZE", "40")
            .env_remove("DATA"),
    );
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    std::fs::create_dir(folder.path("pictures")).unwrap();
    std::fs::copy(folder.path("one/pictures/a02.png"), folder.path("pictures/a02.png")).unwrap();
    let (run, found) = grade(&folder, &["one/pictures", "pictures", "--scenes", "01,02,aa"]);
    assert_eq!([&found[0], &found[1]].map(statuses), [["ok", "ok", "ok"], ["missing"; 3]], "{}", run.stdout);
    assert_eq!(found[0]["name"], "one/pictures");
    // All colours one level brighter.
    for name in ["a02.png", "a02n.png", "a02d.png"] {
        let mut picture = folder.picture(&format!("one/pictures/{name}"));
        if name == "a02.png" {
            picture.iter_mut().for_each(|byte| *byte = byte.saturating_add(1));
        }
        picture.save(folder.path(&format!("pictures/{name}"))).unwrap();
    }
    let (_, found) = grade(&folder, &["pictures", "--scenes", "02"]);
    assert_eq!(statuses(&found[0]), ["differs"]);
    let rounded = "no pixel differs by more than 1 level: are bytes rounded, not truncated?\n";
    assert_eq!(notes(&found[0], 0), rounded);
    let parts =
        ["--scenes 01,09", "none", "one/pictures/a01.png", "--starter one", "--size 0", "--csv none/g.csv"];
    let messages = [
        "no scene '09'",
        "no program or folder 'none'",
        "cannot be executed",
        "no folder one/data",
        "at least 4",
        "no folder for",
    ];
    for (arguments, message) in parts.into_iter().zip(messages) {
        let words: Vec<&str> = arguments.split(' ').collect();
        let run = python(&folder, "scripts/grade.py", &words);
        assert_eq!(run.exit_code, 2, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
}

/// The program under test renders; it does not compare its own pictures.
#[test]
fn golden_pictures_are_not_met_by_doing_nothing() {
    let folder = Folder::new();
    write_submission(&folder, "nothing", "exit 0");
    let golden = |program: &str| {
        folder.run(Command::new(project("scripts/golden.sh")).env("A2", program).env("A2_JUDGE", A2))
    };
    let nothing = golden("./nothing");
    assert_eq!(nothing.exit_code, 1, "{}", nothing.stdout);
    assert_eq!(nothing.stdout.matches("missing").count(), 21, "{}", nothing.stdout);
    let ours = golden(A2);
    assert_eq!(ours.exit_code, 0, "{}{}", ours.stdout, ours.stderr);
    assert_eq!(ours.stdout.matches("| ok | 0.0000% | 0 | 0 | 0 | 0.0000 |").count(), 21, "{}", ours.stdout);
}

#[test]
fn a_scene_that_fails_does_not_stop_the_batch() {
    let folder = Folder::new();
    write_submission(&folder, "picky", &format!("case $2 in *scene03*) exit 5;; esac; exec {A2} \"$@\""));
    let mut script = Command::new(project("scripts/render_all.sh"));
    let run = folder.run(script.arg("out").env("A2", folder.path("picky")).env("SIZE", "9").env_remove("DATA"));
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("scene03_sphere failed with exit code 5"), "{}", run.stderr);
    assert_eq!(std::fs::read_dir(folder.path("out")).unwrap().count(), 19);
}
