//! Pieces of SVG. They are few. The library `plotters` puts labels at powers of ten only, of which most of these curves
//! pass one or two, and would add 3% to a build.

use std::fmt::{Display, Write as _};

/// A place in a figure, in pixels from its upper left corner.
pub type Place = (f64, f64);

/// A figure that is being drawn.
pub struct Drawing {
    pub text: String,
}

impl Drawing {
    pub fn new(width: f64, height: f64) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
        );
        Self { text }
    }

    /// Returns the finished text of the figure.
    pub fn finish(mut self) -> String {
        self.text += "</svg>\n";
        self.text
    }

    /// Adds data that is not shown.
    pub fn data(&mut self, text: &str) {
        let lines: Vec<_> = text.lines().map(escaped).collect();
        self.push(format_args!("<metadata>\n{}\n</metadata>", lines.join("\n")));
    }

    fn push(&mut self, element: impl Display) {
        let _ = writeln!(self.text, "{element}");
    }

    /// Writes words. `anchor` says which part of them is at the place: `start`, `middle` or `end`.
    pub fn words(&mut self, (x, y): Place, anchor: &str, attributes: &str, words: &str) {
        let words = escaped(words);
        self.push(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{attributes}>{words}</text>"
        ));
    }

    pub fn line(&mut self, from: Place, to: Place, style: &str) {
        self.path(&[from, to], &format!("fill=\"none\" {style}"));
    }

    pub fn rectangle(&mut self, (x, y): Place, (width, height): (f64, f64), style: &str) {
        self.push(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {style}/>"
        ));
    }

    /// Draws a line through places, or with a `fill` the area inside.
    pub fn path(&mut self, places: &[Place], style: &str) {
        let places: Vec<_> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        self.push(format_args!("<polyline points=\"{}\" {style}/>", places.join(" ")));
    }

    pub fn dot(&mut self, (x, y): Place, style: &str) {
        self.push(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" {style}/>"));
    }

    /// Draws what `draw` draws, inside a rectangle only. `name` must be its own in the figure.
    pub fn clipped(&mut self, name: &str, corner: Place, size: (f64, f64), draw: impl FnOnce(&mut Self)) {
        self.push(format_args!("<clipPath id=\"{name}\">"));
        self.rectangle(corner, size, "");
        self.push(format_args!("</clipPath>\n<g clip-path=\"url(#{name})\">"));
        draw(self);
        self.push("</g>");
    }
}

/// Returns a text as XML and HTML show it.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            // No XML may hold most of these.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}
