//! Crop: a rectangular part of a terrain.

use orograph_core::prelude::*;

/// How the part to keep is measured.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// In cells.
    Cells,
    /// In metres on the ground, rounded to whole cells: the same ground at every resolution.
    Metres,
}

/// Cuts a rectangle out of a terrain. Heights, place in the world and georeference stay as they are.
#[derive(Params, Clone, Debug)]
pub struct Crop {
    /// How the rectangle is measured.
    #[param(default = Measure::Cells)]
    pub measure: Measure,
    /// First row to keep, when measured in cells.
    #[param(default = 0u32, range = 0..=131_072, slider = 0..=4096, unit = "cells")]
    pub row: u32,
    /// First column to keep, when measured in cells.
    #[param(default = 0u32, range = 0..=131_072, slider = 0..=4096, unit = "cells")]
    pub col: u32,
    /// Rows to keep, when measured in cells; 0 keeps all to the southern edge.
    #[param(default = 0u32, range = 0..=131_072, slider = 0..=4096, unit = "cells")]
    pub rows: u32,
    /// Columns to keep, when measured in cells; 0 keeps all to the eastern edge.
    #[param(default = 0u32, range = 0..=131_072, slider = 0..=4096, unit = "cells")]
    pub cols: u32,
    /// From the northern edge to the rectangle, when measured in metres.
    #[param(default = 0, range = 0.0..=100_000_000.0, slider = 0.0..=100_000.0, unit = "m")]
    pub north: f64,
    /// From the western edge to the rectangle, when measured in metres.
    #[param(default = 0, range = 0.0..=100_000_000.0, slider = 0.0..=100_000.0, unit = "m")]
    pub west: f64,
    /// Extent from north to south, when measured in metres; 0 keeps all to the southern edge.
    #[param(default = 0, range = 0.0..=100_000_000.0, slider = 0.0..=100_000.0, unit = "m")]
    pub height: f64,
    /// Extent from west to east, when measured in metres; 0 keeps all to the eastern edge.
    #[param(default = 0, range = 0.0..=100_000_000.0, slider = 0.0..=100_000.0, unit = "m")]
    pub width: f64,
}

/// Inputs of [`Crop`].
#[derive(Inputs)]
pub struct CropIn<'a> {
    /// Terrain to cut from.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Crop`].
#[derive(Outputs)]
pub struct CropOut {
    /// The part kept.
    pub terrain: Heightfield,
}

impl Node for Crop {
    const ID: &'static str = "transform.crop";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CropIn<'a>;
    type Outputs = CropOut;

    fn run(&self, inputs: CropIn<'_>, job: &Job) -> Result<CropOut> {
        let grid = inputs.terrain.grid();
        let [row, col, rows, cols] = match self.measure {
            Measure::Cells => [self.row, self.col, self.rows, self.cols].map(|n| n as usize),
            Measure::Metres => {
                let cells = |metres: f64, side: f64| (metres / side).round() as usize;
                // A rectangle thinner than a cell is still one cell, not all of them.
                let extent = |metres: f64, side: f64| cells(metres, side).max(usize::from(metres > 0.0));
                let (x, y) = (grid.cell.x, grid.cell.y);
                [cells(self.north, y), cells(self.west, x), extent(self.height, y), extent(self.width, x)]
            }
        };
        let to_edge = |n: usize, start: usize, all: usize| if n == 0 { all.saturating_sub(start) } else { n };
        let (rows, cols) = (to_edge(rows, row, grid.rows), to_edge(cols, col, grid.cols));
        Ok(CropOut { terrain: inputs.terrain.crop(row, col, rows, cols, job)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn run(node: &Crop) -> Result<Heightfield> {
        let terrain = field(6, 8, |row, col| (10 * row + col) as f64);
        Ok(node.run(CropIn { terrain: &terrain }, &Job::detached())?.terrain)
    }

    #[test]
    fn cells_and_metres_cut_the_same_part() {
        let cells = run(&Crop { row: 1, col: 2, rows: 2, cols: 3, ..Crop::default() }).unwrap();
        assert_eq!(cells.cells(), [12.0, 13.0, 14.0, 22.0, 23.0, 24.0]);
        let (north, west, height, width) = (10.0, 20.0, 20.0, 30.0);
        let node = Crop { measure: Measure::Metres, north, west, height, width, ..Crop::default() };
        let metres = run(&node).unwrap();
        assert_eq!((metres.cells(), metres.grid()), (cells.cells(), cells.grid()));
    }

    #[test]
    fn zero_goes_to_the_edge_and_beyond_it_is_refused() {
        let rest = run(&Crop { row: 4, col: 7, ..Crop::default() }).unwrap();
        assert_eq!(rest.cells(), [47.0, 57.0]);
        assert!(run(&Crop { row: 4, rows: 3, ..Crop::default() }).is_err());
        assert!(run(&Crop { row: 7, ..Crop::default() }).is_err());
    }
}
