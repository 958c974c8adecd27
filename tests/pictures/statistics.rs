//! Statistical tests of random samples: pictures are unbiased with any sampler and any number of samples.
//! [`coverage`](super::coverage) tests that the estimated error is right.

use crate::support::batch::{self, Scene};
use crate::support::{Folder, SCENE, TRIANGLE, options_of_numbers, picture, project};
use a2::measure::Report;
use a2::options::Options;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// The scenes of the course's batch with their flags, as words of a command line.
pub static SCENES: LazyLock<Vec<String>> =
    LazyLock::new(|| batch::scenes().iter().map(Scene::arguments).collect());
pub const SAMPLERS: [&str; 3] = ["independent", "stratified", "sobol"];

/// A copy of `data/` whose cube map has 64 x 64 texels a face. Small pictures are rendered by the thousand here, and
/// decoding the large faces would take most of the time.
pub static DATA: LazyLock<PathBuf> = LazyLock::new(|| {
    let (from, to) = (project("data"), Path::new(env!("CARGO_TARGET_TMPDIR")).join("statistics"));
    for folder in ["", "models", "tex/courtyard"] {
        std::fs::create_dir_all(to.join(folder)).unwrap();
        for entry in std::fs::read_dir(from.join(folder)).unwrap().map(|entry| entry.unwrap().path()) {
            let copy = to.join(folder).join(entry.file_name().unwrap());
            if folder.starts_with("tex") {
                image::imageops::thumbnail(&picture(&entry), 64, 64).save(copy).unwrap();
            } else if entry.is_file() {
                std::fs::copy(entry, copy).unwrap();
            }
        }
    }
    to
});

pub fn arguments(scene: &str, flags: &str) -> Options {
    let data = &*DATA;
    options_of_numbers(&format!("-input {}/{scene} -output unused.png -quiet {flags}", data.display()))
}

pub fn rendered(args: &Options) -> Report {
    a2::render_scene(args).unwrap()
}

/// Renders a picture and returns its colours as numbers.
pub fn colors(args: &Options) -> Vec<f64> {
    rendered(args).frame.film.linear.unwrap().into_iter().map(f64::from).collect()
}

/// Mean and variance of many pictures with different seeds, for each pixel the mean of its channels.
struct Many {
    runs: f64,
    mean: Vec<f64>,
    /// Of a single picture.
    variance: Vec<f64>,
}

/// Renders a picture with each seed.
fn many(args: &Options, seeds: std::ops::Range<u64>) -> Many {
    let runs = (seeds.end - seeds.start) as f64;
    let mut many = Many { runs, mean: vec![], variance: vec![] };
    for (run, seed) in seeds.enumerate() {
        let values = colors(&Options { seed, ..args.clone() });
        let values: Vec<f64> = values.chunks(3).map(|c| (c[0] + c[1] + c[2]) / 3.0).collect();
        if run == 0 {
            many.mean = vec![0.0; values.len()];
            many.variance = vec![0.0; values.len()];
        }
        // Welford's update of mean and sum of squares.
        for (i, value) in values.into_iter().enumerate() {
            let difference = value - many.mean[i];
            many.mean[i] += difference / (run + 1) as f64;
            many.variance[i] += difference * (value - many.mean[i]);
        }
    }
    many.variance.iter_mut().for_each(|sum| *sum /= runs - 1.0);
    many
}

/// Number of samples, of the independent sampler, in the pictures that count as true.
const TRUE_SAMPLES: f64 = 64.0;

/// Returns the difference of the means of two series of pictures in standard errors: of the worst pixel, and of the
/// sum over all pixels, which is far more sensitive to a common shift. The pictures of the first series have at least
/// `samples` samples a pixel.
fn distances(series: &Many, truth: &Many, samples: f64) -> (f64, f64) {
    let mut worst: f64 = 0.0;
    let (mut differences, mut variances) = (0.0, 0.0);
    for i in 0..series.mean.len() {
        let difference = series.mean[i] - truth.mean[i];
        let of_truth = truth.variance[i] / truth.runs;
        differences += difference;
        variances += series.variance[i] / series.runs + of_truth;
        // A rare event may be missing in the series, and then the variance of the series is too small.
        let independent = truth.variance[i] * TRUE_SAMPLES / samples;
        let variance = series.variance[i].max(independent) / series.runs + of_truth;
        if variance > 1e-18 {
            worst = worst.max(difference.abs() / variance.sqrt());
        }
    }
    (worst, differences.abs() / variances.sqrt())
}

/// Checks that two series have the same mean. About 256 pixels are tested in thirty pairs of series. With 60 degrees
/// of freedom less than one pixel in a million differs by more than 5.5 standard errors by chance; the sum over all
/// pixels exceeds 4.2 in one of 40,000 cases.
fn assert_same_mean(what: &str, series: &Many, truth: &Many, samples: f64) {
    let (worst, together) = distances(series, truth, samples);
    assert!(
        worst < 5.5 && together < 4.2,
        "{what}: worst pixel {worst:.2}, together {together:.2} standard errors"
    );
}

const SMALL: &str = "-size 16 16";

#[test]
fn every_sampler_is_unbiased_with_any_number_of_samples() {
    for scene in [&SCENES[3], &SCENES[6]] {
        let truth = many(&arguments(scene, &format!("{SMALL} -sampler independent -samples 64")), 1000..1100);
        for sampler in SAMPLERS {
            for samples in [1, 7, 16] {
                let flags = format!("{SMALL} -sampler {sampler} -samples {samples}");
                let series = many(&arguments(scene, &flags), 0..60);
                assert_same_mean(&format!("{scene} {flags}"), &series, &truth, f64::from(samples));
            }
        }
    }
}

#[test]
fn a_report_leaves_the_picture_as_it_is() {
    for scene in [&SCENES[1], &SCENES[6]] {
        for sampler in SAMPLERS {
            for flags in ["-samples 1", "-samples 2", "-samples 7", "-samples 16", "-samples 4 -filter"] {
                let flags = format!("{SMALL} -sampler {sampler} {flags}");
                let plain = colors(&arguments(scene, &flags));
                let measured = colors(&arguments(scene, &format!("{flags} -stats -error-map e.png")));
                assert!(plain == measured, "{scene} {flags}");
            }
        }
    }
}

#[test]
fn adaptive_sampling_is_unbiased() {
    for (scene, filter) in [(&SCENES[1], ""), (&SCENES[6], ""), (&SCENES[3], "-filter")] {
        let truth = format!("{SMALL} -sampler independent -samples 64 {filter}");
        let truth = many(&arguments(scene, &truth), 1000..1060);
        for sampler in ["", "-sampler independent", "-sampler stratified"] {
            let flags = format!("{SMALL} -target-error 3 {sampler} {filter}");
            let series = many(&arguments(scene, &flags), 0..80);
            assert_same_mean(&format!("{scene} {flags}"), &series, &truth, 2.0);
        }
    }
}

/// The tests of means above would also pass if they could see nothing.
#[test]
fn a_shift_of_the_samples_is_detected() {
    let scene = &SCENES[3];
    let truth = many(&arguments(scene, &format!("{SMALL} -sampler independent -samples 64")), 1000..1060);
    // The same picture on a grid that is one sixteenth larger.
    let shifted = many(&arguments(scene, "-size 17 17 -samples 16"), 0..60);
    let cut = |values: &[f64]| values.chunks(17).take(16).flat_map(|row| row[..16].to_vec()).collect::<Vec<f64>>();
    let shifted = Many { runs: shifted.runs, mean: cut(&shifted.mean), variance: cut(&shifted.variance) };
    let (worst, together) = distances(&shifted, &truth, 16.0);
    assert!(worst > 20.0 || together > 20.0, "worst {worst}, together {together}");
}

#[test]
fn stratified_and_sobol_samples_are_better_than_independent_ones() {
    // 8 samples are better than 16 independent ones in every scene, because all scenes have edges.
    for scene in SCENES.iter() {
        let size = "-size 32 32";
        let truth = colors(&arguments(scene, &format!("{size} -sampler sobol -samples 512 -seed 99")));
        let error = |sampler: &str, samples: u32| {
            let flags = format!("{size} -sampler {sampler} -samples {samples}");
            (0..4)
                .map(|seed| mean_square(&colors(&Options { seed, ..arguments(scene, &flags) }), &truth))
                .sum::<f64>()
        };
        let (independent, stratified, sobol) =
            (error("independent", 16), error("stratified", 8), error("sobol", 8));
        assert!(stratified.min(sobol) < independent, "{scene}: {independent} {stratified} {sobol}");
    }
}

pub fn mean_square(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64
}

/// Clamps values as pictures do.
pub fn shown(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.clamp(0.0, 1.0)).collect()
}

#[test]
fn a_target_error_is_reached_with_few_samples_in_flat_pixels() {
    for scene in SCENES.iter() {
        let args = arguments(scene, "-size 32 32 -target-error 2");
        let run = rendered(&args);
        assert!(run.frame.estimate.unwrap().levels.rmse <= 2.0, "{scene}");
        let (least, most) = (run.frame.samples.least.unwrap(), run.frame.samples.most);
        assert!(
            f64::from(least) < run.frame.samples.mean() && most >= 4 * least,
            "{scene}: {:?}",
            run.frame.samples
        );
    }
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "Sphere { center 0 0 99 radius 1 }"));
    // A picture without edges needs nothing after the first pass, if it has so many pixels that nothing large can hide.
    for (size, samples, rays) in [(100, 2, 20_000), (40, 4, 1600 * 4 + 41 * 41)] {
        let flags = format!("-output unused.png -quiet -size {size} {size} -target-error 1.3");
        let flat = rendered(&options_of_numbers(&format!("-input {} {flags}", folder.path("s.txt").display())));
        assert_eq!((flat.frame.samples.least, flat.frame.samples.most), (Some(samples), samples), "{size}");
        assert_eq!(flat.frame.counts.camera, rays, "{size}");
    }
}

#[test]
fn adaptive_pictures_are_the_same_with_any_number_of_threads() {
    let args = arguments(&SCENES[6], "-size 40 40 -target-error 2 -filter -normals n.png -depth 8 18 d.png");
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let film = pool.install(|| rendered(&args)).frame.film;
        (film.color, film.normals, film.depth)
    };
    assert!(with_threads(1) == with_threads(3));
}

#[test]
fn a_time_limit_gives_a_complete_picture() {
    let folder = tempfile::tempdir().unwrap();
    for scene in SCENES.iter() {
        let limited = arguments(scene, "-size 400 400");
        let plain = rendered(&limited).frame.film.color.unwrap();
        let picture = folder.path().join("o.png");
        let line = format!("{} -size 400 400 -time-limit 0.2 -quiet -output", limited.input.display());
        let flags = scene.split(' ').skip(1);
        let start = Instant::now();
        let status = Command::new(env!("CARGO_BIN_EXE_a2"))
            .args(["-input"].into_iter().chain(line.split(' ')))
            .arg(&picture)
            .args(flags)
            .status();
        // 3: not every pixel was reached.
        let exit_code = status.unwrap().code();
        assert!(matches!(exit_code, Some(0 | 3)), "{scene}: {exit_code:?}");
        // Ten times the limit, for machines under load.
        assert!(start.elapsed() < Duration::from_secs(2), "{scene}: {:?}", start.elapsed());
        let bytes = image::open(&picture).unwrap().into_rgb8();
        assert_eq!(bytes.dimensions(), (400, 400));
        let squares: f64 = bytes.iter().zip(&plain).map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2)).sum();
        let rmse = (squares / plain.len() as f64).sqrt();
        assert!(rmse < 40.0, "{scene}: {rmse} levels from the plain picture");
    }
}
