//! Reverse Chaikin subdivision of a terrain: half the cells, and the details that they lack.

use orograph_core::prelude::*;

use super::chaikin::{Bands, Boundary, FEWEST, Surface};

/// Which way a terrain is taken apart.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Along rows and down columns.
    Both,
    /// Along rows alone: every row is a curve.
    Across,
    /// Down columns alone: every column is a curve.
    Down,
}

/// How a terrain is taken apart and put together.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Halving {
    /// Which way terrain is taken apart.
    #[param(default = Axes::Both)]
    pub axes: Axes,
    /// How the ends of rows and columns are treated.
    #[param(default = Boundary::Natural)]
    pub boundary: Boundary,
}

/// Splits terrain into a coarse one of half the cells and the details that it lacks, by reverse Chaikin subdivision.
///
/// Repeat it on the coarse terrain for more levels; `filter.chaikin_compose` puts all together again. Bands that the axes
/// leave out have no cells.
#[derive(Params, Clone, Debug)]
pub struct ChaikinDecompose {
    /// How the terrain is taken apart.
    #[param(flatten)]
    pub halving: Halving,
}

/// Inputs of [`ChaikinDecompose`].
#[derive(Inputs)]
pub struct ChaikinDecomposeIn<'a> {
    /// Terrain without voids.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`ChaikinDecompose`].
#[derive(Outputs)]
pub struct ChaikinDecomposeOut {
    /// Terrain of twice the cell size.
    pub coarse: Heightfield,
    /// Details along rows.
    pub across: Heightfield,
    /// Details down columns.
    pub down: Heightfield,
    /// Details along both.
    pub diagonal: Heightfield,
}

impl Node for ChaikinDecompose {
    const ID: &'static str = "filter.chaikin_decompose";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ChaikinDecomposeIn<'a>;
    type Outputs = ChaikinDecomposeOut;

    fn run(&self, inputs: ChaikinDecomposeIn<'_>, job: &Job) -> Result<ChaikinDecomposeOut> {
        job.check()?;
        let (rows, cols) = inputs.terrain.grid().size();
        let short = match self.halving.axes {
            Axes::Both => rows.min(cols),
            Axes::Across => cols,
            Axes::Down => rows,
        };
        if short < FEWEST {
            return Err(Error::invalid(
                format!(
                    "terrain of {rows} × {cols} cells cannot be halved: {FEWEST} are needed along each axis"
                ),
                "choose the longer axis alone, or a larger terrain",
            ));
        }
        let surface = surface_of(inputs.terrain, "terrain", job)?;
        let bands = self.halving.decompose(&surface, job)?;
        let raster = |surface: Surface| raster_of(surface, inputs.terrain.grid(), self.halving.axes);
        Ok(ChaikinDecomposeOut {
            coarse: raster(bands.coarse)?,
            across: raster(bands.across)?,
            down: raster(bands.down)?,
            diagonal: raster(bands.diagonal)?,
        })
    }
}

impl Halving {
    /// Takes a surface apart.
    pub(super) fn decompose(self, surface: &Surface, job: &Job<'_>) -> Result<Bands> {
        let size = surface.size;
        match self.axes {
            Axes::Both => surface.decompose(self.boundary, job),
            Axes::Across => {
                let [coarse, across] = surface.halved(self.boundary, job)?;
                Ok(Bands { size, coarse, across, ..Bands::default() })
            }
            Axes::Down => {
                let [coarse, down] = surface.transposed(job)?.halved(self.boundary, job)?;
                let (coarse, down) = (coarse.transposed(job)?, down.transposed(job)?);
                Ok(Bands { size, coarse, down, ..Bands::default() })
            }
        }
    }

    /// Puts a surface together.
    pub(super) fn compose(self, bands: &Bands, job: &Job<'_>) -> Result<Surface> {
        match self.axes {
            Axes::Both => bands.compose(self.boundary, job),
            Axes::Across => bands.coarse.doubled(&bands.across, self.boundary, bands.size.1, job),
            Axes::Down => {
                let (coarse, down) = (bands.coarse.transposed(job)?, bands.down.transposed(job)?);
                coarse.doubled(&down, self.boundary, bands.size.0, job)?.transposed(job)
            }
        }
    }
}

/// Bytes that the steps take for each cell.
const BYTES: u64 = 40;

/// The heights of a raster, none of which may be missing.
pub(super) fn surface_of(raster: &Heightfield, what: &str, job: &Job<'_>) -> Result<Surface> {
    let size = raster.grid().size();
    job.admit(raster.grid().len() as u64 * BYTES, || format!("the halves of {} × {} cells", size.0, size.1))?;
    job.check()?;
    if raster.void_count() > 0 {
        return Err(Error::invalid(
            format!("`{what}` has voids, of which nothing can be taken apart or put together"),
            "fill them first, for instance by repair.void_patch",
        ));
    }
    Ok(Surface { size, cells: raster.cells().iter().map(|&height| f64::from(height)).collect() })
}

/// A raster of a half, each of whose cells lies between two of `fine` along the axes.
fn raster_of(surface: Surface, fine: &Grid, axes: Axes) -> Result<Heightfield> {
    let (down, across) = match axes {
        Axes::Both => (2.0, 2.0),
        Axes::Across => (1.0, 2.0),
        Axes::Down => (2.0, 1.0),
    };
    // The first coarse cell lies half a cell before the first fine one.
    let first = [down, across].map(|scale| if scale > 1.0 { -0.5 } else { 0.0 });
    let grid = fine.sampled(surface.size.0, surface.size.1, [down, across], first)?;
    Heightfield::new(grid, surface.cells.iter().map(|&height| height as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        filter::chaikin_compose::{ChaikinCompose, ChaikinComposeIn},
        test_fields::field,
    };

    fn hills(rows: usize, cols: usize) -> Heightfield {
        field(rows, cols, |row, col| {
            500.0 + 80.0 * libm::sin(row as f64 / 3.0) + 5.0 * ((row * 7 + col * 5) % 11) as f64
        })
    }

    #[test]
    fn what_is_taken_apart_is_put_together_again() {
        for axes in [Axes::Both, Axes::Across, Axes::Down] {
            for boundary in [Boundary::Natural, Boundary::Clamped] {
                for (rows, cols) in [(20, 31), (4, 4), (17, 5)] {
                    let halving = Halving { axes, boundary };
                    let terrain = hills(rows, cols);
                    let inputs = ChaikinDecomposeIn { terrain: &terrain };
                    let out = ChaikinDecompose { halving }.run(inputs, &Job::detached()).unwrap();
                    let inputs = ChaikinComposeIn {
                        coarse: &out.coarse,
                        across: Some(&out.across),
                        down: Some(&out.down),
                        diagonal: Some(&out.diagonal),
                        like: &terrain,
                    };
                    let again = ChaikinCompose { halving }.run(inputs, &Job::detached()).unwrap().terrain;
                    assert_eq!(again.grid(), terrain.grid());
                    let apart = again.cells().iter().zip(terrain.cells()).map(|(a, b)| (a - b).abs());
                    assert!(apart.fold(0.0, f32::max) < 1e-3);
                }
            }
        }
    }

    #[test]
    fn coarse_cells_lie_where_their_ground_is() {
        // A plane is a plane again, at the same places in the world.
        let plane = field(30, 24, |row, col| 2.0 * row as f64 - 3.0 * col as f64);
        let out = ChaikinDecompose::default()
            .run(ChaikinDecomposeIn { terrain: &plane }, &Job::detached())
            .unwrap();
        let grid = out.coarse.grid();
        assert_eq!(grid.cell, CellSize { x: 20.0, y: 20.0 });
        for (row, col) in [(0, 0), (5, 7), (15, 12)] {
            let at = grid.position(row, col);
            let expected = -2.0 * at.y / 10.0 - 3.0 * at.x / 10.0;
            assert!((f64::from(out.coarse.at(row, col)) - expected).abs() < 1e-3);
        }
    }

    #[test]
    fn voids_and_short_terrain_are_refused() {
        let run = |terrain: &Heightfield| {
            ChaikinDecompose::default().run(ChaikinDecomposeIn { terrain }, &Job::detached()).map(|_| ())
        };
        assert!(run(&hills(3, 30)).unwrap_err().to_string().contains("cannot be halved"));
        let mut holed = hills(8, 8);
        holed.cells_mut()[5] = f32::NAN;
        assert!(run(&holed).unwrap_err().to_string().contains("has voids"));
    }
}
