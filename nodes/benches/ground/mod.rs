//! Ground to measure on.

use orograph_core::{CellSize, Grid, Heightfield, key, signed_unit};

/// Fractal noise of value lattices: the widest of 512 cells and `relief` metres, each further one of half both.
pub(crate) fn rough((rows, cols): (usize, usize), side: f64, octaves: u64, relief: f64) -> Heightfield {
    let lattice = |octave: u64, x: usize, y: usize| signed_unit(key(1, octave, x as i64, y as i64));
    let height = |row: usize, col: usize| {
        (0..octaves).fold(0.0, |sum, octave| {
            let step = 512_usize >> octave;
            let (x, y, fx, fy) = (col / step, row / step, (col % step) as f64, (row % step) as f64);
            let (fx, fy) = (fx / step as f64, fy / step as f64);
            let at = |dx, dy| lattice(octave, x + dx, y + dy);
            let top = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
            let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
            sum + (top + (bottom - top) * fy) * relief / f64::from(1 << octave)
        })
    };
    let grid = Grid::new(rows, cols, CellSize::square(side)).expect("the sides are small");
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols) as f32).collect();
    Heightfield::new(grid, cells).expect("one height a cell")
}
