//! Sketches and star-shaped mountains of known shape.

use orograph_core::prelude::*;

use crate::test_fields::field;

/// A straight stroke between two places (x, y).
pub(super) type Stroke = [[f64; 2]; 2];

pub(super) const LAMBDA: [Stroke; 2] = [[[90.0, 60.0], [170.0, 200.0]], [[128.0, 128.0], [90.0, 200.0]]];

pub(super) const TREE: [Stroke; 5] = [
    [[40.0, 200.0], [80.0, 120.0]],
    [[80.0, 120.0], [150.0, 90.0]],
    [[150.0, 90.0], [220.0, 40.0]],
    [[150.0, 90.0], [200.0, 170.0]],
    [[80.0, 120.0], [60.0, 60.0]],
];

/// A polygon of 180 sides.
pub(super) fn circle(middle: f64, radius: f64) -> Vec<Stroke> {
    let at = |i: usize| {
        let angle = i as f64 * std::f64::consts::TAU / 180.0;
        [middle + radius * libm::cos(angle), middle + radius * libm::sin(angle)]
    };
    (0..180).map(|i| [at(i), at(i + 1)]).collect()
}

/// Distance from a place (x, y) to the nearest stroke.
pub(super) fn off(strokes: &[Stroke], x: f64, y: f64) -> f64 {
    let one = |[a, b]: &Stroke| {
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let t = (((x - a[0]) * along[0] + (y - a[1]) * along[1]) / square).clamp(0.0, 1.0);
        libm::hypot(x - a[0] - t * along[0], y - a[1] - t * along[1])
    };
    strokes.iter().map(one).fold(f64::INFINITY, f64::min)
}

/// White strokes on black.
pub(super) fn drawn(strokes: &[Stroke], side: usize, width: f64) -> Heightfield {
    field(side, side, |row, col| f64::from(u8::from(off(strokes, col as f64, row as f64) <= width / 2.0)))
}

/// A summit in the middle of 129 × 129 cells from which `arms` ridges run down to the border.
pub(super) fn star(arms: usize, turn: f64) -> Heightfield {
    let strokes: Vec<Stroke> = (0..arms).map(|arm| arm_of(arms, turn, arm)).collect();
    field(129, 129, |row, col| {
        let (x, y) = (col as f64, row as f64);
        100.0 - 0.25 * libm::hypot(x - 64.0, y - 64.0) - 0.6 * off(&strokes, x, y)
    })
}

/// One arm of [`star`], well beyond the border.
pub(super) fn arm_of(arms: usize, turn: f64, arm: usize) -> Stroke {
    let angle = turn + std::f64::consts::TAU * arm as f64 / arms as f64;
    [[64.0, 64.0], [64.0 + 1000.0 * libm::cos(angle), 64.0 + 1000.0 * libm::sin(angle)]]
}
