//! Seam removal: the step at a cut is spread over the overlap, all other steps are kept (Zhou 2007, appendix B).
//!
//! Solved for what is added to the composite: at every cell of the overlap the sum of its four steps is to be what it
//! was, except that a step across the seam becomes the wanted one. So the right side is zero away from the seam, and
//! without a seam nothing changes to the bit. The paper wants no step at all across the seam; that deletes the slope
//! that belongs there and leaves a terrace of one cell, so the default is the mean of the two surfaces' own steps.

use orograph_core::prelude::*;

use super::{
    masked::{Cell, Domain, solve},
    rectangle,
};

/// The step that is wanted across a seam.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeamGradient {
    /// The mean of the steps that the old and the new surface have there.
    Average,
    /// None, as published.
    Zero,
}

/// Two surfaces and whose each cell is.
#[derive(Clone, Copy, Debug)]
pub struct Composite<'a> {
    /// Number of columns.
    pub cols: usize,
    /// Heights that were there; NaN where there were none.
    pub old: &'a [f32],
    /// Heights of the patch; NaN where it has none.
    pub new: &'a [f32],
    /// Whether each cell is the patch's.
    pub is_new: &'a [bool],
}

impl Composite<'_> {
    /// The height of a cell before its seams are removed.
    #[must_use]
    pub fn height(&self, i: usize) -> f32 {
        if self.is_new[i] && !self.new[i].is_nan() { self.new[i] } else { self.old[i] }
    }

    /// The step wanted from cell `i` to its neighbour `j`, on the other side of the seam.
    fn step(&self, i: usize, j: usize, gradient: SeamGradient) -> f64 {
        if gradient == SeamGradient::Zero {
            return 0.0;
        }
        let own = |heights: &[f32]| f64::from(heights[j]) - f64::from(heights[i]);
        let (old, new) = (own(self.old), own(self.new));
        match (old.is_nan(), new.is_nan()) {
            (false, false) => f64::midpoint(old, new),
            (false, true) => old,
            (true, false) => new,
            (true, true) => 0.0,
        }
    }
}

/// What is to be added to each cell of the composite. The overlap, where both have heights, moves, and `grow` cells
/// beyond it; all else stays.
///
/// # Errors
/// [`Error::Invalid`] when lengths do not agree, and those of the solvers.
pub fn correction(
    composite: &Composite<'_>,
    gradient: SeamGradient,
    grow: usize,
    job: &Job<'_>,
) -> Result<Vec<f64>> {
    job.check()?;
    let Composite { cols, old, new, is_new } = *composite;
    let n = old.len();
    if new.len() != n || is_new.len() != n || cols == 0 && n > 0 || cols > 0 && !n.is_multiple_of(cols) {
        return Err(Error::invalid(
            "a patch and the ground below it have different sizes",
            "cut both to one window",
        ));
    }
    let both = |i: usize| !old[i].is_nan() && !new[i].is_nan();
    let kind = |i: usize| match composite.height(i) {
        height if height.is_nan() => Cell::Outside,
        _ if both(i) => Cell::Free,
        _ => Cell::Fixed,
    };
    let mut cells: Vec<Cell> = (0..n).map(kind).collect();
    for _ in 0..grow {
        job.check()?;
        let before = cells.clone();
        for (row, start) in (0..n).step_by(cols.max(1)).enumerate() {
            if row.is_multiple_of(64) {
                job.check()?;
            }
            for (col, i) in (start..start + cols).enumerate() {
                if before[i] == Cell::Fixed {
                    let free = |inside: bool, j: usize| inside && before[j] == Cell::Free;
                    let beside = free(col > 0, i.wrapping_sub(1))
                        || free(col + 1 < cols, i + 1)
                        || free(row > 0, i.wrapping_sub(cols))
                        || free(i + cols < n, i + cols);
                    cells[i] = if beside { Cell::Free } else { Cell::Fixed };
                }
            }
        }
    }
    job.check()?;
    let mut right = vec![0.0; n];
    let mut edge = |i: usize, j: usize| {
        let has = cells[i] != Cell::Outside && cells[j] != Cell::Outside;
        if has && is_new[i] != is_new[j] {
            let step = f64::from(composite.height(j)) - f64::from(composite.height(i));
            let excess = step - composite.step(i, j, gradient);
            right[i] += excess;
            right[j] -= excess;
        }
    };
    for (row, start) in (0..n).step_by(cols.max(1)).enumerate() {
        if row.is_multiple_of(64) {
            job.check()?;
        }
        for (col, i) in (start..start + cols).enumerate() {
            if col + 1 < cols {
                edge(i, i + 1);
            }
            if i + cols < n {
                edge(i, i + cols);
            }
        }
    }
    job.check()?;
    let driven = |i: usize| cells[i] == Cell::Free && right[i] != 0.0;
    if !(0..n).any(driven) {
        return Ok(vec![0.0; n]);
    }
    if let Some([top, left, rows, width]) = lone_rectangle(cols, &cells) {
        let inner: Vec<f64> =
            (0..rows * width).map(|i| right[(top + i / width) * cols + left + i % width]).collect();
        let mut out = vec![0.0; n];
        for (row, values) in rectangle::solve(width, &inner, job)?.chunks(width).enumerate() {
            out[(top + row) * cols + left..][..width].copy_from_slice(values);
        }
        return Ok(out);
    }
    solve(&Domain { cols, cells: &cells, weights: [1.0; 2] }, &right, job)
}

/// Top, left, rows and columns of the free cells, when they are one rectangle with fixed cells all around.
fn lone_rectangle(cols: usize, cells: &[Cell]) -> Option<[usize; 4]> {
    let first = cells.iter().position(|&cell| cell == Cell::Free)?;
    let last = cells.iter().rposition(|&cell| cell == Cell::Free)?;
    let (top, left, bottom, right) = (first / cols, first % cols, last / cols, last % cols);
    let inside =
        top > 0 && left > 0 && (bottom + 1) * cols < cells.len() && right + 1 < cols && right >= left;
    if !inside {
        return None;
    }
    let fits = cells.iter().enumerate().all(|(i, &cell)| {
        let (row, col) = (i / cols, i % cols);
        let across = (left..=right).contains(&col);
        let down = (top..=bottom).contains(&row);
        let beside =
            across && (row + 1 == top || row == bottom + 1) || down && (col + 1 == left || col == right + 1);
        match cell {
            Cell::Free => across && down,
            Cell::Fixed => !(across && down),
            Cell::Outside => !(beside || across && down),
        }
    });
    fits.then_some([top, left, bottom + 1 - top, right + 1 - left])
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, signed_unit};

    use super::*;

    fn corrected(composite: &Composite<'_>, gradient: SeamGradient) -> Vec<f64> {
        let added = correction(composite, gradient, 0, &Job::detached()).unwrap();
        added.iter().enumerate().map(|(i, add)| f64::from(composite.height(i)) + add).collect()
    }

    fn noise(seed: u64, n: usize) -> Vec<f32> {
        (0..n)
            .map(|i| 1000.0 + (400.0 * signed_unit(key(seed, 0, i as i64, 0))).round() as f32 / 8.0)
            .collect()
    }

    #[test]
    fn without_a_seam_nothing_moves() {
        let (old, new) = (noise(1, 200), noise(2, 200));
        let composite = Composite { cols: 20, old: &old, new: &new, is_new: &[true; 200] };
        for gradient in [SeamGradient::Average, SeamGradient::Zero] {
            assert_eq!(correction(&composite, gradient, 0, &Job::detached()).unwrap(), vec![0.0; 200]);
        }
    }

    #[test]
    fn along_a_line_the_step_is_spread_evenly() {
        // Ten cells; old ground on the first eight, the patch on the last eight; the seam after the fourth.
        let old: Vec<f32> = (0..10).map(|i| if i < 8 { 100.0 + i as f32 } else { f32::NAN }).collect();
        let new: Vec<f32> = (0..10).map(|i| if i < 2 { f32::NAN } else { 120.0 + i as f32 }).collect();
        let is_new: Vec<bool> = (0..10).map(|i| i >= 4).collect();
        let composite = Composite { cols: 10, old: &old, new: &new, is_new: &is_new };
        // Six free cells, so seven edges from fixed to fixed; Zero removes 21 m of step, Average the 20 m of offset.
        for (gradient, step) in [(SeamGradient::Zero, 21.0), (SeamGradient::Average, 20.0)] {
            for (i, height) in corrected(&composite, gradient).into_iter().enumerate() {
                let before = f64::from(composite.height(i));
                let along = (i as f64 - 1.0).clamp(0.0, 7.0);
                let truth = before + step * along / 7.0 - if i >= 4 { step } else { 0.0 };
                assert!((height - truth).abs() < 1e-4, "{gradient:?} {i}: {height} {truth}");
            }
        }
    }

    /// Old ground everywhere, the patch on a square inside with a frame around; the seam is an inner ring.
    fn inlay(offset: f32, hole: bool) -> (Vec<f32>, Vec<f32>, Vec<bool>) {
        let old = noise(3, 30 * 30);
        let inside = |i: usize, by: usize| {
            (5 + by..25 - by).contains(&(i / 30)) && (5 + by..25 - by).contains(&(i % 30))
        };
        let new: Vec<f32> = (0..900)
            .map(|i| if inside(i, 0) && !(hole && i == 15 * 30 + 15) { old[i] + offset } else { f32::NAN })
            .collect();
        let is_new = (0..900).map(|i| inside(i, 4) && !new[i].is_nan()).collect();
        (old, new, is_new)
    }

    #[test]
    fn a_raised_copy_comes_down_as_a_harmonic_field() {
        // By the fast way for rectangles and, with a fixed cell within, by the general one.
        for hole in [false, true] {
            let (old, new, is_new) = inlay(40.0, hole);
            let composite = Composite { cols: 30, old: &old, new: &new, is_new: &is_new };
            let heights = corrected(&composite, SeamGradient::Average);
            let above: Vec<f64> = heights.iter().zip(&old).map(|(h, &old)| h - f64::from(old)).collect();
            for i in 0..900 {
                let inside = (5..25).contains(&(i / 30)) && (5..25).contains(&(i % 30));
                if inside && !new[i].is_nan() {
                    let mean = (above[i - 1] + above[i + 1] + above[i - 30] + above[i + 30]) / 4.0;
                    assert!((above[i] - mean).abs() < 1e-4, "{hole} {i}: {} {mean}", above[i]);
                } else {
                    assert_eq!(heights[i], f64::from(composite.height(i)));
                }
            }
        }
    }

    #[test]
    fn both_solvers_agree() {
        let (old, mut new, is_new) = inlay(40.0, false);
        new.iter_mut().enumerate().for_each(|(i, h)| *h += (i % 7) as f32);
        let composite = Composite { cols: 30, old: &old, new: &new, is_new: &is_new };
        let fast = correction(&composite, SeamGradient::Zero, 0, &Job::detached()).unwrap();
        // A cell far outside without value makes it no lone rectangle only if it is beside: put one at a corner's side.
        let mut holed = old.clone();
        holed[4 * 30 + 4] = f32::NAN;
        let general = {
            let composite = Composite { old: &holed, ..composite };
            let cells: Vec<Cell> =
                (0..900).map(|i| if !new[i].is_nan() { Cell::Free } else { Cell::Fixed }).collect();
            let mut right = vec![0.0; 900];
            for i in 0..900 {
                for j in [i + 1, i + 30] {
                    if j < 900 && is_new[i] != is_new[j] {
                        let step = f64::from(composite.height(j)) - f64::from(composite.height(i));
                        right[i] += step;
                        right[j] -= step;
                    }
                }
            }
            solve(&Domain { cols: 30, cells: &cells, weights: [1.0; 2] }, &right, &Job::detached()).unwrap()
        };
        for (fast, general) in fast.iter().zip(general) {
            assert!((fast - general).abs() < 1e-4, "{fast} {general}");
        }
    }

    #[test]
    fn flat_ground_moves_by_no_more_than_the_step() {
        let (_, new, is_new) = inlay(0.0, true);
        let old = vec![0.0_f32; 900];
        let new: Vec<f32> = new.iter().map(|h| if h.is_nan() { f32::NAN } else { 7.0 }).collect();
        let composite = Composite { cols: 30, old: &old, new: &new, is_new: &is_new };
        let heights = corrected(&composite, SeamGradient::Zero);
        assert!(
            heights.iter().enumerate().all(|(i, h)| (h - f64::from(composite.height(i))).abs() <= 7.0 + 1e-4)
        );
    }
}
