//! The grid of nodes that make a terrain from nothing.

use orograph_core::prelude::*;

/// A grid of `width` × `height` metres with square cells, `cells` of them along the longer side unless the run sets a
/// resolution. Its north-west corner is the world's origin, so that a preview covers the same ground as the build.
///
/// # Errors
/// As [`Grid::new`].
pub(crate) fn extent(width: f64, height: f64, cells: u32, job: &Job<'_>) -> Result<Grid> {
    let longer = f64::from(job.resolution().unwrap_or(cells).max(1));
    let side = width.max(height) / longer;
    let count = |length: f64| (length / side).round().max(1.0) as usize;
    let mut grid = Grid::new(count(height), count(width), CellSize::square(side))?;
    grid.origin.x = side / 2.0;
    grid.origin.y = -side / 2.0;
    Ok(grid)
}
