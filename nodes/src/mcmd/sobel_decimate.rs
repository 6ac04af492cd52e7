//! Decimation by edges: the cells where a terrain changes most (Belhadj 2007, the SRTM example).
//!
//! The magnitude is that of the 3 × 3 Sobel operator over metres, so that cells need not be square. Beyond the border
//! the border cell repeats, and a void counts as the height at the operator's centre. Departure: border cells may be
//! kept at a step, so that the reconstruction has an edge to hold on to.

use orograph_core::prelude::*;

use crate::mcmd::selection::keep_least;

/// Keeps the measured cells where the terrain is steepest and makes voids of the others.
///
/// Ties are kept in row-major order. Kept cells keep their heights to the bit.
#[derive(Params, Clone, Debug)]
pub struct SobelDecimate {
    /// Share of the measured cells that is kept for their steepness, rounded up to a whole cell.
    #[param(default = 0.1, range = 0.0..=1.0, slider = 0.005..=0.3, unit = "1")]
    pub keep: f64,
    /// Keeps the four corners besides.
    #[param(default = true)]
    pub corners: bool,
    /// Keeps every so many cells along the border besides; 0 keeps none.
    #[param(default = 0u32, range = 0..=100_000, slider = 0..=64, unit = "cells")]
    pub border_step: u32,
}

/// Inputs of [`SobelDecimate`].
#[derive(Inputs)]
pub struct SobelDecimateIn<'a> {
    /// Terrain to thin out.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`SobelDecimate`].
#[derive(Outputs)]
pub struct SobelDecimateOut {
    /// The cells kept; all others are voids.
    pub constraints: Heightfield,
}

impl Node for SobelDecimate {
    const ID: &'static str = "mcmd.sobel_decimate";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = SobelDecimateIn<'a>;
    type Outputs = SobelDecimateOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn run(&self, inputs: SobelDecimateIn<'_>, job: &Job) -> Result<SobelDecimateOut> {
        let terrain = inputs.terrain;
        let (rows, cols) = terrain.grid().size();
        let mut steepness = Heightfield::filled(terrain.grid().clone(), 0.0, job)?;
        if !terrain.grid().is_empty() {
            steepness = Heightfield::build(terrain.grid().clone(), job, |row, out| {
                steepness_of_row(terrain, row, out);
                Ok(())
            })?;
        }
        // Bits of a non-negative float order as the float does; the steepest come first.
        let rank = |row: usize, col: usize| u64::from(!steepness.at(row, col).to_bits()) << 32;
        let always = |row: usize, col: usize| {
            let (last_row, last_col) = (rows - 1, cols - 1);
            let on = |i: usize, last: usize| i == 0 || i == last;
            let corner = on(row, last_row) && on(col, last_col);
            let step = self.border_step as usize;
            let beat = step > 0
                && ((on(row, last_row) && col.is_multiple_of(step))
                    || (on(col, last_col) && row.is_multiple_of(step)));
            (self.corners && corner) || beat
        };
        let constraints = keep_least(terrain, self.keep, rank, always, job)?;
        Ok(SobelDecimateOut { constraints })
    }
}

/// Sobel magnitude in metres per metre, times eight; 0 at voids, which are never kept.
fn steepness_of_row(terrain: &Heightfield, row: usize, out: &mut [f32]) {
    let (rows, cols) = terrain.grid().size();
    let cell = terrain.grid().cell;
    let (above, below) = (row.saturating_sub(1), (row + 1).min(rows - 1));
    let (north, here, south) = (terrain.row(above), terrain.row(row), terrain.row(below));
    for (col, out) in out.iter_mut().enumerate() {
        let (west, east) = (col.saturating_sub(1), (col + 1).min(cols - 1));
        let centre = here[col];
        if centre.is_nan() {
            *out = 0.0;
            continue;
        }
        let of = |height: f32| f64::from(if height.is_nan() { centre } else { height });
        let [nw, n, ne] = [west, col, east].map(|col| of(north[col]));
        let [w, e] = [west, east].map(|col| of(here[col]));
        let [sw, s, se] = [west, col, east].map(|col| of(south[col]));
        let along = ((ne + 2.0 * e + se) - (nw + 2.0 * w + sw)) / cell.x;
        let down = ((sw + 2.0 * s + se) - (nw + 2.0 * n + ne)) / cell.y;
        *out = (along * along + down * down).sqrt() as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn kept(node: &SobelDecimate, terrain: &Heightfield) -> Vec<(usize, usize)> {
        let out = node.run(SobelDecimateIn { terrain }, &Job::detached()).unwrap().constraints;
        let cols = terrain.cols();
        let known = |i: &usize| !out.cells()[*i].is_nan();
        (0..out.cells().len()).filter(known).map(|i| (i / cols, i % cols)).collect()
    }

    #[test]
    fn a_cliff_is_kept_and_flat_ground_is_not() {
        // A step between columns 4 and 5: both columns see it.
        let cliff = field(10, 10, |_, col| if col < 5 { 0.0 } else { 100.0 });
        let node = SobelDecimate { keep: 0.2, corners: false, border_step: 0 };
        let expected: Vec<_> = (0..10).flat_map(|row| [(row, 4), (row, 5)]).collect();
        assert_eq!(kept(&node, &cliff), expected);
    }

    #[test]
    fn ties_corners_and_the_border_come_as_promised_and_voids_never() {
        let mut flat = field(5, 6, |_, _| 3.0);
        let node = SobelDecimate { keep: 0.1, corners: false, border_step: 0 };
        assert_eq!(kept(&node, &flat), [(0, 0), (0, 1), (0, 2)]);
        let node = SobelDecimate { keep: 0.0, corners: true, border_step: 0 };
        assert_eq!(kept(&node, &flat), [(0, 0), (0, 5), (4, 0), (4, 5)]);
        let node = SobelDecimate { keep: 0.0, corners: false, border_step: 4 };
        assert_eq!(kept(&node, &flat), [(0, 0), (0, 4), (0, 5), (4, 0), (4, 4), (4, 5)]);
        flat.cells_mut()[0] = f32::NAN;
        let node = SobelDecimate { keep: 1.0, corners: true, border_step: 1 };
        assert_eq!(kept(&node, &flat).len(), 29);
    }

    #[test]
    fn tiny_and_void_terrains_pass() {
        let node = SobelDecimate::default();
        assert_eq!(kept(&node, &field(0, 0, |_, _| 0.0)), []);
        assert_eq!(kept(&node, &field(1, 1, |_, _| 5.0)), [(0, 0)]);
        assert_eq!(kept(&node, &field(3, 3, |_, _| f64::NAN)), []);
    }
}
