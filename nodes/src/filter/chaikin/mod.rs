//! Reverse Chaikin subdivision: a coarse curve or surface of half the samples, and the details that it lacks.
//!
//! Multiresolution of quadratic B-splines (Samavati, F. F. and Bartels, R. H. (1999), "Multiresolution curve and surface
//! representation: reversing subdivision rules by least-squares data fitting", Computer Graphics Forum 18), as void
//! patching uses it (Wecker, Samavati and Gavrilova 2007). What was decomposed is composed again exactly, but for rounding.
//! A curve of an odd number of samples is extended by one in a straight line, which is dropped again.

mod surface;

use orograph_core::prelude::*;

pub use surface::{Bands, Surface};

/// Fewest samples of which a coarse curve can be made.
pub const FEWEST: usize = 4;

/// How the ends of a curve are treated.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Ends go on in a straight line: a steady slope has no details.
    Natural,
    /// The coarse curve keeps the end samples, as in Wecker et al. 2007; slopes at the ends show as details.
    Clamped,
}

/// Samples of the coarse curve of `fine` samples.
#[must_use]
pub fn coarse_len(fine: usize) -> usize {
    fine.div_ceil(2) + 1
}

/// The least length of at least `wanted` samples that can be halved `levels` times without extension: 2^L q + 2.
#[must_use]
pub fn whole_len(wanted: usize, levels: u32) -> usize {
    let unit = 1_usize << levels;
    wanted.saturating_sub(2).div_ceil(unit).max(1) * unit + 2
}

/// The coarse curve and the details of `fine`, which has at least [`FEWEST`] samples; [`coarse_len`] of the one, two fewer
/// of the other.
pub fn decompose(fine: &[f64], boundary: Boundary, coarse: &mut Vec<f64>, details: &mut Vec<f64>) {
    coarse.clear();
    details.clear();
    let at = |i: usize| match fine.get(i) {
        Some(value) => *value,
        None => 2.0 * fine[fine.len() - 1] - fine[fine.len() - 2],
    };
    let m = fine.len().next_multiple_of(2);
    let n = m / 2 + 1;
    let inner = |i: usize, sign: f64| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| at(2 * i - 2 + k));
        -0.25 * a + 0.75 * b + sign * (0.75 * c - 0.25 * d)
    };
    match boundary {
        Boundary::Natural => {
            coarse.push(1.5 * at(0) - 0.5 * at(1));
            coarse.extend((1..n - 1).map(|i| inner(i, 1.0)));
            coarse.push(1.5 * at(m - 1) - 0.5 * at(m - 2));
            details.extend((1..n - 1).map(|i| inner(i, -1.0)));
        }
        Boundary::Clamped if m == FEWEST => {
            let [a, b, c, d] = [0, 1, 2, 3].map(at);
            coarse.extend([a, -0.5 * a + b + c - 0.5 * d, d]);
            details.push(-0.5 * a + b - c + 0.5 * d);
        }
        Boundary::Clamped => {
            let first = |sign: f64| -0.5 * at(0) + at(1) + sign * (0.75 * at(2) - 0.25 * at(3));
            let last =
                |sign: f64| -0.25 * at(m - 4) + 0.75 * at(m - 3) + sign * (at(m - 2) - 0.5 * at(m - 1));
            coarse.extend([at(0), first(1.0)]);
            coarse.extend((2..n - 2).map(|i| inner(i, 1.0)));
            coarse.extend([last(1.0), at(m - 1)]);
            details.push(first(-1.0));
            details.extend((2..n - 2).map(|i| inner(i, -1.0)));
            details.push(last(-1.0));
        }
    }
}

/// The curve of `len` samples that [`decompose`] took apart.
pub fn compose(coarse: &[f64], details: &[f64], boundary: Boundary, len: usize, fine: &mut Vec<f64>) {
    let n = coarse.len();
    fine.clear();
    // Details before the first and after the last are none.
    let detail = |j: usize| j.checked_sub(1).and_then(|j| details.get(j)).copied().unwrap_or(0.0);
    let pair = |j: usize| {
        let (c, next, d, next_d) = (coarse[j], coarse[j + 1], detail(j), detail(j + 1));
        [0.75 * c + 0.25 * next - 0.75 * d + 0.25 * next_d, 0.25 * c + 0.75 * next - 0.25 * d + 0.75 * next_d]
    };
    match boundary {
        Boundary::Natural => fine.extend((0..n - 1).flat_map(pair)),
        Boundary::Clamped => {
            fine.extend([coarse[0], 0.5 * (coarse[0] + coarse[1] + details[0])]);
            fine.extend((1..n - 2).flat_map(pair));
            fine.extend([0.5 * (coarse[n - 2] + coarse[n - 1] - details[n - 3]), coarse[n - 1]]);
        }
    }
    fine.truncate(len);
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::gaussian;

    const BOTH: [Boundary; 2] = [Boundary::Natural, Boundary::Clamped];

    fn halves(fine: &[f64], boundary: Boundary) -> (Vec<f64>, Vec<f64>) {
        let (mut coarse, mut details) = Default::default();
        decompose(fine, boundary, &mut coarse, &mut details);
        (coarse, details)
    }

    #[test]
    fn curves_of_any_length_are_composed_again() {
        for boundary in BOTH {
            for m in FEWEST..70 {
                let fine: Vec<f64> = (0..m as i64).map(|i| 100.0 * gaussian(1, 1, i, m as i64)).collect();
                let (coarse, details) = halves(&fine, boundary);
                assert_eq!((coarse.len(), details.len()), (coarse_len(m), coarse_len(m) - 2));
                let mut again = Vec::new();
                compose(&coarse, &details, boundary, m, &mut again);
                assert_eq!(again.len(), m);
                assert!(again.iter().zip(&fine).all(|(a, b)| (a - b).abs() < 1e-10), "{boundary:?} {m}");
            }
        }
    }

    #[test]
    fn corner_cutting_has_no_details_and_is_reversed() {
        // Chaikin's rule by itself: a quarter and three quarters along each side.
        let coarse: Vec<f64> = (0..9).map(|i| gaussian(2, 2, i, 0)).collect();
        for boundary in BOTH {
            let mut fine: Vec<f64> = coarse
                .windows(2)
                .flat_map(|w| [0.75 * w[0] + 0.25 * w[1], 0.25 * w[0] + 0.75 * w[1]])
                .collect();
            if boundary == Boundary::Clamped {
                // Its first side is cut in half, and its end kept.
                let n = coarse.len();
                (fine[0], fine[1]) = (coarse[0], 0.5 * (coarse[0] + coarse[1]));
                let m = fine.len();
                (fine[m - 2], fine[m - 1]) = (0.5 * (coarse[n - 2] + coarse[n - 1]), coarse[n - 1]);
            }
            let (found, details) = halves(&fine, boundary);
            assert!(found.iter().zip(&coarse).all(|(a, b)| (a - b).abs() < 1e-12), "{boundary:?}");
            assert!(details.iter().all(|detail| detail.abs() < 1e-12), "{boundary:?}");
        }
    }

    #[test]
    fn a_ramp_has_details_only_at_clamped_ends() {
        let ramp: Vec<f64> = (0..20).map(|i| 3.0 * f64::from(i)).collect();
        let (_, natural) = halves(&ramp, Boundary::Natural);
        assert!(natural.iter().all(|detail| detail.abs() < 1e-12));
        let (_, clamped) = halves(&ramp, Boundary::Clamped);
        // A quarter of the slope, of opposite sign at the two ends.
        assert!((clamped[0].abs() - 0.75).abs() < 1e-12 && (clamped[8].abs() - 0.75).abs() < 1e-12);
        assert!(clamped[1..8].iter().all(|detail| detail.abs() < 1e-12));
    }

    #[test]
    fn whole_lengths_are_those_of_the_paper() {
        assert_eq!([3, 11, 19, 27].map(|wanted| whole_len(wanted, 3)), [10, 18, 26, 34]);
        assert_eq!([10, 18].map(|wanted| whole_len(wanted, 3)), [10, 18]);
        assert_eq!(whole_len(5, 1), 6);
        assert_eq!(whole_len(0, 0), 3);
    }
}
