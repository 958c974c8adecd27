//! Curves whose points lie where theory puts them.

use super::axis::{Axis, Quantity};
use super::curve::Curve;
use super::words::{short, time};
use super::*;
use crate::render::error_estimate::Interval;

fn point(method: Method, samples: f64, seconds: f64, error: f64) -> Point {
    let levels = Interval { rmse: error, low: 0.9 * error, high: 1.1 * error };
    Point {
        method,
        samples,
        samples_a_pixel: samples,
        camera_rays: samples,
        target: None,
        times: Times { wall: Duration::from_secs_f64(seconds), cpu: Duration::from_secs_f64(seconds) },
        rays: 100,
        estimate: Some(ErrorEstimate { linear: levels, levels, ..ErrorEstimate::default() }),
        true_error: None,
    }
}

/// Makes points of 2, 4, 8 ... samples, of which two cost a second, with errors of 4, 2, 1 ... times 2^`steepness`.
fn points(method: Method, count: i32, seconds: f64, steepness: f64) -> Vec<Point> {
    let one = |i: i32| {
        let factor = 2_f64.powi(i);
        point(method, 2.0 * factor, seconds * factor, 4.0 * factor.powf(-steepness))
    };
    (0..count).map(one).collect()
}

const SOBOL: Method = Method::Fixed(SamplerKind::Sobol);
const INDEPENDENT: Method = Method::Fixed(SamplerKind::Independent);

#[test]
fn a_slope_is_that_of_the_line_and_its_interval_holds_the_truth() {
    let some = points(SOBOL, 5, 1.0, 0.75);
    let slope = Curve::all(&some)[0].slope(Point::cpu_seconds).unwrap();
    assert!((slope.slope + 0.75).abs() < 1e-9 && slope.half_width < 1e-6, "{slope:?}");
    let mut off = points(SOBOL, 5, 1.0, 0.5);
    for (point, factor) in off.iter_mut().zip([1.05, 0.97, 1.0, 1.04, 0.95]) {
        point.estimate = point.estimate.map(|mut estimate| {
            estimate.levels.rmse *= factor;
            estimate
        });
    }
    let slope = Curve::all(&off)[0].slope(Point::cpu_seconds).unwrap();
    assert!(slope.half_width > 0.01 && (slope.slope + 0.5).abs() < slope.half_width, "{slope:?}");
    assert_eq!(Curve::all(&some[..2])[0].slope(Point::cpu_seconds), None);
    assert!(Curve::all(&[point(SOBOL, 4.0, 1.0, 0.0)]).is_empty());
}

#[test]
fn costs_lie_on_the_curve_and_beyond_it_on_a_line_no_steeper_than_theory() {
    let some = [points(INDEPENDENT, 5, 1.0, 0.5), points(Method::Adaptive, 4, 0.1, 3.0)].concat();
    let curves = Curve::all(&some);
    let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
    let between = curves[0].cost(4.0 / 3.0_f64.sqrt()).unwrap();
    assert!(close(between.cpu_seconds, 3.0) && close(between.samples, 6.0) && !between.is_extrapolated);
    let beyond = curves[0].cost(0.5).unwrap();
    assert!(close(beyond.cpu_seconds, 64.0) && beyond.is_extrapolated, "{beyond:?}");
    assert_eq!(curves[0].cost(5.0), None);
    // The last adaptive point has 4/2^9 levels in 0.8 s. A line of slope -3 would give a hundredth more of time.
    let beyond = curves[1].cost(4.0 / 4096.0).unwrap();
    assert!(close(beyond.cpu_seconds, 0.8 * 8.0_f64.powf(1.0 / 0.75)), "{beyond:?}");
}

#[test]
fn targets_are_powers_of_two_between_the_errors() {
    assert_eq!(targets(points(INDEPENDENT, 9, 1.0, 0.5).iter()), [4.0, 2.0, 1.0, 0.5, 0.25]);
    let root = 2.0_f64.sqrt();
    let few = targets(points(INDEPENDENT, 4, 1.0, 0.5).iter());
    assert!(few.iter().zip([4.0, 2.0 * root, 2.0, root]).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{few:?}");
    assert!(targets([point(SOBOL, 4.0, 1.0, 0.0)].iter()).is_empty());
}

#[test]
fn the_sentences_name_the_cheapest_way() {
    let crate::args::Request::Render(options) =
        crate::args::parse(["-input", "s.txt", "-output", "o.png"].map(Into::into)).unwrap()
    else {
        panic!()
    };
    let some = [points(INDEPENDENT, 9, 1.0, 0.5), points(SOBOL, 5, 0.01, 0.75)].concat();
    let said = |points, is_whole| sentences(&options, &Convergence { points, is_whole });
    assert_eq!(
        said(some.clone(), true),
        "An error of 0.5 levels costs 160 ms of processor time here: sobol, 32 samples a pixel.\n\
         A quarter of that error would cost about 1 s of processor time here: sobol, 203 samples a pixel."
    );
    assert!(said(Vec::new(), true).starts_with("No error above 0 is known"));
    assert!(said(some, false).lines().nth(2).unwrap().starts_with("Interrupted: the curves end"));
}

#[test]
fn numbers_keep_two_digits() {
    let cases =
        [(0.0123, "0.012"), (0.5, "0.5"), (16.0, "16"), (1234.0, "1234"), (9.96, "10"), (1.5e-5, "0.000015")];
    for (number, text) in cases {
        assert_eq!(short(number), text);
    }
    assert_eq!([time(2.5e-5), time(0.002), time(0.25), time(31.0)], ["25 µs", "2 ms", "250 ms", "31 s"]);
}

#[test]
fn labels_of_ticks_do_not_overlap() {
    for quantity in [Quantity::Levels, Quantity::Seconds, Quantity::Samples] {
        for (low, high) in [(1.0, 1.0), (0.3, 0.4), (1.9, 2.1), (0.004, 3.0), (1e-5, 1e4), (0.7, 65536.0)] {
            let axis = Axis::new(quantity, [low, high].into_iter(), 0.0, 424.0);
            let ticks = axis.ticks();
            let labelled: Vec<_> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
            assert!(labelled.len() >= 2, "{quantity:?} {low} {high}");
            for pair in labelled.windows(2) {
                // A digit is 7 pixels wide.
                let width = 3.5 * (pair[0].label.chars().count() + pair[1].label.chars().count()) as f64;
                assert!(
                    pair[1].place - pair[0].place > width,
                    "{quantity:?} {low} {high}: {} and {}",
                    pair[0].label,
                    pair[1].label
                );
            }
        }
    }
}
