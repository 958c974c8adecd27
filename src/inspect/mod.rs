//! `-pixel`: the ray trees of single pixels. Pixels in, every step of [`trace_ray`] with its numbers out.
//!
//! [`recorder`] writes down what `trace_ray` does, so the numbers are those of the picture. [`names`] says which part of
//! the scene file each of them comes from. [`text`] is for people, [`json`] for programs.

mod json;
mod names;
mod numbers;
mod recorder;
mod text;

use crate::options::{Options, PixelPlace};
use crate::plan::Plan;
use crate::ray_counts::RayCounts;
use crate::render::{Pixel, RayMaker};
use crate::scene::{MeshFile, Places, Scene};
use crate::timing::Deadline;
use crate::trace::trace_ray;
use names::Names;
use recorder::{Path, Recorder};
use vecmath::{Real, Vector3};

/// How a pixel gets its colour.
#[derive(Debug)]
pub struct InspectedPixel {
    /// Column and row, from the upper left corner.
    pub pixel: (u32, u32),
    /// The value of the pixel; the film makes bytes of it. Depth and normal only count if there are pictures of them.
    pub shown: Pixel,
    pub samples: Vec<InspectedSample>,
    /// Index of the sample whose path is known.
    pub chosen: usize,
    pub path: Path,
}

/// One of the samples of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct InspectedSample {
    /// Where its ray goes through the picture, in pixels from the upper left corner.
    pub place: (Real, Real),
    pub color: Vector3,
}

/// Traces the pixels that `-pixel` names.
pub fn inspect(
    scene: &Scene,
    places: &Places,
    mesh_files: &[MeshFile],
    plan: &Plan,
    options: &Options,
) -> Vec<InspectedPixel> {
    let maker = RayMaker::new(options);
    let names = Names::new(scene, places, mesh_files);
    options.pixels.iter().map(|&wanted| inspect_pixel(wanted, &maker, &names, plan)).collect()
}

fn inspect_pixel(wanted: PixelPlace, maker: &RayMaker, names: &Names, plan: &Plan) -> InspectedPixel {
    let scene = names.scene;
    let mut places = Vec::new();
    maker.set_places(&[wanted.pixel()], &mut places);
    let distance = |&place: &(Real, Real)| {
        let (x, y) = maker.in_picture(place);
        (x - wanted.x as Real).hypot(y - wanted.y as Real)
    };
    let distances: Vec<Real> = places.iter().map(distance).collect();
    let nearest = |a: &usize, b: &usize| distances[*a].total_cmp(&distances[*b]);
    let chosen = (0..places.len()).min_by(nearest).unwrap_or_default();
    let mut recorder = Recorder::new(names);
    let mut seen = Vec::with_capacity(places.len());
    for (index, &place) in places.iter().enumerate() {
        let ray = scene.camera.ray(maker.grid.ndc(place));
        seen.extend(if index == chosen {
            trace_ray(scene, plan, ray, Deadline::NEVER, &mut recorder)
        } else {
            trace_ray(scene, plan, ray, Deadline::NEVER, &mut RayCounts::default())
        });
    }
    let sample = |(&place, color)| InspectedSample { place: maker.in_picture(place), color };
    InspectedPixel {
        pixel: wanted.pixel(),
        shown: maker.shown(&seen),
        samples: places.iter().zip(seen.iter().map(|seen| seen.color)).map(sample).collect(),
        chosen,
        path: recorder.finish(plan),
    }
}
