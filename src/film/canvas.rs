//! [`Canvas`]: a picture with numbers and a few words in it, and the colours that stand for numbers.

/// Red, green and blue.
pub type Rgb = [u8; 3];

/// Side of a glyph's dots in pixels.
const DOT: usize = 2;
/// Dots in a glyph's row, and its rows.
const GLYPH_COLUMNS: usize = 3;
const GLYPH_ROWS: usize = 5;
/// Width of a character with the gap behind it, and its height, in pixels.
pub const CHARACTER_WIDTH: usize = (GLYPH_COLUMNS + 1) * DOT;
pub const CHARACTER_HEIGHT: usize = GLYPH_ROWS * DOT;

const TEXT: Rgb = [230, 230, 230];
/// Colours of the shares 0 to 1 in equal steps, each brighter than the one before.
const RAMP: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [70.0, 90.0, 255.0],
    [190.0, 80.0, 230.0],
    [245.0, 100.0, 90.0],
    [255.0, 165.0, 30.0],
    [255.0, 250.0, 200.0],
];

/// Returns the false colour of a share from 0 to 1: black, blue, violet, red, orange, nearly white.
pub fn false_color(share: f64) -> Rgb {
    let place = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let stop = (place as usize).min(RAMP.len() - 2);
    let share = place - stop as f64;
    [0, 1, 2].map(|channel| (RAMP[stop][channel] * (1.0 - share) + RAMP[stop + 1][channel] * share) as u8)
}

/// A picture to draw into: three bytes a pixel, rows from the top.
#[derive(Debug)]
pub struct Canvas {
    pub width: usize,
    pub bytes: Vec<u8>,
}

impl Canvas {
    /// Makes a canvas of one colour.
    pub fn new(width: usize, height: usize, ground: Rgb) -> Self {
        Self { width, bytes: ground.repeat(width * height) }
    }

    pub fn get(&self, x: usize, y: usize) -> Rgb {
        let at = 3 * (y * self.width + x);
        [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]]
    }

    pub fn set(&mut self, x: usize, y: usize, color: Rgb) {
        let at = 3 * (y * self.width + x);
        self.bytes[at..at + 3].copy_from_slice(&color);
    }

    pub fn fill(&mut self, left: usize, top: usize, width: usize, height: usize, color: Rgb) {
        for y in top..top + height {
            (left..left + width).for_each(|x| self.set(x, y, color));
        }
    }

    /// Writes digits and capital letters, the upper left corner of the first one at `left`, `top`. What has no glyph is left
    /// blank.
    pub fn write(&mut self, text: &str, left: usize, top: usize) {
        for (index, character) in text.chars().enumerate() {
            let left = left + index * CHARACTER_WIDTH;
            for (row, dots) in glyph(character).into_iter().enumerate() {
                for column in (0..GLYPH_COLUMNS).filter(|column| dots >> (GLYPH_COLUMNS - 1 - column) & 1 == 1) {
                    self.fill(left + column * DOT, top + row * DOT, DOT, DOT, TEXT);
                }
            }
        }
    }
}

/// Returns the rows of a character from the top, a bit for each dot.
fn glyph(character: char) -> [u8; GLYPH_ROWS] {
    match character {
        '0' => [0b111, 0b101, 0b101, 0b101, 0b111],
        '1' => [0b010, 0b110, 0b010, 0b010, 0b111],
        '2' => [0b111, 0b001, 0b111, 0b100, 0b111],
        '3' => [0b111, 0b001, 0b111, 0b001, 0b111],
        '4' => [0b101, 0b101, 0b111, 0b001, 0b001],
        '5' => [0b111, 0b100, 0b111, 0b001, 0b111],
        '6' => [0b111, 0b100, 0b111, 0b101, 0b111],
        '7' => [0b111, 0b001, 0b001, 0b001, 0b001],
        '8' => [0b111, 0b101, 0b111, 0b101, 0b111],
        '9' => [0b111, 0b101, 0b111, 0b001, 0b111],
        'A' => [0b010, 0b101, 0b111, 0b101, 0b101],
        'B' => [0b110, 0b101, 0b110, 0b101, 0b110],
        'E' => [0b111, 0b100, 0b111, 0b100, 0b111],
        'G' => [0b111, 0b100, 0b101, 0b101, 0b111],
        'I' => [0b111, 0b010, 0b010, 0b010, 0b111],
        'L' => [0b100, 0b100, 0b100, 0b100, 0b111],
        'M' => [0b101, 0b111, 0b111, 0b101, 0b101],
        'N' => [0b110, 0b101, 0b101, 0b101, 0b101],
        'O' => [0b010, 0b101, 0b101, 0b101, 0b010],
        'R' => [0b110, 0b101, 0b110, 0b101, 0b101],
        'S' => [0b011, 0b100, 0b010, 0b001, 0b110],
        'T' => [0b111, 0b010, 0b010, 0b010, 0b010],
        'X' => [0b101, 0b101, 0b010, 0b101, 0b101],
        'Y' => [0b101, 0b101, 0b010, 0b010, 0b010],
        '-' => [0b000, 0b000, 0b111, 0b000, 0b000],
        '.' => [0b000, 0b000, 0b000, 0b000, 0b010],
        _ => [0; GLYPH_ROWS],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_brighter() {
        let brightness = |step: u32| {
            let channels = false_color(f64::from(step) / 50.0).into_iter().zip([2, 7, 1]);
            channels.map(|(channel, share)| u32::from(channel) * share).sum::<u32>()
        };
        let ramp: Vec<u32> = (0..=50).map(brightness).collect();
        assert!(ramp.is_sorted_by(|a, b| a < b), "{ramp:?}");
        assert_eq!((false_color(-1.0), false_color(7.0)), ([0; 3], [255, 250, 200]));
    }

    #[test]
    fn text_is_drawn_in_its_place() {
        let mut canvas = Canvas::new(20, 12, [9; 3]);
        canvas.write("1L", 1, 1);
        let rows: Vec<String> = canvas
            .bytes
            .chunks(3 * 20)
            .map(|row| row.chunks(3).map(|pixel| if pixel == TEXT { '#' } else { '.' }).collect())
            .collect();
        assert_eq!(rows[0], ".".repeat(20));
        assert_eq!(rows[1], "...##....##.........");
        assert_eq!(rows[3], ".####....##.........");
        assert_eq!(rows[10], ".######..######.....");
    }
}
