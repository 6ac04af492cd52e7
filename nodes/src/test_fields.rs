//! Analytic terrains for the tests of this crate.

use orograph_core::{CellSize, Grid, Heightfield};

/// A field of `rows` × `cols` cells of 10 m with the height `f(row, col)`.
pub(crate) fn field(rows: usize, cols: usize, f: impl Fn(usize, usize) -> f64) -> Heightfield {
    let grid = Grid::new(rows, cols, CellSize::square(10.0)).unwrap();
    let cells = (0..rows * cols).map(|i| f(i / cols, i % cols) as f32).collect();
    Heightfield::new(grid, cells).unwrap()
}

/// A field of one row.
pub(crate) fn row(heights: &[f32]) -> Heightfield {
    field(1, heights.len(), |_, col| f64::from(heights[col]))
}
