//! One multigrid cycle on cells: a good guess at the solution of Poisson's equation, symmetric in its input.
//!
//! Each coarser level halves the cells (McAdams, Sifakis and Teran 2010): a coarse cell is fixed if one of its four is,
//! else free if one is, else outside. Corrections are spread bilinearly and residuals gathered by the transpose. A
//! level is smoothed by two Jacobi sweeps with Chebyshev's weights before and, in reverse, after, which rows can do
//! in parallel and without branches: values are 0 wherever a cell is not free. A guess needs no more than single
//! precision; what it misses the next one finds.

use std::ops::Range;

use super::{
    masked::Cell,
    rows::{Kernel, fill},
};

/// Weights of the two sweeps, the zeros of Chebyshev's polynomial on the upper three quarters of the spectrum (0, 2).
const SWEEPS: [f32; 2] = [0.561_7, 1.389_2];
/// Levels end at this many cells along the shorter side, where this many sweeps settle the rest.
const COARSEST: usize = 3;
const COARSEST_SWEEPS: usize = 24;

struct Level {
    rows: usize,
    cols: usize,
    /// Weights of the steps along a row and along a column.
    weights: [f32; 2],
    /// Sum of the weights of a free cell's neighbours and its inverse; 0 for cells that are not free.
    diagonal: Vec<f32>,
    inverse: Vec<f32>,
    value: Vec<f32>,
    spare: Vec<f32>,
    right: Vec<f32>,
}

/// The levels over a domain, finest first. All arrays have a frame one cell wide.
pub(super) struct Levels {
    levels: Vec<Level>,
}

impl Levels {
    /// For the framed cells of a domain with the `diagonal` of its matrix and the strengths by which cells are held.
    pub(super) fn new(
        cols: usize,
        framed: &[Cell],
        diagonal: &[f64],
        holds: &[f64],
        weights: [f64; 2],
    ) -> Self {
        let rows = framed.len() / (cols + 2) - 2;
        let mut levels = vec![Level::new(rows, cols, diagonal, weights)];
        let (mut rows, mut cols) = (rows, cols);
        let (mut framed, mut holds) = (framed.to_vec(), holds.to_vec());
        while rows.min(cols) > COARSEST && framed.contains(&Cell::Free) {
            framed = coarser(rows, cols, &framed);
            holds = gathered(cols, &holds);
            (rows, cols) = (rows.div_ceil(2), cols.div_ceil(2));
            levels.push(Level::new(rows, cols, &diagonal_of(cols, &framed, &holds, weights), weights));
        }
        Self { levels }
    }

    /// What the last [`precondition`](Self::precondition) found.
    pub(super) fn correction(&self) -> &[f32] {
        &self.levels[0].value
    }

    /// One cycle for the right side that `write` sets, from zero.
    pub(super) fn precondition(&mut self, write: impl FnOnce(&mut [f32])) {
        write(&mut self.levels[0].right);
        let last = self.levels.len() - 1;
        for k in 0..last {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let (fine, coarse) = (&mut fine[k], &mut coarse[0]);
            fine.start(SWEEPS[0]);
            fine.sweep(SWEEPS[1]);
            fine.residual();
            fine.gather(coarse);
        }
        let coarsest = &mut self.levels[last];
        coarsest.start(SWEEPS[0]);
        coarsest.sweep(SWEEPS[1]);
        for i in 0..COARSEST_SWEEPS {
            // There and back, so that the whole stays symmetric.
            let weight = if i < COARSEST_SWEEPS / 2 { i % 2 } else { 1 - i % 2 };
            coarsest.sweep(SWEEPS[weight]);
        }
        coarsest.sweep(SWEEPS[1]);
        coarsest.sweep(SWEEPS[0]);
        for k in (0..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let fine = &mut fine[k];
            fine.spread(&coarse[0]);
            fine.sweep(SWEEPS[1]);
            fine.sweep(SWEEPS[0]);
        }
    }
}

/// The matrix's diagonal: the sum of the weights of a free cell's neighbours and its hold; 0 for cells that are not free.
pub(super) fn diagonal_of(cols: usize, framed: &[Cell], holds: &[f64], [across, down]: [f64; 2]) -> Vec<f64> {
    let stride = cols + 2;
    let flows = |j: usize, weight: f64| if framed[j] == Cell::Outside { 0.0 } else { weight };
    let at = |i: usize| {
        let near =
            flows(i - 1, across) + flows(i + 1, across) + flows(i - stride, down) + flows(i + stride, down);
        near + holds.get(i).copied().unwrap_or(0.0)
    };
    framed.iter().enumerate().map(|(i, &cell)| if cell == Cell::Free { at(i) } else { 0.0 }).collect()
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

/// The holds of coarser cells: all that pulls at their four cells. Nearly every domain is held nowhere and has none.
fn gathered(cols: usize, holds: &[f64]) -> Vec<f64> {
    let (stride, coarse_stride) = (cols + 2, cols.div_ceil(2) + 2);
    let rows = (holds.len() / stride).saturating_sub(2);
    let n = if holds.is_empty() { 0 } else { (rows.div_ceil(2) + 2) * coarse_stride };
    let mut out = vec![0.0; n];
    for row in 0..rows {
        for col in 0..cols {
            out[(row / 2 + 1) * coarse_stride + col / 2 + 1] += holds[(row + 1) * stride + col + 1];
        }
    }
    out
}

/// The four neighbours' values along a stretch of a row.
struct Near<'a> {
    west: &'a [f32],
    north: &'a [f32],
    east: &'a [f32],
    south: &'a [f32],
}

impl<'a> Near<'a> {
    #[inline(always)]
    fn new(x: &'a [f32], range: &Range<usize>, stride: usize) -> Self {
        let shifted = |start: usize| &x[start..start + range.len()];
        Self {
            west: shifted(range.start - 1),
            north: shifted(range.start - stride),
            east: shifted(range.start + 1),
            south: shifted(range.start + stride),
        }
    }

    #[inline(always)]
    fn sum(&self, k: usize, [across, down]: [f32; 2]) -> f32 {
        across * (self.west[k] + self.east[k]) + down * (self.north[k] + self.south[k])
    }
}

/// The first sweep, from zero.
struct Start<'a>(&'a Level, f32);

impl Kernel for Start<'_> {
    #[inline(always)]
    fn run(&self, range: Range<usize>, out: &mut [f32]) {
        let (inverse, right) = (&self.0.inverse[range.clone()], &self.0.right[range]);
        for ((out, inverse), b) in out.iter_mut().zip(inverse).zip(right) {
            *out = self.1 * inverse * b;
        }
    }
}

/// A sweep. Cells that are not free stay 0.
struct Sweep<'a>(&'a Level, f32);

impl Kernel for Sweep<'_> {
    #[inline(always)]
    fn run(&self, range: Range<usize>, out: &mut [f32]) {
        let Level { cols, weights, .. } = *self.0;
        let near = Near::new(&self.0.value, &range, cols + 2);
        let (inverse, right) = (&self.0.inverse[range.clone()], &self.0.right[range.clone()]);
        let (value, n) = (&self.0.value[range], out.len());
        let (inverse, right, value) = (&inverse[..n], &right[..n], &value[..n]);
        for (k, out) in out.iter_mut().enumerate() {
            let exact = (right[k] + near.sum(k, weights)) * inverse[k];
            *out = value[k] + self.1 * (exact - value[k]);
        }
    }
}

/// What is left of the right side.
struct Residual<'a>(&'a Level);

impl Kernel for Residual<'_> {
    #[inline(always)]
    fn run(&self, range: Range<usize>, out: &mut [f32]) {
        let Level { cols, weights, .. } = *self.0;
        let near = Near::new(&self.0.value, &range, cols + 2);
        let (diagonal, right) = (&self.0.diagonal[range.clone()], &self.0.right[range.clone()]);
        let (value, n) = (&self.0.value[range], out.len());
        let (diagonal, right, value) = (&diagonal[..n], &right[..n], &value[..n]);
        for (k, out) in out.iter_mut().enumerate() {
            let rest = right[k] - diagonal[k] * value[k] + near.sum(k, weights);
            *out = if diagonal[k] == 0.0 { 0.0 } else { rest };
        }
    }
}

/// The finer level's residual, gathered as the coarser one's right side: the transpose of [`Spread`].
struct Gather<'a> {
    fine: &'a Level,
    coarse_stride: usize,
}

impl Kernel for Gather<'_> {
    const BY_ROW: bool = true;

    #[inline(always)]
    fn run(&self, range: Range<usize>, out: &mut [f32]) {
        let stride = self.fine.cols + 2;
        let coarse_row = range.start / self.coarse_stride - 1;
        out.fill(0.0);
        for (i, down) in [0.25, 0.75, 0.75, 0.25].into_iter().enumerate() {
            // Rows 2r - 1 to 2r + 2 of the finer level, in the frame's count one more.
            let row = 2 * coarse_row + i;
            if row > self.fine.rows + 1 {
                continue;
            }
            let rest = &self.fine.spare[row * stride..(row + 1) * stride];
            let gathered = |k: usize, last: f32| {
                down * (0.25 * (rest[2 * k] + last) + 0.75 * (rest[2 * k + 1] + rest[2 * k + 2]))
            };
            // The last cell of an odd row has no cell beyond the frame.
            let whole = (stride - 2) / 2;
            for (k, out) in out.iter_mut().enumerate().take(whole) {
                *out += gathered(k, rest[2 * k + 3]);
            }
            for (k, out) in out.iter_mut().enumerate().skip(whole) {
                *out += gathered(k, 0.0);
            }
        }
    }
}

/// This level's values with the coarser one's added, bilinearly.
struct Spread<'a> {
    fine: &'a Level,
    coarse: &'a Level,
}

impl Kernel for Spread<'_> {
    const BY_ROW: bool = true;

    #[inline(always)]
    fn run(&self, range: Range<usize>, out: &mut [f32]) {
        let (stride, coarse_stride) = (self.fine.cols + 2, self.coarse.cols + 2);
        let row = range.start / stride - 1;
        // A cell lies a quarter of a coarse cell off the centre of its own, towards the row or column before or after.
        let own = row / 2 + 1;
        let other = if row.is_multiple_of(2) { own - 1 } else { own + 1 };
        let near = &self.coarse.value[own * coarse_stride..(own + 1) * coarse_stride];
        let far = &self.coarse.value[other * coarse_stride..(other + 1) * coarse_stride];
        let blend = |k: usize| 0.75 * near[k] + 0.25 * far[k];
        let free = &self.fine.inverse[range.clone()];
        let value = &self.fine.value[range];
        for (k, out) in out.chunks_mut(2).enumerate() {
            let (before, own, after) = (blend(k), blend(k + 1), blend(k + 2));
            let moved = [0.75 * own + 0.25 * before, 0.75 * own + 0.25 * after];
            for (i, out) in out.iter_mut().enumerate() {
                let moved = if free[2 * k + i] == 0.0 { 0.0 } else { moved[i] };
                *out = value[2 * k + i] + moved;
            }
        }
    }
}

impl Level {
    fn new(rows: usize, cols: usize, diagonal: &[f64], weights: [f64; 2]) -> Self {
        let inverse = diagonal.iter().map(|&d| if d > 0.0 { (1.0 / d) as f32 } else { 0.0 }).collect();
        let zeros = || vec![0.0; diagonal.len()];
        Self {
            rows,
            cols,
            weights: weights.map(|weight| weight as f32),
            diagonal: diagonal.iter().map(|&d| d as f32).collect(),
            inverse,
            value: zeros(),
            spare: zeros(),
            right: zeros(),
        }
    }

    fn start(&mut self, weight: f32) {
        let mut value = std::mem::take(&mut self.value);
        fill(&mut value, self.cols, &Start(self, weight));
        self.value = value;
    }

    fn sweep(&mut self, weight: f32) {
        let mut next = std::mem::take(&mut self.spare);
        fill(&mut next, self.cols, &Sweep(self, weight));
        self.spare = std::mem::replace(&mut self.value, next);
    }

    /// Into `spare`.
    fn residual(&mut self) {
        let mut rest = std::mem::take(&mut self.spare);
        fill(&mut rest, self.cols, &Residual(self));
        self.spare = rest;
    }

    fn gather(&self, coarse: &mut Self) {
        let (cols, coarse_stride) = (coarse.cols, coarse.cols + 2);
        fill(&mut coarse.right, cols, &Gather { fine: self, coarse_stride });
    }

    fn spread(&mut self, coarse: &Self) {
        let mut next = std::mem::take(&mut self.spare);
        fill(&mut next, self.cols, &Spread { fine: self, coarse });
        self.spare = std::mem::replace(&mut self.value, next);
    }
}
