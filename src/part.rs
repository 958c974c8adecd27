//! [`Label`]: of which picture a file is a part, and where it lies in it.

use crate::film::Plane;
use crate::options::{Epsilon, Options, Region};
use std::fmt;

/// What a picture file says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    pub place: Region,
    /// Of the whole picture.
    pub size: (u32, u32),
    /// Of this program.
    pub version: String,
    /// What the picture shows, and the flags that decide its pixels.
    pub arguments: String,
    /// Hash of the scene and the files that it names.
    pub files: u128,
}

impl Label {
    /// Makes the label of a picture that `options` ask for.
    pub fn new(options: &Options, plane: Plane, files: u128) -> Self {
        Self {
            place: options.shown(),
            size: (options.width, options.height),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            arguments: arguments(options, plane),
            files,
        }
    }

    /// Parses a label; `None` if it is none.
    pub fn parse(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let mut line = |key: &str| lines.next()?.strip_prefix(key)?.strip_prefix(' ');
        let numbers = |text: &str| text.split(' ').map(|word| word.parse().ok()).collect::<Option<Vec<u32>>>();
        let [x, row, width, height] = numbers(line("place")?)?[..] else { return None };
        let [whole_width, whole_height] = numbers(line("size")?)?[..] else { return None };
        let place = Region { x, row, width, height };
        let label = Self {
            place,
            size: (whole_width, whole_height),
            version: line("version")?.to_owned(),
            arguments: line("arguments")?.to_owned(),
            files: u128::from_str_radix(line("files")?, 16).ok()?,
        };
        place.lies_in(label.size).then_some(label)
    }

    /// Returns in what the pictures of two parts differ; `None` if they are parts of one.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let of = |what: &str, own: &str, others: &str| Some(format!("it has {what} '{own}', not '{others}'"));
        let size = |label: &Self| format!("{} x {}", label.size.0, label.size.1);
        if self.version != other.version {
            of("version", &self.version, &other.version)
        } else if self.arguments != other.arguments {
            of("arguments", &self.arguments, &other.arguments)
        } else if self.size != other.size {
            of("the whole size", &size(self), &size(other))
        } else {
            (self.files != other.files).then(|| "its scene, or a file that the scene names, is another".to_owned())
        }
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Region { x, row, width, height } = self.place;
        writeln!(f, "place {x} {row} {width} {height}")?;
        writeln!(f, "size {} {}", self.size.0, self.size.1)?;
        writeln!(f, "version {}", self.version)?;
        writeln!(f, "arguments {}", self.arguments)?;
        write!(f, "files {:032x}", self.files)
    }
}

/// Returns all that decides a picture's pixels, besides the scene and the size.
fn arguments(options: &Options, plane: Plane) -> String {
    let mut text = match (plane, &options.depth) {
        (Plane::Depth | Plane::ColoredDepth, Some(depth)) => format!("depth {} {}", depth.min, depth.max),
        (Plane::Depth | Plane::ColoredDepth, None) => "depth".to_owned(),
        (Plane::Normals, _) => "normals".to_owned(),
        (Plane::Color, _) if options.color_is_numbers() => format!("numbers -bounces {}", options.bounces),
        (Plane::Color, _) => format!("color -bounces {}", options.bounces),
    };
    text += if options.shadows { " -shadows" } else { "" };
    if options.jitter {
        let (samples, sampler, seed) = (options.samples(), options.measure.sampler.name(), options.seed);
        text += &format!(" -samples {samples} -sampler {sampler} -seed {seed}");
    }
    text += if options.filter { " -filter" } else { "" };
    text += if options.robust { " -robust" } else { "" };
    text + &match options.epsilon {
        Epsilon::Along(distance) => format!(" -epsilon {distance}"),
        Epsilon::Auto => " -epsilon auto".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label() -> Label {
        Label {
            place: Region { x: 3, row: 4, width: 5, height: 6 },
            size: (10, 20),
            version: "1.2".to_owned(),
            arguments: "color -bounces 4".to_owned(),
            files: 0xf00d << 70,
        }
    }

    #[test]
    fn a_label_is_read_back() {
        assert_eq!(Label::parse(&label().to_string()), Some(label()));
        let outside = Label { size: (7, 20), ..label() };
        for text in ["", "place 1 2 3", &outside.to_string(), &label().to_string().replace("size", "sizes")] {
            assert_eq!(Label::parse(text), None, "{text}");
        }
    }

    #[test]
    fn a_difference_is_named() {
        let elsewhere = Label { place: Region { x: 0, ..label().place }, ..label() };
        assert_eq!(label().difference(&elsewhere), None);
        for (other, part) in [
            (Label { version: "1.3".to_owned(), ..label() }, "version '1.2', not '1.3'"),
            (Label { arguments: "color".to_owned(), ..label() }, "arguments 'color -bounces 4', not 'color'"),
            (Label { size: (10, 21), ..label() }, "the whole size '10 x 20', not '10 x 21'"),
            (Label { files: 0, ..label() }, "its scene"),
        ] {
            let difference = label().difference(&other).unwrap();
            assert!(difference.contains(part), "{difference}");
        }
    }
}
