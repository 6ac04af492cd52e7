//! The discrete Fourier transform of a plane.

use orograph_core::prelude::*;
use rayon::prelude::*;
use rustfft::{FftDirection, FftPlanner, num_complex::Complex};

/// Transforms rows × columns of numbers, row-major, without scaling. The result lies column by column: transforming
/// it back gives the numbers in their own order, times their count.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub(super) fn transform(
    cells: Vec<Complex<f64>>,
    (rows, cols): (usize, usize),
    direction: FftDirection,
    job: &Job,
) -> Result<Vec<Complex<f64>>> {
    if cells.is_empty() || rows * cols != cells.len() {
        return Ok(Vec::new());
    }
    // The numbers themselves, and once more while they are turned.
    job.admit(cells.len() as u64 * 32, || format!("a Fourier transform of {rows} × {cols} cells"))?;
    let mut planner = FftPlanner::new();
    let mut cells = cells;
    lines(&mut cells, cols, &mut planner, direction, job)?;
    let mut turned = vec![Complex::default(); cells.len()];
    turned.par_chunks_mut(rows).enumerate().try_for_each(|(col, line)| {
        job.check()?;
        line.iter_mut().enumerate().for_each(|(row, cell)| *cell = cells[row * cols + col]);
        Ok(())
    })?;
    lines(&mut turned, rows, &mut planner, direction, job)?;
    Ok(turned)
}

fn lines(
    cells: &mut [Complex<f64>],
    long: usize,
    planner: &mut FftPlanner<f64>,
    direction: FftDirection,
    job: &Job,
) -> Result<()> {
    let plan = planner.plan_fft(long, direction);
    let scratch = || vec![Complex::default(); plan.get_inplace_scratch_len()];
    cells.par_chunks_mut(long).try_for_each_init(scratch, |scratch, line| {
        job.check()?;
        plan.process_with_scratch(line, scratch);
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn it_is_the_sum_that_defines_it_and_turns_back() {
        let (rows, cols) = (6, 7);
        let cells: Vec<_> =
            (0..42).map(|i| Complex::new(((i * 31) % 17) as f64, ((i * 13) % 5) as f64)).collect();
        let job = Job::detached();
        let found = transform(cells.clone(), (rows, cols), FftDirection::Forward, &job).unwrap();
        for (v, u) in [(0, 0), (1, 3), (5, 6), (2, 1)] {
            let mut sum = Complex::<f64>::default();
            for (i, cell) in cells.iter().enumerate() {
                let turn = (i / cols * v) as f64 / rows as f64 + (i % cols * u) as f64 / cols as f64;
                let (sine, cosine) = libm::sincos(-TAU * turn);
                sum += cell * Complex::new(cosine, sine);
            }
            assert!((found[u * rows + v] - sum).norm() < 1e-9);
        }
        let back = transform(found, (cols, rows), FftDirection::Inverse, &job).unwrap();
        assert!(back.iter().zip(&cells).all(|(back, cell)| (back / 42.0 - cell).norm() < 1e-12));
    }
}
