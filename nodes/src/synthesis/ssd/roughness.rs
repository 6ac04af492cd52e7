//! How rough the windows of an exemplar are, beside the whole of it.

use orograph_core::Heightfield;
use rayon::prelude::*;

/// Share of the usual roughness below which windows are all alike.
const LEAST: f64 = 0.1;

/// Sums of the steps between neighbouring cells over rectangles of coarse cells.
pub(super) struct Roughness {
    cols: usize,
    sums: Vec<f64>,
    /// The mean of a coarse cell.
    usual: f64,
}

impl Roughness {
    /// Of `rows` × `cols` coarse cells, each `factor` cells wide.
    pub(super) fn new(terrain: &Heightfield, factor: usize, rows: usize, cols: usize) -> Self {
        let mut cells = vec![0.0; rows * cols];
        cells.par_chunks_mut(cols.max(1)).enumerate().for_each(|(row, cells)| {
            for line in row * factor..(row + 1) * factor {
                let own = terrain.row(line);
                let below = terrain.row((line + 1).min(terrain.rows() - 1));
                for (col, cell) in cells.iter_mut().enumerate() {
                    for at in col * factor..(col + 1) * factor {
                        let east = own[(at + 1).min(own.len() - 1)];
                        // Steps to voids count as none.
                        let step = |to: f32| f64::from((to - own[at]).abs().max(0.0));
                        *cell += step(east) + step(below[at]);
                    }
                }
            }
        });
        let mut sums = vec![0.0; (rows + 1) * (cols + 1)];
        for row in 0..rows {
            let mut along = 0.0;
            for col in 0..cols {
                along += cells[row * cols + col];
                sums[(row + 1) * (cols + 1) + col + 1] = sums[row * (cols + 1) + col + 1] + along;
            }
        }
        let usual = sums[sums.len() - 1] / ((rows * cols) as f64).max(1.0);
        Self { cols: cols + 1, sums, usual }
    }

    /// What a mean square of differences is multiplied by for the window of `h` × `w` coarse cells from (`row`, `col`):
    /// those of unlike ground grow with the square of its roughness.
    pub(super) fn weight(&self, row: usize, col: usize, h: usize, w: usize) -> f64 {
        let at = |row: usize, col: usize| self.sums[row * self.cols + col];
        let sum = at(row + h, col + w) - at(row, col + w) - at(row + h, col) + at(row, col);
        let share = sum / (self.usual * (h * w) as f64);
        // Level ground has no usual roughness; NaN becomes 1.
        let share = share.clamp(LEAST, 1.0);
        if share.is_nan() { 1.0 } else { 1.0 / (share * share) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn windows_weigh_by_the_square_of_what_they_are_smoother_by() {
        // Steps of 1 m in the west, 3 m in the middle and none in the east; 2 m down from each row, so 3, 5 and 2 m a cell.
        let terrain = field(60, 90, |row, col| {
            let across = if col < 30 { col as f64 } else { 30.0 + 3.0 * (col.min(60) - 30) as f64 };
            across + 2.0 * row as f64
        });
        for factor in [1, 2, 3] {
            let roughness = Roughness::new(&terrain, factor, 60 / factor, 90 / factor);
            let weight = |col: usize| roughness.weight(0, col / factor, 12 / factor, 12 / factor);
            // The last row has none below it.
            let usual = (30.0 * (1.0 + 3.0) / 90.0) + 2.0 * 59.0 / 60.0;
            let expected = |rough: f64| {
                let share = f64::max(usual / rough, 1.0);
                share * share
            };
            for (col, rough) in [(6, 3.0), (36, 5.0), (66, 2.0)] {
                assert!((weight(col) - expected(rough)).abs() < 1e-9, "{factor} {col}: {}", weight(col));
            }
        }
        assert_eq!(Roughness::new(&field(9, 9, |_, _| 4.0), 1, 9, 9).weight(0, 0, 5, 5), 1.0);
    }
}
