//! [`Options`]: what the user wants, as plain data that every module may read.
//!
//! [`args`](crate::args) makes them of a command line. Nothing here does anything.

use crate::input::is_standard;
use crate::simd::InstructionSet;
use std::path::{Path, PathBuf};
use vecmath::Vector3;

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 65_536;
pub const MAX_BOUNCES: u32 = 100_000;
pub const MAX_THREADS: usize = 1024;
/// Samples with `-jitter` and without `-samples`: the course's number.
pub const DEFAULT_SAMPLES: u32 = 16;
/// Largest number of samples: all samples of a pixel are in memory at the same time.
pub const MAX_SAMPLES: u32 = 1 << 16;

/// How a scene is to be rendered, and into which files.
#[derive(Clone, Debug)]
pub struct Options {
    pub input: PathBuf,
    /// Colour picture.
    pub color: Option<PathBuf>,
    pub depth: Option<DepthPicture>,
    pub normals: Option<PathBuf>,
    /// Pixels.
    pub width: u32,
    pub height: u32,
    /// Only this part of the picture is rendered.
    pub region: Option<Region>,
    /// Leave alone what the same run has finished before.
    pub skip_done: bool,
    /// Depth of mirror recursion.
    pub bounces: u32,
    /// Whether it was typed.
    pub bounces_are_given: bool,
    pub shadows: bool,
    pub jitter: bool,
    pub filter: bool,
    /// Where shadow and mirror rays start.
    pub epsilon: Epsilon,
    /// Do without the starter's shortcuts where they give wrong pictures.
    pub robust: bool,
    /// Render one ray at a time, by the plain definition.
    pub plain: bool,
    /// Number of threads; `None`: one for each processor.
    pub threads: Option<usize>,
    pub seed: u64,
    pub quiet: bool,
    /// Bytes.
    pub max_memory: Option<u64>,
    /// The instruction set that rays are computed with.
    pub simd: InstructionSet,
    /// Print the plan.
    pub explain: bool,
    /// Places whose ray trees are shown.
    pub pixels: Vec<PixelPlace>,
    /// Picture of what each pixel costs.
    pub cost: Option<PathBuf>,
    /// Read everything and render nothing.
    pub check: bool,
    pub measure: MeasureOptions,
}

impl Options {
    /// Returns the pictures to write.
    pub fn pictures(&self) -> impl Iterator<Item = &Path> + Clone {
        let depth = self.depth.as_ref().map(|depth| depth.path.as_path());
        [self.color.as_deref(), self.normals.as_deref(), depth].into_iter().flatten()
    }

    /// Returns all files to write.
    pub fn files(&self) -> impl Iterator<Item = &Path> + Clone {
        self.files_by_flag().map(|file| file.1)
    }

    /// Returns all files to write, each with its flag.
    pub fn files_by_flag(&self) -> impl Iterator<Item = (&'static str, &Path)> + Clone {
        let MeasureOptions { error_map, report, convergence, .. } = &self.measure;
        let depth = self.depth.as_ref().map(|depth| &depth.path);
        let files = [
            ("output", self.color.as_ref()),
            ("normals", self.normals.as_ref()),
            ("depth", depth),
            ("cost", self.cost.as_ref()),
            ("error-map", error_map.as_ref()),
            ("report", report.as_ref()),
            ("convergence", convergence.as_ref()),
        ];
        files.into_iter().filter_map(|(flag, path)| Some((flag, path?.as_path())))
    }

    /// Returns whether colours are computed: for a picture, or to show how a pixel gets its colour and what it costs. What
    /// they need is what -check reads.
    pub fn wants_colors(&self) -> bool {
        self.color.is_some() || self.check || self.cost.is_some() || !self.pixels.is_empty()
    }

    /// Returns the number of samples for each pixel of the traced grid.
    pub fn samples(&self) -> u32 {
        if self.jitter { self.measure.samples.unwrap_or(DEFAULT_SAMPLES) } else { 1 }
    }

    /// Returns the number of pixels of the traced grid for each pixel of the picture.
    pub fn grid_pixels(&self) -> u32 {
        if self.filter { 9 } else { 1 }
    }

    /// Returns the part of the picture that is rendered.
    pub fn shown(&self) -> Region {
        self.region.unwrap_or(Region::whole(self.width, self.height))
    }

    /// Returns the number of pixels that are rendered.
    pub fn pixel_count(&self) -> u64 {
        let shown = self.shown();
        u64::from(shown.width) * u64::from(shown.height)
    }

    /// Returns whether files are labelled, so that they can be joined, or be recognised.
    pub fn wants_labels(&self) -> bool {
        self.region.is_some() || self.skip_done
    }

    /// Returns whether the whole picture stays in memory until it is written: where pixels are rendered again, or are
    /// compared with others. Otherwise it is written while it is rendered.
    pub fn keeps_film(&self) -> bool {
        let measure = &self.measure;
        let is_compared = measure.reference.is_some() || measure.wants_error_map() || measure.keep_linear;
        let has_background = self.depth.as_ref().is_some_and(|depth| depth.background.is_some());
        is_compared || measure.is_adaptive() || measure.convergence.is_some() || has_background
    }

    /// Returns whether the colour picture's file holds numbers instead of bytes.
    pub fn color_is_numbers(&self) -> bool {
        self.color.as_ref().is_some_and(|path| !has_extension(path, "png") && !is_standard(path))
    }

    /// Returns whether the colour picture's file is an EXR.
    pub fn color_is_exr(&self) -> bool {
        self.color.as_ref().is_some_and(|path| has_extension(path, "exr"))
    }

    /// Returns whether colours are kept as numbers, for a file or for a comparison.
    pub fn keeps_linear(&self) -> bool {
        let wanted = self.color_is_numbers() || self.measure.reference.is_some() || self.measure.keep_linear;
        wanted && self.color.is_some()
    }
}

/// `-pixel X Y`: a place in the picture, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelPlace {
    pub x: f64,
    pub y: f64,
}

impl PixelPlace {
    /// Returns column and row of the pixel.
    pub fn pixel(&self) -> (u32, u32) {
        (self.x as u32, self.y as u32)
    }
}

/// A rectangle of a picture in pixels, from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub x: u32,
    pub row: u32,
    pub width: u32,
    pub height: u32,
}

impl Region {
    pub fn whole(width: u32, height: u32) -> Self {
        Self { x: 0, row: 0, width, height }
    }

    /// Returns part `index` of `count` of a picture of this size, from 0: some rows, or, if there are more parts than rows,
    /// a piece of a row. Parts differ by one row at most, and pieces are at most twice as long as others, and a pixel. There
    /// must be a pixel for each.
    pub fn part(index: u64, count: u64, (width, height): (u32, u32)) -> Self {
        let (w, h) = (u64::from(width), u64::from(height));
        let cut = |length: u64, index: u64, count: u64| (length * index / count) as u32;
        if count <= h {
            let (row, end) = (cut(h, index, count), cut(h, index + 1, count));
            return Self { x: 0, row, width, height: end - row };
        }
        // The parts of a row begin with the number of all parts in the rows above.
        let row = ((index + 1) * h - 1) / count;
        let (first, end) = (count * row / h, count * (row + 1) / h);
        let (x, right) = (cut(w, index - first, end - first), cut(w, index + 1 - first, end - first));
        Self { x, row: row as u32, width: right - x, height: 1 }
    }

    /// Returns the row below the last one.
    pub fn end_row(&self) -> u32 {
        self.row + self.height
    }

    /// Returns whether it has pixels, all of which lie in a picture of this size.
    pub fn lies_in(&self, (width, height): (u32, u32)) -> bool {
        let fits = |start: u32, length: u32, whole: u32| length > 0 && start < whole && length <= whole - start;
        fits(self.x, self.width, width) && fits(self.row, self.height, height)
    }
}

/// `-merge OUT PART...`
#[derive(Clone, Debug)]
pub struct MergeOptions {
    pub output: PathBuf,
    /// At least one.
    pub parts: Vec<PathBuf>,
}

/// `-depth MIN MAX FILE`
#[derive(Clone, Debug, PartialEq)]
pub struct DepthPicture {
    pub min: f64,
    pub max: f64,
    /// Whether the range is found while rendering; until then it is 0 to 1.
    pub is_auto: bool,
    /// The colour where nothing is hit, each component from 0 to 1; `None`: black.
    pub background: Option<Vector3>,
    pub path: PathBuf,
}

/// How pixels are sampled, and what is measured about the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasureOptions {
    pub sampler: SamplerKind,
    /// Whether the sampler was named. Otherwise `-convergence` compares all of them.
    pub sampler_is_given: bool,
    /// Samples for each pixel of the traced grid with `-jitter`; `None`: [`DEFAULT_SAMPLES`].
    pub samples: Option<u32>,
    /// PNG of the estimated error.
    pub error_map: Option<PathBuf>,
    /// JSON.
    pub report: Option<PathBuf>,
    /// A table on standard error.
    pub stats: bool,
    /// The picture that counts as true: PNG, PFM or EXR.
    pub reference: Option<PathBuf>,
    /// SVG, HTML or CSV.
    pub convergence: Option<PathBuf>,
    /// Byte levels.
    pub target_error: Option<f64>,
    /// Seconds since the program started.
    pub time_limit: Option<f64>,
    /// Keep the colours as numbers in the film, even if no file needs them.
    pub keep_linear: bool,
}

impl MeasureOptions {
    /// Returns whether samples are taken in independent sets, from which the error of their mean is estimated.
    pub fn wants_estimate(&self) -> bool {
        self.stats
            || self.report.is_some()
            || self.error_map.is_some()
            || self.convergence.is_some()
            || self.is_adaptive()
    }

    /// Returns whether the estimated error of each pixel is kept: for a picture of its own, or for the page of
    /// `-convergence`.
    pub fn wants_error_map(&self) -> bool {
        self.error_map.is_some() || self.convergence.as_ref().is_some_and(|path| has_extension(path, "html"))
    }

    /// Returns whether times are measured.
    pub fn wants_times(&self) -> bool {
        self.stats || self.report.is_some()
    }

    /// Returns whether the number of samples is determined while rendering.
    pub fn is_adaptive(&self) -> bool {
        self.target_error.is_some() || self.time_limit.is_some()
    }
}

/// `-compare A B`
#[derive(Clone, Debug)]
pub struct CompareOptions {
    pub a: PathBuf,
    pub b: PathBuf,
    /// PNG of both pictures and their differences.
    pub diff: Option<PathBuf>,
    /// JSON.
    pub report: Option<PathBuf>,
    /// Two pixels are alike when no channel differs by more levels than this.
    pub levels: u8,
    /// Percentage of pixels that may be unlike.
    pub percent: f64,
}

impl CompareOptions {
    /// Returns whether two pictures are alike of which this percentage of the pixels is not.
    pub fn are_alike(&self, percent: f64) -> bool {
        percent <= self.percent
    }
}

/// The starter's ray offset: shadow and mirror rays start this far along their direction, in world units times the
/// length of the direction. The course's pictures depend on it.
pub const STARTER_EPSILON: f64 = 0.01;

/// The ray offset, which keeps shadow and mirror rays from hitting the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Epsilon {
    /// A distance along the ray, in world units: [`STARTER_EPSILON`] for the course's pictures.
    Along(f64),
    /// The error bound of each hit, along the surface's normal.
    Auto,
}

impl Default for Epsilon {
    fn default() -> Self {
        Self::Along(STARTER_EPSILON)
    }
}

/// How the samples of a pixel are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Each sample lies anywhere in the pixel.
    Independent,
    /// The pixel is divided into one cell for each sample. Cells have equal area and are nearly square: the course's
    /// "uniform sampling + random jitter".
    #[default]
    Stratified,
    /// Sobol's sequence in two dimensions with Owen's scrambling. More samples can follow at any time.
    Sobol,
}

impl SamplerKind {
    pub const ALL: [Self; 3] = [Self::Independent, Self::Stratified, Self::Sobol];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        }
    }

    /// Returns the expected convergence order at an edge: b if the squared error falls as n^-b with n samples. A
    /// curved edge crosses about sqrt(n) of n cells, which gives 3/2 for one sample in each cell.
    pub fn convergence_order(self) -> f64 {
        match self {
            Self::Independent => 1.0,
            Self::Stratified | Self::Sobol => 1.5,
        }
    }
}

/// Returns whether a file's name ends in `.extension`, in capitals or not.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_picture_once_and_are_of_equal_size() {
        for (width, height, counts) in [(7, 13, 1..92), (1, 5, 1..6), (5, 1, 1..6), (65_536, 65_536, 990..1010)] {
            for count in counts {
                let parts: Vec<_> = (0..count).map(|index| Region::part(index, count, (width, height))).collect();
                let pixels = |part: &Region| u64::from(part.width) * u64::from(part.height);
                assert!(parts.iter().all(|part| part.lies_in((width, height))), "{count}");
                assert_eq!(parts.iter().map(pixels).sum::<u64>(), u64::from(width) * u64::from(height), "{count}");
                let starts = |part: &Region| u64::from(part.row) * u64::from(width) + u64::from(part.x);
                let ends = parts.iter().map(|part| starts(part) + pixels(part));
                assert!(ends.eq(parts.iter().skip(1).map(starts).chain([u64::from(width) * u64::from(height)])));
                let (least, most) = (parts.iter().map(pixels).min(), parts.iter().map(pixels).max());
                let (least, most) = (least.unwrap(), most.unwrap());
                let allowed = if count <= u64::from(height) { least + u64::from(width) } else { 2 * least + 1 };
                assert!(most <= allowed, "{count}: {least} to {most}");
            }
        }
    }
}
