//! Conjugate gradients preconditioned by a multigrid cycle.
//!
//! The cycle's guess at what is left to correct also tells when to stop: at a hundredth of a millimetre, less than
//! heights are stored to. Seven or eight steps reach that on most regions, whatever their size. Sums are taken in an order
//! of their own, so the result does not depend on threads.

use orograph_core::prelude::*;
use pulp::Arch;

use super::{
    masked::Cell,
    multigrid::{Levels, diagonal_of},
    rows::{Apply, Scaled, Subtract, Turn, dot, each, each_two, greatest},
};

/// A solution is taken when the next correction is nowhere larger, in metres; the error is of that size then.
pub(super) const ACCURACY: f64 = 1e-5;
/// The same as a share of the largest value, for heights that no terrain has.
const RELATIVE: f64 = 1e-9;
const MAX_STEPS: usize = 400;

/// Preconditioned conjugate gradients on arrays with a frame one cell wide.
pub(super) struct Iteration {
    levels: Levels,
    stride: usize,
    weights: [f64; 2],
    diagonal: Vec<f64>,
    rest: Vec<f64>,
    solution: Vec<f64>,
}

impl Iteration {
    pub(super) fn new(
        cols: usize,
        framed: &[Cell],
        holds: &[f64],
        mut right: Vec<f64>,
        weights: [f64; 2],
    ) -> Self {
        let diagonal = diagonal_of(cols, framed, holds, weights);
        let levels = Levels::new(cols, framed, &diagonal, holds, weights);
        right.iter_mut().zip(&diagonal).filter(|(_, diagonal)| **diagonal == 0.0).for_each(|(b, _)| *b = 0.0);
        let solution = vec![0.0; right.len()];
        Self { levels, stride: cols + 2, weights, diagonal, rest: right, solution }
    }

    /// The solution and the number of steps that it took.
    pub(super) fn run(mut self, job: &Job<'_>) -> Result<(Vec<f64>, usize)> {
        let (stride, arch) = (self.stride, Arch::new());
        let (mut along, mut image) = (vec![0.0; self.rest.len()], vec![0.0; self.rest.len()]);
        let mut largest = greatest(self.rest.iter().map(|rest| rest.abs()));
        let start = largest;
        let (mut last, mut accuracy) = (0.0, ACCURACY);
        // How far the solution is to go along before the way turns.
        let mut length = 0.0;
        for step in 0..MAX_STEPS {
            job.check()?;
            if largest == 0.0 {
                self.go(&along, length, 0.0);
                return Ok((self.solution, step));
            }
            // In single precision whatever the scale.
            let (rest, scale) = (&self.rest, 1.0 / largest);
            self.levels.precondition(|right| {
                each(right, stride, |start, out| {
                    arch.dispatch(Scaled { rest: &rest[start..], scale, out });
                });
            });
            let corrected = self.levels.correction();
            let judged = dot(rest, corrected, stride);
            let product = judged.iter().map(|judged| judged.0).sum::<f64>() * largest;
            let most = greatest(judged.iter().map(|judged| judged.1)) * largest;
            accuracy = if step == 0 { accuracy.max(RELATIVE * most) } else { accuracy };
            if most <= accuracy {
                self.go(&along, length, largest);
                return Ok((self.solution, step));
            }
            let share = if step == 0 { 0.0 } else { product / last };
            last = product;
            each_two((&mut along, &mut self.solution), stride, |start, along, solution| {
                let correction = &corrected[start..];
                arch.dispatch(Turn { along, solution, length, correction, largest, share });
            });
            let curvature: f64 = self.apply(&along, &mut image).into_iter().sum();
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            length = product / curvature;
            largest = greatest(each(&mut self.rest, stride, |start, rest| {
                let image = &image[start..start + rest.len()];
                arch.dispatch(Subtract { rest, image, length })
            }));
        }
        Err(Error::NotConverged { steps: MAX_STEPS as u64, residual: largest / start })
    }

    /// Lets the solution go `length` along, and then by what was last corrected.
    fn go(&mut self, along: &[f64], length: f64, correction: f64) {
        let corrected = self.levels.correction();
        each(&mut self.solution, self.stride, |start, x| {
            for ((x, along), z) in x.iter_mut().zip(&along[start..]).zip(&corrected[start..]) {
                *x = *x + length * along + f64::from(*z) * correction;
            }
        });
    }

    /// The matrix times `x`, and the scalar products of both by lots of rows.
    fn apply(&self, x: &[f64], out: &mut [f64]) -> Vec<f64> {
        let stride = self.stride;
        let last = out.len() - stride;
        let (arch, diagonal, weights) = (Arch::new(), &self.diagonal, self.weights);
        each(&mut out[stride..last], stride, |start, out| {
            arch.dispatch(Apply { x, diagonal, weights, stride, first: start + stride, out })
        })
    }
}
