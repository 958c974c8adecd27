//! The place that a direction meets on the faces of a cube map, and the colour between the texels there.

use vecmath::{Real, Vector3};

/// 1/255 in two parts: the first lacks the lowest eight bits, so that its product with a byte is exact.
const SHARE_HIGH: Real = Real::from_bits((1.0 as Real / 255.0).to_bits() & !0xff);
const SHARE_LOW: Real = (1.0 - 255.0 * SHARE_HIGH) / 255.0;

/// Returns byte / 255 to the last bit, without a division. A product with 1/255 would differ in the last bit, which
/// truncation to bytes would show.
#[inline(always)]
fn share(byte: u8) -> Real {
    // By way of `i32`, from which processors convert.
    let byte = i32::from(byte) as Real;
    byte * SHARE_HIGH + byte * SHARE_LOW
}

/// Bytes behind the last texel, so that eight bytes can be read from every texel on.
pub(super) const PADDING: usize = 8;

/// The place of the cube map that a ray sees when it leaves the scene.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub face: u32,
    /// From 0 to 1, v from the bottom.
    pub u: Real,
    pub v: Real,
}

impl Place {
    /// Finds the place in a direction, which must be a unit vector. The orientation of each face is the starter's.
    /// There are no branches, so that loops over directions vectorise.
    #[inline(always)]
    pub fn of(d: Vector3) -> Self {
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        let x_wins = (x >= y) & (x >= z);
        let y_wins = !x_wins & (y >= z);
        let largest = if x_wins {
            d.x
        } else if y_wins {
            d.y
        } else {
            d.z
        };
        let across = if x_wins { d.z } else { d.x };
        let upward = if y_wins { d.z } else { d.y };
        let (u, v) = ((across / largest + 1.0) / 2.0, (upward / largest + 1.0) / 2.0);
        let is_positive = largest > 0.0;
        let axis = if x_wins {
            0
        } else if y_wins {
            2
        } else {
            4
        };
        let is_turned = if is_positive { !x_wins & !y_wins } else { y_wins };
        Self {
            face: axis + u32::from(!is_positive),
            u: if is_turned { 1.0 - u } else { u },
            v: if is_positive { v } else { 1.0 - v },
        }
    }
}

/// Where the four texels around a place lie in the bytes of a face.
#[derive(Clone, Copy)]
pub(crate) struct Spot {
    /// Offsets of the left texels of both rows.
    pub upper: u32,
    pub lower: u32,
    /// Bits from a left texel to its right neighbour: 0 at the border, where a texel is its own neighbour.
    pub step: u32,
    /// Weights of the right texels and of the lower texels.
    pub right: Real,
    pub below: Real,
}

impl Spot {
    /// Finds the spot of a place in a face of this size, without branches.
    #[inline(always)]
    pub fn of(place: &Place, (width, height): (i32, i32)) -> Self {
        let (x, y) = (place.u * width as Real, (1.0 - place.v) * height as Real);
        let ((column, left_of_x), (row, above_y)) = (floored(x), floored(y));
        let last = (width - 1, height - 1);
        // Of NaN nothing is known.
        let (left, upper) = (column.max(0).min(last.0), row.max(0).min(last.1));
        let lower = (upper + 1).min(last.1);
        Self {
            upper: 3 * (upper * width + left) as u32,
            lower: 3 * (lower * width + left) as u32,
            step: if left < last.0 { 24 } else { 0 },
            right: x - left_of_x,
            below: y - above_y,
        }
    }
}

/// Returns the largest whole number up to `x`, which is at least 0 and far below 2^31: as an integer and as it is. A
/// conversion of the language would look for numbers beyond the integers, and take three times as long.
#[inline(always)]
fn floored(x: Real) -> (i32, Real) {
    /// From here on all numbers are whole, and so are sums.
    const WHOLE: Real = 1.0 / Real::EPSILON;
    let nearest = x + WHOLE;
    let floor = if nearest - WHOLE > x { nearest - 1.0 } else { nearest };
    (floor.to_bits().wrapping_sub(WHOLE.to_bits()) as i32, floor - WHOLE)
}

/// Four texels, a byte for red, green and blue each, red lowest: upper left, upper right, lower left, lower right. What
/// stands above is of no interest.
#[derive(Clone, Copy, Default)]
pub(crate) struct Texels(pub [u32; 4]);

impl Texels {
    /// Reads the texels at a spot of a face; `None` from a face that could not be decoded.
    #[inline(always)]
    pub fn read(bytes: &[u8], spot: &Spot) -> Option<Self> {
        // Both texels of a row at once.
        let row = |offset: u32| {
            let (start, end) = (offset as usize, offset as usize + PADDING);
            let row = u64::from_le_bytes(*bytes.get(start..end)?.first_chunk()?);
            Some([row as u32, (row >> (spot.step % 64)) as u32])
        };
        let ([a, b], [c, d]) = (row(spot.upper)?, row(spot.lower)?);
        Some(Self([a, b, c, d]))
    }

    /// Interpolates bilinearly. Four equal texels give their own value to the bit, which v(1 - w) + vw would not.
    #[inline(always)]
    pub fn blend(self, right: Real, below: Real) -> Vector3 {
        let color =
            |texel: u32| Vector3::new(share(texel as u8), share((texel >> 8) as u8), share((texel >> 16) as u8));
        let between = |from: Vector3, to: Vector3, share: Real| from + (to - from) * share;
        let [upper_left, upper_right, lower_left, lower_right] = self.0.map(color);
        let upper = between(upper_left, upper_right, right);
        let lower = between(lower_left, lower_right, right);
        between(upper, lower, below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_quotients_to_the_bit() {
        for byte in 0..=255 {
            assert_eq!(share(byte), Real::from(byte) / 255.0, "{byte}");
        }
    }

    #[test]
    fn numbers_are_rounded_down() {
        for x in [0.0, 0.25, 0.5, 0.75, 1.0 - Real::EPSILON, 1.0, 1.5, 2.5, 4095.5, 65_535.75, 65_536.0] {
            assert_eq!(floored(x), (x as i32, x.floor()), "{x}");
        }
    }
}
