//! [`EmptyTiles`]: tiles through which nothing but a background of one colour can be seen.
//!
//! A ray that does not enter the box around an object does not hit it, by definition. So a tile that no box reaches needs
//! one sample a pixel, which is exact, and not sixteen.

use super::rays::RayMaker;
use super::tiles::Tile;
use super::tracer::Tracer;
use crate::camera::{PixelGrid, Place};
use crate::objects::Object;
use crate::options::Options;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::trace::Seen;
use vecmath::Real;

/// Objects up to which boxes are looked at one by one.
const MOST_OBJECTS: usize = 4096;
/// Pixels by which boxes are larger in the picture, for the rounding of their places.
const MARGIN: Real = 0.1;

/// Rectangles of the traced grid that may show an object.
pub struct EmptyTiles<'a> {
    /// `None`: an object may show anywhere.
    boxes: Option<Vec<[Place; 2]>>,
    maker: &'a RayMaker,
}

impl<'a> EmptyTiles<'a> {
    /// Projects the boxes of all objects. No tile is empty if a pixel has one sample anyway, or if the background is
    /// not of one colour.
    pub fn new(scene: &Scene, plan: &Plan, options: &Options, maker: &'a RayMaker) -> Self {
        let objects = &scene.geometry.objects;
        let has_one_color = !(plan.color && scene.background.cube_map.is_some());
        let is_useful = options.jitter || options.filter;
        let boxes = (has_one_color && is_useful && objects.len() <= MOST_OBJECTS).then(|| {
            let box_of = |object: &_| projected(scene, object, maker.grid);
            objects.iter().map(box_of).collect::<Option<Vec<_>>>()
        });
        Self { boxes: boxes.flatten(), maker }
    }

    /// Returns whether every ray through a tile sees the background.
    pub fn contain(&self, tile: &Tile) -> bool {
        let Some(boxes) = &self.boxes else { return false };
        let (left, top) = self.maker.corner((tile.x, tile.row));
        let (right, bottom) = self.maker.corner((tile.x + tile.width, tile.row + tile.height));
        boxes.iter().all(|[low, high]| high.0 < left || low.0 > right || high.1 < bottom || low.1 > top)
    }

    /// Returns what every ray through an empty tile sees. One ray is traced.
    pub fn seen_through(&self, tile: &Tile, tracer: &mut dyn Tracer) -> Seen {
        let mut seen = Vec::new();
        tracer.trace(self.maker.grid, &[self.maker.corner((tile.x, tile.row))], &mut seen);
        debug_assert!(seen[0].depth.is_none(), "it is empty");
        seen[0]
    }
}

/// Returns the rectangle of places that the box around an object covers, as its lower left and upper right corner. `None`
/// if it may cover anything.
fn projected(scene: &Scene, object: &Object, grid: PixelGrid) -> Option<[Place; 2]> {
    let bounds = object.bounds?;
    let bounds = bounds.grown(object.sideways_error * scene.camera.center.max_abs());
    let (mut low, mut high) = ((Real::INFINITY, Real::INFINITY), (Real::NEG_INFINITY, Real::NEG_INFINITY));
    for corner in bounds.corners() {
        let (x, y) = grid.place_of(scene.camera.ndc_of(corner)?)?;
        low = (low.0.min(x - MARGIN), low.1.min(y - MARGIN));
        high = (high.0.max(x + MARGIN), high.1.max(y + MARGIN));
    }
    [low.0, low.1, high.0, high.1].iter().all(|place| place.is_finite()).then_some([low, high])
}
