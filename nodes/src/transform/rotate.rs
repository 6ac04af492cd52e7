//! Rotate: a terrain turned about its middle.

use std::sync::Arc;

use glam::DVec2;
use orograph_core::prelude::*;

use super::sample::{Interpolation, sample};

/// Turns a terrain clockwise about its middle.
///
/// Quarter turns move whole cells and change no height. Other angles interpolate, on a grid just large enough
/// to hold the turned terrain; corners that it does not cover are voids. A georeference turns with the cells,
/// so that every height keeps its true place on Earth.
#[derive(Params, Clone, Debug)]
pub struct Rotate {
    /// How far to turn clockwise.
    #[param(default = 90, range = -360.0..=360.0, unit = "deg")]
    pub angle: f64,
    /// How heights between cells are found, at angles other than quarter turns.
    #[param(default = Interpolation::Cubic)]
    pub interpolation: Interpolation,
}

/// Inputs of [`Rotate`].
#[derive(Inputs)]
pub struct RotateIn<'a> {
    /// Terrain to turn.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Rotate`].
#[derive(Outputs)]
pub struct RotateOut {
    /// Turned terrain.
    pub terrain: Heightfield,
}

impl Node for Rotate {
    const ID: &'static str = "transform.rotate";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = RotateIn<'a>;
    type Outputs = RotateOut;

    fn run(&self, inputs: RotateIn<'_>, job: &Job) -> Result<RotateOut> {
        let terrain = inputs.terrain;
        if terrain.grid().is_empty() {
            return Err(Error::EmptyInput { what: "terrain".into() });
        }
        let quarters = self.angle / 90.0;
        let terrain = if quarters.fract() == 0.0 {
            quarter_turns(terrain, quarters.rem_euclid(4.0) as usize, job)?
        } else {
            self.turn(terrain, job)?
        };
        Ok(RotateOut { terrain })
    }

    fn cost(&self) -> f64 {
        15.0
    }
}

impl Rotate {
    fn turn(&self, terrain: &Heightfield, job: &Job) -> Result<Heightfield> {
        let (old, cell) = (terrain.grid(), terrain.grid().cell);
        let (sin, cos) = libm::sincos(self.angle.to_radians());
        let (height, width) = (old.rows as f64 * cell.y, old.cols as f64 * cell.x);
        // The slack keeps rounding from adding a cell.
        let count = |extent: f64| ((extent - 1e-9 * extent).ceil() as usize).max(1);
        let rows = count((height * cos.abs() + width * sin.abs()) / cell.y);
        let cols = count((width * cos.abs() + height * sin.abs()) / cell.x);
        // From a place in the new grid, as (column, row) of corners, to the old: about the middle of both.
        let (across, down) = ([cos, sin * cell.y / cell.x], [-sin * cell.x / cell.y, cos]);
        let (mid_col, mid_row) = (cols as f64 / 2.0, rows as f64 / 2.0);
        let old_from_new = [
            old.cols as f64 / 2.0 - across[0] * mid_col - across[1] * mid_row,
            across[0],
            across[1],
            old.rows as f64 / 2.0 - down[0] * mid_col - down[1] * mid_row,
            down[0],
            down[1],
        ];
        let grid = moved(old, rows, cols, cell, old_from_new)?;
        let [c0, c_col, c_row, r0, r_col, r_row] = old_from_new;
        Heightfield::build(grid, job, |row, out| {
            let y = row as f64 + 0.5;
            for (col, out) in out.iter_mut().enumerate() {
                let x = col as f64 + 0.5;
                let (at_col, at_row) = (c0 + c_col * x + c_row * y - 0.5, r0 + r_col * x + r_row * y - 0.5);
                *out = sample(terrain, at_row, at_col, self.interpolation);
            }
            Ok(())
        })
    }
}

/// `terrain` turned clockwise by whole quarters, cell by cell.
fn quarter_turns(terrain: &Heightfield, quarters: usize, job: &Job) -> Result<Heightfield> {
    let old = terrain.grid();
    let (rows, cols) = (old.rows as f64, old.cols as f64);
    let swapped = CellSize { x: old.cell.y, y: old.cell.x };
    let grid = match quarters {
        0 => old.clone(),
        1 => moved(old, old.cols, old.rows, swapped, [0.0, 0.0, 1.0, rows, -1.0, 0.0])?,
        2 => moved(old, old.rows, old.cols, old.cell, [cols, -1.0, 0.0, rows, 0.0, -1.0])?,
        _ => moved(old, old.cols, old.rows, swapped, [cols, 0.0, -1.0, 0.0, 1.0, 0.0])?,
    };
    Heightfield::build(grid, job, |row, out| {
        for (col, out) in out.iter_mut().enumerate() {
            *out = match quarters {
                0 => terrain.at(row, col),
                1 => terrain.at(old.rows - 1 - col, row),
                2 => terrain.at(old.rows - 1 - row, old.cols - 1 - col),
                _ => terrain.at(col, old.cols - 1 - row),
            };
        }
        Ok(())
    })
}

/// A grid of another size about the middle of `old`, whose (column, row) of cell corners lie in `old` where the
/// affine `old_from_new` says; the georeference follows them.
pub(super) fn moved(
    old: &Grid,
    rows: usize,
    cols: usize,
    cell: CellSize,
    old_from_new: [f64; 6],
) -> Result<Grid> {
    let mut grid = Grid::new(rows, cols, cell)?;
    let to_middle = |grid: &Grid| {
        let (cols, rows) = (grid.cols as f64 - 1.0, grid.rows as f64 - 1.0);
        DVec2::new(cols * grid.cell.x, -rows * grid.cell.y) / 2.0
    };
    let middle = old.position(0, 0) + to_middle(old);
    grid.origin = middle - to_middle(&grid);
    grid.georef = old.georef_here().map(|georef| {
        let ([x0, xc, xr, y0, yc, yr], [c0, cc, cr, r0, rc, rr]) = (georef.transform, old_from_new);
        let through = |start: f64, per_col: f64, per_row: f64| {
            let step = |c: f64, r: f64| per_col * c + per_row * r;
            [start + step(c0, r0), step(cc, rc), step(cr, rr)]
        };
        let ([a, b, c], [d, e, f]) = (through(x0, xc, xr), through(y0, yc, yr));
        Arc::new(Georef { transform: [a, b, c, d, e, f], crs: georef.crs })
    });
    Ok(grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn placed() -> Heightfield {
        let terrain = field(3, 5, |row, col| (10 * row + col) as f64);
        let mut grid = terrain.grid().clone();
        grid.cell = CellSize { x: 10.0, y: 20.0 };
        let transform = [500.0, 10.0, 0.0, 900.0, 0.0, -20.0];
        grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
        terrain.with_grid(grid).unwrap()
    }

    fn turn(terrain: &Heightfield, angle: f64) -> Heightfield {
        let node = Rotate { angle, ..Rotate::default() };
        node.run(RotateIn { terrain }, &Job::detached()).unwrap().terrain
    }

    /// Georeferenced place of a cell's centre.
    fn place(field: &Heightfield, row: usize, col: usize) -> [f64; 2] {
        let t = field.grid().georef_here().unwrap().transform;
        let (c, r) = (col as f64 + 0.5, row as f64 + 0.5);
        [t[0] + t[1] * c + t[2] * r, t[3] + t[4] * c + t[5] * r]
    }

    #[test]
    fn a_quarter_turn_takes_north_to_east_and_four_are_none() {
        let terrain = placed();
        let right = turn(&terrain, 90.0);
        assert_eq!(right.row(0), [20.0, 10.0, 0.0]);
        assert_eq!(right.grid().cell, CellSize { x: 20.0, y: 10.0 });
        let mut four = terrain.clone();
        for _ in 0..4 {
            four = turn(&four, 90.0);
        }
        assert_eq!((four.cells(), four.grid()), (terrain.cells(), terrain.grid()));
        assert_eq!(turn(&terrain, -90.0).cells(), turn(&terrain, 270.0).cells());
        assert_eq!(turn(&terrain, 180.0).row(0)[0], 24.0);
    }

    #[test]
    fn heights_keep_their_georeferenced_place() {
        let terrain = placed();
        for angle in [90.0, 180.0, 270.0] {
            let turned = turn(&terrain, angle);
            for row in 0..turned.rows() {
                for col in 0..turned.cols() {
                    let height = turned.at(row, col) as usize;
                    assert_eq!(
                        place(&turned, row, col),
                        place(&terrain, height / 10, height % 10),
                        "{angle}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_plane_turned_is_a_plane_turned() {
        // Rises to the north by 0.1 m per m, on cells twice as high as wide; turned by 30 degrees, its rise
        // points that far east of north.
        let plane = field(40, 80, |row, _| -2.0 * row as f64);
        let mut grid = plane.grid().clone();
        grid.cell = CellSize { x: 10.0, y: 20.0 };
        let turned = turn(&plane.with_grid(grid).unwrap(), 30.0);
        let (row, col) = (turned.rows() / 2, turned.cols() / 2);
        let east = f64::from(turned.at(row, col + 1) - turned.at(row, col)) / 10.0;
        let north = f64::from(turned.at(row - 1, col) - turned.at(row, col)) / 20.0;
        assert!((east - 0.05).abs() < 1e-4, "{east}");
        assert!((north - 0.1 * 0.75_f64.sqrt()).abs() < 1e-4, "{north}");
        assert!(turned.at(0, 0).is_nan());
    }
}
