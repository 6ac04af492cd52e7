//! Mirror: a terrain turned over along an axis.

use orograph_core::prelude::*;

use super::rotate::moved;

/// Which sides change places.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// East and west.
    EastWest,
    /// North and south.
    NorthSouth,
    /// Both: a half turn.
    Both,
}

/// Mirrors a terrain.
///
/// It keeps its stretch of ground in the world. A georeference goes with the cells: its transform gets steps
/// of the other sign, so that every height keeps its true place on Earth.
#[derive(Params, Clone, Debug)]
pub struct Mirror {
    /// Which sides change places.
    #[param(default = Axis::EastWest)]
    pub axis: Axis,
}

/// Inputs of [`Mirror`].
#[derive(Inputs)]
pub struct MirrorIn<'a> {
    /// Terrain to mirror.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Mirror`].
#[derive(Outputs)]
pub struct MirrorOut {
    /// Mirrored terrain.
    pub terrain: Heightfield,
}

impl Node for Mirror {
    const ID: &'static str = "transform.mirror";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = MirrorIn<'a>;
    type Outputs = MirrorOut;

    fn run(&self, inputs: MirrorIn<'_>, job: &Job) -> Result<MirrorOut> {
        let (terrain, old) = (inputs.terrain, inputs.terrain.grid());
        let (rows, cols) = (old.rows as f64, old.cols as f64);
        let (turn_cols, turn_rows) = (self.axis != Axis::NorthSouth, self.axis != Axis::EastWest);
        let along = |turn: bool, n: f64| if turn { [n, -1.0] } else { [0.0, 1.0] };
        let ([col0, col_step], [row0, row_step]) = (along(turn_cols, cols), along(turn_rows, rows));
        let grid = moved(old, old.rows, old.cols, old.cell, [col0, col_step, 0.0, row0, 0.0, row_step])?;
        let terrain = Heightfield::build(grid, job, |row, out| {
            let row = if turn_rows { old.rows - 1 - row } else { row };
            out.copy_from_slice(terrain.row(row));
            if turn_cols {
                out.reverse();
            }
            Ok(())
        })?;
        Ok(MirrorOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::test_fields::field;

    #[test]
    fn sides_change_places_and_twice_is_once_not() {
        let terrain = field(2, 3, |row, col| (10 * row + col) as f64);
        let run = |axis, terrain: &Heightfield| {
            Mirror { axis }.run(MirrorIn { terrain }, &Job::detached()).unwrap().terrain
        };
        assert_eq!(run(Axis::EastWest, &terrain).cells(), [2.0, 1.0, 0.0, 12.0, 11.0, 10.0]);
        assert_eq!(run(Axis::NorthSouth, &terrain).cells(), [10.0, 11.0, 12.0, 0.0, 1.0, 2.0]);
        assert_eq!(run(Axis::Both, &terrain).cells(), [12.0, 11.0, 10.0, 2.0, 1.0, 0.0]);
        let mut grid = terrain.grid().clone();
        let transform = [100.0, 2.0, 0.5, 900.0, 0.25, -3.0];
        grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
        let placed = terrain.with_grid(grid).unwrap();
        for axis in [Axis::EastWest, Axis::NorthSouth, Axis::Both] {
            let twice = run(axis, &run(axis, &placed));
            assert_eq!((twice.cells(), twice.grid()), (placed.cells(), placed.grid()));
        }
        let once = run(Axis::EastWest, &placed).grid().georef_here().unwrap().transform;
        assert_eq!(once, [106.0, -2.0, 0.5, 900.75, -0.25, -3.0]);
    }
}
