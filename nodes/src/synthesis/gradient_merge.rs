//! Gradient merge: one surface from the steps that all patches had where they came from.
//!
//! Patch by patch, a step at a seam is spread over the overlap, and what is placed late bends what was placed early. Here
//! all cells are solved for at once (the gradient-domain way of Pérez 2003 and Guérin 2022): within a patch the steps are
//! those of its source, across a seam those that were found when it was blended. The surface blended so far holds the
//! solution at long range, so slopes change by little everywhere instead of by much in overlaps.

use orograph_core::prelude::*;

use super::{
    canvas::Canvas,
    poisson::{
        masked::{Cell, Domain, solve},
        natural,
    },
};

/// Redoes the heights of `canvas`, held to those before beyond about `reach` cells. Given ground stays to the bit, and
/// then nothing else holds the rest.
///
/// # Errors
/// Those of the solvers, and cancellation.
pub fn merge(canvas: &mut Canvas, reach: f64, job: &Job<'_>) -> Result<()> {
    let (cols, n) = (canvas.size.1, canvas.heights.len());
    job.admit(n as u64 * 24, || format!("the steps of {n} cells"))?;
    let mut right = vec![0.0; n];
    for i in 0..n {
        if i % cols == 0 {
            job.check()?;
        }
        let mut edge = |j: usize, own: f32| {
            let excess = f64::from(own) - (f64::from(canvas.heights[j]) - f64::from(canvas.heights[i]));
            if !excess.is_nan() {
                // What the step must grow by.
                right[i] -= excess;
                right[j] += excess;
            }
        };
        let [across, down] = canvas.steps[i];
        if (i + 1) % cols != 0 {
            edge(i + 1, across);
        }
        if i + cols < n {
            edge(i + cols, down);
        }
    }
    if !right.iter().all(|b| b.is_finite()) {
        return Err(Error::invalid("a height is infinite", "declare that value as nodata in the source"));
    }
    let frozen = (0..n).any(|i| canvas.is_frozen(i));
    let change = if frozen {
        let kind = |i: usize| if canvas.is_frozen(i) { Cell::Fixed } else { Cell::Free };
        let cells: Vec<Cell> = (0..n).map(kind).collect();
        solve(&Domain { cols, cells: &cells, weights: [1.0; 2] }, &right, job)?
    } else {
        natural::solve(cols, &right, 1.0 / (reach * reach).max(1.0), job)?
    };
    for (i, change) in change.into_iter().enumerate() {
        if !canvas.is_frozen(i) {
            canvas.heights[i] = (f64::from(canvas.heights[i]) + change) as f32;
        }
    }
    Ok(())
}
