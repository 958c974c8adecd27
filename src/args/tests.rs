//! Command lines and what they mean.

use super::*;
use crate::options::{DepthPicture, MAX_SAMPLES, SamplerKind};

fn parsed(line: &str) -> Result<Request, Error> {
    parse(line.split_whitespace().map(OsString::from))
}

fn render(line: &str) -> Options {
    match parsed(line) {
        Ok(Request::Render(options)) => *options,
        other => panic!("{line}: {other:?}"),
    }
}

fn refusal(line: &str) -> String {
    match parsed(line) {
        Err(Error::Usage(message)) => message,
        other => panic!("{line}: {other:?}"),
    }
}

#[test]
fn one_dash_and_two_mean_the_same_in_any_order() {
    for line in [
        "-input s.txt -output o.png -size 30 20 -bounces 4 -shadows",
        "--shadows --bounces 4 --size 30 20 --output o.png --input s.txt",
    ] {
        let options = render(line);
        assert_eq!((options.width, options.height, options.bounces, options.shadows), (30, 20, 4, true));
        assert!(!options.jitter && !options.filter && options.depth.is_none());
    }
}

#[test]
fn the_last_of_a_repeated_flag_counts() {
    let options = render("-input s.txt -input t.txt -output o.png -size 1 2 -size 3 4 -jitter -jitter");
    assert_eq!((options.input, options.width, options.height), (PathBuf::from("t.txt"), 3, 4));
}

#[test]
fn depth_may_be_negative_and_inverted() {
    let options = render("-input s.txt -depth 1 -1.5e3 d.png");
    assert_eq!(
        options.depth.unwrap(),
        DepthPicture { min: 1.0, max: -1500.0, is_auto: false, background: None, path: "d.png".into() }
    );
}

#[test]
fn robust_rays_start_just_off_the_surface_unless_a_distance_is_given() {
    let epsilon = |flags: &str| render(&format!("-input s.txt -output o.png {flags}")).epsilon;
    assert_eq!(epsilon(""), Epsilon::Along(0.01));
    assert_eq!(epsilon("-robust"), Epsilon::Auto);
    assert_eq!(epsilon("-epsilon auto"), Epsilon::Auto);
    assert_eq!(epsilon("-epsilon 1e-4 -robust"), Epsilon::Along(1e-4));
    assert!(render("-input s.txt -output o.png -robust").robust);
}

#[test]
fn errors_name_flag_value_and_expectation() {
    for (line, parts) in [
        ("-input s.txt", &["-output", "-depth"] as &[_]),
        ("-output o.png", &["-input"]),
        ("-input s.txt -output o.jpg", &["-output", ".png, .pfm", "o.jpg"]),
        ("-input s.obj -output o.png", &["-input", ".txt", "s.obj"]),
        ("-input s.txt -output o.png -size 0 5", &["-size", "'0'", "from 1 to 65536"]),
        ("-input s.txt -output o.png -size 5 65537", &["-size", "'65537'", "from 1 to 65536"]),
        ("-input s.txt -output o.png -size 5", &["-size", "W H"]),
        ("-input s.txt -output o.png -size 5 -shadows", &["-size", "W H"]),
        ("-input s.txt -output o.png -bounces -1", &["-bounces", "'-1'"]),
        ("-input s.txt -output o.png -bounces 2.5", &["-bounces", "'2.5'"]),
        ("-input s.txt -output o.png -threads -1e40", &["-threads", "'-1e40'"]),
        ("-input s.txt -output o.png -seed -.50", &["-seed", "'-.50'"]),
        ("-input s.txt -output o.png -max-memory -1M", &["-max-memory", "'-1M'"]),
        ("-input s.txt -output o.png -tile -1/2", &["-tile", "'-1/2'"]),
        ("-input s.txt -output -1.jpg", &["-output", "'-1.jpg'"]),
        ("-input s.txt -output o.png -7", &["'-7' belongs to no flag"]),
        ("-7 -input s.txt -output o.png", &["'-7' belongs to no flag"]),
        ("-7", &["-input", "'-7'"]),
        ("-input s.txt -output o.png -shadows=-7", &["-shadows takes no value"]),
        ("-input s.txt -output o.png ---shadows", &["unknown flag ---shadows (did you mean -shadows?)"]),
        ("-input s.txt -output o.png --shadow", &["unknown flag -shadow (did you mean -shadows?)"]),
        ("-input s.txt -output o.png -pixel 99999999999 1", &["-pixel", "from 0 to 65535", "'99999999999'"]),
        ("-input s.txt -output o.png -bouncse 2", &["-bouncse", "did you mean -bounces"]),
        ("-input s.txt -output o.png stray", &["'stray' belongs to no flag: the scene is 's.txt'"]),
        ("s.txt t.txt -output o.png", &["'t.txt' belongs to no flag: the scene is 's.txt'"]),
        ("s.txt -compare a.png b.png", &["'s.txt' belongs to no flag: -compare takes two pictures"]),
        ("-compare a.png b.png -diff -", &["-diff", ".png", "'-'"]),
        ("- -output o.png -depth 0 1", &["-depth needs 3 values"]),
        ("s.txt -output", &["-output needs 1 value: -output FILE"]),
        ("s.txt -output o.png -shadows=1", &["-shadows takes no value"]),
        ("-input s.txt -depth nan 1 d.png", &["-depth", "'nan'"]),
        ("-input s.txt -output o.png -threads 0", &["-threads", "'0'"]),
        ("-input s.txt -output o.png -epsilon -1", &["-epsilon", "'-1'", "auto"]),
        ("-input s.txt -output o.png -epsilon nan", &["-epsilon", "'nan'"]),
        ("-input s.txt -output o.png -simd mmx", &["-simd", "sse2, avx2, avx512", "'mmx'"]),
        ("-input s.txt -output o.png -seed -3", &["-seed", "'-3'"]),
        ("-input s.txt -output o.png -diff d.png", &["-diff", "-compare"]),
        ("-input s.txt -output o.png -samples 0", &["-samples", "'0'", "from 1 to 65536"]),
        (
            "-input s.txt -output o.png -sampler halton",
            &["-sampler", "independent, stratified, sobol", "'halton'"],
        ),
        ("-input s.txt -output o.png -target-error 0", &["-target-error", "above 0", "'0'"]),
        ("-input s.txt -output o.png -time-limit nan", &["-time-limit", "above 0", "'nan'"]),
        ("-input s.txt -output o.png -report r.txt", &["-report", ".json", "r.txt"]),
        ("-input s.txt -output o.png -reference r.jpg", &["-reference", ".png, .pfm, .exr", "r.jpg"]),
        ("-input s.txt -normals o.png -target-error 1", &["-target-error", "-output"]),
        ("-input s.txt -output o.png -convergence c.pdf", &["-convergence", ".svg, .html, .csv", "c.pdf"]),
        ("-input s.txt -output o.png -target-error 0.05 -samples 4", &["-samples", "-target-error", "chooses"]),
        ("-input s.txt -output o.png -convergence c.csv -time-limit 1", &["-convergence", "-time-limit"]),
        ("-compare a.png b.png -size 3 3", &["-size", "-compare"]),
        ("-compare a.png", &["-compare", "A B"]),
        ("-compare a.png b.png -tolerance 300 1", &["-tolerance", "'300'"]),
    ] {
        let message = refusal(line);
        for part in parts {
            assert!(message.contains(part), "{line}: '{part}' is not in: {message}");
        }
    }
}

#[test]
fn flags_about_random_samples_imply_jitter() {
    for flags in ["-samples 4", "-sampler sobol", "-target-error 1", "-time-limit 2", "-error-map e.png"] {
        assert!(render(&format!("-input s.txt -output o.png {flags}")).jitter, "{flags}");
    }
    for flags in ["-stats", "-report r.json", "-reference r.pfm", "-seed 3"] {
        assert!(!render(&format!("-input s.txt -output o.png {flags}")).jitter, "{flags}");
    }
    let sampler = |flags: &str| render(&format!("-input s.txt -output o.png {flags}")).measure.sampler;
    assert_eq!(sampler("-jitter"), SamplerKind::Stratified);
    assert_eq!(sampler("-target-error 1"), SamplerKind::Sobol);
}

#[test]
fn help_names_every_flag() {
    for help in ["-h", "-help"] {
        let Ok(Request::Print(text)) = parsed(help) else { panic!() };
        for Flag { name, .. } in flags() {
            assert!(text.split_whitespace().any(|word| word == format!("-{name}")), "{help}: {name}");
        }
    }
}

#[test]
fn help_is_shown_beside_flags_without_their_values() {
    let Ok(Request::Print(screen)) = parsed("-h") else { panic!() };
    for line in ["-merge -h", "-compare -h", "s.txt -size 3 -h", "-h -output"] {
        assert!(matches!(parsed(line), Ok(Request::Print(text)) if text == screen), "{line}");
    }
}

#[test]
fn help_fits_a_terminal() {
    for help in ["-h", "-help"] {
        let Ok(Request::Print(text)) = parsed(help) else { panic!() };
        for line in text.lines() {
            assert!(line.chars().count() <= 80 && line == line.trim_end(), "{help}: {line}");
        }
    }
    let Ok(Request::Print(screen)) = parsed("-h") else { panic!() };
    assert!(screen.lines().count() < 30, "{screen}");
}

/// One number each, wherever it is told.
#[test]
fn limits_are_the_same_everywhere() {
    let (Ok(Request::Print(help)), Ok(Request::Print(version))) = (parsed("-help"), parsed("-V")) else {
        panic!()
    };
    let limits = [MAX_SIDE, MAX_BOUNCES, MAX_SAMPLES];
    let in_order = |text: &str| limits.iter().filter(|limit| text.contains(&limit.to_string())).count();
    assert_eq!((in_order(&help), in_order(&version)), (3, 3), "{help}{version}");
    let page = include_str!("../../ARCHITECTURE.md").replace(',', "");
    assert!(page.contains(&format!("pictures up to {MAX_SIDE} x {MAX_SIDE} {MAX_BOUNCES} bounces")));
    let size = refusal("s.txt -output o.png -size 0 5");
    assert!(size.contains(&format!("from 1 to {MAX_SIDE}, found '0'")), "{size}");
}

#[test]
fn the_scene_needs_no_flag_and_a_dash_is_a_file() {
    let options = render("s.txt -output - -size 3 4 -report r.json");
    assert_eq!((options.input, options.color), (PathBuf::from("s.txt"), Some(PathBuf::from("-"))));
    assert!(!render("s.txt -output -").color_is_numbers() && render("s.txt -output o.pfm").color_is_numbers());
    assert_eq!(render("-output o.png -size 3 4 - -report -").input, PathBuf::from("-"));
    assert_eq!(render("-output o.png s.txt -input s.txt").input, PathBuf::from("s.txt"));
    assert!(render("s.txt -check").check);
}

#[test]
fn the_version_says_what_was_built() {
    for flag in ["-V", "-version", "--version"] {
        let Ok(Request::Print(text)) = parsed(flag) else { panic!("{flag}") };
        assert!(text.starts_with(concat!("a2 ", env!("CARGO_PKG_VERSION"), "\ncommit ")), "{text}");
        assert!(text.contains(InstructionSet::NAMES[0]) && text.contains(std::env::consts::ARCH), "{text}");
    }
}
