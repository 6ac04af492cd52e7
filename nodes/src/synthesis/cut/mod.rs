//! The seam of a new patch: which of its cells replace what is already there, with the least mismatch along the cut.
//!
//! After Zhou 2007 §5.3, which takes it from Kwatra 2003. The weight of an edge between neighbouring cells s and t of
//! the overlap is `|a(s) - b(s)| + |a(t) - b(t)|`. Of several cuts of the same cost the one with the fewest old cells
//! is taken, so the answer does not depend on the method.
//!
//! A step along the seam is spread afterwards; what the eye finds then is the bend that is left where two slopes meet. So
//! there is a weight of slopes, too.

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
    /// By their differences in height and in slope, over how rough the ground is: what shows once the step is spread.
    Slope,
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
    /// The same by heights alone, as [`SeamWeight::Plain`] has it, in metres.
    pub mismatch: f64,
    /// Number of edges cut.
    pub n_cut: usize,
}

impl Seam {
    /// Mean cost of a cut edge; 0 without one.
    #[must_use]
    pub fn mean_cost(&self) -> f64 {
        self.cost / self.n_cut.max(1) as f64
    }

    /// Mean mismatch in height of a cut edge, in metres; 0 without one.
    #[must_use]
    pub fn mean_mismatch(&self) -> f64 {
        self.mismatch / self.n_cut.max(1) as f64
    }
}

/// Steps below this share of a metre do not make a cut any cheaper, which keeps flat ground from costing infinitely much.
const FLAT: f64 = 1e-3;

/// A difference in slope weighs as much as the height that it comes to over so many cells: about as far as the step of a seam
/// is spread.
const REACH: f64 = 16.0;

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
    if (0..n).any(|i| both(i) && (old[i].is_infinite() || new[i].is_infinite())) {
        return Err(Error::invalid(
            "the ground or the patch holds an infinite height",
            "declare that value as nodata in the source",
        ));
    }
    let all_known = new.iter().map(|height| !height.is_nan()).collect();
    let mut found = Seam { new: all_known, cost: 0.0, mismatch: 0.0, n_cut: 0 };
    let Some(overlap) = Overlap::of(cols, n, both) else { return Ok(found) };
    let mismatch = |i: usize, j: usize| {
        let own = |i: usize| f64::from((old[i] - new[i]).abs());
        own(i) + own(j)
    };
    let grounds = match weight {
        SeamWeight::Slope => Some(Grounds::of(overlay, &overlap, job)?),
        SeamWeight::Plain | SeamWeight::Gradient => None,
    };
    let edge = |i: usize, j: usize| {
        if !both(i) || !both(j) {
            return f64::NAN;
        }
        if let Some(grounds) = &grounds {
            return (mismatch(i, j) + REACH * grounds.bend(i, j)) / grounds.roughness(i, j);
        }
        let step = |heights: &[f32]| f64::from((heights[i] - heights[j]).abs());
        match weight {
            SeamWeight::Gradient => mismatch(i, j) / (2.0 * (step(old) + step(new)) + FLAT),
            SeamWeight::Plain | SeamWeight::Slope => mismatch(i, j),
        }
    };
    let right = overlap.map(job, |i, col| if col + 1 < cols { edge(i, i + 1) } else { f64::NAN })?;
    let down = overlap.map(job, |i, _| if i + cols < n { edge(i, i + cols) } else { f64::NAN })?;
    let largest = right.iter().chain(&down).fold(0.0_f64, |most, &w| most.max(w));
    // 1024ths of a metre, or coarser for mismatches that no terrain has; one more prefers short cuts.
    let scale = (MAX_CAPACITY / largest).min(1024.0);
    let capacity = |&weight: &f64| {
        // Rounded by hand, as processors of old round by a call; no weight becomes 0.
        let whole = (weight * scale) as u32;
        let half_up = u32::from(weight * scale - f64::from(whole) >= 0.5);
        if weight.is_nan() { 0 } else { whole + half_up + 1 }
    };
    let capacities = |weights: &[f64]| -> Vec<u32> { weights.iter().map(capacity).collect() };
    job.check()?;
    let pins = overlap.map(job, |i, col| if both(i) { pin(overlay, i, col) } else { Pin::Free })?;
    let (right_capacities, down_capacities) = (capacities(&right), capacities(&down));
    job.check()?;
    let network =
        Network { cols: overlap.cols, right: &right_capacities, down: &down_capacities, pins: &pins };
    // Without old cells to keep the cut is nowhere and all is new; the flow's labels say just that.
    let old_side = min_cut(&network, job)?.source_side;
    job.check()?;
    let (has_old, has_new) = (pins.contains(&Pin::Source), pins.contains(&Pin::Sink));
    let is_new = |old_side: bool| has_new && !old_side || !has_old;
    let mut sides = old_side.iter();
    overlap.map(job, |i, _| {
        let old_side = sides.next().is_some_and(|&side| side);
        found.new[i] = if both(i) { is_new(old_side) } else { found.new[i] };
    })?;
    job.check()?;
    for (weights, step, stride) in [(&right, 1, 1), (&down, overlap.cols, cols)] {
        for (i, &weight) in weights.iter().enumerate() {
            if !weight.is_nan() && is_new(old_side[i]) != is_new(old_side[i + step]) {
                found.cost += weight;
                found.mismatch += mismatch(overlap.cell(i), overlap.cell(i) + stride);
                found.n_cut += 1;
            }
        }
    }
    Ok(found)
}

/// The least rectangle of a window that holds all cells which both surfaces have.
struct Overlap {
    first: usize,
    rows: usize,
    cols: usize,
    stride: usize,
}

impl Overlap {
    /// `None` without such a cell.
    fn of(stride: usize, n: usize, both: impl Fn(usize) -> bool) -> Option<Self> {
        let (mut top, mut bottom, mut left, mut right) = (usize::MAX, 0, usize::MAX, 0);
        for (row, start) in (0..n).step_by(stride.max(1)).enumerate() {
            let Some(first) = (0..stride).find(|&col| both(start + col)) else { continue };
            let last = (first..stride).rfind(|&col| both(start + col)).unwrap_or(first);
            (top, bottom) = (top.min(row), row);
            (left, right) = (left.min(first), right.max(last));
        }
        let (rows, cols) = ((bottom + 1).checked_sub(top)?, right + 1 - left);
        Some(Self { first: top * stride + left, rows, cols, stride })
    }

    /// The number in the window of a cell of the rectangle.
    fn cell(&self, i: usize) -> usize {
        self.first + i / self.cols * self.stride + i % self.cols
    }

    /// What `f` gives for each cell of the rectangle, by its number and its column in the window.
    fn map<T>(&self, job: &Job<'_>, mut f: impl FnMut(usize, usize) -> T) -> Result<Vec<T>> {
        let mut out = Vec::with_capacity(self.rows * self.cols);
        let left = self.first % self.stride;
        for row in 0..self.rows {
            job.check()?;
            let first = self.first + row * self.stride;
            out.extend((0..self.cols).map(|col| f(first + col, left + col)));
        }
        Ok(out)
    }
}

/// The cells beside cell `i` of a window of `n`.
fn neighbours(i: usize, col: usize, cols: usize, n: usize) -> impl Iterator<Item = usize> + Clone {
    let near = [
        (col > 0).then(|| i - 1),
        i.checked_sub(cols),
        (col + 1 < cols).then_some(i + 1),
        (i + cols < n).then_some(i + cols),
    ];
    near.into_iter().flatten()
}

/// How the slopes of both surfaces differ at each cell of a window, and how rough they are; 0 beyond the overlap.
struct Grounds {
    /// Mean difference of their steps to the neighbours, in metres.
    bends: Vec<f32>,
    /// Mean size of these steps, in metres.
    steps: Vec<f32>,
    /// Mean of the latter.
    typical: f64,
}

impl Grounds {
    fn of(overlay: &Overlay<'_>, overlap: &Overlap, job: &Job<'_>) -> Result<Self> {
        let Overlay { cols, old, new, .. } = *overlay;
        let n = new.len();
        let (mut bends, mut steps) = (vec![0.0; n], vec![0.0; n]);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        overlap.map(job, |i, col| {
            let near = neighbours(i, col, cols, n);
            let (mut bend, mut step, mut known) = (0.0, 0.0, 0.0_f32);
            for j in near {
                let (of_old, of_new) = (old[j] - old[i], new[j] - new[i]);
                if !of_old.is_nan() && !of_new.is_nan() {
                    bend += (of_old - of_new).abs();
                    step += 0.5 * (of_old.abs() + of_new.abs());
                    known += 1.0;
                }
            }
            if known > 0.0 {
                (bends[i], steps[i]) = (bend / known, step / known);
                (sum, count) = (sum + f64::from(steps[i]), count + 1.0);
            }
        })?;
        Ok(Self { bends, steps, typical: sum / count.max(1.0) })
    }

    /// The difference in slope at both ends of an edge.
    fn bend(&self, i: usize, j: usize) -> f64 {
        f64::from(self.bends[i]) + f64::from(self.bends[j])
    }

    /// How rough the ground is at an edge, from 1 for none; 2 for what is usual in the overlap.
    fn roughness(&self, i: usize, j: usize) -> f64 {
        let own = 0.5 * (f64::from(self.steps[i]) + f64::from(self.steps[j]));
        1.0 + own / self.typical.max(FLAT)
    }
}

/// The pin of a cell of the overlap: beside ground that only one of the two has, and where the caller says so.
fn pin(overlay: &Overlay<'_>, i: usize, col: usize) -> Pin {
    let Overlay { cols, old, new, keep } = *overlay;
    let near = neighbours(i, col, cols, new.len());
    let beside = |has: &[f32], lacks: &[f32]| near.clone().any(|j| !has[j].is_nan() && lacks[j].is_nan());
    match keep.get(i).copied().unwrap_or(Keep::Either) {
        _ if beside(old, new) => Pin::Source,
        _ if beside(new, old) => Pin::Sink,
        Keep::Old => Pin::Source,
        Keep::New => Pin::Sink,
        Keep::Either => Pin::Free,
    }
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
    fn slopes_that_agree_win_over_heights_that_only_cross() {
        // Surfaces that cross steeply in columns 4 and 5, and run 3 m above each other on parallel slopes in 6 and 7.
        let (old, new) = strips(|_, col| if col >= 6 { 3.0 } else { 4.0 * (col as f64 - 4.5) });
        let by =
            |weight| seam(&Overlay { cols: 12, old: &old, new: &new, keep: &[] }, weight, &Job::detached());
        let (plain, slope) = (by(SeamWeight::Plain).unwrap(), by(SeamWeight::Slope).unwrap());
        for row in 0..8 {
            let first_new = |seam: &Seam| (0..12).find(|&col| seam.new[row * 12 + col]).unwrap();
            assert!(first_new(&plain) == 5 && first_new(&slope) >= 7, "{row}");
        }
        assert!(plain.mismatch <= slope.mismatch && plain.cost == plain.mismatch);
    }

    #[test]
    fn a_weight_of_slopes_does_not_hang_on_the_unit_of_heights() {
        let (old, new) = strips(|row, col| 10.0 * unit(key(9, 7, row as i64, col as i64)));
        let cut = |scale: f32| {
            let scaled = |heights: &[f32]| heights.iter().map(|height| height * scale).collect::<Vec<f32>>();
            let overlay = Overlay { cols: 12, old: &scaled(&old), new: &scaled(&new), keep: &[] };
            seam(&overlay, SeamWeight::Slope, &Job::detached()).unwrap()
        };
        let (own, other) = (cut(1.0), cut(64.0));
        assert!(own.new == other.new && (other.cost / own.cost / 64.0 - 1.0).abs() < 1e-3);
        // On ground without a slope nothing but heights counts.
        let flat = |height: f32, cols: std::ops::Range<usize>| {
            (0..96).map(|i| if cols.contains(&(i % 12)) { height } else { f32::NAN }).collect::<Vec<f32>>()
        };
        let overlay = Overlay { cols: 12, old: &flat(5.0, 0..9), new: &flat(7.0, 3..12), keep: &[] };
        let level = seam(&overlay, SeamWeight::Slope, &Job::detached()).unwrap();
        assert_eq!((level.cost, level.mismatch), (8.0 * 4.0, 8.0 * 4.0));
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
        assert_eq!(cut(&old, &new, &[]), Seam { new: vec![true; 24], cost: 0.0, mismatch: 0.0, n_cut: 0 });
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
