//! The seam of a new patch: which of its cells replace what is already there, with the least mismatch along the cut.
//!
//! After Zhou 2007 §5.3, which takes it from Kwatra 2003. The weight of an edge between neighbouring cells s and t of
//! the overlap is `|a(s) - b(s)| + |a(t) - b(t)|`. Of several cuts of the same cost the one with the fewest old cells
//! is taken, so the answer does not depend on the method.

pub mod max_flow;

use orograph_core::prelude::*;

use max_flow::{Network, Pin, min_cut};

/// How the mismatch of two neighbouring cells is weighed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeamWeight {
    /// By their difference in height, as published.
    Plain,
    /// By that over the steps of both surfaces along the edge, which moves seams into rough ground (Kwatra 2003).
    Gradient,
}

/// Who a cell of the window is to belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Whichever the cut gives.
    Either,
    /// What is there already.
    Old,
    /// The new patch.
    New,
}

/// A new patch over the ground that is already there, in the patch's window.
///
/// The window reaches one cell beyond the patch wherever the output does, so that what goes on there is seen.
#[derive(Clone, Copy, Debug)]
pub struct Overlay<'a> {
    /// Number of columns of the window.
    pub cols: usize,
    /// Heights that are there already; NaN where there are none.
    pub old: &'a [f32],
    /// Heights of the new patch; NaN where it has none.
    pub new: &'a [f32],
    /// Cells that must stay or come, beyond those at the rim of the overlap; may be empty.
    pub keep: &'a [Keep],
}

/// A seam.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// Whether each cell of the window is the new patch's.
    pub new: Vec<bool>,
    /// Cost of the cut in metres: the weights of the cut edges added up; a pure number for [`SeamWeight::Gradient`].
    pub cost: f64,
    /// Number of edges cut.
    pub n_cut: usize,
}

impl Seam {
    /// Mean mismatch of a cut edge; 0 without one.
    #[must_use]
    pub fn mean_cost(&self) -> f64 {
        if self.n_cut == 0 { 0.0 } else { self.cost / self.n_cut as f64 }
    }
}

/// Steps below this share of a metre do not make a cut any cheaper, which keeps flat ground from costing infinitely much.
const FLAT: f64 = 1e-3;

/// Most that a capacity may be; the sum of an edge's two directions must fit in 32 bits.
const MAX_CAPACITY: f64 = (1_u64 << 30) as f64;

/// The cheapest seam between old and new.
///
/// # Errors
/// [`Error::Invalid`] when lengths do not agree, cancellation, and refusal of the memory.
pub fn seam(overlay: &Overlay<'_>, weight: SeamWeight, job: &Job<'_>) -> Result<Seam> {
    let Overlay { cols, old, new, keep } = *overlay;
    let n = new.len();
    let fits = old.len() == n && (keep.is_empty() || keep.len() == n);
    if !fits || cols == 0 && n > 0 || cols > 0 && !n.is_multiple_of(cols) {
        return Err(Error::invalid(
            "a patch and the ground below it have different sizes",
            "cut both to one window",
        ));
    }
    let both = |i: usize| !old[i].is_nan() && !new[i].is_nan();
    let mismatch = |i: usize| f64::from((old[i] - new[i]).abs());
    let edge = |i: usize, j: usize| {
        let plain = mismatch(i) + mismatch(j);
        match weight {
            SeamWeight::Plain => plain,
            SeamWeight::Gradient => {
                let step = |heights: &[f32]| f64::from((heights[i] - heights[j]).abs());
                plain / (2.0 * (step(old) + step(new)) + FLAT)
            }
        }
    };
    let (across, below) = (
        |i: usize| !(i + 1).is_multiple_of(cols) && both(i) && both(i + 1),
        |i: usize| i + cols < n && both(i) && both(i + cols),
    );
    let weights = |on: &dyn Fn(usize) -> bool, step: usize| -> Vec<f64> {
        (0..n).map(|i| if on(i) { edge(i, i + step) } else { f64::NAN }).collect()
    };
    let (right, down) = (weights(&across, 1), weights(&below, cols));
    let pins = pins(overlay);
    let overlap = (0..n).filter(|&i| both(i));
    if overlap.into_iter().any(|i| old[i].is_infinite() || new[i].is_infinite()) {
        return Err(Error::invalid(
            "the ground or the patch holds an infinite height",
            "declare that value as nodata in the source",
        ));
    }
    let largest = right.iter().chain(&down).fold(0.0_f64, |most, &w| most.max(w));
    // 1024ths of a metre, or coarser for mismatches that no terrain has; one more prefers short cuts.
    let scale = (MAX_CAPACITY / largest).min(1024.0);
    let capacities = |weights: &[f64]| -> Vec<u32> {
        weights.iter().map(|w| if w.is_nan() { 0 } else { (w * scale).round() as u32 + 1 }).collect()
    };
    let network = Network { cols, right: &capacities(&right), down: &capacities(&down), pins: &pins };
    // Without old cells to keep the cut is nowhere and all is new; the flow's labels say just that.
    let old_side = min_cut(&network, job)?.source_side;
    let (has_old, has_new) = (pins.contains(&Pin::Source), pins.contains(&Pin::Sink));
    let is_new = |i: usize| {
        if both(i) { has_new && !old_side[i] || !has_old } else { !new[i].is_nan() }
    };
    let labels: Vec<bool> = (0..n).map(is_new).collect();
    let mut found = Seam { new: labels, cost: 0.0, n_cut: 0 };
    for (weights, step) in [(&right, 1), (&down, cols)] {
        for (i, &weight) in weights.iter().enumerate() {
            if !weight.is_nan() && found.new[i] != found.new[i + step] {
                found.cost += weight;
                found.n_cut += 1;
            }
        }
    }
    Ok(found)
}

/// The pins of the overlap: beside ground that only one of the two has, and where the caller says so.
fn pins(overlay: &Overlay<'_>) -> Vec<Pin> {
    let Overlay { cols, old, new, keep } = *overlay;
    let n = new.len();
    let pin = |i: usize| {
        if old[i].is_nan() || new[i].is_nan() {
            return Pin::Free;
        }
        let col = i % cols;
        let near = [
            (col > 0).then(|| i - 1),
            (i >= cols).then(|| i - cols),
            (col + 1 < cols).then_some(i + 1),
            (i + cols < n).then_some(i + cols),
        ];
        let beside = |has: &[f32], lacks: &[f32]| {
            near.into_iter().flatten().any(|j| !has[j].is_nan() && lacks[j].is_nan())
        };
        let (beside_old, beside_new) = (beside(old, new), beside(new, old));
        match keep.get(i).copied().unwrap_or(Keep::Either) {
            _ if beside_old => Pin::Source,
            _ if beside_new => Pin::Sink,
            Keep::Old => Pin::Source,
            Keep::New => Pin::Sink,
            Keep::Either => Pin::Free,
        }
    };
    (0..n).map(pin).collect()
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, unit};

    use super::*;

    /// Old ground in all but the right three columns, the new patch in all but the left three, 8 × 12.
    fn strips(difference: impl Fn(usize, usize) -> f64) -> (Vec<f32>, Vec<f32>) {
        let at = |i: usize| (i / 12, i % 12);
        let ground = |i: usize| (100.0 + 3.0 * unit(key(1, 1, i as i64, 0))) as f32;
        let old = (0..96).map(|i| if at(i).1 < 9 { ground(i) } else { f32::NAN }).collect();
        let new = (0..96)
            .map(|i| if at(i).1 >= 3 { ground(i) + difference(at(i).0, at(i).1) as f32 } else { f32::NAN })
            .collect();
        (old, new)
    }

    fn cut(old: &[f32], new: &[f32], keep: &[Keep]) -> Seam {
        let overlay = Overlay { cols: 12, old, new, keep };
        seam(&overlay, SeamWeight::Plain, &Job::detached()).unwrap()
    }

    #[test]
    fn equal_surfaces_cost_nothing_and_the_rim_is_pinned() {
        let (old, new) = strips(|_, _| 0.0);
        let seam = cut(&old, &new, &[]);
        assert_eq!((seam.cost, seam.n_cut), (0.0, 8));
        for row in 0..8 {
            assert!(
                !seam.new[row * 12 + 3]
                    && seam.new[row * 12 + 8]
                    && seam.new[row * 12 + 11]
                    && !seam.new[row * 12]
            );
        }
    }

    #[test]
    fn the_seam_follows_the_column_where_both_agree() {
        let (old, new) = strips(|_, col| if (5..=6).contains(&col) { 0.0 } else { 40.0 });
        let seam = cut(&old, &new, &[]);
        for row in 0..8 {
            assert!(!seam.new[row * 12 + 5] && seam.new[row * 12 + 6]);
        }
        assert!(seam.cost < 1e-3);
    }

    #[test]
    fn pinned_cells_are_kept_and_swapping_sides_costs_the_same() {
        let (old, new) = strips(|row, col| 10.0 * unit(key(7, 7, row as i64, col as i64)));
        let mut keep = vec![Keep::Either; 96];
        (keep[4 * 12 + 7], keep[6 * 12 + 4]) = (Keep::Old, Keep::New);
        let seam = cut(&old, &new, &keep);
        assert!(!seam.new[4 * 12 + 7] && seam.new[6 * 12 + 4]);
        let swapped: Vec<Keep> = keep
            .iter()
            .map(|keep| match keep {
                Keep::Old => Keep::New,
                Keep::New => Keep::Old,
                Keep::Either => Keep::Either,
            })
            .collect();
        let back = cut(&new, &old, &swapped);
        // A cut of least capacity need not be the one of least cost to the last bit: capacities are 1024ths.
        assert!((back.cost - seam.cost).abs() < 0.05, "{} {}", back.cost, seam.cost);
    }

    #[test]
    fn no_overlap_is_no_cut_and_no_pin_is_no_seam() {
        let old = vec![f32::NAN; 24];
        let new = vec![5.0; 24];
        assert_eq!(cut(&old, &new, &[]), Seam { new: vec![true; 24], cost: 0.0, n_cut: 0 });
        let inside = cut(&[1.0; 24], &[5.0; 24], &[]);
        assert_eq!((inside.n_cut, inside.cost), (0, 0.0));
        assert!(cut(&[], &[], &[]).new.is_empty());
        let mut framed = [5.0; 24];
        framed[0] = f32::NAN;
        assert!(cut(&[1.0; 24], &framed, &[]).new.iter().all(|new| !new));
    }

    #[test]
    fn absurd_heights_do_not_overflow() {
        let (mut old, new) = strips(|_, _| 1.0);
        old[5] = 3e38;
        let _ = cut(&old, &new, &[]);
        old[5] = f32::INFINITY;
        let overlay = Overlay { cols: 12, old: &old, new: &new, keep: &[] };
        assert!(seam(&overlay, SeamWeight::Gradient, &Job::detached()).is_err());
    }
}
