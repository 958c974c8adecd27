//! [`ErrorSums`]: sums over pixels, of which an [`ErrorEstimate`] is made.

use super::error_estimate::{ErrorEstimate, Interval};
use super::halves_error::{HalvesError, clamped_variance};
use super::spread::{SetKind, Spread};
use super::unseen::{EXPECTED, Unseen};
use vecmath::Vector3;

/// Sums over pixels, from which the error is estimated.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorSums {
    pub pixels: u64,
    /// Of these, pixels that are known to be exact.
    exact: u64,
    /// The largest colour component of any sample, or of anything in the scene, if that is known. Unseen details count as
    /// no brighter.
    pub peak: f64,
    linear: Sums,
    levels: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Sums of the spread within pixels, averaged over the channels: fine and coarse.
    spread: [f64; 2],
    /// Sum of the variances of the difference between v and the true squared error.
    squares: f64,
}

impl Sums {
    /// Adds the fine and the coarse spread of a pixel, averaged over the channels.
    fn add(&mut self, [fine, coarse]: [f64; 2], relative_variance: f64) {
        self.spread = [self.spread[0] + fine, self.spread[1] + coarse];
        self.squares += relative_variance * fine * fine;
    }

    fn merge(&mut self, other: &Self) {
        self.spread = [self.spread[0] + other.spread[0], self.spread[1] + other.spread[1]];
        self.squares += other.squares;
    }

    /// Returns the coarse spread as a multiple of the fine one.
    fn ratio(&self) -> f64 {
        let [fine, coarse] = self.spread;
        if fine > 0.0 { coarse / fine } else { 1.0 }
    }

    /// Returns what the fine spread must be multiplied by to be the squared error.
    fn factor(&self, kind: SetKind) -> f64 {
        kind.factor(self.ratio())
    }

    fn mean_square(&self, kind: SetKind, pixels: f64) -> f64 {
        self.factor(kind) * self.spread[0] / pixels
    }

    fn interval(&self, kind: SetKind, pixels: f64, [white, bright]: [f64; 2]) -> Interval {
        /// Number of standard deviations within which 95% of a normal distribution lie.
        const TWO_SIDED: f64 = 1.959_964;
        let mean_square = self.mean_square(kind, pixels);
        let relative = if self.spread[0] > 0.0 { self.squares / self.spread[0].powi(2) } else { 0.0 };
        // The logarithm of a ratio of two sums of n squares has the variance 4/n (1 + 1/n).
        let variance = relative * (1.0 + relative / 4.0);
        let factor = |deviation: f64| (TWO_SIDED * (variance + deviation * deviation).sqrt()).exp();
        let [below, above] = kind.factor_deviations().map(factor);
        let least = kind.least_factor(self.ratio()) * self.spread[0] / pixels;
        Interval {
            rmse: mean_square.max(EXPECTED * white).sqrt(),
            low: (least / below).sqrt(),
            high: (mean_square * above + bright).sqrt(),
        }
    }
}

impl ErrorSums {
    /// Adds a pixel with this mean of all samples, and the spread of `sets` means. Returns its squared error in squared
    /// levels by the coarse spread, up to [`coarse_factor`](Self::coarse_factor): of one pixel it says more than the fine
    /// one, because more groups are compared.
    pub fn add(&mut self, kind: SetKind, mean: Vector3, spread: &Spread, sets: u32) -> f64 {
        let mean = mean.to_array().map(|c| c as f64);
        let shown = Spread { fine: clamped(mean, spread.fine), coarse: clamped(mean, spread.coarse) };
        self.add_means(kind.relative_variance(sets), spread.means(), shown.means())
    }

    /// Adds pixels of two halves each.
    pub fn add_halves<'a>(&mut self, errors: impl IntoIterator<Item = &'a HalvesError>) {
        let relative_variance = SetKind::Independent.relative_variance(2);
        // Sums in registers, because there are many pixels.
        let Self { mut pixels, mut linear, mut levels, .. } = *self;
        for error in errors {
            pixels += 1;
            linear.add([error.squared_linear(); 2], relative_variance);
            levels.add([f64::from(error.squared_levels) / (255.0 * 255.0); 2], relative_variance);
        }
        *self = Self { pixels, linear, levels, ..*self };
    }

    /// Adds the fine and the coarse spread of a pixel, averaged over the channels. Returns the coarse one in squared
    /// levels.
    fn add_means(&mut self, relative_variance: f64, linear: [f64; 2], levels: [f64; 2]) -> f64 {
        self.pixels += 1;
        self.linear.add(linear, relative_variance);
        self.levels.add(levels, relative_variance);
        255.0 * 255.0 * levels[1]
    }

    /// Adds pixels that are known to be exact.
    pub fn add_exact(&mut self, pixels: u64) {
        self.pixels += pixels;
        self.exact += pixels;
    }

    /// Forgets all pixels, but not how bright samples were.
    pub fn clear(&mut self) {
        *self = Self { peak: self.peak, ..Self::default() };
    }

    /// Notes how bright anything can be, if that is known.
    pub fn see_brightest(&mut self, brightest: Option<f64>) {
        self.peak = self.peak.max(brightest.unwrap_or(0.0));
    }

    /// Notes the brightness of a sample.
    pub fn see(&mut self, color: Vector3) {
        self.peak = self.peak.max(color.x as f64).max(color.y as f64).max(color.z as f64);
    }

    /// Adds parts up in their order, because rounding depends on the order.
    pub fn total(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut total = Self::default();
        parts.into_iter().for_each(|part| total.merge(&part));
        total
    }

    fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.exact += other.exact;
        self.peak = self.peak.max(other.peak);
        self.linear.merge(&other.linear);
        self.levels.merge(&other.levels);
    }

    /// Returns the estimate if every pixel has at least so many samples; `None` without pixels.
    pub fn estimate(&self, kind: SetKind, samples: u32) -> Option<ErrorEstimate> {
        let pixels = self.pixels as f64;
        let unseen = Unseen { samples, pixels: self.pixels };
        let brightest = self.peak.max(1.0);
        let is_exact = self.exact == self.pixels;
        let [white, bright, linear] =
            [unseen.mean_square(1.0), unseen.mean_square(brightest), unseen.linear_mean_square(brightest)]
                .map(|mean_square| if is_exact { 0.0 } else { mean_square });
        (self.pixels > 0).then(|| {
            let levels = self.levels.interval(kind, pixels, [white, bright]);
            // No error of a shown colour is above white.
            let scaled = |share: f64| 255.0 * share.min(1.0);
            ErrorEstimate {
                linear: self.linear.interval(kind, pixels, [white, linear]),
                levels: Interval { rmse: scaled(levels.rmse), low: scaled(levels.low), high: scaled(levels.high) },
                seen: scaled(self.levels.mean_square(kind, pixels).sqrt()),
                unseen: scaled(white.sqrt()),
            }
        })
    }

    /// Returns what the coarse spread of a pixel must be multiplied by to be its squared error.
    pub fn coarse_factor(&self, kind: SetKind) -> f64 {
        let [fine, coarse] = self.levels.spread;
        if coarse > 0.0 { self.levels.factor(kind) * fine / coarse } else { 1.0 }
    }
}

/// Returns the variances that remain after colours with this mean are clamped to \[0, 1\].
#[inline]
fn clamped(mean: [f64; 3], mut variances: [f64; 3]) -> [f64; 3] {
    for (variance, mean) in variances.iter_mut().zip(mean) {
        *variance = clamped_variance(mean, *variance);
    }
    variances
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared([a, b]: [Vector3; 2]) -> HalvesError {
        HalvesError::new(a, b, 1.0)
    }

    fn halves() -> [Vector3; 2] {
        [Vector3::new(0.2, 0.4, 0.6), Vector3::new(0.4, 0.4, 0.5)]
    }

    #[test]
    fn the_error_of_halves_is_half_their_difference() {
        let mut sums = ErrorSums::default();
        sums.add_halves(&[compared(halves()); 100]);
        let expected = ((0.1f64.powi(2) + 0.05f64.powi(2)) / 3.0).sqrt();
        let estimate = sums.estimate(SetKind::Independent, 2).unwrap();
        assert!((estimate.linear.rmse - expected).abs() < 1e-6);
        assert!((estimate.levels.rmse - 255.0 * expected).abs() < 1e-4);
        assert!(estimate.levels.low < estimate.levels.rmse && estimate.levels.rmse < estimate.levels.high);
    }

    #[test]
    fn samples_that_agree_prove_no_error_of_zero() {
        let mut sums = ErrorSums::default();
        sums.add_halves(&[compared([Vector3::splat(0.5); 2]); 900]);
        let levels = |sums: &ErrorSums, samples| sums.estimate(SetKind::Independent, samples).unwrap().levels;
        // 3 * 255^2 / (2^2 * 900), and a sixth of it.
        let two = levels(&sums, 2);
        assert!((two.high.powi(2) - 54.1875).abs() < 1e-9, "{two:?}");
        assert!((two.rmse.powi(2) - 54.1875 / 6.0).abs() < 1e-9);
        assert_eq!(two.low, 0.0);
        assert!((levels(&sums, 20).high - two.high / 10.0).abs() < 1e-9);
        // A bright detail changes more, until the pixel is white.
        sums.see(Vector3::new(0.1, 50.0, 0.2));
        assert!((levels(&sums, 2).high.powi(2) - 25.0 * 4.0 * 54.1875).abs() < 1e-6);
    }

    #[test]
    fn unseen_details_are_as_bright_as_anything_can_be() {
        let mut sums = ErrorSums::default();
        sums.add_halves(&[compared([Vector3::splat(50.0); 2]); 900]);
        sums.see(Vector3::splat(50.0));
        // Not less than what was seen. Of levels the sum is at most 1: 3 / 900 times 300.
        for (brightest, levels, linear) in [
            (None, 25.0, 25.0 * 25.0),
            (Some(10.0), 25.0, 25.0 * 25.0),
            (Some(80.0), 40.0, 40.0 * 40.0),
            (Some(1e6), 300.0, 2.5e11),
            (Some(f64::INFINITY), 300.0, f64::INFINITY),
        ] {
            sums.see_brightest(brightest);
            let estimate = sums.estimate(SetKind::Independent, 2).unwrap();
            for (high, square) in [(estimate.levels.high / 255.0, levels), (estimate.linear.high, linear)] {
                let expected = (3.0 / 900.0 * square).sqrt();
                assert!(high == expected || (high / expected - 1.0).abs() < 1e-12, "{high}, not {expected}");
            }
        }
    }

    #[test]
    fn pixels_that_are_known_have_no_error() {
        let mut sums = ErrorSums::default();
        sums.add_exact(75);
        assert_eq!(sums.estimate(SetKind::Independent, 2).unwrap(), ErrorEstimate::default());
        let mut mixed = ErrorSums::default();
        mixed.add_halves(&[compared(halves()); 25]);
        let alone = mixed.estimate(SetKind::Independent, 2).unwrap();
        mixed.merge(&sums);
        let mixed = mixed.estimate(SetKind::Independent, 2).unwrap();
        assert!((mixed.seen - alone.seen / 2.0).abs() < 1e-12);
        // 3 details may hide in a quarter of the pixels as well as in all.
        assert!((mixed.unseen - alone.unseen / 2.0).abs() < 1e-12);
    }

    #[test]
    fn pixels_that_were_not_reached_may_be_black_or_white() {
        let mut sums = ErrorSums::default();
        sums.add_halves(&[compared(halves()); 100]);
        let reached = sums.estimate(SetKind::Independent, 2).unwrap();
        let whole = reached.with_rest(0.75, 20.0);
        assert!((whole.levels.rmse.powi(2) - (0.75 * reached.levels.rmse.powi(2) + 100.0)).abs() < 1e-9);
        assert!(whole.levels.low < reached.levels.low && whole.levels.high > 127.5 && whole.unseen > 127.5);
        assert!(whole.linear.high.is_infinite());
    }

    #[test]
    fn no_pixels_no_estimate() {
        assert_eq!(ErrorSums::default().estimate(SetKind::Independent, 2), None);
    }
}
