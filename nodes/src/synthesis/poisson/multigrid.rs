//! One multigrid cycle on cells: a good guess at the solution of Poisson's equation, symmetric in its input.
//!
//! Each coarser level halves the cells (McAdams, Sifakis and Teran 2010): a coarse cell is fixed if one of its four is,
//! else free if one is, else outside. Corrections are spread bilinearly and residuals gathered by the transpose. A
//! level is smoothed by two Jacobi sweeps with Chebyshev's weights before and, in reverse, after, which rows can do
//! in parallel and without branches: values are 0 wherever a cell is not free. A guess needs no more than single
//! precision; what it misses the next one finds.
//!
//! Memory is what a cycle waits for. So all that is done on a level on the way down goes through its rows once, each step a
//! row behind the one before ([`Descent`]), and so does all on the way up ([`Ascent`]).

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::{
    masked::Cell,
    rolling::Rolling,
    rows::{PARALLEL, made},
    stencil::{Line, Stencil, gather, spread},
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
            fine[k].descend(&mut coarse[0]);
        }
        self.levels[last].settle();
        for k in (0..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            fine[k].ascend(&coarse[0]);
        }
    }
}

/// The matrix's diagonal: the sum of the weights of a free cell's neighbours and its hold; 0 for cells that are not free.
pub(super) fn diagonal_of(cols: usize, framed: &[Cell], holds: &[f64], [across, down]: [f64; 2]) -> Vec<f64> {
    let stride = cols + 2;
    let flows = |j: usize, weight: f64| if framed[j] == Cell::Outside { 0.0 } else { weight };
    let at = |i: usize| {
        if framed[i] != Cell::Free {
            return 0.0;
        }
        let near =
            flows(i - 1, across) + flows(i + 1, across) + flows(i - stride, down) + flows(i + stride, down);
        near + holds.get(i).copied().unwrap_or(0.0)
    };
    made(framed.len(), at)
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

/// Rows of the coarser level that are made together on the way down, and half the rows that are on the way up.
const LOT: usize = 16;

impl Level {
    fn new(rows: usize, cols: usize, diagonal: &[f64], weights: [f64; 2]) -> Self {
        let inverse = |diagonal: f64| if diagonal > 0.0 { (1.0 / diagonal) as f32 } else { 0.0 };
        let zeros = || vec![0.0; diagonal.len()];
        Self {
            rows,
            cols,
            weights: weights.map(|weight| weight as f32),
            diagonal: made(diagonal.len(), |i| diagonal[i] as f32),
            inverse: made(diagonal.len(), |i| inverse(diagonal[i])),
            value: zeros(),
            spare: zeros(),
            right: zeros(),
        }
    }

    fn stride(&self) -> usize {
        self.cols + 2
    }

    /// A row of what does not change in a cycle, counted with the frame.
    fn line(&self, row: usize) -> Line<'_> {
        let range = row * self.stride()..(row + 1) * self.stride();
        Line {
            diagonal: &self.diagonal[range.clone()],
            inverse: &self.inverse[range.clone()],
            right: &self.right[range],
        }
    }

    /// Two sweeps from zero, and what they leave of the right side as that of the coarser level.
    fn descend(&mut self, coarse: &mut Self) {
        let (stride, coarse_stride, arch) = (self.stride(), coarse.stride(), Arch::new());
        let (mut value, mut gathered) = (std::mem::take(&mut self.value), std::mem::take(&mut coarse.right));
        let inner = stride..value.len() - stride;
        let coarse_inner = coarse_stride..gathered.len() - coarse_stride;
        let (value_lot, gathered_lot) = (2 * LOT * stride, LOT * coarse_stride);
        let lot = |(i, (value, gathered)): (usize, (&mut [f32], &mut [f32]))| {
            arch.dispatch(Descent { level: self, first: 2 * LOT * i + 1, value, gathered });
        };
        if value.len() < PARALLEL {
            value[inner]
                .chunks_mut(value_lot)
                .zip(gathered[coarse_inner].chunks_mut(gathered_lot))
                .enumerate()
                .for_each(lot);
        } else {
            value[inner]
                .par_chunks_mut(value_lot)
                .zip(gathered[coarse_inner].par_chunks_mut(gathered_lot))
                .enumerate()
                .for_each(lot);
        }
        (self.value, coarse.right) = (value, gathered);
    }

    /// The coarser level's values added, and two sweeps.
    fn ascend(&mut self, coarse: &Self) {
        let (stride, arch) = (self.stride(), Arch::new());
        let mut next = std::mem::take(&mut self.spare);
        let inner = stride..next.len() - stride;
        let lot = |(i, next): (usize, &mut [f32])| {
            arch.dispatch(Ascent { level: self, coarse, first: 2 * LOT * i + 1, next });
        };
        if next.len() < PARALLEL {
            next[inner].chunks_mut(2 * LOT * stride).enumerate().for_each(lot);
        } else {
            next[inner].par_chunks_mut(2 * LOT * stride).enumerate().for_each(lot);
        }
        self.spare = std::mem::replace(&mut self.value, next);
    }

    /// As many sweeps from zero as the coarsest level takes, there and back, so that the whole stays symmetric.
    fn settle(&mut self) {
        let there = (0..COARSEST_SWEEPS).map(|i| if i < COARSEST_SWEEPS / 2 { i % 2 } else { 1 - i % 2 });
        let all = std::iter::once(1).chain(there).chain([1, 0]);
        self.start(SWEEPS[0]);
        all.for_each(|which| self.sweep(SWEEPS[which]));
    }

    fn start(&mut self, weight: f32) {
        let (stride, mut value) = (self.stride(), std::mem::take(&mut self.value));
        for row in 1..=self.rows {
            self.line(row).start(weight, &mut value[row * stride..][..stride]);
        }
        self.value = value;
    }

    fn sweep(&mut self, weight: f32) {
        let (stride, mut next) = (self.stride(), std::mem::take(&mut self.spare));
        for row in 1..=self.rows {
            let near = [row - 1, row, row + 1].map(|row| &self.value[row * stride..][..stride]);
            let stencil = Stencil { near, weights: self.weights };
            stencil.sweep(weight, &self.line(row), &mut next[row * stride..][..stride]);
        }
        self.spare = std::mem::replace(&mut self.value, next);
    }
}

/// The way down through some rows of a level.
struct Descent<'a> {
    level: &'a Level,
    /// The first of the rows, an odd one as the frame counts.
    first: usize,
    /// Their values after two sweeps.
    value: &'a mut [f32],
    /// The right side of the coarser rows over them.
    gathered: &'a mut [f32],
}

impl NullaryFnOnce for Descent<'_> {
    type Output = ();

    /// Rows beyond the lot that its own ones look at are made here, too, which costs less than to wait for other lots.
    #[inline(always)]
    fn call(self) {
        let Self { level, first, value, gathered } = self;
        let stride = level.stride();
        let rows = value.len() / stride;
        let coarse_stride = level.cols.div_ceil(2) + 2;
        let within = |row: usize| (1..=level.rows).contains(&row);
        let mut started = Rolling::<3>::new(stride);
        let mut swept = Rolling::<3>::new(stride);
        let mut rest = Rolling::<4>::new(stride);
        let last = first + 2 * (gathered.len() / coarse_stride);
        // Three rows before the first one is the earliest that matters; none lies before the frame.
        for row in first.saturating_sub(3)..=last + 2 {
            match started.row(row) {
                out if within(row) => level.line(row).start(SWEEPS[0], out),
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match swept.row(row) {
                out if within(row) => {
                    let stencil = Stencil { near: started.around(row), weights: level.weights };
                    stencil.sweep(SWEEPS[1], &level.line(row), out);
                    if (first..first + rows).contains(&row) {
                        value[(row - first) * stride..][..stride].copy_from_slice(out);
                    }
                }
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match rest.row(row) {
                out if within(row) => {
                    let stencil = Stencil { near: swept.around(row), weights: level.weights };
                    stencil.residual(&level.line(row), out);
                }
                out => out.fill(0.0),
            }
            // A coarse row over this one and the one before gathers from one more on either side.
            if row >= first + 2 && (row - first).is_multiple_of(2) {
                let out = &mut gathered[((row - first) / 2 - 1) * coarse_stride..][..coarse_stride];
                let four = [rest.made(row - 3), rest.made(row - 2), rest.made(row - 1), rest.made(row)];
                gather(four, out);
            }
        }
    }
}

/// The way up through some rows of a level.
struct Ascent<'a> {
    level: &'a Level,
    coarse: &'a Level,
    /// The first of the rows, as the frame counts.
    first: usize,
    next: &'a mut [f32],
}

impl NullaryFnOnce for Ascent<'_> {
    type Output = ();

    /// As on the way down.
    #[inline(always)]
    fn call(self) {
        let Self { level, coarse, first, next } = self;
        let (stride, coarse_stride) = (level.stride(), coarse.stride());
        let rows = next.len() / stride;
        let within = |row: usize| (1..=level.rows).contains(&row);
        let mut lifted = Rolling::<3>::new(stride);
        let mut swept = Rolling::<3>::new(stride);
        let mut blend = vec![0.0; coarse_stride];
        for row in first.saturating_sub(2)..first + rows + 2 {
            match lifted.row(row) {
                out if within(row) => {
                    // A row lies a quarter of a coarse one off the middle of its own, towards the one before or after.
                    let own = row.div_ceil(2);
                    let other = if row.is_multiple_of(2) { own + 1 } else { own - 1 };
                    let [own, other] =
                        [own, other].map(|row| &coarse.value[row * coarse_stride..][..coarse_stride]);
                    for ((blend, own), other) in blend.iter_mut().zip(own).zip(other) {
                        *blend = 0.75 * own + 0.25 * other;
                    }
                    let free = level.line(row).inverse;
                    spread(&blend, free, &level.value[row * stride..][..stride], out);
                }
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match swept.row(row) {
                out if within(row) => {
                    let stencil = Stencil { near: lifted.around(row), weights: level.weights };
                    stencil.sweep(SWEEPS[1], &level.line(row), out);
                }
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1).filter(|row| *row >= first) else { continue };
            let stencil = Stencil { near: swept.around(row), weights: level.weights };
            let out = &mut next[(row - first) * stride..][..stride];
            stencil.sweep(SWEEPS[0], &level.line(row), out);
        }
    }
}
