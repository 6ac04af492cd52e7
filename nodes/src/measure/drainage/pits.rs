//! Closed depressions: the patches of ground that a flood raised.

use orograph_core::prelude::*;

use super::flood::around;

/// The closed depressions of a terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pits {
    /// How many there are.
    pub count: u64,
    /// Cells in them.
    pub cells: u64,
    /// Depth below the spill level summed over their cells, in metres.
    pub depth_sum: f64,
    /// Sum over the depressions of the depth at their deepest, in metres.
    pub deepest_sum: f64,
    /// Depth of the deepest one, in metres; 0 without any.
    pub deepest: f64,
}

impl Pits {
    /// Counts the depressions at least `least` metres deep between a terrain and the same terrain filled.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, filled: &Heightfield, least: f64, job: &Job) -> Result<Self> {
        let mut pits = Self::default();
        each_depression(terrain, filled, job, |Depression { cells, depth_sum, depth, .. }| {
            if depth >= least {
                pits.count += 1;
                pits.cells += cells.len() as u64;
                pits.depth_sum += depth_sum;
                pits.deepest_sum += depth;
                pits.deepest = pits.deepest.max(depth);
            }
        })?;
        Ok(pits)
    }
}

/// A closed depression.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Depression<'a> {
    /// The first of its deepest cells.
    pub(crate) bottom: usize,
    /// Its cells, in no order that means anything.
    pub(crate) cells: &'a [usize],
    /// What it fills to, in metres.
    pub(crate) level: f32,
    /// Depth below the spill level summed over them, in metres.
    pub(crate) depth_sum: f64,
    /// Depth at its deepest, in metres.
    pub(crate) depth: f64,
}

/// Shows the depressions between a terrain and the same terrain filled, by their first cells. Raised cells that touch, if
/// only at a corner, are one depression where they fill to the same level.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub(crate) fn each_depression(
    terrain: &Heightfield,
    filled: &Heightfield,
    job: &Job,
    mut show: impl FnMut(Depression<'_>),
) -> Result<()> {
    terrain.grid().match_size("terrain", filled.grid(), "filled")?;
    let (size, n) = (terrain.grid().size(), terrain.grid().len());
    job.admit(n as u64, || "a mark for each cell".into())?;
    let mut seen = vec![false; n];
    let depth = |cell: usize| f64::from(filled.cells()[cell]) - f64::from(terrain.cells()[cell]);
    let (mut open, mut cells) = (Vec::new(), Vec::new());
    for start in 0..n {
        if start.is_multiple_of(1 << 16) {
            job.check()?;
        }
        let raised = |cell: usize| depth(cell) > 0.0;
        if seen[start] || !raised(start) {
            continue;
        }
        let level = filled.cells()[start];
        let (mut bottom, mut deepest, mut depth_sum) = (start, 0.0, 0.0);
        cells.clear();
        seen[start] = true;
        open.push(start);
        while let Some(cell) = open.pop() {
            cells.push(cell);
            if cells.len().is_multiple_of(1 << 16) {
                job.check()?;
            }
            depth_sum += depth(cell);
            if depth(cell) > deepest || depth(cell) == deepest && cell < bottom {
                (bottom, deepest) = (cell, depth(cell));
            }
            for (_, other) in around(size, cell) {
                if !seen[other] && raised(other) && filled.cells()[other] == level {
                    seen[other] = true;
                    open.push(other);
                }
            }
        }
        show(Depression { bottom, cells: &cells, level, depth_sum, depth: deepest });
    }
    Ok(())
}
