//! [`Panel`]: two pictures and their differences side by side, as one picture with a legend.
//!
//! The colours of the differences go up by doublings, so that a difference of 1 level is seen and 16 and 200 are told
//! apart: black is no difference at all, then blue (1), violet (4), red (16), orange (64) to almost white (255).

use super::comparison::{Comparison, SHOWN_REGIONS};
use super::picture::{Differences, Picture};
use super::regions::Region;
use crate::film::{CHARACTER_HEIGHT, Canvas, Rgb, false_color};

/// Pixels between pictures, and around all.
const MARGIN: usize = 10;
/// Small pictures are enlarged by a whole factor, as long as no side is longer than this.
const ENLARGED_SIDE: usize = 200;
/// Pixels of the legend for each doubling of the difference, and of the field that stands for no difference.
const DOUBLING: usize = 36;
/// Pixels of the legend in all: eight doublings, the field, and half of the last number.
const LEGEND_WIDTH: usize = 9 * DOUBLING + 3 * MARGIN;
const LEGEND_HEIGHT: usize = 14;

const GROUND: Rgb = [40, 40, 40];
const OUTLINE: Rgb = [120, 120, 120];

/// Returns the colour of a difference in levels.
fn color(level: u8) -> Rgb {
    if level == 0 {
        return [0; 3];
    }
    // Level 1 is at the first stop above black, and two doublings are a step.
    false_color((1.0 + libm::log2(f64::from(level)) / 2.0) / 5.0)
}

/// Two pictures and their differences.
pub struct Panel<'a> {
    a: &'a Picture,
    b: &'a Picture,
    levels: &'a [u8],
    regions: &'a [Region],
    /// Pixels of the panel along each side of a pixel.
    scale: usize,
}

impl<'a> Panel<'a> {
    pub fn of(a: &'a Picture, b: &'a Picture, differences: &'a Differences, comparison: &'a Comparison) -> Self {
        let longer = a.size.0.max(a.size.1) as usize;
        let regions = &comparison.regions[..SHOWN_REGIONS.min(comparison.regions.len())];
        Self { a, b, levels: &differences.levels, regions, scale: (ENLARGED_SIDE / longer).max(1) }
    }

    /// Returns width and height.
    pub fn size(&self) -> (u32, u32) {
        let (width, height) = self.shown_size();
        let wide = 3 * width + 4 * MARGIN;
        let high = height + LEGEND_HEIGHT + 2 * CHARACTER_HEIGHT + 6 * MARGIN;
        (wide.max(LEGEND_WIDTH + 2 * MARGIN) as u32, high as u32)
    }

    /// Returns width and height of each of the three pictures.
    fn shown_size(&self) -> (usize, usize) {
        (self.a.size.0 as usize * self.scale, self.a.size.1 as usize * self.scale)
    }

    /// Returns the picture: three bytes a pixel, rows from the top.
    pub fn drawn(&self) -> Vec<u8> {
        let (width, height) = (self.size().0 as usize, self.size().1 as usize);
        let mut canvas = Canvas::new(width, height, GROUND);
        let top = 2 * MARGIN + CHARACTER_HEIGHT;
        let (shown_width, shown_height) = self.shown_size();
        let left = [0, 1, 2].map(|index| MARGIN + index * (shown_width + MARGIN));
        ["A", "B", "A-B"].iter().zip(left).for_each(|(text, left)| canvas.write(text, left, MARGIN));
        for y in 0..shown_height {
            for x in 0..shown_width {
                let pixel = y / self.scale * self.a.size.0 as usize + x / self.scale;
                let colors = [self.a.bytes(pixel), self.b.bytes(pixel), color(self.levels[pixel])];
                left.iter().zip(colors).for_each(|(left, color)| canvas.set(left + x, top + y, color));
            }
        }
        self.outline(&mut canvas, left[2], top);
        draw_legend(&mut canvas, top + shown_height + 2 * MARGIN);
        canvas.bytes
    }

    /// Draws a line around each of the largest regions, but over no pixel that differs.
    fn outline(&self, canvas: &mut Canvas, left: usize, top: usize) {
        let (width, height) = self.shown_size();
        for region in self.regions {
            let before = |side: u32| (side as usize * self.scale).saturating_sub(2);
            let behind = |side: u32, end: usize| ((side as usize + 1) * self.scale + 1).min(end - 1);
            let (first, last) = (before(region.left), behind(region.right, width));
            let (upper, lower) = (before(region.top), behind(region.bottom, height));
            let across = (first..=last).flat_map(|x| [(x, upper), (x, lower)]);
            let down = (upper..=lower).flat_map(|y| [(first, y), (last, y)]);
            for (x, y) in across.chain(down) {
                if canvas.get(left + x, top + y) == color(0) {
                    canvas.set(left + x, top + y, OUTLINE);
                }
            }
        }
    }
}

/// Draws the colour of every difference over its number.
fn draw_legend(canvas: &mut Canvas, top: usize) {
    let numbers = top + LEGEND_HEIGHT + MARGIN / 2;
    canvas.fill(MARGIN, top, DOUBLING / 2, LEGEND_HEIGHT, color(0));
    canvas.write("0", MARGIN, numbers);
    let left = MARGIN + DOUBLING;
    for x in 0..8 * DOUBLING {
        let level = libm::exp2(x as f64 / DOUBLING as f64) as u8;
        canvas.fill(left + x, top, 1, LEGEND_HEIGHT, color(level));
    }
    for doubling in 0..=8 {
        let level = (1_u32 << doubling).min(255).to_string();
        canvas.write(&level, left + doubling * DOUBLING, numbers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::RgbImage;

    #[test]
    fn differences_that_matter_look_different() {
        let apart = |a: u8, b: u8| {
            let channels = color(a).into_iter().zip(color(b));
            channels.map(|(a, b)| u32::from(a.abs_diff(b))).sum::<u32>()
        };
        for (a, b) in [(0, 1), (1, 4), (4, 16), (16, 64), (64, 255), (16, 200)] {
            assert!(apart(a, b) > 100, "{a}, {b}: {:?}, {:?}", color(a), color(b));
        }
        // Also where only brightness counts.
        let brightness =
            |level| color(level).into_iter().zip([2, 7, 1]).map(|(c, share)| u32::from(c) * share).sum();
        let ramp: Vec<u32> = [0, 1, 4, 16, 64, 255].map(brightness).to_vec();
        assert!(ramp.is_sorted_by(|a, b| a < b), "{ramp:?}");
    }

    #[test]
    fn a_panel_shows_both_pictures_and_outlines_their_differences() {
        let mut b = RgbImage::from_pixel(100, 60, image::Rgb([7, 8, 9]));
        let a = Picture::of_bytes(b.clone());
        b.put_pixel(50, 30, image::Rgb([7, 8, 10]));
        let b = Picture::of_bytes(b);
        let differences = a.differences(&b);
        let comparison = Comparison::of(&a, &b, &differences, 0);
        let panel = Panel::of(&a, &b, &differences, &comparison);
        let (width, height) = panel.size();
        let canvas = Canvas { width: width as usize, bytes: panel.drawn() };
        assert_eq!(canvas.bytes.len(), 3 * (width * height) as usize);
        // Enlarged twice, so pixel 50, 30 begins at 100, 60.
        let [left, top] = [MARGIN, 2 * MARGIN + CHARACTER_HEIGHT];
        let at = |index: usize, x: usize, y: usize| canvas.get(left + index * (200 + MARGIN) + x, top + y);
        assert_eq!([at(0, 0, 0), at(1, 101, 61), at(1, 199, 119)], [[7, 8, 9], [7, 8, 10], [7, 8, 9]]);
        assert_eq!([at(2, 100, 60), at(2, 101, 61), at(2, 0, 0)], [color(1), color(1), color(0)]);
        assert_eq!([at(2, 98, 58), at(2, 103, 63), at(2, 99, 59)], [OUTLINE, OUTLINE, color(0)]);
    }
}
