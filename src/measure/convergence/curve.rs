//! [`Curve`]: the points of one method, and what lies between them and beyond.

use super::{Method, Point};
use crate::options::SamplerKind;

/// The points of one method whose error is known and not 0, in the order of their cost.
pub struct Curve<'a> {
    pub method: Method,
    pub points: Vec<&'a Point>,
}

/// What an error costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    pub cpu_seconds: f64,
    /// A pixel.
    pub samples: f64,
    /// Whether the curve ends before this error, and its slope was followed.
    pub is_extrapolated: bool,
}

/// A slope on logarithmic axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    pub slope: f64,
    /// Of the 95% confidence interval.
    pub half_width: f64,
}

impl<'a> Curve<'a> {
    /// Returns the curves of all methods that have points, in the order of the points.
    pub fn all(points: &'a [Point]) -> Vec<Self> {
        let mut curves: Vec<Self> = Vec::new();
        for point in points.iter().filter(|point| point.error() > Some(0.0)) {
            match curves.last_mut() {
                Some(curve) if curve.method == point.method => curve.points.push(point),
                _ => curves.push(Self { method: point.method, points: vec![point] }),
            }
        }
        curves
    }

    /// Fits the slope of the error against a cost.
    pub fn slope(&self, cost: impl Fn(&Point) -> f64) -> Option<Slope> {
        let logarithms = self.points.iter().map(|point| (cost(point).log2(), point.error().unwrap_or(0.0).log2()));
        fitted_slope(&logarithms.filter(|(x, y)| x.is_finite() && y.is_finite()).collect::<Vec<_>>())
    }

    /// Returns what an error costs: on the straight line between its neighbours on logarithmic axes, or, if all points
    /// have larger errors, on a line through the last one. `None` if all have smaller errors, or if they do not fall.
    pub fn cost(&self, error: f64) -> Option<Cost> {
        let errors: Vec<f64> = self.points.iter().map(|point| point.error().unwrap_or(0.0)).collect();
        let (costs, rays): (Vec<f64>, Vec<f64>) =
            self.points.iter().map(|point| (point.cpu_seconds(), point.samples_a_pixel)).unzip();
        let after = errors.iter().position(|&other| other <= error);
        match after {
            Some(0) if errors[0] < error => None,
            Some(0) => Some(Cost { cpu_seconds: costs[0], samples: rays[0], is_extrapolated: false }),
            Some(i) => {
                let share = (error / errors[i - 1]).log2() / (errors[i] / errors[i - 1]).log2();
                let between = |of: &[f64]| of[i - 1] * (of[i] / of[i - 1]).powf(share);
                Some(Cost { cpu_seconds: between(&costs), samples: between(&rays), is_extrapolated: false })
            }
            None => {
                let last = self.points.last()?;
                let further = |cost: fn(&Point) -> f64| {
                    let slope = self.cautious_slope(cost)?;
                    Some(cost(last) * (error / last.error()?).powf(1.0 / slope))
                };
                let (cpu_seconds, samples) =
                    (further(Point::cpu_seconds)?, further(|point| point.samples_a_pixel)?);
                Some(Cost { cpu_seconds, samples, is_extrapolated: true })
            }
        }
    }

    /// Returns the slope beyond the last point: the fitted one, but none that is steeper than theory promises. The
    /// first points of adaptive sampling fall much faster than what follows.
    fn cautious_slope(&self, cost: fn(&Point) -> f64) -> Option<f64> {
        let order = match self.method {
            Method::Fixed(sampler) => sampler.convergence_order(),
            Method::Adaptive => SamplerKind::Sobol.convergence_order(),
        };
        let slope = self.slope(cost).map_or(-order / 2.0, |fitted| fitted.slope.max(-order / 2.0));
        (slope < 0.0).then_some(slope)
    }
}

/// Fits a line by least squares. Returns its slope if there are three points that are not all at one place.
fn fitted_slope(points: &[(f64, f64)]) -> Option<Slope> {
    /// Two-sided 95% points of Student's t distribution, by degrees of freedom.
    const STUDENT: [f64; 8] = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31];
    if points.len() < 3 {
        return None;
    }
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x_mean, y_mean) = (mean(|point| point.0), mean(|point| point.1));
    let spread: f64 = points.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
    let slope = points.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).sum::<f64>() / spread;
    let residual: f64 = points.iter().map(|(x, y)| (y - y_mean - slope * (x - x_mean)).powi(2)).sum();
    let student = STUDENT[(points.len() - 3).min(STUDENT.len() - 1)];
    let half_width = student * (residual / (count - 2.0) / spread).sqrt();
    (spread > 0.0).then_some(Slope { slope, half_width })
}
