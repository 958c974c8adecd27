//! [`Film`]: the planes of bytes and numbers that become pictures, and the formats of picture files.
//!
//! Depths and normals must already be mapped to \[0, 1\]. Nothing here knows of rays or scenes.

mod canvas;
#[cfg(feature = "exr")]
mod exr;
mod label;
mod numbers;
mod picture_writer;
mod png;

pub use canvas::{CHARACTER_HEIGHT, CHARACTER_WIDTH, Canvas, Rgb, false_color};
pub use label::{file_beside, is_whole, read_label};
pub use numbers::{NumberPicture, encode_numbers, read_numbers};
pub use picture_writer::{PictureWriter, Plane};
pub use png::{encode_png, write_png};

use crate::error::Error;
use crate::options::Options;
use vecmath::{Real, Vector3};

/// The planes that a film has.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planes {
    pub color: bool,
    pub depth: bool,
    pub normals: bool,
    pub linear: bool,
    pub error_map: bool,
}

impl Planes {
    /// Returns the planes that the pictures and comparisons of `options` need.
    pub fn wanted_by(options: &Options) -> Self {
        Self {
            // A file of numbers needs no bytes.
            color: options.renders_colors() && (!options.color_is_numbers() || options.keeps_film()),
            depth: options.depth.is_some(),
            normals: options.normals.is_some(),
            linear: options.keeps_linear(),
            error_map: options.measure.wants_error_map(),
        }
    }

    /// Returns the bytes of a film for each pixel.
    pub fn bytes_per_pixel(&self) -> usize {
        let planes = [(self.color, 3), (self.depth, 1), (self.normals, 3), (self.linear, 12), (self.error_map, 4)];
        planes.into_iter().map(|(wanted, bytes)| if wanted { bytes } else { 0 }).sum()
    }
}

/// A picture, or a rectangle of one, in several planes; rows from the top.
#[derive(Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Three bytes a pixel.
    pub color: Option<Vec<u8>>,
    /// One byte a pixel.
    pub depth: Option<Vec<u8>>,
    /// Three bytes a pixel.
    pub normals: Option<Vec<u8>>,
    /// Colours as traced, neither clamped nor rounded: three numbers a pixel.
    pub linear: Option<Vec<f32>>,
    /// Estimated squared errors of the colours in squared byte levels: one number a pixel.
    pub variances: Option<Vec<f32>>,
}

impl Film {
    /// Makes a black film.
    pub fn new(width: u32, height: u32, planes: Planes) -> Self {
        let pixels = width as usize * height as usize;
        let plane = |wanted: bool, bytes: usize| wanted.then(|| vec![0; pixels * bytes]);
        Self {
            width,
            height,
            color: plane(planes.color, 3),
            depth: plane(planes.depth, 1),
            normals: plane(planes.normals, 3),
            linear: planes.linear.then(|| vec![0.0; 3 * pixels]),
            variances: planes.error_map.then(|| vec![0.0; pixels]),
        }
    }

    /// Returns a part of the film: so many columns, from the top to the bottom.
    pub fn columns(&mut self, first: u32, count: u32) -> Columns<'_> {
        Columns { film: self, first: first as usize, count: count as usize }
    }

    /// Returns the picture of the errors: one byte a pixel, in sixteenths of a level.
    pub fn error_map(&self) -> Option<Vec<u8>> {
        let to_byte = |variance: &f32| (16.0 * variance.sqrt()).round() as u8;
        self.variances.as_ref().map(|variances| variances.iter().map(to_byte).collect())
    }

    /// Copies a tile into the film, with its top left pixel at (`x`, `row`). The tile must have the same planes.
    pub fn place(&mut self, x: u32, row: u32, tile: &Self) {
        let film_width = self.width as usize;
        let rows = TileRows {
            first: row as usize * film_width + x as usize,
            film_width,
            tile_width: tile.width as usize,
        };
        rows.copy(&mut self.color, &tile.color, 3);
        rows.copy(&mut self.depth, &tile.depth, 1);
        rows.copy(&mut self.normals, &tile.normals, 3);
        rows.copy(&mut self.linear, &tile.linear, 3);
        rows.copy(&mut self.variances, &tile.variances, 1);
    }
}

/// Some columns of a film. Pixels come row by row.
pub struct Columns<'a> {
    film: &'a mut Film,
    first: usize,
    count: usize,
}

impl Columns<'_> {
    /// Sets the colours of all pixels, if the film has a plane for them.
    pub fn set_colors<P>(&mut self, pixels: &[P], color: impl Fn(&P) -> Vector3) {
        for (row, pixels) in self.rows(|film| &mut film.linear, 3, pixels) {
            let numbers = row.as_chunks_mut().0.iter_mut();
            numbers.zip(pixels).for_each(|(numbers, pixel)| *numbers = color(pixel).to_array().map(|c| c as f32));
        }
        for (row, pixels) in self.rows(|film| &mut film.color, 3, pixels) {
            set_bytes(row, pixels, &color);
        }
    }

    /// Sets the normals of all pixels, if the film has a plane for them: components from 0 to 1.
    pub fn set_normals<P>(&mut self, pixels: &[P], normal: impl Fn(&P) -> Vector3) {
        for (row, pixels) in self.rows(|film| &mut film.normals, 3, pixels) {
            set_bytes(row, pixels, &normal);
        }
    }

    /// Sets the depths of all pixels, if the film has a plane for them: from 0 to 1.
    pub fn set_depths<P>(&mut self, pixels: &[P], depth: impl Fn(&P) -> Real) {
        for (row, pixels) in self.rows(|film| &mut film.depth, 1, pixels) {
            row.iter_mut().zip(pixels).for_each(|(byte, pixel)| *byte = to_byte(depth(pixel)));
        }
    }

    /// Returns whether the film has a plane of squared errors.
    pub fn have_variances(&self) -> bool {
        self.film.variances.is_some()
    }

    /// Sets the squared errors of all pixels, if the film has a plane for them: in squared byte levels.
    pub fn set_variances(&mut self, variances: &[f32]) {
        for (row, variances) in self.rows(|film| &mut film.variances, 1, variances) {
            row.copy_from_slice(variances);
        }
    }

    /// Sets all pixels to the same colour, normal and depth, where the film has planes for them.
    pub fn fill(&mut self, color: Vector3, normal: Vector3, depth: Real) {
        let fill_bytes = |row: &mut [u8], [r, g, b]: [Real; 3]| row.as_chunks_mut().0.fill([r, g, b].map(to_byte));
        let linear = color.to_array().map(|c| c as f32);
        self.rows_of(|film| &mut film.linear, 3).for_each(|row| row.as_chunks_mut().0.fill(linear));
        self.rows_of(|film| &mut film.color, 3).for_each(|row| fill_bytes(row, color.to_array()));
        self.rows_of(|film| &mut film.normals, 3).for_each(|row| fill_bytes(row, normal.to_array()));
        self.rows_of(|film| &mut film.depth, 1).for_each(|row| row.fill(to_byte(depth)));
    }

    /// Iterates over the rows of a plane within the columns, each with its pixels, if the film has this plane.
    fn rows<'p, T: 'static, P>(
        &mut self,
        plane: impl Fn(&mut Film) -> &mut Option<Vec<T>>,
        channels: usize,
        pixels: &'p [P],
    ) -> impl Iterator<Item = (&mut [T], &'p [P])> {
        let count = self.count;
        self.rows_of(plane, channels).zip(pixels.chunks_exact(count))
    }

    /// Iterates over the rows of a plane within the columns, if the film has this plane.
    fn rows_of<T: 'static>(
        &mut self,
        plane: impl Fn(&mut Film) -> &mut Option<Vec<T>>,
        channels: usize,
    ) -> impl Iterator<Item = &mut [T]> {
        let width = self.film.width as usize;
        let part = channels * self.first..channels * (self.first + self.count);
        let rows = plane(self.film).iter_mut().flat_map(move |plane| plane.chunks_exact_mut(channels * width));
        rows.map(move |row| &mut row[part.clone()])
    }
}

/// Takes the bands of a picture: films of its whole width, one after the other from the top.
pub trait BandWriter: Send {
    /// # Errors
    /// As the writer says; then no further band comes.
    fn write(&mut self, band: &Film) -> Result<(), Error>;
}

/// Keeps all bands in a film.
pub struct FilmWriter {
    pub film: Film,
    /// Rows that are written.
    rows: u32,
}

impl FilmWriter {
    pub fn new(width: u32, height: u32, planes: Planes) -> Self {
        Self { film: Film::new(width, height, planes), rows: 0 }
    }
}

impl BandWriter for FilmWriter {
    fn write(&mut self, band: &Film) -> Result<(), Error> {
        self.film.place(0, self.rows, band);
        self.rows += band.height;
        Ok(())
    }
}

/// The place of a tile's rows in a film, in pixels.
struct TileRows {
    first: usize,
    film_width: usize,
    tile_width: usize,
}

impl TileRows {
    /// Copies a plane of a tile into the plane of a film, if there is one.
    fn copy<T: Copy>(&self, film: &mut Option<Vec<T>>, tile: &Option<Vec<T>>, channels: usize) {
        let (Some(film), Some(tile)) = (film, tile) else { return };
        let film_rows = film[channels * self.first..].chunks_mut(channels * self.film_width);
        for (film_row, tile_row) in film_rows.zip(tile.chunks_exact(channels * self.tile_width)) {
            film_row[..tile_row.len()].copy_from_slice(tile_row);
        }
    }
}

fn set_bytes<P>(row: &mut [u8], pixels: &[P], color: impl Fn(&P) -> Vector3) {
    let bytes = row.as_chunks_mut().0.iter_mut();
    bytes.zip(pixels).for_each(|(bytes, pixel)| *bytes = color(pixel).to_array().map(to_byte));
}

/// Returns clamp(trunc(255 c), 0, 255); NaN gives 0. There is no gamma.
pub fn to_byte(value: Real) -> u8 {
    // The cast truncates, saturates, and takes NaN to 0.
    (value * 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_truncated_and_saturate() {
        for (value, byte) in [
            (0.0, 0),
            (0.5, 127),
            (0.999, 254),
            (1.0, 255),
            (7.0, 255),
            (1e30, 255),
            (Real::INFINITY, 255),
            (-0.5, 0),
            (Real::NAN, 0),
        ] {
            assert_eq!(to_byte(value), byte, "{value}");
        }
    }

    #[test]
    fn pixels_land_in_their_place_in_every_plane() {
        let planes = Planes { color: true, depth: true, linear: true, ..Planes::default() };
        // Two columns of three in a part of a film, and this part below the first row of another.
        let mut part = Film::new(3, 2, planes);
        let mut columns = part.columns(1, 2);
        columns.set_colors(&[1u8, 2, 3, 4], |&n| Vector3::splat(Real::from(n) / 255.0));
        columns.set_depths(&[1u8, 2, 3, 4], |&n| Real::from(n) / 255.0);
        let mut film = Film::new(4, 3, planes);
        film.place(1, 1, &part);
        let expected = [0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 3, 4];
        assert_eq!(film.depth.unwrap(), expected);
        assert_eq!(film.color.unwrap(), expected.map(|byte| [byte; 3]).concat());
        assert_eq!(film.linear.unwrap(), expected.map(|byte| [byte as f32 / 255.0; 3]).concat());
        assert!(film.normals.is_none() && film.variances.is_none());
    }
}
