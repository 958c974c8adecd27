//! Whether parts cover a picture, each pixel once.

use crate::options::Region;
use std::ops::Range;

/// Rows that consist of the same parts, from left to right.
#[derive(Debug, PartialEq, Eq)]
pub struct Span {
    pub rows: Range<u32>,
    /// Indices.
    pub parts: Vec<usize>,
}

/// Why parts make no picture. Pixels are columns and rows; parts are indices.
#[derive(Debug, PartialEq, Eq)]
pub enum Problem {
    Gap { pixel: (u32, u32) },
    Overlap { parts: [usize; 2], pixel: (u32, u32) },
}

/// Returns the spans of a picture of this size, from the top. All parts must lie in it.
///
/// # Errors
/// The first pixel that no part has, or two.
pub fn spans(parts: &[Region], (width, height): (u32, u32)) -> Result<Vec<Span>, Problem> {
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&part| (parts[part].row, parts[part].x));
    let mut coming = order.into_iter().peekable();
    let (mut spans, mut active, mut row) = (Vec::new(), Vec::<usize>::new(), 0);
    while row < height {
        while let Some(part) = coming.next_if(|&part| parts[part].row == row) {
            active.push(part);
        }
        active.sort_by_key(|&part| parts[part].x);
        let mut x = 0;
        for (index, &part) in active.iter().enumerate() {
            let pixel = (x.min(parts[part].x), row);
            if parts[part].x < x {
                return Err(Problem::Overlap { parts: [active[index - 1], part], pixel });
            } else if parts[part].x > x {
                return Err(Problem::Gap { pixel });
            }
            x += parts[part].width;
        }
        if x < width {
            return Err(Problem::Gap { pixel: (x, row) });
        }
        let end = active.iter().map(|&part| parts[part].end_row()).min().unwrap_or(height);
        let end = coming.peek().map_or(end, |&part| parts[part].row.min(end));
        spans.push(Span { rows: row..end, parts: active.clone() });
        active.retain(|&part| parts[part].end_row() > end);
        row = end;
    }
    Ok(spans)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(x: u32, row: u32, width: u32, height: u32) -> Region {
        Region { x, row, width, height }
    }

    #[test]
    fn rows_of_the_same_parts_are_found() {
        let parts = [region(2, 0, 2, 3), region(0, 1, 2, 2), region(0, 0, 2, 1)];
        let expected = [Span { rows: 0..1, parts: vec![2, 0] }, Span { rows: 1..3, parts: vec![1, 0] }];
        assert_eq!(spans(&parts, (4, 3)).unwrap(), expected);
    }

    #[test]
    fn gaps_and_overlaps_are_found() {
        let gap = |x, row| Err(Problem::Gap { pixel: (x, row) });
        let overlap = |a, b, x, row| Err(Problem::Overlap { parts: [a, b], pixel: (x, row) });
        for (parts, expected) in [
            (vec![], gap(0, 0)),
            (vec![region(0, 0, 3, 4)], gap(3, 0)),
            (vec![region(1, 0, 3, 4)], gap(0, 0)),
            (vec![region(0, 0, 4, 3)], gap(0, 3)),
            (vec![region(0, 0, 4, 1), region(0, 2, 4, 2)], gap(0, 1)),
            (vec![region(0, 0, 4, 4), region(2, 2, 1, 1)], overlap(0, 1, 2, 2)),
            (vec![region(0, 0, 3, 4), region(2, 0, 2, 4)], overlap(0, 1, 2, 0)),
            (vec![region(0, 0, 4, 4), region(0, 0, 4, 4)], overlap(0, 1, 0, 0)),
        ] {
            assert_eq!(spans(&parts, (4, 4)), expected, "{parts:?}");
        }
    }
}
