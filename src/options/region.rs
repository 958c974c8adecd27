//! [`Region`]: a rectangle of a picture, and how a picture is divided into such.

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
