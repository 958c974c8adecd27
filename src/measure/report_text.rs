//! A [`Report`] as JSON, as a table, and as a line.

use super::reference::{RELATIVE_EPSILON, TrueError};
use super::report::{Report, peak_memory};
use crate::cost::Cost;
use crate::options::{Options, Region};
use crate::render::PREVIEW_MIRRORS;
use crate::render::error_estimate::{ErrorEstimate, Interval};
use crate::scene::MeshFile;
use crate::timing::Times;
use serde_json::{Value, json};
use std::fmt::Write as _;

impl Report {
    /// Returns the report as JSON. Unknown and infinite values are null.
    pub fn json(&self, options: &Options) -> String {
        let measure = &options.measure;
        let (counts, samples) = (&self.frame.counts, &self.frame.samples);
        let phases = self.phases.named().map(|(name, times)| (name.to_owned(), times_json(times)));
        let value = json!({
            "a2": env!("CARGO_PKG_VERSION"),
            "scene": options.input.display().to_string(),
            "width": options.width,
            "height": options.height,
            "region": region_json(options.shown()),
            "threads": self.threads,
            "seed": options.seed,
            "phases": Value::Object(phases.into_iter().collect()),
            "total": times_json(self.total),
            "rays": {
                "camera": counts.camera,
                "shadow": counts.shadow,
                "mirror": counts.mirror,
                "total": counts.total(),
                "shadow_left_out": counts.shadow_left_out,
                "million_per_second": self.million_rays_a_second(),
            },
            "peak_memory_bytes": peak_memory(),
            "cube_map_faces_decoded": self.decoded_faces,
            "meshes": self.mesh_files.iter().map(mesh_json).collect::<Vec<_>>(),
            "left_out": self.left_out,
            "samples": {
                "sampler": options.jitter.then(|| measure.sampler.name()),
                "per_pixel_least": samples.least,
                "per_pixel_mean": samples.mean(),
                "per_pixel_most": samples.most,
                "passes": samples.passes,
                "share_of_pixels_reached": samples.reached(),
                "target_error_levels": measure.target_error,
                "target_error_reached": measure.target_error.map(|target| self.is_below(target)),
                "time_limit_seconds": measure.time_limit,
            },
            "depth_range": self.depth_range,
            "cost": self.cost.as_ref().map(cost_json),
            "pixels": self.pixels.iter().map(|pixel| pixel.json(options)).collect::<Vec<_>>(),
            "estimated_error": self.frame.estimate.as_ref().map(estimate_json),
            "true_error": self.true_error.as_ref().map(true_error_json),
        });
        // Writing cannot fail, because the value has only maps with text keys, numbers and texts.
        format!("{value:#}\n")
    }

    /// Returns the report as a table for the user.
    pub fn table(&self, options: &Options) -> String {
        let mut text = String::from("phase        wall s     cpu s\n");
        for (name, times) in self.phases.named().into_iter().chain([("total", self.total)]) {
            let (wall, cpu) = (times.wall.as_secs_f64(), times.cpu.as_secs_f64());
            let _ = writeln!(text, "{name:<8} {wall:>10.4} {cpu:>9.4}");
        }
        let counts = &self.frame.counts;
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
        for file in &self.mesh_files {
            let _ = writeln!(text, "mesh         {file}");
        }
        for reason in &self.left_out {
            let _ = writeln!(text, "left out     {reason}");
        }
        text += &self.cost.as_ref().map(cost_lines).unwrap_or_default();
        let samples = &self.frame.samples;
        let (least, most) = (samples.least.unwrap_or(0), samples.most);
        let sampler = if options.jitter { options.measure.sampler.name() } else { "not random" };
        let mean = samples.mean();
        let _ = match (least, most) {
            (1, 2..) => writeln!(
                text,
                "samples      {sampler}, {mean:.2} a pixel in the mean (up to {most}; 1 where only background is seen)"
            ),
            _ => writeln!(text, "samples      {sampler}, {mean:.2} a pixel ({least} to {most})"),
        };
        text += &self.verdict(options);
        if let Some(error) = &self.true_error {
            let _ = write!(text, "{error}");
        }
        text
    }

    /// Returns the estimated error in a line.
    pub fn verdict(&self, options: &Options) -> String {
        let mut text = match &self.frame.estimate {
            Some(ErrorEstimate { levels, linear, unseen, .. }) => format!(
                "estimated    RMSE {:.4} levels, 95% between {:.4} and {:.4} (linear {:.3e});\n             \
                 details that no sample met: below {unseen:.4} with 95%\n",
                levels.rmse, levels.low, levels.high, linear.rmse
            ),
            None if !options.renders_colors() => "estimated    no error: no colours are asked for\n".to_owned(),
            None if options.jitter => "estimated    no error: too few samples to tell\n".to_owned(),
            None => "estimated    no error: nothing is random (give -jitter or -samples)\n".to_owned(),
        };
        let samples = &self.frame.samples;
        if samples.unreached > 0 {
            let percent = 100.0 * (1.0 - samples.reached());
            let _ = writeln!(
                text,
                "warning: {percent:.1}% of the pixels were not reached in time: they show a coarse preview of at most \
                 {PREVIEW_MIRRORS} mirrors in a row, and count in the estimate as black or white in the worst case"
            );
        }
        text
    }
}

fn mesh_json(file: &MeshFile) -> Value {
    let counts = &file.counts;
    json!({
        "file": file.path.display().to_string(),
        "vertices": counts.vertices,
        "faces": counts.faces,
        "triangles": counts.triangles,
        "degenerate_faces_left_out": counts.degenerate,
        "polygons_cut": counts.polygons,
        "concave_polygons": counts.concave,
        "points_left_out": counts.points,
        "lines_left_out": counts.lines,
    })
}

/// Returns the lines of the table about `-cost`.
fn cost_lines(cost: &Cost) -> String {
    let [rays, boxes, triangles] = cost.mean_and_most();
    let exact = cost.tests.exact_triangles as f64 / cost.pixels.len() as f64;
    let mut text = format!(
        "cost         a pixel takes {:.2} rays (at most {}), {:.2} boxes ({}), {:.2} triangles ({}), {exact:.2} of them exactly\n",
        rays.0, rays.1, boxes.0, boxes.1, triangles.0, triangles.1
    );
    for (kind, counts) in &cost.tests.objects {
        let _ = writeln!(text, "             {kind}: {} tests, {} hits", counts.tested, counts.hit);
    }
    text
}

fn cost_json(cost: &Cost) -> Value {
    let [rays, boxes, triangles] = cost.mean_and_most().map(|(mean, most)| json!({ "mean": mean, "most": most }));
    let tests = &cost.tests;
    let objects = tests
        .objects
        .iter()
        .map(|(&kind, counts)| (kind.to_owned(), json!({ "tests": counts.tested, "hits": counts.hit })));
    json!({
        "rays": cost.rays.total(),
        "boxes": tests.boxes,
        "triangles": tests.triangles,
        "exact_triangles": tests.exact_triangles,
        "objects": Value::Object(objects.collect()),
        "a_pixel": { "rays": rays, "boxes": boxes, "triangles": triangles },
    })
}

fn region_json(region: Region) -> Value {
    json!({ "x": region.x, "y": region.row, "width": region.width, "height": region.height })
}

fn times_json(times: Times) -> Value {
    json!({ "wall_seconds": times.wall.as_secs_f64(), "cpu_seconds": times.cpu.as_secs_f64() })
}

fn interval_json(interval: &Interval) -> Value {
    json!({ "rmse": interval.rmse, "low_95": interval.low, "high_95": interval.high })
}

fn estimate_json(estimate: &ErrorEstimate) -> Value {
    json!({
        "levels": interval_json(&estimate.levels),
        "linear": interval_json(&estimate.linear),
        "unseen_levels_95": estimate.unseen,
    })
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
