//! How far apart the slopes of two terrains are: the Wasserstein-1 distance of their histograms.
//!
//! Slopes after Horn (see [`surface`]) in bins of 1°, so that the distance is the sum of the differences of the two
//! cumulative distributions, in degrees: how far the slopes would have to be turned, on average.

use orograph_core::prelude::*;

use super::sums::per_row;
use crate::surface;

const BINS: usize = 90;

/// The distance in degrees over the cells that `counts` holds for and whose slope both terrains know; NaN for none.
pub(super) fn slope_distance(
    terrain: &Heightfield,
    reference: &Heightfield,
    counts: impl Fn(usize, usize) -> bool + Sync,
    job: &Job,
) -> Result<f64> {
    let bin = |gradient| (surface::slope_degrees(gradient) as usize).min(BINS - 1);
    let rows = per_row(terrain.rows(), job, |row| {
        let mut histograms = [[0_u32; 2]; BINS];
        for col in (0..terrain.cols()).filter(|&col| counts(row, col)) {
            let slopes = (surface::gradient(terrain, row, col), surface::gradient(reference, row, col));
            // Beside a void the reference may know a neighbour that the terrain lacks, and its slope is another's.
            if let (Some(own), Some(truth)) = slopes {
                histograms[bin(own)][0] += 1;
                histograms[bin(truth)][1] += 1;
            }
        }
        Ok(histograms)
    })?;
    let mut sums = [[0_u64; 2]; BINS];
    for histograms in rows {
        for (sum, row) in sums.iter_mut().zip(histograms) {
            sum[0] += u64::from(row[0]);
            sum[1] += u64::from(row[1]);
        }
    }
    let count: u64 = sums.iter().map(|pair| pair[0]).sum();
    let (mut ahead, mut distance) = (0_i64, 0_u64);
    for [own, truth] in sums {
        ahead += own as i64 - truth as i64;
        distance += ahead.unsigned_abs();
    }
    Ok(distance as f64 / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    /// A plane that rises eastward at so many degrees, on cells of 10 m.
    fn plane(degrees: f64) -> Heightfield {
        let rise = 10.0 * libm::tan(degrees.to_radians());
        field(8, 9, |_, col| rise * col as f64)
    }

    #[test]
    fn planes_are_as_far_apart_as_their_slopes() {
        let job = Job::detached();
        for (a, b, apart) in [(10.5, 10.5, 0.0), (10.5, 30.5, 20.0), (30.5, 10.5, 20.0), (0.2, 79.5, 79.0)] {
            assert_eq!(slope_distance(&plane(a), &plane(b), |_, _| true, &job).unwrap(), apart, "{a} {b}");
        }
        assert!(slope_distance(&plane(1.0), &plane(2.0), |_, _| false, &job).unwrap().is_nan());
    }

    #[test]
    fn only_the_cells_that_count_are_compared() {
        let job = Job::detached();
        // Steep in the east alone.
        let bent = field(8, 9, |_, col| if col < 5 { 0.0 } else { 1000.0 * (col - 4) as f64 });
        let flat = plane(0.0);
        let over = |from: usize, to: usize| {
            slope_distance(&bent, &flat, |_, col| (from..to).contains(&col), &job).unwrap()
        };
        assert_eq!(over(0, 4), 0.0);
        assert!(over(6, 9) > 80.0 && over(0, 9) > 20.0);
    }
}
