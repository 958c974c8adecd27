//! [`Axis`]: a logarithmic axis of a figure, and where its ticks are.

use super::words::{short, time};

/// What an axis shows, which decides its ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Levels,
    Seconds,
    /// Numbers of samples, with ticks at powers of two.
    Samples,
}

/// Maps values to places between `start` and `end`, in pixels.
pub struct Axis {
    quantity: Quantity,
    /// Logarithms to the base of ten.
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

/// A value with a grid line; its label is empty where there is no room for one.
pub struct Tick {
    pub place: f64,
    pub label: String,
}

impl Axis {
    /// Makes an axis for values above 0, of which there must be one.
    pub fn new(quantity: Quantity, values: impl Iterator<Item = f64>, start: f64, end: f64) -> Self {
        /// So many decades at least, which hold two of the numbers 1, 2 and 5.
        const LEAST: f64 = 0.75;
        /// Share of the axis on either side of the values.
        const MARGIN: f64 = 0.06;
        let (low, high) = values
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let half = ((high - low) / 2.0 * (1.0 + 2.0 * MARGIN)).max(LEAST / 2.0);
        let middle = f64::midpoint(low, high);
        Self { quantity, low: middle - half, high: middle + half, start, end }
    }

    pub fn place(&self, value: f64) -> f64 {
        self.start + (value.log10() - self.low) / (self.high - self.low) * (self.end - self.start)
    }

    /// Returns the ends of the axis, as values.
    pub fn ends(&self) -> (f64, f64) {
        (10_f64.powf(self.low), 10_f64.powf(self.high))
    }

    /// Returns the values with a grid line.
    pub fn ticks(&self) -> Vec<Tick> {
        let (low, high) = self.ends();
        let decades = self.high - self.low;
        let ticks: Vec<(f64, bool)> = match self.quantity {
            Quantity::Samples => {
                let every = (decades * 10_f64.log2() / 8.0).ceil() as i32;
                let powers = low.log2().ceil() as i32..=high.log2().floor() as i32;
                powers.map(|power| (2_f64.powi(power), power % every == 0)).collect()
            }
            Quantity::Levels | Quantity::Seconds => {
                let labelled: &[i32] = if decades < 2.5 { &[1, 2, 5] } else { &[1] };
                let every = (decades / 6.0).ceil() as i32;
                let all = (self.low.floor() as i32..=self.high.ceil() as i32)
                    .flat_map(|decade| (1..10).map(move |digit| (digit, decade)));
                let values = all.map(|(digit, decade)| {
                    (f64::from(digit) * 10_f64.powi(decade), decade % every == 0 && labelled.contains(&digit))
                });
                values.filter(|(value, _)| (low..=high).contains(value)).collect()
            }
        };
        let label = |value: f64| if self.quantity == Quantity::Seconds { time(value) } else { short(value) };
        let tick = |(value, is_labelled)| Tick {
            place: self.place(value),
            label: if is_labelled { label(value) } else { String::new() },
        };
        ticks.into_iter().map(tick).collect()
    }
}
