//! [`Cells`]: the parts of a pixel in which the stratified sampler takes one sample each.

use vecmath::Real;

/// A pixel divided into cells of equal area.
///
/// The numbers of cells in two rows differ by at most one. The height of a row is proportional to its number of
/// cells, so that any number of cells covers the pixel and all have the same area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    pub count: u32,
    /// Cells in most rows.
    pub columns: u32,
    /// Cells in the rows that hold one more, which come first.
    pub in_longer_rows: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    column: u32,
    columns: u32,
    /// Cells in the rows before this one.
    before: u32,
    count: u32,
}

impl Cells {
    pub const ONE: Self = Self { count: 1, columns: 1, in_longer_rows: 0 };

    /// Divides a pixel into so many cells.
    pub fn new(count: u32) -> Self {
        let rows = nearest_root(count);
        let columns = count / rows;
        Self { count, columns, in_longer_rows: (count % rows) * (columns + 1) }
    }

    /// Iterates over the first cell of each row.
    #[inline(always)]
    fn rows(self) -> impl Iterator<Item = Cell> {
        let mut before = 0;
        std::iter::from_fn(move || {
            let columns = self.columns + u32::from(before < self.in_longer_rows);
            let first = Cell { column: 0, columns, before, count: self.count };
            before += columns;
            (first.before < self.count).then_some(first)
        })
    }

    /// Takes a place in each of the cells to a place in the pixel. Call it inside `vectorize`.
    #[inline(always)]
    pub fn place_each(self, places: &mut [(Real, Real)]) {
        let mut rest = places;
        for first in self.rows() {
            let (row, later) = rest.split_at_mut(first.columns as usize);
            for (column, place) in row.iter_mut().enumerate() {
                let cell = Cell { column: column as u32, ..first };
                // Products with powers of two are quotients to the bit, and take a fraction of the time.
                *place = match first.columns.is_power_of_two() && first.count.is_power_of_two() {
                    true => cell.place_by(*place, |a, b| a * (1.0 / b)),
                    false => cell.place(place.0, place.1),
                };
            }
            rest = later;
        }
    }

    /// Returns the cell of a sample.
    pub fn cell(&self, index: u32) -> Cell {
        let (columns, start) =
            if index < self.in_longer_rows { (self.columns + 1, 0) } else { (self.columns, self.in_longer_rows) };
        let (row, column) = ((index - start) / columns, (index - start) % columns);
        Cell { column, columns, before: start + row * columns, count: self.count }
    }
}

impl Cell {
    /// Takes a place in the cell to a place in the pixel.
    #[inline(always)]
    pub fn place(&self, x: Real, y: Real) -> (Real, Real) {
        self.place_by((x, y), |a, b| a / b)
    }

    #[inline(always)]
    fn place_by(&self, (x, y): (Real, Real), divide: impl Fn(Real, Real) -> Real) -> (Real, Real) {
        let (columns, count) = (self.columns as Real, self.count as Real);
        let x = divide(self.column as Real + x, columns);
        let y = divide(self.before as Real + y * columns, count);
        (below_one(x), below_one(y))
    }
}

/// Returns the whole number nearest to the root of `count`.
fn nearest_root(count: u32) -> u32 {
    let root = count.isqrt();
    root + u32::from(count - root * root > root)
}

/// Returns a number, or the largest one below 1: in `f32`, 32 random bits may round up to 1.
#[inline(always)]
pub fn below_one(number: Real) -> Real {
    const BELOW_ONE: Real = 1.0 - Real::EPSILON / 2.0;
    // One instruction; `min` takes three, because it looks for NaN.
    if number < BELOW_ONE { number } else { BELOW_ONE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_equal_area_and_cover_the_pixel() {
        for count in 1..300 {
            let cells: Vec<Cell> = (0..count).map(|index| Cells::new(count).cell(index)).collect();
            let rows: Vec<Cell> = Cells::new(count).rows().collect();
            assert_eq!(rows, cells.iter().filter(|cell| cell.column == 0).copied().collect::<Vec<_>>());
            for (index, cell) in cells.iter().enumerate() {
                let corners = [cell.place(0.0, 0.0), cell.place(1.0, 1.0)];
                let area = (corners[1].0 - corners[0].0) * (corners[1].1 - corners[0].1);
                assert!((area * count as Real - 1.0).abs() < 1e3 * Real::EPSILON, "{index} of {count}");
                // Each cell begins where the cell before it ended.
                let expected_column = if cell.before == index as u32 { 0 } else { cells[index - 1].column + 1 };
                assert_eq!(cell.column, expected_column);
                assert_eq!(cell.before + cell.column, index as u32);
            }
            assert!(cells[0].columns.abs_diff(count.isqrt()) <= 1, "{count}");
        }
    }
}
