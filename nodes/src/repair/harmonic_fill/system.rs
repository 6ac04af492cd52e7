//! The linear equations of one hole and their solution by preconditioned conjugate gradients.

use orograph_core::prelude::*;

/// Stop at this residual, relative to that of a flat fill.
const RESIDUAL: f64 = 1e-10;

/// Give up above this residual.
const HOPELESS: f64 = 1e-6;

/// No unknown: a known cell, or a void that is not to be filled.
pub(super) const NONE: u32 = u32::MAX;

/// The equations of one hole: minus the weighted Laplacian, in the cells' row-major order.
pub(super) struct System {
    pub(super) weight_x: f64,
    pub(super) weight_y: f64,
    /// Unknowns west, north, east and south of each.
    pub(super) near: Vec<[u32; 4]>,
    pub(super) diagonal: Vec<f64>,
}

const WEST: usize = 0;
const NORTH: usize = 1;
const EAST: usize = 2;
const SOUTH: usize = 3;

impl System {
    #[inline]
    pub(super) fn weight(&self, side: usize) -> f64 {
        if side == WEST || side == EAST { self.weight_x } else { self.weight_y }
    }

    /// The part of `x` that neighbour `side` of unknown `i` has, weighted.
    #[inline]
    fn part(&self, x: &[f64], i: usize, side: usize) -> f64 {
        x.get(self.near[i][side] as usize).map_or(0.0, |x| x * self.weight(side))
    }

    fn multiply(&self, x: &[f64], out: &mut [f64], job: &Job<'_>) -> Result<()> {
        for (i, out) in out.iter_mut().enumerate() {
            check_often(i, job)?;
            let around = self.part(x, i, WEST)
                + self.part(x, i, NORTH)
                + self.part(x, i, EAST)
                + self.part(x, i, SOUTH);
            *out = self.diagonal[i] * x[i] - around;
        }
        Ok(())
    }

    /// Reciprocal pivots of the modified incomplete factorisation: fill-in is added to the diagonal, almost wholly.
    fn pivots(&self, job: &Job<'_>) -> Result<Vec<f64>> {
        let (fill, safety) = (0.97, 0.25);
        let mut pivots: Vec<f64> = Vec::with_capacity(self.near.len());
        for (i, &diagonal) in self.diagonal.iter().enumerate() {
            check_often(i, job)?;
            let mut pivot = diagonal;
            for (side, across) in [(WEST, SOUTH), (NORTH, EAST)] {
                let before = self.near[i][side] as usize;
                if let Some(reciprocal) = pivots.get(before).filter(|_| self.near[i][side] != NONE) {
                    let weight = self.weight(side);
                    let dropped = if self.near[before][across] == NONE { 0.0 } else { self.weight(across) };
                    pivot -= weight * (weight + fill * dropped) * reciprocal * reciprocal;
                }
            }
            let pivot = if pivot < safety * diagonal { diagonal } else { pivot };
            pivots.push(1.0 / pivot.sqrt());
        }
        Ok(pivots)
    }

    /// Applies the inverse of the factorisation.
    fn precondition(&self, pivots: &[f64], residual: &[f64], out: &mut [f64], job: &Job<'_>) -> Result<()> {
        for i in 0..out.len() {
            check_often(i, job)?;
            let mut sum = residual[i];
            for side in [WEST, NORTH] {
                let near = self.near[i][side] as usize;
                if let Some(pivot) = pivots.get(near) {
                    sum += self.weight(side) * pivot * out[near];
                }
            }
            out[i] = sum * pivots[i];
        }
        for i in (0..out.len()).rev() {
            check_often(i, job)?;
            let around = self.part(out, i, EAST) + self.part(out, i, SOUTH);
            out[i] = (out[i] + around * pivots[i]) * pivots[i];
        }
        Ok(())
    }

    /// The solution for a right-hand side.
    ///
    /// # Errors
    /// [`Error::NotConverged`] or cancellation.
    pub(super) fn solve(&self, mut residual: Vec<f64>, job: &Job<'_>) -> Result<Vec<f64>> {
        let n = residual.len();
        let mut x = vec![0.0; n];
        let start = dot(&residual, &residual, job)?.sqrt();
        if start == 0.0 {
            return Ok(x);
        }
        let pivots = self.pivots(job)?;
        let mut z = vec![0.0; n];
        self.precondition(&pivots, &residual, &mut z, job)?;
        let mut direction = z.clone();
        let mut image = vec![0.0; n];
        let mut energy = dot(&residual, &z, job)?;
        let cap = (20.0 * (n as f64).sqrt()) as u64 + 200;
        let mut share = 1.0;
        for _ in 0..cap {
            job.check()?;
            self.multiply(&direction, &mut image, job)?;
            let step = energy / dot(&direction, &image, job)?;
            for start in (0..n).step_by(PIECE) {
                job.check()?;
                for i in start..n.min(start + PIECE) {
                    x[i] += step * direction[i];
                    residual[i] -= step * image[i];
                }
            }
            share = dot(&residual, &residual, job)?.sqrt() / start;
            if share <= RESIDUAL {
                return Ok(x);
            }
            self.precondition(&pivots, &residual, &mut z, job)?;
            let next = dot(&residual, &z, job)?;
            let turn = next / energy;
            energy = next;
            for (direction, z) in direction.chunks_mut(PIECE).zip(z.chunks(PIECE)) {
                job.check()?;
                direction.iter_mut().zip(z).for_each(|(direction, z)| *direction = z + turn * *direction);
            }
        }
        // NaN counts as hopeless too.
        if share <= HOPELESS { Ok(x) } else { Err(Error::NotConverged { steps: cap, residual: share }) }
    }
}

/// Hears of a cancellation every few hundred microseconds of a loop over unknowns, of which a hole may have many millions.
#[inline]
pub(super) fn check_often(i: usize, job: &Job<'_>) -> Result<()> {
    if i.is_multiple_of(PIECE) { job.check() } else { Ok(()) }
}

/// Cells between two questions whether the work was cancelled.
const PIECE: usize = 1 << 16;

fn dot(a: &[f64], b: &[f64], job: &Job<'_>) -> Result<f64> {
    let mut sum = 0.0;
    for (a, b) in a.chunks(PIECE).zip(b.chunks(PIECE)) {
        job.check()?;
        sum = a.iter().zip(b).fold(sum, |sum, (a, b)| sum + a * b);
    }
    Ok(sum)
}
