//! Choosing the k cells of least rank, without sorting and without storing the ranks.

use orograph_core::{Grid, Heightfield, Job, Result};
use rayon::prelude::*;

/// Bits of a rank that one pass sorts out.
const DIGIT: u32 = 12;

/// A copy of `terrain` that keeps `keep` of its measured cells, rounded up: those of least `rank(row, col)`, ties in
/// row-major order. `always` cells are kept besides. All others become voids.
///
/// The rank of the last cell kept is found digit by digit from histograms, whose counts do not depend on threads.
///
/// # Errors
/// [`orograph_core::Error::TooLarge`] when the copy does not fit, or cancellation.
pub(crate) fn keep_least(
    terrain: &Heightfield,
    keep: f64,
    rank: impl Fn(usize, usize) -> u64 + Sync,
    always: impl Fn(usize, usize) -> bool + Sync,
    job: &Job<'_>,
) -> Result<Heightfield> {
    let measured = terrain.grid().len() - terrain.void_count();
    // A share written as a quotient may miss its whole number by a rounding error.
    let wanted = (keep * measured as f64 - 1e-9).ceil().clamp(0.0, measured as f64) as u64;
    let threshold = Threshold::find(terrain, wanted, &rank, job)?;
    let ties = threshold.ties_before_rows(terrain, &rank, job)?;
    Heightfield::build(terrain.grid().clone(), job, |row, out| {
        let mut tie = ties[row];
        for (col, (out, &height)) in out.iter_mut().zip(terrain.row(row)).enumerate() {
            if height.is_nan() {
                continue;
            }
            let rank = rank(row, col) >> threshold.shift;
            let tied = rank == threshold.rank;
            let kept = rank < threshold.rank || (tied && tie < threshold.ties);
            tie += u64::from(tied);
            if kept || always(row, col) {
                *out = height;
            }
        }
        Ok(())
    })
}

/// The leading bits of the last rank kept.
struct Threshold {
    rank: u64,
    /// Bits that need not be looked at.
    shift: u32,
    /// How many cells of that very rank are kept.
    ties: u64,
}

impl Threshold {
    fn find(
        terrain: &Heightfield,
        wanted: u64,
        rank: &(impl Fn(usize, usize) -> u64 + Sync),
        job: &Job<'_>,
    ) -> Result<Self> {
        let mut found = Self { rank: 0, shift: u64::BITS, ties: wanted };
        loop {
            if found.shift == 0 {
                return Ok(found);
            }
            let digit = DIGIT.min(found.shift);
            let shift = found.shift - digit;
            let counts = histogram(terrain, job, digit, |row, col| {
                let leading = rank(row, col) >> shift;
                let same = found.shift == u64::BITS || leading >> digit == found.rank;
                same.then_some((leading & ((1 << digit) - 1)) as usize)
            })?;
            let mut before = 0;
            let mut bin = 0;
            while bin + 1 < counts.len() && before + counts[bin] < found.ties {
                before += counts[bin];
                bin += 1;
            }
            let leading = if found.shift == u64::BITS { 0 } else { found.rank << digit };
            found = Self { rank: leading | bin as u64, shift, ties: found.ties - before };
            // A bin that is kept whole, or not at all, needs no closer look.
            if found.ties == counts[bin] || found.ties == 0 {
                return Ok(found);
            }
        }
    }

    /// For each row, how many cells of the threshold's rank lie in the rows before it.
    fn ties_before_rows(
        &self,
        terrain: &Heightfield,
        rank: &(impl Fn(usize, usize) -> u64 + Sync),
        job: &Job<'_>,
    ) -> Result<Vec<u64>> {
        let tied = |row: usize| {
            let cells = terrain.row(row).iter().enumerate().filter(|(_, height)| !height.is_nan());
            cells.filter(|(col, _)| rank(row, *col) >> self.shift == self.rank).count() as u64
        };
        let in_row: Vec<u64> = (0..terrain.rows())
            .into_par_iter()
            .map(|row| job.check().map(|()| tied(row)))
            .collect::<Result<_>>()?;
        let before = in_row.iter().scan(0, |sum, &n| Some(std::mem::replace(sum, *sum + n)));
        Ok(before.collect())
    }
}

fn histogram(
    terrain: &Heightfield,
    job: &Job<'_>,
    digit: u32,
    bin_of: impl Fn(usize, usize) -> Option<usize> + Sync,
) -> Result<Vec<u64>> {
    let empty = || vec![0_u64; 1 << digit];
    let Grid { rows, cols, .. } = *terrain.grid();
    (0..rows)
        .into_par_iter()
        .with_min_len((65_536 / cols.max(1)).max(1))
        .try_fold(empty, |mut counts, row| {
            job.check()?;
            for (col, height) in terrain.row(row).iter().enumerate() {
                if !height.is_nan()
                    && let Some(bin) = bin_of(row, col)
                {
                    counts[bin] += 1;
                }
            }
            Ok(counts)
        })
        .try_reduce(empty, |mut a, b| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            Ok(a)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn the_least_ranks_are_kept_with_ties_in_row_major_order() {
        for (rows, cols, spread) in [(7, 9, 5), (1, 40, 1), (30, 30, 100_000), (5, 5, u64::MAX)] {
            let rank = |row: usize, col: usize| orograph_core::key(1, 2, row as i64, col as i64) % spread;
            let terrain =
                field(
                    rows,
                    cols,
                    |row, col| if (row + col) % 4 == 0 { f64::NAN } else { (row * cols + col) as f64 },
                );
            let mut order: Vec<(u64, usize)> = (0..rows * cols)
                .filter(|i| !terrain.cells()[*i].is_nan())
                .map(|i| (rank(i / cols, i % cols), i))
                .collect();
            order.sort_unstable();
            for keep in [0.0, 0.01, 0.1, 0.5, 0.99, 1.0] {
                let kept = keep_least(&terrain, keep, rank, |_, _| false, &Job::detached()).unwrap();
                let n = (keep * order.len() as f64).ceil() as usize;
                let mut expected = vec![f32::NAN.to_bits(); rows * cols];
                order[..n].iter().for_each(|&(_, i)| expected[i] = terrain.cells()[i].to_bits());
                let bits: Vec<u32> = kept.cells().iter().map(|height| height.to_bits()).collect();
                assert_eq!(bits, expected, "{keep} of {rows} × {cols}, ranks below {spread}");
            }
        }
    }
}
