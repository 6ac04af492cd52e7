//! The grid of nodes that make a terrain from nothing.

use orograph_core::prelude::*;

use crate::Ground;

/// A grid over the ground with square cells, so that distances in cells mean the same both ways. Its north-west corner
/// is the world's origin, so that a preview covers the same ground as the build.
///
/// # Errors
/// As [`Grid::new`].
pub(crate) fn extent(ground: &Ground, job: &Job<'_>) -> Result<Grid> {
    let (cells, longer) = ground.longer_side(job);
    let side = longer / f64::from(cells);
    let count = |length: f64| (length / side).round().max(1.0) as usize;
    let mut grid = Grid::new(count(ground.height), count(ground.width), CellSize::square(side))?;
    grid.origin.x = side / 2.0;
    grid.origin.y = -side / 2.0;
    Ok(grid)
}
