//! Heights between cells.

use orograph_core::prelude::*;

/// How a height between cells follows from those around it.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The nearest cell's height: measured heights pass unchanged, in steps.
    Nearest,
    /// Straight between the four cells around.
    Bilinear,
    /// A Catmull-Rom spline through the sixteen cells around: smooth, and sharper than bilinear.
    Cubic,
}

/// The first of up to four neighbouring cells along an axis, and their weights.
struct Taps {
    first: i64,
    weights: [f64; 4],
    n: usize,
}

fn taps(at: f64, method: Interpolation) -> Taps {
    let below = at.floor();
    let (t, first) = (at - below, below as i64);
    match method {
        Interpolation::Nearest => {
            Taps { first: first + i64::from(t >= 0.5), weights: [1.0, 0.0, 0.0, 0.0], n: 1 }
        }
        Interpolation::Bilinear => Taps { first, weights: [1.0 - t, t, 0.0, 0.0], n: 2 },
        Interpolation::Cubic => Taps { first: first - 1, weights: catmull_rom(t), n: 4 },
    }
}

/// The Catmull–Rom weights of the four cells around a fraction `t` past the second.
pub(crate) fn catmull_rom(t: f64) -> [f64; 4] {
    [
        t * (t * (2.0 - t) - 1.0) / 2.0,
        (t * t * (3.0 * t - 5.0) + 2.0) / 2.0,
        t * (t * (4.0 - 3.0 * t) + 1.0) / 2.0,
        t * t * (t - 1.0) / 2.0,
    ]
}

/// The height at a fractional (row, column); border cells go on for half a cell, and beyond lies nothing.
///
/// A void where the nearest cell is one. With a void further off among the cells needed, the known ones'
/// bilinear weights are scaled up to make one.
#[must_use]
pub fn sample(terrain: &Heightfield, row: f64, col: f64, method: Interpolation) -> f32 {
    let (rows, cols) = terrain.grid().size();
    // Written so that NaN is outside. The slack takes up the rounding of positions at the very edge.
    let inside = |at: f64, n: usize| at >= -0.5 - 1e-9 && at <= n as f64 - 0.5 + 1e-9;
    if rows == 0 || cols == 0 || !inside(row, rows) || !inside(col, cols) {
        return f32::NAN;
    }
    let at = |row: i64, col: i64| {
        terrain.at(row.clamp(0, rows as i64 - 1) as usize, col.clamp(0, cols as i64 - 1) as usize)
    };
    let nearest = at((row + 0.5).floor() as i64, (col + 0.5).floor() as i64);
    if nearest.is_nan() || method == Interpolation::Nearest {
        return nearest;
    }
    let weigh = |method| {
        let (down, across) = (taps(row, method), taps(col, method));
        let (mut sum, mut known) = (0.0, 0.0);
        let mut voids = false;
        for i in 0..down.n {
            for j in 0..across.n {
                let weight = down.weights[i] * across.weights[j];
                let height = at(down.first + i as i64, across.first + j as i64);
                if height.is_nan() {
                    voids |= weight != 0.0;
                } else {
                    sum += weight * f64::from(height);
                    known += weight;
                }
            }
        }
        (sum, known, voids)
    };
    let (mut sum, mut known, voids) = weigh(method);
    if voids && method == Interpolation::Cubic {
        // Its negative weights must not be scaled up.
        (sum, known, _) = weigh(Interpolation::Bilinear);
    }
    (if voids { sum / known } else { sum }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn a_plane_is_met_exactly_and_a_parabola_by_the_spline() {
        let plane = field(8, 8, |row, col| 3.0 * row as f64 - 2.0 * col as f64);
        let parabola = field(8, 8, |_, col| (col * col) as f64);
        for (row, col) in [(2.0, 3.0), (2.3, 3.7), (4.5, 1.25), (1.01, 5.99)] {
            for method in [Interpolation::Bilinear, Interpolation::Cubic] {
                let height = f64::from(sample(&plane, row, col, method));
                assert!((height - (3.0 * row - 2.0 * col)).abs() < 1e-5, "{method:?}");
            }
            let height = f64::from(sample(&parabola, row, col, Interpolation::Cubic));
            assert!((height - col * col).abs() < 1e-5);
        }
        assert_eq!(sample(&plane, 2.4, 3.6, Interpolation::Nearest), plane.at(2, 4));
    }

    #[test]
    fn voids_spread_no_further_than_their_own_half_cell() {
        let terrain = field(5, 5, |row, col| if (row, col) == (2, 2) { f64::NAN } else { 7.0 });
        for method in [Interpolation::Nearest, Interpolation::Bilinear, Interpolation::Cubic] {
            assert!(sample(&terrain, 2.4, 1.6, method).is_nan());
            assert!((sample(&terrain, 2.6, 2.0, method) - 7.0).abs() < 1e-6);
            assert!(sample(&terrain, -0.6, 0.0, method).is_nan());
            assert!((sample(&terrain, -0.5, 4.5, method) - 7.0).abs() < 1e-6);
            assert!(sample(&terrain, f64::NAN, 0.0, method).is_nan());
        }
    }
}
