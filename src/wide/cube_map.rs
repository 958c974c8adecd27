//! Look-ups of a packet in a cube map: [`CubeMap::color`] for many directions at once.

use crate::cube_map::{CubeMap, Place, Spot, Texels};
use crate::simd::packet::{PACKET, Scalars, Vectors, lanes_in, span};
use crate::simd::{Simd, vectorize};

/// A whole number for each lane.
type Integers = [u32; PACKET];

/// Scratch of look-ups.
pub struct CubeMapScratch {
    directions: Vectors,
    places: Places,
    spots: Spots,
    texels: [Integers; 4],
    colors: Vectors,
}

/// A [`Place`] for each lane.
struct Places {
    face: Integers,
    u: Scalars,
    v: Scalars,
}

/// A [`Spot`] for each lane.
struct Spots {
    upper: Integers,
    lower: Integers,
    step: Integers,
    right: Scalars,
    below: Scalars,
}

impl CubeMapScratch {
    pub const EMPTY: Self = Self {
        directions: Vectors::ZERO,
        places: Places { face: [0; PACKET], u: [0.0; PACKET], v: [0.0; PACKET] },
        spots: Spots {
            upper: [0; PACKET],
            lower: [0; PACKET],
            step: [0; PACKET],
            right: [0.0; PACKET],
            below: [0.0; PACKET],
        },
        texels: [[0; PACKET]; 4],
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
    let CubeMapScratch { directions, places, spots, texels, colors } = scratch;
    find_places(simd, directions, active, places);
    match cube_map.common_size() {
        Some(size) => find_spots(
            simd,
            places,
            #[inline(always)]
            |_| size,
            active,
            spots,
        ),
        None => find_spots(simd, places, |face| cube_map.size(face), active, spots),
    }
    // The bytes of the faces that have been met, or of their upper halves; eight, because a remainder by eight is quick.
    let mut faces: [&[u8]; 8] = [&[]; 8];
    for lane in lanes_in(active) {
        let (face, spot) = (places.face[lane], spots.get(lane));
        let bytes = &mut faces[face as usize % 8];
        let Texels(found) = Texels::read(bytes, &spot).unwrap_or_else(|| {
            *bytes = cube_map.bytes(face, &spot);
            Texels::read(bytes, &spot).unwrap_or_default()
        });
        for (texels, found) in texels.iter_mut().zip(found) {
            texels[lane] = found;
        }
    }
    blend(simd, texels, [&spots.right, &spots.below], active, colors);
    colors
}

fn find_places<S: Simd>(simd: S, directions: &mut Vectors, active: u64, places: &mut Places) {
    vectorize!(simd, {
        directions.normalize(active);
        for lane in span(active) {
            places.set(lane, Place::of(directions.get(lane)));
        }
    });
}

fn find_spots<S: Simd>(
    simd: S,
    places: &Places,
    size: impl Fn(u32) -> (i32, i32),
    active: u64,
    spots: &mut Spots,
) {
    vectorize!(simd, {
        for lane in span(active) {
            spots.set(lane, Spot::of(&places.get(lane), size(places.face[lane])));
        }
    });
}

fn blend<S: Simd>(
    simd: S,
    [a, b, c, d]: &[Integers; 4],
    [right, below]: [&Scalars; 2],
    active: u64,
    colors: &mut Vectors,
) {
    vectorize!(simd, {
        for lane in span(active) {
            let texels = Texels([a[lane], b[lane], c[lane], d[lane]]);
            colors.set(lane, texels.blend(right[lane], below[lane]));
        }
    });
}

impl Places {
    #[inline(always)]
    fn get(&self, lane: usize) -> Place {
        Place { face: self.face[lane], u: self.u[lane], v: self.v[lane] }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, place: Place) {
        (self.face[lane], self.u[lane], self.v[lane]) = (place.face, place.u, place.v);
    }
}

impl Spots {
    #[inline(always)]
    fn get(&self, lane: usize) -> Spot {
        Spot {
            upper: self.upper[lane],
            lower: self.lower[lane],
            step: self.step[lane],
            right: self.right[lane],
            below: self.below[lane],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, spot: Spot) {
        (self.upper[lane], self.lower[lane], self.step[lane]) = (spot.upper, spot.lower, spot.step);
        (self.right[lane], self.below[lane]) = (spot.right, spot.below);
    }
}
