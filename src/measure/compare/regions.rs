//! [`Region`]: a box around pixels that differ and lie near each other.

/// A box around pixels that differ; `right` and `bottom` are inside. Columns from the left, rows from the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub left: u32,
    pub top: u32,
    pub right: u32,
    pub bottom: u32,
    /// Number of pixels that differ.
    pub pixels: u64,
    /// Largest difference in levels, rounded up.
    pub worst: u8,
}

impl Region {
    fn joined(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
            pixels: self.pixels + other.pixels,
            worst: self.worst.max(other.worst),
        }
    }
}

/// Least side of a cell in pixels: pixels nearer than that are in one region.
const CELL: usize = 8;
/// Largest number of cells along a side, so that large pictures have few regions, too.
const MOST_CELLS: usize = 256;

/// Returns the regions of the pixels that differ by more than `above` levels, those of most pixels first.
///
/// The picture is divided into square cells. Cells with such pixels that touch each other, at a corner too, are one region.
pub fn regions(levels: &[u8], width: usize, above: u8) -> Vec<Region> {
    let side = CELL.max(width.max(levels.len() / width).div_ceil(MOST_CELLS));
    let columns = width.div_ceil(side);
    let mut cells = vec![None::<Region>; columns * (levels.len() / width).div_ceil(side)];
    for (row, line) in levels.chunks_exact(width).enumerate() {
        for (column, &worst) in line.iter().enumerate().filter(|&(_, &worst)| worst > above) {
            let (x, y) = (column as u32, row as u32);
            let pixel = Region { left: x, top: y, right: x, bottom: y, pixels: 1, worst };
            let cell = &mut cells[row / side * columns + column / side];
            *cell = Some(cell.map_or(pixel, |region| region.joined(pixel)));
        }
    }
    let mut found: Vec<Region> =
        (0..cells.len()).filter_map(|start| connected(&mut cells, columns, start)).collect();
    found.sort_by_key(|region| (std::cmp::Reverse(region.pixels), region.top, region.left));
    found
}

/// Takes the cells that touch each other, beginning with the one at `start`, and returns their region.
fn connected(cells: &mut [Option<Region>], columns: usize, start: usize) -> Option<Region> {
    let mut region = cells[start].take()?;
    let mut stack = vec![start];
    while let Some(cell) = stack.pop() {
        let (column, row) = (cell % columns, cell / columns);
        for row in row.saturating_sub(1)..(row + 2).min(cells.len() / columns) {
            for column in column.saturating_sub(1)..(column + 2).min(columns) {
                if let Some(neighbor) = cells[row * columns + column].take() {
                    region = region.joined(neighbor);
                    stack.push(row * columns + column);
                }
            }
        }
    }
    Some(region)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels of a picture with these pixels: column, row, levels.
    fn levels(width: usize, height: usize, pixels: &[(usize, usize, u8)]) -> Vec<u8> {
        let mut levels = vec![0; width * height];
        pixels.iter().for_each(|&(column, row, value)| levels[row * width + column] = value);
        levels
    }

    #[test]
    fn near_pixels_are_one_region_and_far_ones_are_several() {
        // The first three lie in cells that touch, one of them at a corner. The last one does not count.
        let pixels = [(7, 7, 3), (8, 8, 200), (20, 9, 2), (60, 3, 9), (61, 3, 9), (60, 40, 9), (3, 40, 1)];
        let found = regions(&levels(70, 50, &pixels), 70, 1);
        assert_eq!(
            found,
            [
                Region { left: 7, top: 7, right: 20, bottom: 9, pixels: 3, worst: 200 },
                Region { left: 60, top: 3, right: 61, bottom: 3, pixels: 2, worst: 9 },
                Region { left: 60, top: 40, right: 60, bottom: 40, pixels: 1, worst: 9 },
            ]
        );
    }

    #[test]
    fn pictures_of_any_shape_have_their_pixels_in_regions() {
        for (width, height) in [(1, 1), (1, 9000), (9000, 1), (17, 33)] {
            let all = regions(&vec![5; width * height], width, 4);
            let whole = (0, 0, width as u32 - 1, height as u32 - 1, (width * height) as u64);
            let found: Vec<_> = all.iter().map(|r| (r.left, r.top, r.right, r.bottom, r.pixels)).collect();
            assert_eq!(found, [whole]);
            assert_eq!(regions(&vec![5; width * height], width, 5), []);
        }
    }
}
