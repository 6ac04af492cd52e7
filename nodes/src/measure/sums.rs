//! Sums over rasters that have the same bits on any number of threads: rows in parallel, then row by row.

use orograph_core::prelude::*;
use rayon::prelude::*;

/// What `of_row` gives for each row, in order of the rows.
///
/// # Errors
/// [`Error::Cancelled`], and what `of_row` returns.
pub(super) fn per_row<T: Send>(
    rows: usize,
    job: &Job,
    of_row: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let row = |row| {
        job.check()?;
        of_row(row)
    };
    (0..rows).into_par_iter().map(row).collect()
}

/// Count, mean and standard deviation (of the population) of numbers given row by row; NaN for none.
pub(super) struct Moments {
    /// How many numbers.
    pub(super) count: usize,
    /// Their mean.
    pub(super) mean: f64,
    /// Their standard deviation.
    pub(super) deviation: f64,
}

impl Moments {
    /// Visits the numbers twice, first for the mean, so that a large mean costs no precision. `row` hands
    /// each number of a row to the function it is given.
    pub(super) fn of(
        rows: usize,
        job: &Job,
        row: impl Fn(usize, &mut dyn FnMut(f64)) + Sync,
    ) -> Result<Self> {
        let sums = per_row(rows, job, |r| {
            let (mut count, mut sum) = (0usize, 0.0);
            row(r, &mut |value| {
                count += 1;
                sum += value;
            });
            Ok((count, sum))
        })?;
        let (count, sum) = sums.iter().fold((0, 0.0), |all, part| (all.0 + part.0, all.1 + part.1));
        let mean = sum / count as f64;
        let squares = per_row(rows, job, |r| {
            let mut sum = 0.0;
            row(r, &mut |value| sum += (value - mean) * (value - mean));
            Ok(sum)
        })?;
        let deviation = (squares.iter().sum::<f64>() / count as f64).sqrt();
        Ok(Self { count, mean: if count == 0 { f64::NAN } else { mean }, deviation })
    }
}
