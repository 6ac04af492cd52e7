//! One multigrid cycle on cells: a good guess at the solution of Poisson's equation, symmetric in its input.
//!
//! Each coarser level halves the cells (McAdams, Sifakis and Teran 2010): a coarse cell is fixed if one of its four is,
//! else free if one is, else outside. Corrections are spread bilinearly and residuals gathered by the transpose. A
//! level is smoothed by two Jacobi sweeps with Chebyshev's weights before and, in reverse, after, which rows can do
//! in parallel and without branches: values are 0 wherever a cell is not free.

use super::masked::{Cell, each_row};

/// Values in an array from which its rows are worked on in parallel.
pub(super) const PARALLEL: usize = 1 << 16;

/// Weights of the two sweeps, the zeros of Chebyshev's polynomial on the upper three quarters of the spectrum (0, 2).
const SWEEPS: [f64; 2] = [0.561_7, 1.389_2];
/// Levels end at this many cells along the shorter side, where this many sweeps settle the rest.
const COARSEST: usize = 3;
const COARSEST_SWEEPS: usize = 24;

struct Level {
    rows: usize,
    cols: usize,
    /// Sum of the weights of a free cell's neighbours and its inverse; 0 for cells that are not free.
    diagonal: Vec<f64>,
    inverse: Vec<f64>,
    value: Vec<f64>,
    spare: Vec<f64>,
    right: Vec<f64>,
}

/// The levels over a domain, finest first. All arrays have a frame one cell wide.
pub(super) struct Levels {
    levels: Vec<Level>,
    weights: [f64; 2],
}

impl Levels {
    pub(super) fn new(rows: usize, cols: usize, cells: &[Cell], holds: &[f64], weights: [f64; 2]) -> Self {
        let mut framed = vec![Cell::Outside; (rows + 2) * (cols + 2)];
        for (row, cells) in cells.chunks(cols).enumerate() {
            framed[(row + 1) * (cols + 2) + 1..][..cols].copy_from_slice(cells);
        }
        // Nearly every domain is held nowhere, and none of it need be stored then.
        let mut springs = holds.to_vec();
        let mut levels = vec![Level::new(rows, cols, &framed, &springs, weights)];
        let (mut rows, mut cols) = (rows, cols);
        while rows.min(cols) > COARSEST && framed.contains(&Cell::Free) {
            framed = coarser(rows, cols, &framed);
            springs = gathered(cols, &springs);
            (rows, cols) = (rows.div_ceil(2), cols.div_ceil(2));
            levels.push(Level::new(rows, cols, &framed, &springs, weights));
        }
        Self { levels, weights }
    }

    /// What the last [`precondition`](Self::precondition) found.
    pub(super) fn correction(&self) -> &[f64] {
        &self.levels[0].value
    }

    /// One cycle for the right side `right`, from zero.
    pub(super) fn precondition(&mut self, right: &[f64]) {
        self.levels[0].right.copy_from_slice(right);
        let last = self.levels.len() - 1;
        for k in 0..last {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let (fine, coarse) = (&mut fine[k], &mut coarse[0]);
            fine.start(SWEEPS[0]);
            fine.sweep(SWEEPS[1], self.weights);
            fine.residual(self.weights);
            fine.gather(coarse);
        }
        let coarsest = &mut self.levels[last];
        coarsest.start(SWEEPS[0]);
        coarsest.sweep(SWEEPS[1], self.weights);
        for i in 0..COARSEST_SWEEPS {
            // There and back, so that the whole stays symmetric.
            let weight = if i < COARSEST_SWEEPS / 2 { i % 2 } else { 1 - i % 2 };
            coarsest.sweep(SWEEPS[weight], self.weights);
        }
        coarsest.sweep(SWEEPS[1], self.weights);
        coarsest.sweep(SWEEPS[0], self.weights);
        for k in (0..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let fine = &mut fine[k];
            fine.spread(&coarse[0]);
            fine.sweep(SWEEPS[1], self.weights);
            fine.sweep(SWEEPS[0], self.weights);
        }
    }

    /// The finest level's matrix times `x`.
    pub(super) fn apply(&self, x: &[f64], out: &mut [f64]) {
        let level = &self.levels[0];
        let weights = self.weights;
        level.rows_of(out, |range, out| {
            let near = Near::new(x, &range, level.stride());
            let (diagonal, own) = (&level.diagonal[range.clone()][..out.len()], &x[range][..out.len()]);
            for (k, out) in out.iter_mut().enumerate() {
                let value = diagonal[k] * own[k] - near.sum(k, weights);
                *out = if diagonal[k] == 0.0 { 0.0 } else { value };
            }
        });
    }
}

fn coarser(rows: usize, cols: usize, framed: &[Cell]) -> Vec<Cell> {
    let stride = cols + 2;
    let (coarse_rows, coarse_cols) = (rows.div_ceil(2), cols.div_ceil(2));
    let mut out = vec![Cell::Outside; (coarse_rows + 2) * (coarse_cols + 2)];
    for row in 0..coarse_rows {
        for col in 0..coarse_cols {
            let at = |i: usize, j: usize| framed[(2 * row + 1 + i) * stride + 2 * col + 1 + j];
            // The frame lends the missing half of an odd last row or column.
            let four = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
            out[(row + 1) * (coarse_cols + 2) + col + 1] = if four.contains(&Cell::Fixed) {
                Cell::Fixed
            } else if four.contains(&Cell::Free) {
                Cell::Free
            } else {
                Cell::Outside
            };
        }
    }
    out
}

/// The holds of coarser cells: all that pulls at their four cells.
fn gathered(cols: usize, holds: &[f64]) -> Vec<f64> {
    let coarse_cols = cols.div_ceil(2);
    let mut out = vec![0.0; holds.len().div_ceil(cols).div_ceil(2) * coarse_cols];
    for (i, hold) in holds.iter().enumerate() {
        out[i / cols / 2 * coarse_cols + i % cols / 2] += hold;
    }
    out
}

/// The four neighbours' values along a stretch of a row.
struct Near<'a> {
    west: &'a [f64],
    north: &'a [f64],
    east: &'a [f64],
    south: &'a [f64],
}

impl<'a> Near<'a> {
    fn new(x: &'a [f64], range: &std::ops::Range<usize>, stride: usize) -> Self {
        let shifted = |start: usize| &x[start..start + range.len()];
        Self {
            west: shifted(range.start - 1),
            north: shifted(range.start - stride),
            east: shifted(range.start + 1),
            south: shifted(range.start + stride),
        }
    }

    #[inline]
    fn sum(&self, k: usize, [across, down]: [f64; 2]) -> f64 {
        across * (self.west[k] + self.east[k]) + down * (self.north[k] + self.south[k])
    }
}

impl Level {
    fn new(rows: usize, cols: usize, framed: &[Cell], holds: &[f64], [across, down]: [f64; 2]) -> Self {
        let stride = cols + 2;
        let len = (rows + 2) * stride;
        let mut diagonal = vec![0.0; len];
        for row in 1..=rows {
            for i in row * stride + 1..=row * stride + cols {
                if framed[i] != Cell::Free {
                    continue;
                }
                let flows = |j: usize, weight: f64| if framed[j] == Cell::Outside { 0.0 } else { weight };
                diagonal[i] = flows(i - 1, across)
                    + flows(i + 1, across)
                    + flows(i - stride, down)
                    + flows(i + stride, down)
                    + holds.get((row - 1) * cols + i % stride - 1).copied().unwrap_or(0.0);
            }
        }
        let inverse = diagonal.iter().map(|&d| if d > 0.0 { 1.0 / d } else { 0.0 }).collect();
        let zeros = || vec![0.0; len];
        Self { rows, cols, diagonal, inverse, value: zeros(), spare: zeros(), right: zeros() }
    }

    fn stride(&self) -> usize {
        self.cols + 2
    }

    /// Calls `f` with the inner stretch of each row of `out` and where it lies.
    fn rows_of(&self, out: &mut [f64], f: impl Fn(std::ops::Range<usize>, &mut [f64]) + Sync) {
        let (rows, cols, stride) = (self.rows, self.cols, self.stride());
        each_row(out, stride, |row, out| {
            if (1..=rows).contains(&row) {
                f(row * stride + 1..row * stride + 1 + cols, &mut out[1..=cols]);
            }
        });
    }

    /// The first sweep, from zero.
    fn start(&mut self, weight: f64) {
        let mut value = std::mem::take(&mut self.value);
        self.rows_of(&mut value, |range, out| {
            let (inverse, right) = (&self.inverse[range.clone()], &self.right[range]);
            out.iter_mut()
                .zip(inverse)
                .zip(right)
                .for_each(|((out, inverse), b)| *out = weight * inverse * b);
        });
        self.value = value;
    }

    fn sweep(&mut self, weight: f64, weights: [f64; 2]) {
        let mut next = std::mem::take(&mut self.spare);
        self.rows_of(&mut next, |range, out| {
            let near = Near::new(&self.value, &range, self.stride());
            let (inverse, right) = (&self.inverse[range.clone()], &self.right[range.clone()]);
            let value = &self.value[range];
            let n = out.len();
            let (inverse, right, value) = (&inverse[..n], &right[..n], &value[..n]);
            for (k, out) in out.iter_mut().enumerate() {
                let exact = (right[k] + near.sum(k, weights)) * inverse[k];
                let moved = value[k] + weight * (exact - value[k]);
                *out = if inverse[k] == 0.0 { 0.0 } else { moved };
            }
        });
        self.spare = std::mem::replace(&mut self.value, next);
    }

    /// What is left of the right side, into `spare`.
    fn residual(&mut self, weights: [f64; 2]) {
        let mut rest = std::mem::take(&mut self.spare);
        self.rows_of(&mut rest, |range, out| {
            let near = Near::new(&self.value, &range, self.stride());
            let (diagonal, right) = (&self.diagonal[range.clone()], &self.right[range.clone()]);
            let value = &self.value[range];
            let n = out.len();
            let (diagonal, right, value) = (&diagonal[..n], &right[..n], &value[..n]);
            for (k, out) in out.iter_mut().enumerate() {
                let rest = right[k] - diagonal[k] * value[k] + near.sum(k, weights);
                *out = if diagonal[k] == 0.0 { 0.0 } else { rest };
            }
        });
        self.spare = rest;
    }

    /// The residual in `spare`, gathered as the coarser level's right side: the transpose of [`spread`](Self::spread).
    fn gather(&self, coarse: &mut Self) {
        let stride = self.stride();
        let (rest, rows) = (&self.spare, self.rows);
        let mut right = std::mem::take(&mut coarse.right);
        coarse.rows_of(&mut right, |range, out| {
            let coarse_row = range.start / coarse.stride() - 1;
            out.fill(0.0);
            for (i, down) in [0.25, 0.75, 0.75, 0.25].into_iter().enumerate() {
                // Rows 2r - 1 to 2r + 2 of the finer level, in the frame's count one more.
                let row = 2 * coarse_row + i;
                if row > rows + 1 {
                    continue;
                }
                let rest = &rest[row * stride..(row + 1) * stride];
                for (k, out) in out.iter_mut().enumerate() {
                    let at = 2 * k;
                    let last = rest.get(at + 3).copied().unwrap_or(0.0);
                    *out += down * (0.25 * (rest[at] + last) + 0.75 * (rest[at + 1] + rest[at + 2]));
                }
            }
        });
        coarse.right = right;
    }

    /// Adds the coarser level's values, bilinearly, to this one's.
    fn spread(&mut self, coarse: &Self) {
        let (stride, coarse_stride) = (self.stride(), coarse.stride());
        let mut value = std::mem::take(&mut self.value);
        self.rows_of(&mut value, |range, out| {
            let row = range.start / stride - 1;
            // A cell lies a quarter of a coarse cell off the centre of its own, towards the row or column before or
            // after.
            let own = row / 2 + 1;
            let other = if row.is_multiple_of(2) { own - 1 } else { own + 1 };
            let near = &coarse.value[own * coarse_stride..(own + 1) * coarse_stride];
            let far = &coarse.value[other * coarse_stride..(other + 1) * coarse_stride];
            let blend = |k: usize| 0.75 * near[k] + 0.25 * far[k];
            let inverse = &self.inverse[range];
            for (k, (out, inverse)) in out.iter_mut().zip(inverse).enumerate() {
                let own = k / 2 + 1;
                let other = if k.is_multiple_of(2) { own - 1 } else { own + 1 };
                let moved = 0.75 * blend(own) + 0.25 * blend(other);
                *out += if *inverse == 0.0 { 0.0 } else { moved };
            }
        });
        self.value = value;
    }
}
