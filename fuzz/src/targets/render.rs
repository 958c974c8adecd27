//! Tiny pictures: the same bits one ray at a time, with every instruction set, and at any number of threads.

use super::scene::compiled;
use super::{grammar, options};
use a2::film::Film;
use a2::options::Options;
use a2::ray_counts::RayCounts;
use a2::render::{Progress, render_uniform};
use a2::simd::InstructionSet;
use arbitrary::{Result, Unstructured};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::Path;
use std::sync::LazyLock;

struct Quiet;

impl Progress for Quiet {
    fn advance(&self, _: usize, _: usize) {}
}

static ONE_THREAD: LazyLock<ThreadPool> = LazyLock::new(|| pool(1));
static TWO_THREADS: LazyLock<ThreadPool> = LazyLock::new(|| pool(2));

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

/// What a picture must have the same of, however it is rendered: all planes and the numbers of rays.
type Rendered = ([Vec<u32>; 4], RayCounts);

/// Renders a scene made of the bytes in every way.
pub fn render(data: &[u8], folder: &Path) -> bool {
    let mut bytes = Unstructured::new(data);
    let Ok(line) = flags(&mut bytes) else { return false };
    let numbers = if bytes.ratio(1, 4).unwrap_or(false) { grammar::Numbers::Any } else { grammar::Numbers::Usual };
    let Ok(text) = grammar::scene(&mut bytes, numbers) else { return false };
    let mut options = options(&line);
    options.measure.keep_linear = true;
    let plain = Options { plain: true, ..options.clone() };
    let Some(expected) = rendered(&text, folder, &plain, &ONE_THREAD) else { return false };
    if numbers == grammar::Numbers::Usual {
        let colors = expected.0[0].iter().map(|&bits| f32::from_bits(bits));
        assert!(colors.into_iter().all(|color| !color.is_nan()), "{line}\n{text}");
    }
    for set in InstructionSet::available() {
        options.simd = set;
        assert!(
            rendered(&text, folder, &options, &ONE_THREAD).as_ref() == Some(&expected),
            "{set}: {line}\n{text}"
        );
    }
    assert!(
        rendered(&text, folder, &options, &TWO_THREADS).as_ref() == Some(&expected),
        "threads: {line}\n{text}"
    );
    true
}

/// Renders a scene; `None` if it is refused.
fn rendered(text: &str, folder: &Path, options: &Options, pool: &ThreadPool) -> Option<Rendered> {
    pool.install(|| {
        let (scene, plan) = compiled(text, folder, options).ok()?;
        let frame = render_uniform(&scene, &plan, options, &Quiet);
        Some((bits(&frame.film), frame.counts))
    })
}

fn bits(film: &Film) -> [Vec<u32>; 4] {
    let bytes = |plane: &Option<Vec<u8>>| plane.iter().flatten().map(|&byte| byte.into()).collect();
    let numbers = film.linear.iter().flatten().map(|number| number.to_bits()).collect();
    [numbers, bytes(&film.color), bytes(&film.normals), bytes(&film.depth)]
}

/// Makes a command line.
fn flags(bytes: &mut Unstructured) -> Result<String> {
    let (width, height) = (bytes.int_in_range(1..=12)?, bytes.int_in_range(1..=12)?);
    let bounces = bytes.int_in_range(0..=4)?;
    let mut line = format!(
        "-input s.txt -output o.png -normals n.png -depth 0 9 d.png -size {width} {height} -bounces {bounces}"
    );
    for flag in ["-shadows", "-robust", "-filter", "-epsilon auto", "-epsilon 1e-4"] {
        if bytes.ratio(1, 3)? {
            line = format!("{line} {flag}");
        }
    }
    if bytes.ratio(1, 3)? {
        let samples = bytes.int_in_range(1..=5)?;
        let sampler = *bytes.choose(&["independent", "stratified", "sobol"])?;
        let seed: u8 = bytes.arbitrary()?;
        line = format!("{line} -samples {samples} -sampler {sampler} -seed {seed}");
    }
    Ok(line)
}
