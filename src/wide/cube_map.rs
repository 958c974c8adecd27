//! Look-ups of a packet in a cube map: [`CubeMap::color`] for many directions at once.

use crate::cube_map::{CubeMap, Place, Texels};
use crate::simd::packet::{PACKET, Scalars, Vectors, lanes_in, span};
use crate::simd::{Simd, vectorize};

/// Scratch of look-ups.
pub struct CubeMapScratch {
    directions: Vectors,
    face: [u64; PACKET],
    u: Scalars,
    v: Scalars,
    texels: [Vectors; 4],
    colors: Vectors,
}

impl CubeMapScratch {
    pub const EMPTY: Self = Self {
        directions: Vectors::ZERO,
        face: [0; PACKET],
        u: [0.0; PACKET],
        v: [0.0; PACKET],
        texels: [Vectors::ZERO; 4],
        colors: Vectors::ZERO,
    };
}

/// Returns the colours in the directions of the active lanes.
pub fn colors<'a, S: Simd>(
    simd: S,
    cube_map: &CubeMap,
    directions: &Vectors,
    active: u64,
    scratch: &'a mut CubeMapScratch,
) -> &'a Vectors {
    scratch.directions = *directions;
    find_places(simd, active, scratch);
    let CubeMapScratch { face, u, v, texels, colors, .. } = scratch;
    for lane in lanes_in(active) {
        let found = cube_map.texels(&Place { face: face[lane] as usize, u: u[lane], v: v[lane] });
        for (texels, found) in texels.iter_mut().zip(found.texels) {
            texels.set(lane, found);
        }
        // The places are of no more use.
        (u[lane], v[lane]) = (found.right, found.below);
    }
    blend(simd, texels, u, v, active, colors);
    colors
}

fn find_places<S: Simd>(simd: S, active: u64, scratch: &mut CubeMapScratch) {
    let CubeMapScratch { directions, face, u, v, .. } = scratch;
    vectorize!(simd, {
        directions.normalize(active);
        for lane in span(active) {
            let place = Place::of(directions.get(lane));
            face[lane] = place.face as u64;
            (u[lane], v[lane]) = (place.u, place.v);
        }
    });
}

fn blend<S: Simd>(
    simd: S,
    [a, b, c, d]: &[Vectors; 4],
    right: &Scalars,
    below: &Scalars,
    active: u64,
    colors: &mut Vectors,
) {
    vectorize!(simd, {
        for lane in span(active) {
            let texels = [a.get(lane), b.get(lane), c.get(lane), d.get(lane)];
            colors.set(lane, Texels { texels, right: right[lane], below: below[lane] }.blend());
        }
    });
}
