//! [`EmptyTiles`]: tiles through which nothing but a background of one colour can be seen.
//!
//! A ray that does not enter the box around an object does not hit it, by definition. So a tile that no box reaches needs
//! one sample a pixel, which is exact, and not sixteen.

use super::tiles::Tile;
use crate::camera::PixelGrid;
use crate::objects::Object;
use crate::options::Options;
use crate::plan::Plan;
use crate::scene::Scene;
use vecmath::{Real, Vector3};

/// Objects up to which boxes are looked at one by one.
const MOST_OBJECTS: usize = 4096;
/// Pixels by which boxes are larger in the picture, for the rounding of their places.
const MARGIN: Real = 0.1;

/// Rectangles of pixels of the traced grid that may show an object; places are counted as [`PixelGrid::place`] does.
pub struct EmptyTiles {
    /// `None`: an object may show anywhere.
    boxes: Option<Vec<[Real; 4]>>,
    grid: PixelGrid,
    is_filtered: bool,
}

impl EmptyTiles {
    /// Projects the boxes of all objects. No tile is empty if a pixel has one sample anyway, or if the background is
    /// not of one colour.
    pub fn new(scene: &Scene, plan: &Plan, options: &Options, grid: PixelGrid) -> Self {
        let objects = &scene.geometry.objects;
        let has_one_color = !(plan.color && scene.background.cube_map.is_some());
        let is_useful = options.jitter || options.filter;
        let boxes = (has_one_color && is_useful && objects.len() <= MOST_OBJECTS).then(|| {
            let box_of = |object: &_| projected(scene, object, grid);
            objects.iter().map(box_of).collect::<Option<Vec<_>>>()
        });
        Self { boxes: boxes.flatten(), grid, is_filtered: options.filter }
    }

    /// Returns whether every ray through a tile sees the background.
    pub fn contain(&self, tile: &Tile) -> bool {
        let Some(boxes) = &self.boxes else { return false };
        let finer = if self.is_filtered { 3 } else { 1 };
        let left = (finer * tile.x) as Real;
        let top = (self.grid.height - finer * tile.row) as Real;
        let (right, bottom) = (left + (finer * tile.width) as Real, top - (finer * tile.height) as Real);
        boxes
            .iter()
            .all(|[min_x, max_x, min_y, max_y]| *max_x < left || *min_x > right || *max_y < bottom || *min_y > top)
    }
}

/// Returns the rectangle of places that the box around an object covers: least and largest x, least and largest y.
/// `None` if it may cover anything.
fn projected(scene: &Scene, object: &Object, grid: PixelGrid) -> Option<[Real; 4]> {
    // A grid one pixel wide looks along its middle, wherever a sample lies.
    let place = |ndc: Real, count: u32| (count > 1).then(|| (ndc + 1.0) * 0.5 * (count - 1) as Real);
    let bounds = object.bounds?;
    let bounds = bounds.grown(object.sideways_error * scene.camera.center.max_abs());
    let mut found = [Real::INFINITY, Real::NEG_INFINITY, Real::INFINITY, Real::NEG_INFINITY];
    for corner in 0..8 {
        let side = |axis: usize| if corner >> axis & 1 == 0 { bounds.min } else { bounds.max };
        let ndc = scene.camera.ndc_of(Vector3::new(side(0).x, side(1).y, side(2).z))?;
        let (x, y) = (place(ndc.0, grid.width)?, place(ndc.1, grid.height)?);
        found = [found[0].min(x), found[1].max(x), found[2].min(y), found[3].max(y)];
    }
    let grown = [found[0] - MARGIN, found[1] + MARGIN, found[2] - MARGIN, found[3] + MARGIN];
    grown.iter().all(|place| place.is_finite()).then_some(grown)
}
