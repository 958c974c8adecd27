//! The curves as SVG: error against processor time on the left, against samples on the right, with slopes below.

use super::axis::{Axis, Quantity};
use super::curve::Curve;
use super::svg::{Drawing, Place};
use super::table::csv;
use super::words::sentences;
use super::{Convergence, Method, Point};
use crate::options::{Options, SamplerKind};
use std::borrow::Cow;

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 560.0;
/// Upper left corners of the two panels, and their size.
const PANELS: [Place; 2] = [(64.0, 84.0), (552.0, 84.0)];
const PANEL: (f64, f64) = (424.0, 330.0);
/// Baseline of the first line of the legend, and the distance to the next.
const LEGEND: f64 = 476.0;
const LEGEND_LINE: f64 = 20.0;

fn color(method: Method) -> &'static str {
    match method {
        Method::Fixed(SamplerKind::Independent) => "#c0392b",
        Method::Fixed(SamplerKind::Stratified) => "#2471a3",
        Method::Fixed(SamplerKind::Sobol) => "#1e8449",
        Method::Adaptive => "#7d3c98",
    }
}

/// What a panel has on its horizontal axis.
struct Against {
    quantity: Quantity,
    label: &'static str,
    cost: fn(&Point) -> f64,
}

const AGAINST: [Against; 2] = [
    Against { quantity: Quantity::Seconds, label: "processor time of all threads", cost: Point::cpu_seconds },
    Against {
        quantity: Quantity::Samples,
        label: "samples a pixel (adaptive: all camera rays)",
        cost: |point| point.samples_a_pixel,
    },
];

/// Returns the name of the scene's file: the folder is no matter of the curve.
pub fn scene_name(options: &Options) -> Cow<'_, str> {
    options.input.file_name().unwrap_or_default().to_string_lossy()
}

/// Returns the figure of all curves. It holds their table, too, as metadata.
pub fn svg(options: &Options, convergence: &Convergence) -> String {
    let mut drawing = Drawing::new(WIDTH, HEIGHT);
    drawing.data(&csv(&convergence.points));
    let Options { width, height, .. } = options;
    let filter = if options.filter { ", -filter" } else { "" };
    let title = format!("{}, {width} x {height}{filter}", scene_name(options));
    drawing.words((WIDTH / 2.0, 22.0), "middle", " font-size=\"16\"", &title);
    for (line, y) in sentences(options, convergence).lines().zip([42.0, 58.0, 74.0]) {
        drawing.words((WIDTH / 2.0, y), "middle", "", line);
    }
    let curves = Curve::all(&convergence.points);
    if curves.is_empty() {
        return drawing.finish();
    }
    for (index, (corner, against)) in PANELS.into_iter().zip(&AGAINST).enumerate() {
        let panel = Panel::new(corner, &curves, against);
        panel.draw_axes(&mut drawing, against.label);
        let name = format!("panel{index}");
        drawing.clipped(&name, corner, PANEL, |drawing| panel.draw_curves(drawing, &curves, against.cost));
    }
    draw_legend(&mut drawing, &curves);
    drawing.finish()
}

/// A panel and its axes.
struct Panel {
    corner: Place,
    x: Axis,
    y: Axis,
}

impl Panel {
    fn new(corner: Place, curves: &[Curve], against: &Against) -> Self {
        let ((left, top), (width, height)) = (corner, PANEL);
        let points = || curves.iter().flat_map(|curve| &curve.points);
        let costs = points().map(|point| (against.cost)(point)).filter(|&cost| cost > 0.0);
        // Bands may be wider: the panel's edge cuts them.
        let errors = points().flat_map(|point| {
            let estimated = point.estimate.map(|estimate| estimate.levels.rmse);
            [point.error(), estimated].into_iter().flatten().filter(|&error| error > 0.0)
        });
        Self {
            corner,
            x: Axis::new(against.quantity, costs, left, left + width),
            y: Axis::new(Quantity::Levels, errors, top + height, top),
        }
    }

    fn draw_axes(&self, drawing: &mut Drawing, label: &str) {
        let ((left, top), (width, height)) = (self.corner, PANEL);
        let (right, bottom) = (left + width, top + height);
        let style = |label: &str| if label.is_empty() { "stroke=\"#f2f2f2\"" } else { "stroke=\"#dddddd\"" };
        for tick in self.x.ticks() {
            drawing.line((tick.place, top), (tick.place, bottom), style(&tick.label));
            drawing.words((tick.place, bottom + 16.0), "middle", "", &tick.label);
        }
        for tick in self.y.ticks() {
            drawing.line((left, tick.place), (right, tick.place), style(&tick.label));
            drawing.words((left - 6.0, tick.place + 4.0), "end", "", &tick.label);
        }
        drawing.rectangle(self.corner, PANEL, "fill=\"none\" stroke=\"#555555\"");
        drawing.words((left + width / 2.0, bottom + 36.0), "middle", "", label);
        let (x, y) = (left - 44.0, top + height / 2.0);
        let turned = format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"");
        drawing.words((x, y), "middle", &turned, "error (RMSE) in levels of 255");
    }

    fn draw_curves(&self, drawing: &mut Drawing, curves: &[Curve], cost: fn(&Point) -> f64) {
        let place = |point: &Point, error: f64| (self.x.place(cost(point)), self.y.place(error.max(1e-9)));
        self.draw_reference_line(drawing, curves, cost);
        for curve in curves {
            let estimated =
                curve.points.iter().filter_map(|&point| Some((point, point.estimate?.levels))).collect::<Vec<_>>();
            let lows = estimated.iter().map(|(point, levels)| place(point, levels.low));
            let highs = estimated.iter().rev().map(|(point, levels)| place(point, levels.high));
            let style = format!("fill=\"{}\" fill-opacity=\"0.15\" stroke=\"none\"", color(curve.method));
            drawing.path(&lows.chain(highs).collect::<Vec<_>>(), &style);
        }
        for curve in curves {
            let color = color(curve.method);
            let known = curve.points.iter().filter_map(|&point| Some(place(point, point.error()?)));
            let places: Vec<_> = known.collect();
            drawing.path(&places, &format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"1.6\""));
            places.iter().for_each(|&at| drawing.dot(at, &format!("fill=\"{color}\"")));
            let compared = curve.points.iter().filter(|point| point.true_error.is_some());
            let estimated = compared.filter_map(|&point| Some(place(point, point.estimate?.levels.rmse)));
            estimated.for_each(|at| drawing.dot(at, &format!("fill=\"white\" stroke=\"{color}\"")));
        }
    }

    /// Draws the slope of independent samples through the first point.
    fn draw_reference_line(&self, drawing: &mut Drawing, curves: &[Curve], cost: fn(&Point) -> f64) {
        let Some((x, error)) =
            curves.first().and_then(|curve| curve.points.first()).and_then(|p| Some((cost(p), p.error()?)))
        else {
            return;
        };
        let (from, to) = self.x.ends();
        let end = |value: f64| (self.x.place(value), self.y.place(error * (x / value).sqrt()));
        drawing.line(end(from), end(to), "stroke=\"#888888\" stroke-dasharray=\"6 4\"");
    }
}

/// Writes what the colours mean, and the slopes, in lines below the panels.
fn draw_legend(drawing: &mut Drawing, curves: &[Curve]) {
    let entry = |index: usize| {
        let (column, line) = ((index % 2) as f64, (index / 2) as f64);
        (PANELS[0].0 + column * (PANELS[1].0 - PANELS[0].0), LEGEND + line * LEGEND_LINE)
    };
    for (index, curve) in curves.iter().enumerate() {
        let ((x, y), color) = (entry(index), color(curve.method));
        drawing.line((x, y - 4.0), (x + 26.0, y - 4.0), &format!("stroke=\"{color}\" stroke-width=\"2.4\""));
        drawing.dot((x + 13.0, y - 4.0), &format!("fill=\"{color}\""));
        let slopes = AGAINST.each_ref().map(|against| match curve.slope(against.cost) {
            Some(slope) => format!("{:.2} ± {:.2}", slope.slope, slope.half_width).replace('-', "−"),
            None => "unknown".to_owned(),
        });
        let words = format!("{}: slope {} in time, {} in samples", curve.method.name(), slopes[0], slopes[1]);
        drawing.words((x + 34.0, y), "start", "", &words);
    }
    let (x, _) = entry(0);
    let y = LEGEND + LEGEND_LINE * (curves.len().div_ceil(2) as f64) + 4.0;
    drawing.line((x, y - 4.0), (x + 26.0, y - 4.0), "stroke=\"#888888\" stroke-dasharray=\"6 4\"");
    let is_compared = curves.iter().flat_map(|curve| &curve.points).any(|point| point.true_error.is_some());
    let meaning = if is_compared { "Dots: true error; rings: its estimate" } else { "Dots: estimated error" };
    let words = format!("slope −1/2. {meaning}; bands: its 95% interval. ± is half of a slope's 95% interval.");
    drawing.words((x + 34.0, y), "start", "", &words);
}
