//! A [`Report`] as JSON and as a table.

use super::reference::{RELATIVE_EPSILON, TrueError};
use super::report::{Report, peak_memory};
use crate::render::error_estimate::{ErrorEstimate, Interval};
use crate::timing::Times;
use serde_json::{Value, json};
use std::fmt::Write as _;

impl Report<'_> {
    /// Million rays of all kinds a second of rendering.
    fn million_rays_a_second(&self) -> f64 {
        let seconds = (self.phases.render.wall + self.phases.filter.wall).as_secs_f64();
        if seconds > 0.0 { self.counts.total() as f64 / seconds / 1e6 } else { 0.0 }
    }

    /// The report as JSON. What is not known is null; so is what is infinite.
    pub fn json(&self) -> String {
        let args = self.args;
        let measure = &args.measure;
        let phases = self.phases.named().map(|(name, times)| (name.to_owned(), times_json(times)));
        let value = json!({
            "a2": env!("CARGO_PKG_VERSION"),
            "scene": args.input.display().to_string(),
            "width": args.width,
            "height": args.height,
            "threads": self.threads,
            "seed": args.seed,
            "phases": Value::Object(phases.into_iter().collect()),
            "total": times_json(self.total),
            "rays": {
                "camera": self.counts.camera,
                "shadow": self.counts.shadow,
                "mirror": self.counts.mirror,
                "total": self.counts.total(),
                "shadow_left_out": self.counts.shadow_left_out,
                "million_per_second": self.million_rays_a_second(),
            },
            "peak_memory_bytes": peak_memory(),
            "cube_map_faces_decoded": self.decoded_faces,
            "left_out": self.left_out,
            "samples": {
                "sampler": args.jitter.then(|| measure.sampler.name()),
                "per_pixel_least": self.sampling.least,
                "per_pixel_mean": self.sampling.mean(),
                "per_pixel_most": self.sampling.most,
                "passes": self.sampling.passes,
                "target_error_levels": measure.target_error,
                "target_error_reached": measure.target_error.map(|target| self.is_below(target)),
                "time_limit_seconds": measure.time_limit,
            },
            "estimated_error": self.estimate.as_ref().map(estimate_json),
            "true_error": self.true_error.as_ref().map(true_error_json),
        });
        // Maps with text keys, numbers and texts: nothing that cannot be written.
        format!("{value:#}\n")
    }

    /// Whether the estimated error is at most `levels`.
    pub fn is_below(&self, levels: f64) -> bool {
        self.sampling.least > Some(0) && self.estimate.is_some_and(|estimate| estimate.levels.rmse <= levels)
    }

    /// The report as a table for a person.
    pub fn table(&self) -> String {
        let mut text = String::from("phase        wall s     cpu s\n");
        for (name, times) in self.phases.named().into_iter().chain([("total", self.total)]) {
            let _ =
                writeln!(text, "{name:<8} {:>10.4} {:>9.4}", times.wall.as_secs_f64(), times.cpu.as_secs_f64());
        }
        let counts = &self.counts;
        let _ = writeln!(
            text,
            "rays         {} camera, {} shadow ({} more left out), {} mirror; {:.2} million a second",
            counts.camera,
            counts.shadow,
            counts.shadow_left_out,
            counts.mirror,
            self.million_rays_a_second()
        );
        if let Some(bytes) = peak_memory() {
            let _ = writeln!(text, "peak memory  {:.1} MB", bytes as f64 / 1e6);
        }
        for reason in self.left_out {
            let _ = writeln!(text, "left out     {reason}");
        }
        let sampling = &self.sampling;
        let (least, most) = (sampling.least.unwrap_or(0), sampling.most);
        let sampler = if self.args.jitter { self.args.measure.sampler.name() } else { "not random" };
        let _ = writeln!(text, "samples      {sampler}, {:.2} a pixel ({least} to {most})", sampling.mean());
        text += &self.verdict();
        if let Some(error) = &self.true_error {
            let _ = write!(text, "{error}");
        }
        text
    }

    /// The estimated error in a line.
    pub fn verdict(&self) -> String {
        let mut text = match &self.estimate {
            Some(ErrorEstimate { levels, linear }) => format!(
                "estimated    RMSE {:.4} levels, 95% between {:.4} and {:.4} (linear {:.3e})\n",
                levels.rmse, levels.low, levels.high, linear.rmse
            ),
            None if self.args.color.is_none() => "estimated    no error: no colours are asked for\n".to_owned(),
            None if self.args.jitter => "estimated    no error: too few samples to tell\n".to_owned(),
            None => "estimated    no error: nothing is random (give -jitter or -samples)\n".to_owned(),
        };
        if self.sampling.least == Some(0) {
            text += "             some pixels were not reached in time: they show their surroundings and are not \
                     part of the estimate\n";
        }
        text
    }
}

fn times_json(times: Times) -> Value {
    json!({ "wall_seconds": times.wall.as_secs_f64(), "cpu_seconds": times.cpu.as_secs_f64() })
}

fn interval_json(interval: &Interval) -> Value {
    json!({ "rmse": interval.rmse, "low_95": interval.low, "high_95": interval.high })
}

fn estimate_json(estimate: &ErrorEstimate) -> Value {
    json!({ "levels": interval_json(&estimate.levels), "linear": interval_json(&estimate.linear) })
}

fn true_error_json(error: &TrueError) -> Value {
    json!({
        "rmse_levels": error.rmse_levels,
        "rmse_linear": error.rmse_linear,
        "relative_mse": error.relative_mse,
        "relative_mse_epsilon": RELATIVE_EPSILON,
        "psnr_db": error.psnr(),
        "worst_levels": error.worst_levels,
        "worst_pixel": error.worst_pixel,
        "share_over_1_level": error.share_over_one_level,
        "ssim": error.ssim,
    })
}
