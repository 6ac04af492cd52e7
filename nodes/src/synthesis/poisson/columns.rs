//! The columns of a rectangle whose rows were transformed: one tridiagonal system for each wave number, solved directly.

use orograph_core::prelude::*;
use rayon::prelude::*;

/// Wave numbers that are eliminated together.
const BLOCK: usize = 32;

/// The solutions, block of wave numbers by block; within one row by row.
pub(super) struct Columns {
    blocks: Vec<Vec<f64>>,
}

impl Columns {
    /// Solves `(across(k) + down(row)) u[row] - u[row - 1] - u[row + 1] = waves[row]` for each of `cols` wave numbers k,
    /// without the terms outside. The diagonals must dominate.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn solve(
        cols: usize,
        waves: &[f64],
        across: impl Fn(usize) -> f64 + Sync,
        down: impl Fn(usize) -> f64 + Sync,
        job: &Job<'_>,
    ) -> Result<Self> {
        let blocks = (0..cols).into_par_iter().step_by(BLOCK).map(|first| {
            job.check()?;
            let across: Vec<f64> = (first..(first + BLOCK).min(cols)).map(&across).collect();
            Ok(eliminate(first, cols, waves, &across, &down))
        });
        Ok(Self { blocks: blocks.collect::<Result<_>>()? })
    }

    /// Writes one row of the solutions.
    pub(super) fn row(&self, row: usize, out: &mut [f64]) {
        for (out, block) in out.chunks_mut(BLOCK).zip(&self.blocks) {
            let width = out.len();
            out.copy_from_slice(&block[row * width..][..width]);
        }
    }
}

/// The systems of the wave numbers from `first` on; row by row, one number each.
fn eliminate(
    first: usize,
    cols: usize,
    waves: &[f64],
    across: &[f64],
    down: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let (rows, width) = (waves.len() / cols, across.len());
    let mut factors = vec![0.0; rows * width];
    let mut out = vec![0.0; rows * width];
    let (mut factor, mut value) = (vec![0.0; width], vec![0.0; width]);
    for row in 0..rows {
        let down = down(row);
        let waves = &waves[row * cols + first..][..width];
        let (factors, out) = (&mut factors[row * width..][..width], &mut out[row * width..][..width]);
        for k in 0..width {
            factor[k] = 1.0 / (across[k] + down - factor[k]);
            value[k] = (waves[k] + value[k]) * factor[k];
            (factors[k], out[k]) = (factor[k], value[k]);
        }
    }
    for row in (0..rows.saturating_sub(1)).rev() {
        let factors = &factors[row * width..][..width];
        let out = &mut out[row * width..][..width];
        for k in 0..width {
            value[k] = out[k] + factors[k] * value[k];
            out[k] = value[k];
        }
    }
    out
}
