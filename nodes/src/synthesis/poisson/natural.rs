//! A surface from its steps: gradient-domain reconstruction on a rectangle with free borders, by cosine transforms.
//!
//! Minimises, over all edges between neighbouring cells, the squared difference between the surface's step and the step
//! wanted, plus `hold` times the squared distance from a given surface, which ties down what steps alone leave open: the
//! level, and slow drift. Cosine transforms along rows make one tridiagonal system of each wave number. Exact to
//! rounding, O(n log n), for any size.

use std::f64::consts::PI;

use orograph_core::prelude::*;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::columns::Columns;

/// The least-squares change `u` for `sum over neighbours q of (u_p - u_q) + hold u_p = b_p`, without flow over the border.
///
/// # Errors
/// [`Error::Invalid`] when `b` is no whole number of rows of `cols` or `hold` is not positive, [`Error::TooLarge`], or
/// cancellation.
pub fn solve(cols: usize, b: &[f64], hold: f64, job: &Job<'_>) -> Result<Vec<f64>> {
    if b.is_empty() {
        return Ok(Vec::new());
    }
    if cols == 0 || !b.len().is_multiple_of(cols) || hold.is_nan() || hold <= 0.0 {
        return Err(Error::invalid(
            "a right side is no rectangle, or nothing holds its solution",
            "give one number a cell",
        ));
    }
    job.admit(b.len() as u64 * 32, || format!("the equations of {} cells", b.len()))?;
    let rows = b.len() / cols;
    let cosines = Cosines::new(cols);
    let mut waves = vec![0.0; b.len()];
    cosines.forward(b, &mut waves, job)?;
    let across = |k: usize| 2.0 - 2.0 * libm::cos(PI * k as f64 / cols as f64) + hold;
    // The first and the last row have one neighbour less.
    let down = |row: usize| f64::from(u8::from(row > 0) + u8::from(row + 1 < rows));
    let columns = Columns::solve(cols, &waves, across, down, job)?;
    waves.chunks_mut(cols).enumerate().for_each(|(row, out)| columns.row(row, out));
    let mut out = vec![0.0; b.len()];
    cosines.inverse(&waves, &mut out, job)?;
    Ok(out)
}

/// Cosine transforms of rows, two of which share one complex transform of twice the length.
struct Cosines {
    cols: usize,
    forward: std::sync::Arc<dyn Fft<f64>>,
    inverse: std::sync::Arc<dyn Fft<f64>>,
    turns: Vec<Complex64>,
}

impl Cosines {
    fn new(cols: usize) -> Self {
        let mut planner = FftPlanner::new();
        let turn = |k: usize| {
            let angle = PI * k as f64 / (2.0 * cols as f64);
            Complex64::new(libm::cos(angle), libm::sin(angle))
        };
        Self {
            cols,
            forward: planner.plan_fft_forward(2 * cols),
            inverse: planner.plan_fft_inverse(2 * cols),
            turns: (0..cols).map(turn).collect(),
        }
    }

    fn each_pair(
        &self,
        transform: &dyn Fft<f64>,
        from: &[f64],
        to: &mut [f64],
        work: impl Fn(&[f64], &mut [f64], &mut [Complex64], &mut dyn FnMut(&mut [Complex64])) + Sync,
        job: &Job<'_>,
    ) -> Result<()> {
        let zero = Complex64::new(0.0, 0.0);
        let cols = self.cols;
        to.par_chunks_mut(2 * cols).zip(from.par_chunks(2 * cols)).try_for_each_init(
            || (vec![zero; 2 * cols], vec![zero; transform.get_inplace_scratch_len()]),
            |(buffer, scratch), (to, from)| {
                job.check()?;
                work(from, to, buffer, &mut |buffer| transform.process_with_scratch(buffer, scratch));
                Ok(())
            },
        )
    }

    fn forward(&self, from: &[f64], to: &mut [f64], job: &Job<'_>) -> Result<()> {
        let cols = self.cols;
        let work = |from: &[f64],
                    to: &mut [f64],
                    buffer: &mut [Complex64],
                    run: &mut dyn FnMut(&mut [Complex64])| {
            for k in 0..cols {
                // Continued as even functions about the border, half a cell outside.
                let value = Complex64::new(from[k], from.get(cols + k).copied().unwrap_or(0.0));
                (buffer[k], buffer[2 * cols - 1 - k]) = (value, value);
            }
            run(buffer);
            for k in 0..cols {
                let value = buffer[k] * self.turns[k].conj() * 0.5;
                to[k] = value.re;
                if let Some(second) = to.get_mut(cols + k) {
                    *second = value.im;
                }
            }
        };
        self.each_pair(&*self.forward, from, to, work, job)
    }

    fn inverse(&self, from: &[f64], to: &mut [f64], job: &Job<'_>) -> Result<()> {
        let cols = self.cols;
        let scale = 1.0 / cols as f64;
        let work = |from: &[f64],
                    to: &mut [f64],
                    buffer: &mut [Complex64],
                    run: &mut dyn FnMut(&mut [Complex64])| {
            buffer[cols] = Complex64::new(0.0, 0.0);
            for k in 0..cols {
                let value = Complex64::new(from[k], from.get(cols + k).copied().unwrap_or(0.0)) * scale;
                buffer[k] = value * self.turns[k];
                if k > 0 {
                    buffer[2 * cols - k] = value * self.turns[k].conj();
                }
            }
            run(buffer);
            for k in 0..cols {
                to[k] = buffer[k].re;
                if let Some(second) = to.get_mut(cols + k) {
                    *second = buffer[k].im;
                }
            }
        };
        self.each_pair(&*self.inverse, from, to, work, job)
    }
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, signed_unit};

    use super::*;

    #[test]
    fn the_matrix_times_the_solution_is_the_right_side() {
        for (rows, cols, hold) in
            [(1, 1, 0.5), (1, 9, 1e-3), (9, 1, 1e-3), (13, 40, 1e-4), (40, 33, 0.1), (64, 7, 1e-6)]
        {
            let truth = |i: usize| 100.0 * signed_unit(key(1, 1, i as i64, 0));
            let right = |i: usize| {
                let col = i % cols;
                let near = [
                    (col > 0).then(|| i - 1),
                    i.checked_sub(cols),
                    (col + 1 < cols).then_some(i + 1),
                    (i + cols < rows * cols).then_some(i + cols),
                ];
                near.into_iter().flatten().map(|j| truth(i) - truth(j)).sum::<f64>() + hold * truth(i)
            };
            let b: Vec<f64> = (0..rows * cols).map(right).collect();
            let u = solve(cols, &b, hold, &Job::detached()).unwrap();
            for (i, u) in u.into_iter().enumerate() {
                assert!((u - truth(i)).abs() < 1e-6, "{rows} × {cols}: {u} {}", truth(i));
            }
        }
        assert!(solve(4, &[1.0; 6], 1.0, &Job::detached()).is_err());
        assert!(solve(2, &[1.0; 6], 0.0, &Job::detached()).is_err());
        assert!(solve(0, &[], 1.0, &Job::detached()).unwrap().is_empty());
    }
}
