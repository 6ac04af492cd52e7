//! Poisson's equation on a rectangle whose surroundings are fixed: sine transforms along rows, elimination along columns.
//!
//! A sine transform along each row turns the five-point matrix into one tridiagonal matrix for each wave number, which
//! is solved directly. Two rows share one complex Fourier transform. Exact to rounding, O(n log n), for any size.

use std::f64::consts::PI;

use orograph_core::prelude::*;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::columns::Columns;

/// The solution of `sum over four neighbours q of (u_p - u_q) = b_p` with u = 0 all around.
///
/// # Errors
/// [`Error::Invalid`] when `b` is no whole number of rows of `cols`, [`Error::TooLarge`], or cancellation.
pub fn solve(cols: usize, b: &[f64], job: &Job<'_>) -> Result<Vec<f64>> {
    if b.is_empty() {
        return Ok(Vec::new());
    }
    if cols == 0 || !b.len().is_multiple_of(cols) {
        return Err(Error::invalid("a right side is no rectangle", "give one number a cell"));
    }
    job.admit(b.len() as u64 * 32, || format!("the equations of {} cells", b.len()))?;
    let period = 2 * (cols + 1);
    let transform = FftPlanner::new().plan_fft_forward(period);
    let mut waves = vec![0.0; b.len()];
    transform_rows(
        &*transform,
        cols,
        |row, out| out.copy_from_slice(&b[row * cols..][..cols]),
        &mut waves,
        job,
    )?;
    let across = |k: usize| 4.0 - 2.0 * libm::cos(PI * (k as f64 + 1.0) / (cols as f64 + 1.0));
    let columns = Columns::solve(cols, &waves, across, |_| 0.0, job)?;
    let mut out = waves;
    transform_rows(&*transform, cols, |row, out| columns.row(row, out), &mut out, job)?;
    // The sine transform is its own inverse up to this.
    let scale = 2.0 / (cols as f64 + 1.0);
    out.par_chunks_mut(1 << 14).for_each(|part| part.iter_mut().for_each(|x| *x *= scale));
    Ok(out)
}

/// Sine transforms of the rows that `read` gives, two at a time.
fn transform_rows(
    transform: &dyn Fft<f64>,
    cols: usize,
    read: impl Fn(usize, &mut [f64]) + Sync,
    out: &mut [f64],
    job: &Job<'_>,
) -> Result<()> {
    let period = 2 * (cols + 1);
    let zero = Complex64::new(0.0, 0.0);
    out.par_chunks_mut(2 * cols).enumerate().try_for_each_init(
        || {
            (
                vec![zero; period],
                vec![zero; transform.get_inplace_scratch_len()],
                vec![0.0; cols],
                vec![0.0; cols],
            )
        },
        |(buffer, scratch, even, odd), (pair, out)| {
            job.check()?;
            let (first, second) = out.split_at_mut(cols);
            read(2 * pair, even);
            if second.is_empty() {
                odd.fill(0.0);
            } else {
                read(2 * pair + 1, odd);
            }
            (buffer[0], buffer[cols + 1]) = (zero, zero);
            for (k, (&a, &b)) in even.iter().zip(&*odd).enumerate() {
                // Continued as odd functions, whose transforms are purely imaginary.
                buffer[k + 1] = Complex64::new(a, b);
                buffer[period - 1 - k] = Complex64::new(-a, -b);
            }
            transform.process_with_scratch(buffer, scratch);
            for (k, first) in first.iter_mut().enumerate() {
                *first = -buffer[k + 1].im / 2.0;
            }
            for (k, second) in second.iter_mut().enumerate() {
                *second = buffer[k + 1].re / 2.0;
            }
            Ok(())
        },
    )
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, signed_unit};

    use super::*;

    #[test]
    fn the_matrix_times_the_solution_is_the_right_side() {
        for (rows, cols) in [(1, 1), (1, 9), (9, 1), (13, 40), (40, 33), (64, 7)] {
            let truth = |row: usize, col: usize| {
                let inside = (1..=rows).contains(&row) && (1..=cols).contains(&col);
                if inside { 100.0 * signed_unit(key(1, 1, row as i64, col as i64)) } else { 0.0 }
            };
            let right = |row: usize, col: usize| {
                4.0 * truth(row, col)
                    - truth(row - 1, col)
                    - truth(row + 1, col)
                    - truth(row, col - 1)
                    - truth(row, col + 1)
            };
            let b: Vec<f64> = (0..rows * cols).map(|i| right(i / cols + 1, i % cols + 1)).collect();
            let u = solve(cols, &b, &Job::detached()).unwrap();
            for (i, u) in u.into_iter().enumerate() {
                assert!((u - truth(i / cols + 1, i % cols + 1)).abs() < 1e-9, "{rows} × {cols}");
            }
        }
        assert!(solve(4, &[1.0; 6], &Job::detached()).is_err());
        assert!(solve(0, &[], &Job::detached()).unwrap().is_empty());
    }
}
