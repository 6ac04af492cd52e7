//! Resize: the same ground in more or fewer cells.

use orograph_core::prelude::*;

use super::sample::{Interpolation, sample};

/// How the new number of cells is given.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// As cells along the longer side; cells keep their proportions.
    Cells,
    /// As the side of a square cell in metres, rounded so that whole cells cover the ground.
    CellSize,
}

/// How new heights follow from old ones.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The area mean along with fewer cells, the cubic with more.
    Auto,
    /// The nearest cell's height.
    Nearest,
    /// Straight between the four cells around.
    Bilinear,
    /// A Catmull-Rom spline through the sixteen cells around.
    Cubic,
    /// The mean of the old cells, weighted by how much of each the new cell covers.
    Area,
}

/// Resamples a terrain to another number of cells; its outer edges and georeference stay.
///
/// Interpolating, a new cell is a void where the nearest old one is. As an area mean it is one where less than
/// half of its area is known.
#[derive(Params, Clone, Debug)]
pub struct Resize {
    /// How the new number of cells is given.
    #[param(default = Measure::Cells)]
    pub measure: Measure,
    /// Cells along the longer side.
    #[param(default = 512u32, range = 1..=65_536, slider = 64..=4096, unit = "cells")]
    pub cells: u32,
    /// Side of a square cell.
    #[param(default = 30, range = 0.001..=100_000.0, slider = 1.0..=200.0, unit = "m")]
    pub cell_size: f64,
    /// How new heights follow from old ones.
    #[param(default = Method::Auto)]
    pub method: Method,
}

/// Inputs of [`Resize`].
#[derive(Inputs)]
pub struct ResizeIn<'a> {
    /// Terrain to resample.
    pub terrain: &'a Heightfield,
    /// Terrain whose numbers of rows and columns to take, instead of the settings'.
    pub like: Option<&'a Heightfield>,
}

/// Outputs of [`Resize`].
#[derive(Outputs)]
pub struct ResizeOut {
    /// The same ground in other cells.
    pub terrain: Heightfield,
}

impl Node for Resize {
    const ID: &'static str = "transform.resize";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ResizeIn<'a>;
    type Outputs = ResizeOut;

    fn run(&self, inputs: ResizeIn<'_>, job: &Job) -> Result<ResizeOut> {
        let old = inputs.terrain.grid();
        let (rows, cols) = inputs.like.map_or_else(|| self.size(old), |like| like.grid().size());
        Ok(ResizeOut { terrain: resize(inputs.terrain, rows, cols, self.method, job)? })
    }

    fn cost(&self) -> f64 {
        15.0
    }
}

impl Resize {
    fn size(&self, old: &Grid) -> (usize, usize) {
        let (rows, cols) = (old.rows as f64, old.cols as f64);
        let scaled = match self.measure {
            Measure::Cells => {
                let scale = f64::from(self.cells) / rows.max(cols);
                (rows * scale, cols * scale)
            }
            Measure::CellSize => (rows * old.cell.y / self.cell_size, cols * old.cell.x / self.cell_size),
        };
        ((scaled.0.round() as usize).max(1), (scaled.1.round() as usize).max(1))
    }
}

/// The same ground in `rows` × `cols` cells.
///
/// # Errors
/// As [`Grid::resized`], and [`Error::TooLarge`] and [`Error::Cancelled`].
pub fn resize(
    terrain: &Heightfield,
    rows: usize,
    cols: usize,
    method: Method,
    job: &Job,
) -> Result<Heightfield> {
    let old = terrain.grid();
    let grid = old.resized(rows, cols)?;
    let interpolation = match method {
        Method::Nearest => Interpolation::Nearest,
        Method::Bilinear => Interpolation::Bilinear,
        Method::Cubic => Interpolation::Cubic,
        Method::Area => return area_mean(terrain, grid, job),
        Method::Auto if rows < old.rows || cols < old.cols => return area_mean(terrain, grid, job),
        Method::Auto => Interpolation::Cubic,
    };
    let (down, across) = (old.rows as f64 / rows as f64, old.cols as f64 / cols as f64);
    Heightfield::build(grid, job, |row, out| {
        let at_row = (row as f64 + 0.5) * down - 0.5;
        for (col, out) in out.iter_mut().enumerate() {
            *out = sample(terrain, at_row, (col as f64 + 0.5) * across - 0.5, interpolation);
        }
        Ok(())
    })
}

fn area_mean(terrain: &Heightfield, grid: Grid, job: &Job) -> Result<Heightfield> {
    let (old_rows, old_cols) = terrain.grid().size();
    let (down, across) = (old_rows as f64 / grid.rows as f64, old_cols as f64 / grid.cols as f64);
    Heightfield::build(grid, job, |row, out| {
        let (first_row, row_shares) = shares(row, down, old_rows);
        for (col, out) in out.iter_mut().enumerate() {
            let (first_col, col_shares) = shares(col, across, old_cols);
            let (mut sum, mut known, mut all) = (0.0, 0.0, 0.0);
            for (i, row_share) in row_shares.iter().enumerate() {
                let cells = &terrain.row(first_row + i)[first_col..];
                for (share, &height) in col_shares.iter().zip(cells) {
                    let area = row_share * share;
                    all += area;
                    if !height.is_nan() {
                        sum += area * f64::from(height);
                        known += area;
                    }
                }
            }
            if known > 0.0 && known >= all / 2.0 {
                *out = (sum / known) as f32;
            }
        }
        job.check()
    })
}

/// The first old cell that new cell `i` of size `step` covers, and how much it covers of each from there.
fn shares(i: usize, step: f64, n: usize) -> (usize, Vec<f64>) {
    let (start, end) = (i as f64 * step, (i + 1) as f64 * step);
    let first = (start as usize).min(n - 1);
    let last = (end.ceil() as usize).clamp(first + 1, n);
    let cover = |cell: usize| ((cell + 1) as f64).min(end) - (cell as f64).max(start);
    (first, (first..last).map(|cell| cover(cell).max(0.0)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};

    fn resized(terrain: &Heightfield, rows: usize, cols: usize, method: Method) -> Heightfield {
        resize(terrain, rows, cols, method, &Job::detached()).unwrap()
    }

    #[test]
    fn the_number_of_cells_follows_the_measure() {
        let mut grid = field(100, 300, |_, _| 0.0).grid().clone();
        grid.cell = CellSize { x: 20.0, y: 30.0 };
        let node = Resize { cells: 150, cell_size: 15.0, ..Resize::default() };
        assert_eq!(node.size(&grid), (50, 150));
        assert_eq!(Resize { measure: Measure::CellSize, ..node }.size(&grid), (200, 400));
    }

    #[test]
    fn an_area_mean_keeps_the_volume() {
        let terrain = field(7, 11, |row, col| ((row * 13 + col * 29) % 17) as f64);
        let mean = |field: &Heightfield| {
            field.cells().iter().map(|&h| f64::from(h)).sum::<f64>() / field.cells().len() as f64
        };
        for (rows, cols) in [(3, 4), (2, 11), (1, 1), (20, 5)] {
            let out = resized(&terrain, rows, cols, Method::Area);
            assert!((mean(&out) - mean(&terrain)).abs() < 1e-5, "{rows} × {cols}");
        }
    }

    #[test]
    fn a_plane_stays_the_same_plane_on_the_same_ground() {
        let plane = field(12, 12, |row, col| 5.0 * row as f64 + 3.0 * col as f64);
        let height = |at: glam::DVec2| -0.5 * at.y + 0.3 * at.x;
        for method in [Method::Bilinear, Method::Cubic, Method::Area] {
            for n in [6, 24] {
                let out = resized(&plane, n, n, method);
                // Growing by area repeats cells, which is not the plane.
                if method == Method::Area && n > 12 {
                    continue;
                }
                for i in n / 4..n - n / 4 {
                    let truth = height(out.grid().position(i, i));
                    assert!((f64::from(out.at(i, i)) - truth).abs() < 1e-4, "{method:?} {n}");
                }
            }
        }
    }

    #[test]
    fn the_same_size_is_the_same_terrain() {
        let terrain = field(5, 6, |row, col| if row == col { f64::NAN } else { (row * col) as f64 });
        for method in [Method::Auto, Method::Nearest, Method::Bilinear, Method::Cubic, Method::Area] {
            let out = resized(&terrain, 5, 6, method);
            let same =
                out.cells().iter().zip(terrain.cells()).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
            assert!(same, "{method:?}");
        }
    }

    #[test]
    fn half_known_cells_are_known() {
        let terrain = row(&[4.0, f32::NAN, f32::NAN, f32::NAN, 8.0, 6.0]);
        let out = resized(&terrain, 1, 3, Method::Area);
        assert_eq!(out.at(0, 0), 4.0);
        assert!(out.at(0, 1).is_nan());
        assert_eq!(out.at(0, 2), 7.0);
    }
}
