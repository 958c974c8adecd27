//! The table of all flags. The parser, the help, the manual page and the completions are made of it.

/// A flag of the command line.
#[derive(Debug)]
pub struct Flag {
    /// Without the dash.
    pub name: &'static str,
    /// What its values are called.
    pub values: &'static [&'static str],
    /// Half a line.
    pub summary: &'static str,
    /// Sentences that follow the summary in `-help`.
    pub more: &'static str,
}

/// The flags by what they are for.
pub const GROUPS: &[(&str, &[Flag])] = &[
    ("Pictures", PICTURES),
    ("Quality", QUALITY),
    ("Measuring", MEASURING),
    ("Running", RUNNING),
    ("Parts of a picture", PARTS),
    ("Comparing", COMPARING),
    ("Help", HELP),
];

/// Iterates over all flags.
pub fn flags() -> impl Iterator<Item = &'static Flag> + Clone {
    GROUPS.iter().flat_map(|group| group.1)
}

const fn flag(
    name: &'static str,
    values: &'static [&'static str],
    summary: &'static str,
    more: &'static str,
) -> Flag {
    Flag { name, values, summary, more }
}

const PICTURES: &[Flag] = &[
    flag(
        "input",
        &["FILE"],
        "Scene to read, .txt; the flag may be left out",
        "- is standard input: files that the scene names are then relative to the current folder.",
    ),
    flag(
        "output",
        &["FILE"],
        "Colour picture: .png, or numbers: .pfm, .exr",
        "Numbers are neither clamped nor rounded. - is standard output, for a PNG picture; the other pictures take it, too.",
    ),
    flag(
        "depth",
        &["MIN", "MAX", "FILE"],
        "Grey picture of the distance, .png; or auto FILE",
        "It is black at distance MIN, white at MAX, and black where nothing is hit. MIN may be above MAX. With auto in \
         place of both they are found, and printed.",
    ),
    flag(
        "depth-background",
        &["R", "G", "B"],
        "Its colour where nothing is hit [0 0 0]",
        "Each number is from 0 to 1.",
    ),
    flag("normals", &["FILE"], "Picture of the surface normals, .png", "Red, green and blue are (n + 1)/2."),
    flag("size", &["W", "H"], "Width and height in pixels [100 100]", "Each is at most 65536."),
    flag(
        "check",
        &[],
        "Read all files and find mistakes, render nothing",
        "It says what the scene holds. The exit code is 1 if anything is wrong.",
    ),
];

const QUALITY: &[Flag] = &[
    flag("bounces", &["N"], "Mirror reflections one after another [0]", "N is at most 100000."),
    flag("shadows", &[], "A light is blocked by what stands before it", ""),
    flag(
        "jitter",
        &[],
        "16 random samples a pixel, not one in its corner",
        "One lies in each cell of a 4 x 4 grid.",
    ),
    flag(
        "samples",
        &["N"],
        "As many random samples a pixel [16]",
        "N is at most 65536, and with -time-limit the most that are taken. It implies -jitter.",
    ),
    flag(
        "sampler",
        &["NAME"],
        "independent, stratified or sobol samples",
        "The default is stratified, with -target-error or -time-limit sobol. It implies -jitter.",
    ),
    flag(
        "filter",
        &[],
        "Smooth: render 3 times as large, then shrink",
        "The picture is filtered down with a Gaussian. It goes with -jitter, too.",
    ),
    flag(
        "epsilon",
        &["E"],
        "Where shadow and mirror rays start [0.01], or auto",
        "They start E along the ray, in units of the scene. With auto they start just beyond the rounding of the surface.",
    ),
    flag("robust", &[], "Right at every scale, not the course's shortcuts", "What it changes is listed below."),
    flag("seed", &["S"], "Seed of the random samples [0]", "The same seed gives the same bytes."),
];

const MEASURING: &[Flag] = &[
    flag("stats", &[], "Print times, rays, memory and estimated error", "The table goes to standard error."),
    flag(
        "report",
        &["FILE"],
        "Write the same as .json",
        "- is standard output. With -compare it says what was found.",
    ),
    flag(
        "reference",
        &["FILE"],
        "Picture that counts as true: say the error",
        "The file is a .png, .pfm or .exr of the same size.",
    ),
    flag(
        "error-map",
        &["FILE"],
        "Picture of the estimated error, .png",
        "It is white at 16 levels, the steps of a byte. It implies -jitter.",
    ),
    flag(
        "convergence",
        &["FILE"],
        "Error against time: .svg, .html or .csv",
        "Each sampler has a curve of this scene, or only the one that -sampler names. It implies -jitter.",
    ),
    flag(
        "target-error",
        &["LEVELS"],
        "Sample where needed until the error is below",
        "The error is the estimated RMSE, in levels of 255. It implies -jitter.",
    ),
    flag(
        "time-limit",
        &["SECONDS"],
        "Stop in time with the best picture so far",
        "Without -samples and -target-error all of the time is used. It implies -jitter.",
    ),
    flag(
        "pixel",
        &["X", "Y"],
        "Print how this pixel gets its colour",
        "X is counted from the left, Y from the top. The flag may be given several times.",
    ),
    flag(
        "cost",
        &["FILE"],
        "Picture of what each pixel takes, .png",
        "That is rays, boxes and triangles, in false colours.",
    ),
    flag("explain", &[], "Say what the scene needs and what is left out", "It goes to standard error."),
];

const RUNNING: &[Flag] = &[
    flag("threads", &["N"], "Worker threads [one for each processor]", "They change nothing in the picture."),
    flag(
        "simd",
        &["NAME"],
        "Instruction set: sse2, avx2 or avx512 [the best]",
        "It changes nothing in the picture.",
    ),
    flag(
        "plain",
        &[],
        "Render by the plain definition: slow, same bytes",
        "It traces one ray at a time, and is the first thing to try when a picture looks wrong.",
    ),
    flag(
        "max-memory",
        &["SIZE"],
        "Refuse what needs more memory, as in 500M",
        "SIZE is bytes, or a number with K, M or G (powers of 1024).",
    ),
    flag("quiet", &[], "No progress and no hints", "Warnings that a picture is wrong are still printed."),
];

const PARTS: &[Flag] = &[
    flag(
        "region",
        &["X", "Y", "W", "H"],
        "Render only this part, from the top left",
        "The picture is W x H pixels of the whole one, byte for byte, from column X and row Y on.",
    ),
    flag(
        "tile",
        &["I/N"],
        "Render only part I of N: some rows",
        "With more parts than rows it is a piece of a row. Parts are of nearly equal size.",
    ),
    flag(
        "skip-done",
        &[],
        "Leave alone what the same run has finished before",
        "That is, pictures that are whole, and of the same scene, files, flags and version.",
    ),
    flag(
        "merge",
        &["OUT", "PART..."],
        "Join parts to one picture instead of rendering",
        "It is the file that one run would write. Parts of another picture, gaps and overlaps are refused.",
    ),
];

const COMPARING: &[Flag] = &[
    flag(
        "compare",
        &["A", "B"],
        "Compare two pictures instead of rendering",
        "They are .png, .pfm or .exr files of the same size. The exit code is 0 if they are alike, 1 if not, 2 if that cannot be told, 3 if their sizes differ.",
    ),
    flag("diff", &["FILE"], "A, B and their differences side by side, .png", "It goes with -compare."),
    flag(
        "tolerance",
        &["LEVELS", "PERCENT"],
        "What counts as alike [1 0.01]",
        "At most LEVELS apart on all but PERCENT of the pixels. It goes with -compare.",
    ),
];

const HELP: &[Flag] = &[
    flag("h", &[], "The flags to begin with", ""),
    flag("help", &[], "All flags, with details and examples", ""),
    flag("version", &[], "Version, build, instruction sets, limits; also -V", ""),
];
