//! Shares of numbers in classes of equal breadth, and how far two such distributions lie apart.
//!
//! Wasserstein-1: the area between the two cumulative distributions, in the numbers' own unit. Jensen–Shannon:
//! Lin, J. (1991), "Divergence measures based on the Shannon entropy", IEEE Transactions on Information Theory
//! 37 (1), to base 2: 0 for equal distributions, 1 for distributions that share no class.

use orograph_core::prelude::*;
use rayon::prelude::*;

/// Shares of numbers in classes of equal breadth.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Lower end of the first class.
    pub low: f64,
    /// Breadth of a class.
    pub step: f64,
    /// Share of the numbers in each class; they sum to 1, or are all 0 without numbers.
    pub shares: Vec<f64>,
    /// How many numbers there were.
    pub count: u64,
}

impl Distribution {
    /// The shares that belong to counts.
    #[must_use]
    pub fn of_counts(low: f64, step: f64, counts: &[u64]) -> Self {
        let count: u64 = counts.iter().sum();
        let shares = counts.iter().map(|&n| n as f64 / count.max(1) as f64).collect();
        Self { low, step, shares, count }
    }

    /// Counts numbers that come row by row into `classes` classes from `low` on; numbers beyond either end
    /// belong to the class there. `row` hands each finite number of a row to the function it is given.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn count(
        rows: usize,
        (low, step, classes): (f64, f64, usize),
        job: &Job,
        row: impl Fn(usize, &mut dyn FnMut(f64)) + Sync,
    ) -> Result<Self> {
        let classes = classes.max(1);
        let last = classes - 1;
        let add = |mut counts: Vec<u64>, r: usize| {
            job.check()?;
            // A number below the first class becomes 0 when it is made an index.
            row(r, &mut |value| counts[(((value - low) / step) as usize).min(last)] += 1);
            Ok(counts)
        };
        let join = |mut a: Vec<u64>, b: Vec<u64>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            Ok(a)
        };
        let none = || vec![0; classes];
        // Whole numbers: their sum does not depend on the order.
        let counts = (0..rows).into_par_iter().with_min_len(16).try_fold(none, add).try_reduce(none, join)?;
        Ok(Self::of_counts(low, step, &counts))
    }

    /// The value at the middle of a class.
    #[must_use]
    pub fn middle(&self, class: usize) -> f64 {
        self.low + (class as f64 + 0.5) * self.step
    }

    /// The value below which `share` (0 to 1) of the numbers lie, numbers spread evenly within their class; NaN
    /// without numbers.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let mut below = 0.0;
        for (class, &own) in self.shares.iter().enumerate() {
            if own > 0.0 && below + own >= share {
                let within = ((share - below) / own).clamp(0.0, 1.0);
                return self.low + (class as f64 + within) * self.step;
            }
            below += own;
        }
        if self.count == 0 { f64::NAN } else { self.low + self.shares.len() as f64 * self.step }
    }

    /// Wasserstein-1 distance to a distribution over the same classes, in the numbers' unit; NaN when either is
    /// empty.
    #[must_use]
    pub fn wasserstein(&self, other: &Self) -> f64 {
        if self.count == 0 || other.count == 0 {
            return f64::NAN;
        }
        let (mut gap, mut area) = (0.0, 0.0);
        for (a, b) in self.shares.iter().zip(&other.shares) {
            gap += a - b;
            area += f64::abs(gap);
        }
        area * self.step
    }

    /// Jensen–Shannon divergence from a distribution over the same classes, 0 to 1; NaN when either is empty.
    #[must_use]
    pub fn jensen_shannon(&self, other: &Self) -> f64 {
        if self.count == 0 || other.count == 0 {
            f64::NAN
        } else {
            jensen_shannon(&self.shares, &other.shares)
        }
    }
}

/// Jensen–Shannon divergence of two vectors of shares to base 2, 0 to 1; NaN when a share is.
#[must_use]
pub fn jensen_shannon(a: &[f64], b: &[f64]) -> f64 {
    let part = |own: f64, middle: f64| if own == 0.0 { 0.0 } else { own * libm::log2(own / middle) };
    let terms = a.iter().zip(b).map(|(&a, &b)| {
        let middle = (a + b) / 2.0;
        (part(a, middle) + part(b, middle)) / 2.0
    });
    // Rounding may leave a hair below nothing; NaN stays NaN.
    let sum = terms.sum::<f64>();
    if sum < 0.0 { 0.0 } else { sum }
}

/// Slope of the least-squares line through points (x, y); NaN for fewer than two places along x.
#[must_use]
pub fn line_slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / n, sum.1 + point.1 / n));
    let (xy, xx) = points.iter().fold((0.0, 0.0), |sum, point| {
        (sum.0 + (point.0 - x) * (point.1 - y), sum.1 + (point.0 - x) * (point.0 - x))
    });
    if xx > 0.0 { xy / xx } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(counts: &[u64]) -> Distribution {
        Distribution::of_counts(0.0, 2.0, counts)
    }

    #[test]
    fn moving_everything_by_a_class_costs_its_breadth() {
        let (a, b) = (of(&[0, 3, 5, 2, 0]), of(&[0, 0, 3, 5, 2]));
        assert!((a.wasserstein(&b) - 2.0).abs() < 1e-12);
        assert_eq!((a.wasserstein(&a), a.jensen_shannon(&a)), (0.0, 0.0));
        assert!(a.wasserstein(&of(&[0; 5])).is_nan() && a.jensen_shannon(&of(&[0; 5])).is_nan());
    }

    #[test]
    fn the_divergence_runs_from_nothing_to_one() {
        assert!((of(&[1, 0]).jensen_shannon(&of(&[0, 1])) - 1.0).abs() < 1e-12);
        // By hand: half of log2(4/3) + half of (log2(2/3) + log2(2)) / 2.
        let hand = 0.5 * libm::log2(4.0 / 3.0) + 0.25 * (libm::log2(2.0 / 3.0) + 1.0);
        assert!((of(&[1, 0]).jensen_shannon(&of(&[1, 1])) - hand).abs() < 1e-12);
    }

    #[test]
    fn numbers_beyond_the_ends_belong_to_the_end_classes() {
        let values = [[-5.0, 0.0, 1.9], [2.0, 3.0, 99.0]];
        let each = |row: usize, hear: &mut dyn FnMut(f64)| values[row].into_iter().for_each(hear);
        let counted = Distribution::count(2, (0.0, 2.0, 3), &Job::detached(), each).unwrap();
        assert_eq!(counted, of(&[3, 2, 1]));
        assert!((counted.quantile(0.5) - 2.0).abs() < 1e-12);
        assert!((counted.quantile(0.25) - 1.0).abs() < 1e-12);
        assert!(of(&[0, 0]).quantile(0.5).is_nan());
    }

    #[test]
    fn a_line_has_its_slope() {
        assert!((line_slope(&[(0.0, 1.0), (1.0, 3.0), (3.0, 7.0)]) - 2.0).abs() < 1e-12);
        assert!(line_slope(&[(1.0, 1.0)]).is_nan() && line_slope(&[]).is_nan());
    }
}
