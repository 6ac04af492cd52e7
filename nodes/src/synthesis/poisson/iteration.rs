//! Conjugate gradients preconditioned by a multigrid cycle.
//!
//! The cycle's guess at what is left to correct also tells when to stop: at a tenth of a millimetre. That guess is
//! taken, too, and leaves about a tenth of itself: less than heights are stored to. Four to seven steps reach that on
//! most regions, whatever their size. Sums are taken in an order
//! of their own, so the result does not depend on threads.

use orograph_core::prelude::*;
use pulp::Arch;

use super::{
    multigrid::Levels,
    network::Finest,
    rows::{Curvature, Equations, ROWS, Scaled, Subtract, Turn, dot, each, each_two, greatest, largest},
};

/// The last correction is nowhere larger, in metres.
const ACCURACY: f64 = 1e-4;
/// The same as a share of the largest value, for heights that no terrain has.
const RELATIVE: f64 = 1e-9;
const MAX_STEPS: usize = 400;

/// Preconditioned conjugate gradients on arrays with a frame one cell wide.
pub(super) struct Iteration<'a> {
    levels: Levels,
    finest: Finest<'a>,
    rest: Vec<f64>,
    solution: Vec<f64>,
}

impl<'a> Iteration<'a> {
    /// For cells of which no connected part is without fixed cell and hold. `right` is 0 where cells are not free.
    pub(super) fn new(finest: Finest<'a>, right: Vec<f64>) -> Self {
        Self { levels: Levels::new(finest), finest, solution: vec![0.0; right.len()], rest: right }
    }

    /// The solution and the number of steps that it took.
    pub(super) fn run(self, job: &Job<'_>) -> Result<(Vec<f64>, usize)> {
        let finest = self.finest;
        if finest.holds.is_empty() {
            self.solve(Equations::<false>(finest), job)
        } else {
            self.solve(Equations::<true>(finest), job)
        }
    }

    fn solve<const HELD: bool>(
        mut self,
        equations: Equations<'_, HELD>,
        job: &Job<'_>,
    ) -> Result<(Vec<f64>, usize)> {
        let (stride, arch) = (self.finest.stride, Arch::new());
        let lot = ROWS * stride;
        let inner = stride..self.rest.len() - stride;
        let start = largest(&self.rest);
        if start == 0.0 {
            return Ok((self.solution, 0));
        }
        // All in single precision is in units of something as large as it is, whatever the scale of heights.
        let mut unit = start;
        let rest = &self.rest;
        each(self.levels.found().1, lot, |first, out| {
            arch.dispatch(Scaled { rest: &rest[first..], scale: 1.0 / unit, out });
        });
        self.levels.guess();
        let (guess, right) = self.levels.found();
        let most = greatest(each(&mut self.solution, lot, |first, solution| {
            solution.iter_mut().zip(&guess[first..]).for_each(|(x, guess)| *x = f64::from(*guess) * unit);
            largest(solution)
        }));
        let accuracy = ACCURACY.max(RELATIVE * most);
        let (rest, right) = (&mut self.rest[inner.clone()], &mut right[inner.clone()]);
        let mut left = greatest(each_two((rest, lot), (right, lot), |first, rest, scaled| {
            let (first, length, scale) = (first + stride, unit, 1.0 / unit);
            arch.dispatch(Subtract { equations, along: guess, first, length, rest, scale, scaled })
        }));
        let mut along = vec![0.0_f32; self.rest.len()];
        let mut last = 0.0;
        // How far the solution is to go along before the way turns.
        let mut length = 0.0;
        for step in 0..MAX_STEPS {
            job.check()?;
            if left == 0.0 {
                self.go(&along, length, 0.0);
                return Ok((self.solution, step));
            }
            self.levels.precondition();
            let (corrected, right) = self.levels.found();
            let judged = dot(&self.rest, corrected, stride);
            let product = judged.iter().map(|judged| judged.0).sum::<f64>() * unit;
            let most = greatest(judged.iter().map(|judged| judged.1)) * unit;
            if most <= accuracy {
                self.go(&along, length, unit);
                return Ok((self.solution, step));
            }
            let share = if step == 0 { 0.0 } else { (product / last) as f32 };
            last = product;
            let scale = (unit / start) as f32;
            each_two((&mut along, lot), (&mut self.solution, lot), |first, along, solution| {
                let correction = &corrected[first..];
                arch.dispatch(Turn { along, solution, length, correction, scale, share });
            });
            let along = &along[..];
            let rows = &mut self.rest[inner.clone()];
            let curvature: f64 = each(rows, lot, |first, rest| {
                let rows = rest.len() / stride;
                arch.dispatch(Curvature { equations, along, first: first + stride, rows })
            })
            .into_iter()
            .sum();
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            length = product / (start * curvature);
            let scale = 1.0 / left;
            let sizes = each_two((rows, lot), (&mut right[inner.clone()], lot), |first, rest, scaled| {
                let first = first + stride;
                arch.dispatch(Subtract { equations, along, first, length, rest, scale, scaled })
            });
            (unit, left) = (left, greatest(sizes));
        }
        Err(Error::NotConverged { steps: MAX_STEPS as u64, residual: left / start })
    }

    /// Lets the solution go `length` along, and then by what was last corrected.
    fn go(&mut self, along: &[f32], length: f64, correction: f64) {
        let (corrected, _) = self.levels.found();
        each(&mut self.solution, ROWS * self.finest.stride, |start, x| {
            for ((x, along), z) in x.iter_mut().zip(&along[start..]).zip(&corrected[start..]) {
                *x = *x + length * f64::from(*along) + f64::from(*z) * correction;
            }
        });
    }
}
