//! The picture of a [`Cost`]: rays, boxes and triangles of each pixel side by side in false colours, each with a legend.

use super::{COUNTED, Cost};
use crate::error::Error;
use crate::film::{CHARACTER_HEIGHT, CHARACTER_WIDTH, Canvas, Rgb, false_color, write_png};
use std::path::Path;

const GROUND: Rgb = [40; 3];
/// Pixels between pictures, and around all.
const MARGIN: usize = 10;
/// Small pictures are enlarged by a whole factor, as long as no side is longer than this. A narrower one leaves room for
/// its legend.
const ENLARGED_SIDE: usize = 200;
/// Height of the legend's bar in pixels.
const BAR_HEIGHT: usize = 14;
/// Share of the pixels that the legend's end may leave out: few are so much dearer that all others would look black.
const BEYOND: f64 = 0.001;
/// Height of a line of text in pixels.
const LINE: usize = CHARACTER_HEIGHT + MARGIN / 2;

impl Cost {
    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// As [`write_png`].
    pub fn write_picture(&self, path: &Path) -> Result<(), Error> {
        let canvas = self.drawn();
        let height = canvas.bytes.len() / (3 * canvas.width);
        write_png(path, canvas.width as u32, height as u32, &canvas.bytes)
    }

    fn drawn(&self) -> Canvas {
        let (width, height) = (self.width as usize, self.height as usize);
        let scale = (ENLARGED_SIDE / width.max(height)).max(1);
        let panel = (width * scale).max(ENLARGED_SIDE);
        let size = (3 * panel + 4 * MARGIN, 2 * MARGIN + 2 * LINE + height * scale + MARGIN + BAR_HEIGHT + LINE);
        let mut canvas = Canvas::new(size.0, size.1, GROUND);
        for kind in 0..COUNTED.len() {
            let left = MARGIN + kind * (panel + MARGIN);
            self.draw_panel(&mut canvas, kind, left, panel, scale);
        }
        canvas
    }

    fn draw_panel(&self, canvas: &mut Canvas, kind: usize, left: usize, panel: usize, scale: usize) {
        let (width, height) = (self.width as usize, self.height as usize);
        let (mean, most) = self.mean_and_most_of(kind);
        canvas.write(&COUNTED[kind].to_uppercase(), left, MARGIN);
        canvas.write(&format!("MEAN {mean:.2} MOST {most}"), left, MARGIN + LINE);
        let (top, end) = (MARGIN + 2 * LINE, self.end_of_legend(kind));
        for (index, pixel) in self.pixels.iter().enumerate() {
            let color = false_color(f64::from(pixel[kind]) / f64::from(end));
            canvas.fill(left + index % width * scale, top + index / width * scale, scale, scale, color);
        }
        let top = top + height * scale + MARGIN;
        for x in 0..panel {
            canvas.fill(left + x, top, 1, BAR_HEIGHT, false_color(x as f64 / (panel - 1) as f64));
        }
        let top = top + BAR_HEIGHT + MARGIN / 2;
        canvas.write("0", left, top);
        let end = end.to_string();
        canvas.write(&end, left + panel - end.len() * CHARACTER_WIDTH, top);
    }

    /// Returns the count at the end of the legend, at least 1. Larger ones have its colour.
    fn end_of_legend(&self, kind: usize) -> u32 {
        let mut counts: Vec<u32> = self.pixels.iter().map(|pixel| pixel[kind]).collect();
        let last = counts.len() - 1 - (counts.len() as f64 * BEYOND) as usize;
        (*counts.select_nth_unstable(last).1).max(1)
    }
}
