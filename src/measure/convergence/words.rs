//! What the curves say, in words.

use super::Convergence;
use super::curve::{Cost, Curve};
use crate::options::Options;

/// What is said of curves whose points are not all there.
pub const INTERRUPTED: &str =
    "Interrupted: the curves end before what was asked for, and the picture may have fewer samples.";

/// Returns two lines about the cheapest way to an error, and to a quarter of it, and a third one if points are missing.
pub fn sentences(options: &Options, convergence: &Convergence) -> String {
    let costs = about_costs(options, &Curve::all(&convergence.points));
    if convergence.is_whole { costs } else { format!("{costs}\n{INTERRUPTED}") }
}

fn about_costs(options: &Options, curves: &[Curve]) -> String {
    let Some(level) = level_of_interest(curves) else {
        return "No error above 0 is known here: give more -samples, or a -reference.".to_owned();
    };
    let grid = f64::from(options.grid_pixels());
    let cost = |level: f64| match cheapest(curves, level) {
        Some((curve, cost)) => format!(
            "{} {} of processor time here: {}, {} samples a pixel.",
            if cost.is_extrapolated { "would cost about" } else { "costs" },
            time(cost.cpu_seconds),
            curve.method.name(),
            short(cost.samples.max(grid)),
        ),
        None => "is not reached by more samples.".to_owned(),
    };
    format!("An error of {} levels {}\nA quarter of that error {}", short(level), cost(level), cost(level / 4.0))
}

/// Returns the error that the sentences are about: half a level, or the nearest power of two that a curve reaches.
fn level_of_interest(curves: &[Curve]) -> Option<f64> {
    const USUAL: f64 = 0.5;
    let errors = || curves.iter().flat_map(|curve| &curve.points).filter_map(|point| point.error());
    let (least, most) = (errors().reduce(f64::min)?, errors().reduce(f64::max)?);
    let power = if least > USUAL { least.log2().ceil() } else { most.log2().floor().min(USUAL.log2()) };
    Some(if (least..=most).contains(&power.exp2()) { power.exp2() } else { least })
}

/// Returns the curve that reaches an error in the least processor time; what is measured goes
/// before what is extrapolated.
fn cheapest<'a>(curves: &'a [Curve<'a>], error: f64) -> Option<(&'a Curve<'a>, Cost)> {
    let costs = curves.iter().filter_map(|curve| Some((curve, curve.cost(error)?)));
    costs.min_by(|(_, a), (_, b)| {
        a.is_extrapolated.cmp(&b.is_extrapolated).then(a.cpu_seconds.total_cmp(&b.cpu_seconds))
    })
}

/// Returns a number with at least two digits that count.
pub fn short(number: f64) -> String {
    with_digits(number, 2)
}

/// Returns a number with at least so many digits that count.
pub fn with_digits(number: f64, digits: i32) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let decimals = (digits - 1 - number.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Returns a time with its unit.
pub fn time(seconds: f64) -> String {
    match seconds {
        0.0 => "0 s".to_owned(),
        ..1e-3 => format!("{} µs", short(1e6 * seconds)),
        ..1.0 => format!("{} ms", short(1e3 * seconds)),
        _ => format!("{} s", short(seconds)),
    }
}
