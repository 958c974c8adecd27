//! Camera rays of a packet: [`Camera::ray`] for many places at once.

use crate::camera::{Camera, PixelGrid, Place};
use crate::simd::packet::{PACKET, RayPacket, first_lanes, span};
use crate::simd::{Simd, vectorize};

/// Makes the rays through at most 64 places. Returns their lanes.
pub fn camera_rays<S: Simd>(
    simd: S,
    camera: &Camera,
    grid: PixelGrid,
    places: &[Place],
    rays: &mut RayPacket,
) -> u64 {
    let active = first_lanes(places.len());
    vectorize!(simd, {
        let (mut x, mut y) = ([0.0; PACKET], [0.0; PACKET]);
        for ((x, y), place) in x.iter_mut().zip(&mut y).zip(places) {
            (*x, *y) = *place;
        }
        for lane in span(active) {
            rays.origin.set(lane, camera.center);
            rays.direction.set(lane, camera.direction(grid.ndc((x[lane], y[lane]))));
        }
        rays.direction.normalize(active);
    });
    active
}
