//! Numbers as people read them.

use vecmath::{Real, Vector3};

/// Returns a number with six digits at most.
pub fn short(number: Real) -> String {
    if !number.is_finite() {
        return number.to_string();
    }
    let scientific = format!("{number:.5e}");
    // Parsed again, so that no zeros stand at its end; the sum makes a zero of minus zero.
    let rounded = scientific.parse::<f64>().unwrap_or(number.into()) + 0.0;
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// Returns three numbers with a space between them.
pub fn short3(vector: Vector3) -> String {
    vector.to_array().map(short).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, -0.0, 1.0, 1.0 / 3.0, -123.456_789, 1e-5, 2.5e9, Real::INFINITY].map(short);
        assert_eq!(shown, ["0", "0", "1", "0.333333", "-123.457", "1e-5", "2.5e9", "inf"]);
        assert_eq!(short3(Vector3::new(1.0, 0.25, -2.0)), "1 0.25 -2");
    }
}
