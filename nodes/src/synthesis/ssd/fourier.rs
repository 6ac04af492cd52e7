//! Two-dimensional Fourier transforms whose spectra lie transposed, which spares a pass.

use std::sync::Arc;

use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

/// Transforms of one size.
pub(super) struct Plane {
    pub(super) rows: usize,
    pub(super) cols: usize,
    along: [Arc<dyn Fft<f64>>; 2],
    down: [Arc<dyn Fft<f64>>; 2],
}

/// The least product of twos, threes and fives that is not less.
pub(super) fn smooth_size(n: usize) -> usize {
    let is_smooth = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    (n.max(1)..).find(|&n| is_smooth(n)).unwrap_or(n)
}

/// Rows that are handled together when a matrix is turned.
const TILE: usize = 32;

impl Plane {
    pub(super) fn new(rows: usize, cols: usize) -> Self {
        let mut planner = FftPlanner::new();
        let mut both = |n: usize| [planner.plan_fft_forward(n), planner.plan_fft_inverse(n)];
        Self { rows, cols, along: both(cols), down: both(rows) }
    }

    /// The spectrum, `cols` rows of `rows` wave numbers, of a field whose rows beyond those given are zero.
    pub(super) fn forward(&self, mut field: Vec<Complex64>) -> Vec<Complex64> {
        run(&*self.along[0], &mut field);
        let mut turned = turn(&field, self.cols, self.rows);
        run(&*self.down[0], &mut turned);
        turned
    }

    /// The first `wanted` rows of the field of a spectrum.
    pub(super) fn inverse(&self, mut spectrum: Vec<Complex64>, wanted: usize) -> Vec<Complex64> {
        run(&*self.down[1], &mut spectrum);
        let mut field = turn(&spectrum, self.rows, self.cols);
        field.truncate(wanted * self.cols);
        run(&*self.along[1], &mut field);
        let scale = 1.0 / (self.rows * self.cols) as f64;
        field.par_chunks_mut(1 << 14).for_each(|part| part.iter_mut().for_each(|x| *x *= scale));
        field
    }
}

fn run(transform: &dyn Fft<f64>, rows: &mut [Complex64]) {
    let zero = Complex64::new(0.0, 0.0);
    rows.par_chunks_mut(transform.len()).with_min_len(8).for_each_init(
        || vec![zero; transform.get_inplace_scratch_len()],
        |scratch, row| transform.process_with_scratch(row, scratch),
    );
}

/// A field of `cols` columns as one of rows of `stride`, zero beyond what it has.
fn turn(field: &[Complex64], cols: usize, stride: usize) -> Vec<Complex64> {
    let rows = field.len() / cols;
    let mut out = vec![Complex64::new(0.0, 0.0); stride * cols];
    out.par_chunks_mut(stride * TILE).enumerate().for_each(|(tile, out)| {
        let first = tile * TILE;
        for start in (0..rows).step_by(TILE) {
            for (col, out) in out.chunks_mut(stride).enumerate() {
                let out = &mut out[start..(start + TILE).min(rows)];
                let column = field[start * cols + first + col..].iter().step_by(cols);
                out.iter_mut().zip(column).for_each(|(out, value)| *out = *value);
            }
        }
    });
    out
}
