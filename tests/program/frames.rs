//! `scripts/frames.sh` renders frames and joins them to an animated PNG.

use crate::support::{Folder, Run, SCENE, project};
use image::codecs::png::PngDecoder;
use image::{AnimationDecoder, DynamicImage, RgbImage};
use std::process::Command;

fn run(folder: &Folder, arguments: &str, rate: &str) -> Run {
    let mut script = Command::new(project("scripts/frames.sh"));
    script.args(arguments.split(' ').filter(|word| !word.is_empty()));
    folder.run(script.env("A2", env!("CARGO_BIN_EXE_a2")).env("RATE", rate).env_remove("PIVOT"))
}

/// The frames of an animated PNG, and milliseconds for one.
fn frames(folder: &Folder, name: &str) -> (Vec<RgbImage>, u32) {
    let file = std::io::BufReader::new(std::fs::File::open(folder.path(name)).unwrap());
    let frames = PngDecoder::new(file).unwrap().apng().unwrap().into_frames().collect_frames().unwrap();
    let delay = frames[0].delay().numer_denom_ms();
    let pictures = frames.into_iter().map(|frame| DynamicImage::from(frame.into_buffer()).into_rgb8());
    (pictures.collect(), delay.0 / delay.1)
}

#[test]
fn frames_of_a_turntable_are_the_scene_from_all_sides() {
    let folder = Folder::new();
    // A triangle that is no mirror image of itself.
    let front = SCENE.replace("vertex2 0 4 0", "vertex2 9 9 0");
    let behind = front.replace("center 0 0 10 direction 0 0 -1", "center 0 0 -10 direction 0 0 1");
    let expected = [&front, &behind].map(|scene| folder.render(scene, "-size 8 6"));
    assert_ne!(expected[0], expected[1]);
    folder.write("front.txt", front).write("behind.txt", behind);
    // Flags begin at the first word with a dash. On no terminal each message has its line.
    let turn = run(&folder, "turn.png -turntable 2 front.txt -size 8 6", "10");
    assert_eq!((turn.exit_code, turn.stdout.as_str()), (0, ""), "{}", turn.stderr);
    assert_eq!(turn.stderr, "1 of 2 frames\n2 of 2 frames\nturn.png: 2 frames\n");
    assert_eq!(frames(&folder, "turn.png"), (expected.to_vec(), 100));
    let two = run(&folder, "two.png front.txt behind.txt -size 8 6", "20");
    assert_eq!(two.exit_code, 0, "{}", two.stderr);
    assert_eq!(frames(&folder, "two.png"), (expected.to_vec(), 50));
}

#[test]
fn a_wrong_command_is_refused_and_says_why() {
    let folder = Folder::new();
    folder.write("scene.txt", SCENE).write("empty.txt", "");
    for (arguments, rate, message) in [
        ("", "20", "the first word must be the file to write"),
        ("-turntable 2 scene.txt", "20", "the first word must be the file to write"),
        ("out.png", "20", "there is no scene"),
        ("out.png -size 8 6 scene.txt", "20", "there is no scene"),
        ("out.png none.txt", "20", "there is no scene 'none.txt'"),
        ("out.png -turntable scene.txt", "20", "FRAMES is 'scene.txt', not a whole number from 1 to 65535"),
        ("out.png -turntable 0 scene.txt", "20", "FRAMES is '0', not a whole number from 1 to 65535"),
        ("out.png -turntable 2 scene.txt scene.txt", "20", "-turntable needs one scene"),
        ("out.png -turntable 2 empty.txt", "20", "empty.txt: there is no PerspectiveCamera"),
        ("out.png scene.txt", "1.5", "RATE is '1.5', not a whole number from 1 to 65535"),
    ] {
        let run = run(&folder, arguments, rate);
        assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""), "{arguments}: {}", run.stderr);
        let expected = format!("error: {message}\n  frames.sh OUT.png SCENE.txt");
        assert!(run.stderr.starts_with(&expected), "{arguments}: {}", run.stderr);
    }
    // What a2 refuses is said by a2.
    let refused = run(&folder, "out.png scene.txt -what", "20");
    assert_eq!(refused.exit_code, 1);
    assert!(refused.stderr.ends_with("error: frame 1 is not rendered: scene.txt\n"), "{}", refused.stderr);
    assert!(!folder.path("out.png").exists());
}
