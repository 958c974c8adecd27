//! The *pilot*: a few rays that show where samples are needed, before they are taken.
//!
//! The corner of every pixel is traced, which is what the plain picture shows. So a pixel sees its four corners, and each
//! ray serves four pixels: one ray a pixel finds every edge that a pixel's width does not hide.

use super::empty_tiles::EmptyTiles;
use super::rays::RayMaker;
use super::tiles::Tile;
use super::tracer::Tracer;
use crate::film::to_byte;
use crate::ray_counts::RayCounts;
use crate::trace::Seen;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};
use vecmath::Vector3;

/// The displayed colours at the corners of all pixels, rows from the top.
struct Corners {
    /// Corners in a row: one more than pixels.
    columns: usize,
    bytes: Vec<[u8; 3]>,
    counts: RayCounts,
}

/// Returns for each pixel of a part of the picture the variance of its corners in squared levels, averaged over the
/// channels, and the rays traced; `None` if the deadline came first.
pub fn variances<'a>(
    part: Tile,
    maker: &RayMaker,
    empty: &EmptyTiles,
    tracer: impl Fn() -> Box<dyn Tracer + 'a> + Sync + Send,
) -> Option<(Vec<f32>, RayCounts)> {
    let columns = part.width as usize + 1;
    let bytes = vec![[0; 3]; columns * (part.height as usize + 1)];
    let corners = Mutex::new(Corners { columns, bytes, counts: RayCounts::default() });
    let trace_corners = |tracer: &mut Box<dyn Tracer + 'a>, in_part: Tile| {
        let tile = Tile { x: part.x + in_part.x, row: part.row + in_part.row, ..in_part };
        let (mut seen, mut is_whole) = (Vec::new(), true);
        let is_empty = empty.contain(&tile);
        if is_empty {
            seen.push(empty.seen_through(&tile, &mut **tracer));
        } else {
            let places: Vec<_> = tile.pixels().map(|corner| maker.corner(corner)).collect();
            is_whole = tracer.trace(maker.grid, &places, &mut seen);
        }
        // A poisoned lock means that another thread has panicked; that panic will be reported.
        if let Ok(mut corners) = corners.lock() {
            match is_empty {
                true => corners.rows(in_part).for_each(|row| row.fill(displayed(seen[0].color))),
                false => corners.set(in_part, &seen),
            }
            corners.counts += tracer.take_counts();
        }
        is_whole
    };
    let tiles = Tile::all(part.width + 1, part.height + 1).into_par_iter();
    let is_whole = tiles.map_init(tracer, trace_corners).all(|is_whole| is_whole);
    let corners = corners.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut variances = vec![0.0; (part.width * part.height) as usize];
    let rows = variances.par_chunks_mut(part.width as usize).enumerate();
    rows.for_each(|(row, variances)| corners.set_variances(row, variances));
    is_whole.then_some((variances, corners.counts))
}

impl Corners {
    /// Iterates over the rows of a tile.
    fn rows(&mut self, tile: Tile) -> impl Iterator<Item = &mut [[u8; 3]]> {
        let rows = self.bytes.chunks_exact_mut(self.columns).skip(tile.row as usize).take(tile.height as usize);
        rows.map(move |row| &mut row[tile.x as usize..][..tile.width as usize])
    }

    fn set(&mut self, tile: Tile, seen: &[Seen]) {
        for (row, seen) in self.rows(tile).zip(seen.chunks_exact(tile.width as usize)) {
            row.iter_mut().zip(seen).for_each(|(bytes, seen)| *bytes = displayed(seen.color));
        }
    }

    /// Sets the variances of a row of pixels.
    fn set_variances(&self, row: usize, variances: &mut [f32]) {
        const CHANNELS: usize = 3;
        let corners = |row: usize| self.bytes[row * self.columns..][..self.columns].as_flattened();
        let columns = corners(row).iter().zip(corners(row + 1)).map(|(&a, &b)| [u32::from(a), u32::from(b)]);
        // Of each channel of each column of corners: plain loops, which are several numbers an instruction.
        let sums: Vec<u32> = columns.clone().map(|[upper, lower]| upper + lower).collect();
        let squares: Vec<u32> = columns.map(|[upper, lower]| upper * upper + lower * lower).collect();
        let sums = sums.iter().zip(&sums[CHANNELS..]).map(|(left, right)| left + right);
        let squares = squares.iter().zip(&squares[CHANNELS..]).map(|(left, right)| left + right);
        // Three times the variance of four numbers is the sum of their squares less a quarter of the square of their sum.
        let spreads: Vec<u32> = squares.zip(sums).map(|(squares, sum)| 4 * squares - sum * sum).collect();
        for (variance, channels) in variances.iter_mut().zip(spreads.as_chunks::<CHANNELS>().0) {
            *variance = channels.iter().sum::<u32>() as f32 / 36.0;
        }
    }
}

fn displayed(color: Vector3) -> [u8; 3] {
    color.to_array().map(to_byte)
}
