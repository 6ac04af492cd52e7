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
    /// Counts the depressions at least `least` metres deep between a terrain and the same terrain filled. Raised
    /// cells that touch, if only at a corner, are one depression where they fill to the same level.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, filled: &Heightfield, least: f64, job: &Job) -> Result<Self> {
        terrain.grid().match_size("terrain", filled.grid(), "filled")?;
        let (size, n) = (terrain.grid().size(), terrain.grid().len());
        job.admit(n as u64, || "a mark for each cell".into())?;
        let mut seen = vec![false; n];
        let depth = |cell: usize| f64::from(filled.cells()[cell]) - f64::from(terrain.cells()[cell]);
        let mut pits = Self::default();
        let mut open = Vec::new();
        for start in 0..n {
            if start.is_multiple_of(1 << 16) {
                job.check()?;
            }
            let raised = |cell: usize| depth(cell) > 0.0;
            if seen[start] || !raised(start) {
                continue;
            }
            let level = filled.cells()[start];
            let (mut cells, mut sum, mut deepest) = (0u64, 0.0, 0.0);
            seen[start] = true;
            open.push(start);
            while let Some(cell) = open.pop() {
                cells += 1;
                if cells.is_multiple_of(1 << 16) {
                    job.check()?;
                }
                sum += depth(cell);
                deepest = f64::max(deepest, depth(cell));
                for (_, other) in around(size, cell) {
                    if !seen[other] && raised(other) && filled.cells()[other] == level {
                        seen[other] = true;
                        open.push(other);
                    }
                }
            }
            if deepest >= least {
                pits.count += 1;
                pits.cells += cells;
                pits.depth_sum += sum;
                pits.deepest_sum += deepest;
                pits.deepest = pits.deepest.max(deepest);
            }
        }
        Ok(pits)
    }
}
