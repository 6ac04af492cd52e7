//! A first guess: means of known cells over squares of doubling size, smoothed on the way back.

use orograph_core::{Job, Result};
use rayon::prelude::*;

/// Cells that one task takes at least.
const CELLS: usize = 1 << 14;

/// Heights at free cells from the known ones around, near and far; known cells keep theirs. Zero where nothing is known.
///
/// # Errors
/// [`Error::Cancelled`](orograph_core::Error::Cancelled).
pub(super) fn start(
    heights: &[f64],
    free: &[bool],
    (rows, cols): (usize, usize),
    job: &Job<'_>,
) -> Result<Vec<f64>> {
    let each = |n: usize| (0..n).into_par_iter().with_min_len(CELLS);
    let known =
        each(rows * cols).map(|i| if free[i] { (0.0, 0.0) } else { (heights[i] as f32, 1.0) }).collect();
    let mut levels: Vec<Means> = vec![Means { size: (rows, cols), cells: known }];
    while let Some(last) = levels.last().filter(|last| last.size.0 * last.size.1 > 1 && last.has_gaps()) {
        job.check()?;
        levels.push(last.halved());
    }
    let mut coarse: Option<(Vec<f32>, (usize, usize))> = None;
    for level in levels.iter().rev() {
        job.check()?;
        let filled = each(level.cells.len()).map(|i| {
            let (mean, weight) = level.cells[i];
            match &coarse {
                _ if weight > 0.0 => mean,
                Some((coarse, size)) => between(coarse, *size, i / level.size.1, i % level.size.1),
                None => 0.0,
            }
        });
        coarse = Some((filled.collect(), level.size));
    }
    let guess = coarse.map_or_else(Vec::new, |(cells, _)| cells);
    Ok(each(rows * cols).map(|i| if free[i] { f64::from(guess[i]) } else { heights[i] }).collect())
}

/// Means of known cells and how many there are.
struct Means {
    size: (usize, usize),
    cells: Vec<(f32, f32)>,
}

impl Means {
    fn has_gaps(&self) -> bool {
        self.cells.iter().any(|(_, weight)| *weight == 0.0)
    }

    fn halved(&self) -> Self {
        let (rows, cols) = self.size;
        let size = (rows.div_ceil(2), cols.div_ceil(2));
        let mean = |i: usize| {
            let (row, col) = (2 * (i / size.1), 2 * (i % size.1));
            let (mut sum, mut weights) = (0.0, 0.0);
            for row in row..(row + 2).min(rows) {
                for (mean, weight) in &self.cells[row * cols + col..row * cols + (col + 2).min(cols)] {
                    sum += mean * weight;
                    weights += weight;
                }
            }
            if weights > 0.0 { (sum / weights, weights) } else { (0.0, 0.0) }
        };
        let cells = (0..size.0 * size.1).into_par_iter().with_min_len(CELLS).map(mean).collect();
        Self { size, cells }
    }
}

/// Bilinear height of cells of twice the size at a fine cell.
fn between(coarse: &[f32], (rows, cols): (usize, usize), row: usize, col: usize) -> f32 {
    let pair = |at: usize, n: usize| {
        let near = at / 2;
        let far = if at.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(n - 1) };
        (near, far)
    };
    let ((near_row, far_row), (near_col, far_col)) = (pair(row, rows), pair(col, cols));
    let line = |row: usize| 0.75 * coarse[row * cols + near_col] + 0.25 * coarse[row * cols + far_col];
    0.75 * line(near_row) + 0.25 * line(far_row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guesses_stay_between_known_heights() {
        let (rows, cols) = (13, 22);
        let heights: Vec<f64> = (0..rows * cols).map(|i| (i % 17) as f64).collect();
        let free: Vec<bool> = (0..rows * cols).map(|i| i % 11 != 0).collect();
        let start =
            |heights: &[f64], free: &[bool]| start(heights, free, (rows, cols), &Job::detached()).unwrap();
        let guess = start(&heights, &free);
        assert!((0..guess.len()).all(|i| free[i] || guess[i] == heights[i]));
        assert!(guess.iter().all(|height| (0.0..=16.0).contains(height)));
        assert!(start(&heights, &vec![true; rows * cols]).iter().all(|height| *height == 0.0));
        let level = start(&vec![5.0; rows * cols], &free);
        assert!(level.iter().all(|height| (height - 5.0).abs() < 1e-5));
    }
}
