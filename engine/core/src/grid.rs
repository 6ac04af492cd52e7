//! Where the cells of a raster lie: counts, true cell size, position in the world, georeference.

use std::sync::Arc;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// No raster may have more cells than this (16 Gi cells); it keeps every index and byte count in range.
pub const MAX_CELLS: u64 = 1 << 34;

/// The true size of a cell on the ground, in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellSize {
    /// Metres from one column to the next.
    pub x: f64,
    /// Metres from one row to the next.
    pub y: f64,
}

impl CellSize {
    /// A square cell with sides of `metres`.
    #[must_use]
    pub const fn square(metres: f64) -> Self {
        Self { x: metres, y: metres }
    }
}

/// A georeference, carried through untouched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Georef {
    /// Affine transform from (column, row) of the *base* grid's cell corners to the coordinate system, in
    /// the order `x = t0 + t1·col + t2·row`, `y = t3 + t4·col + t5·row`.
    pub transform: [f64; 6],
    /// The coordinate reference system: `EPSG:n` where it has a number, otherwise the source's own text.
    pub crs: String,
}

/// The cells of a raster and their place in the world. Rows run north to south, columns west to east.
///
/// A crop moves [`row0`](Self::row0) and [`col0`](Self::col0) by whole cells and leaves everything else, so
/// the position of a cell has the same bits in the crop as in the whole. That is what makes tiled and
/// untiled results equal to the bit, and it moves the georeference along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Row of the base grid that is this grid's row 0.
    pub row0: i64,
    /// Column of the base grid that is this grid's column 0.
    pub col0: i64,
    /// Cell size in metres.
    pub cell: CellSize,
    /// World position, in metres (x east, y north), of the centre of the base grid's first cell.
    pub origin: DVec2,
    /// Coordinate system of the base grid, where there is one.
    pub georef: Option<Arc<Georef>>,
}

impl Grid {
    /// A grid at the world's origin without georeference.
    ///
    /// # Errors
    /// [`Error::TooLarge`] beyond [`MAX_CELLS`]; [`Error::Invalid`] unless the cell size is positive and finite.
    pub fn new(rows: usize, cols: usize, cell: CellSize) -> Result<Self> {
        let cells = (rows as u64).checked_mul(cols as u64);
        if cells.is_none_or(|cells| cells > MAX_CELLS) {
            return Err(Error::TooLarge {
                what: format!("a grid of {rows} × {cols} cells"),
                bytes: cells.unwrap_or(u64::MAX).saturating_mul(4),
                limit: MAX_CELLS * 4,
            });
        }
        let positive = |side: f64| side.is_finite() && side > 0.0;
        if !positive(cell.x) || !positive(cell.y) {
            return Err(Error::invalid(
                format!("a cell of {} × {} m has no area", cell.x, cell.y),
                "give the cell size in metres, greater than zero",
            ));
        }
        Ok(Self { rows, cols, row0: 0, col0: 0, cell, origin: DVec2::ZERO, georef: None })
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    /// Whether there is no cell at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0 || self.cols == 0
    }

    /// Rows and columns.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.rows, self.cols)
    }

    /// World position of a cell's centre, in metres. The same bits for the same cell in every crop.
    #[must_use]
    pub fn position(&self, row: usize, col: usize) -> DVec2 {
        let (base_row, base_col) = self.base(row, col);
        DVec2::new(
            self.origin.x + base_col as f64 * self.cell.x,
            self.origin.y - base_row as f64 * self.cell.y,
        )
    }

    /// Row and column of a cell in the base grid: what random numbers are drawn from.
    #[must_use]
    pub fn base(&self, row: usize, col: usize) -> (i64, i64) {
        (self.row0 + row as i64, self.col0 + col as i64)
    }

    /// Fractional (row, column) of a world position in this grid: the inverse of [`position`](Self::position).
    #[must_use]
    pub fn locate(&self, position: DVec2) -> (f64, f64) {
        (
            (self.origin.y - position.y) / self.cell.y - self.row0 as f64,
            (position.x - self.origin.x) / self.cell.x - self.col0 as f64,
        )
    }

    /// The part of `rows` × `cols` cells that starts at (`row`, `col`).
    ///
    /// # Errors
    /// [`Error::Invalid`] when the part does not lie inside.
    pub fn crop(&self, row: usize, col: usize, rows: usize, cols: usize) -> Result<Self> {
        let inside = |start: usize, n: usize, all: usize| start.checked_add(n).is_some_and(|end| end <= all);
        if !inside(row, rows, self.rows) || !inside(col, cols, self.cols) {
            return Err(Error::invalid(
                format!(
                    "a crop of {rows} × {cols} cells at row {row}, column {col} leaves the grid of {} × {}",
                    self.rows, self.cols
                ),
                "move or shrink the crop",
            ));
        }
        let (row0, col0) = self.base(row, col);
        Ok(Self { rows, cols, row0, col0, ..self.clone() })
    }

    /// The same stretch of ground in `rows` × `cols` cells: outer edges stay, cells grow or shrink.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::EmptyInput`] when either grid has no cells.
    pub fn resized(&self, rows: usize, cols: usize) -> Result<Self> {
        if self.is_empty() || rows == 0 || cols == 0 {
            return Err(Error::EmptyInput { what: "the grid".into() });
        }
        let (scale_y, scale_x) = (self.rows as f64 / rows as f64, self.cols as f64 / cols as f64);
        let cell = CellSize { x: self.cell.x * scale_x, y: self.cell.y * scale_y };
        let mut grid = Self::new(rows, cols, cell)?;
        // The first cell's outer corner stays where it was; its centre moves by half the change in size.
        grid.origin = self.position(0, 0) + DVec2::new(cell.x - self.cell.x, self.cell.y - cell.y) / 2.0;
        grid.georef = self.georef_here().map(|georef| {
            let [x0, xc, xr, y0, yc, yr] = georef.transform;
            let transform = [x0, xc * scale_x, xr * scale_y, y0, yc * scale_x, yr * scale_y];
            Arc::new(Georef { transform, crs: georef.crs })
        });
        Ok(grid)
    }

    /// Another grid on the same ground: `scale` of this one's rows and columns from cell to cell, the first of them at the
    /// fractional row and column `first`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn sampled(&self, rows: usize, cols: usize, scale: [f64; 2], first: [f64; 2]) -> Result<Self> {
        let cell = CellSize { x: self.cell.x * scale[1], y: self.cell.y * scale[0] };
        let mut grid = Self::new(rows, cols, cell)?;
        grid.origin = self.position(0, 0) + DVec2::new(first[1] * self.cell.x, -first[0] * self.cell.y);
        grid.georef = self.georef_here().map(|georef| {
            let [x0, xc, xr, y0, yc, yr] = georef.transform;
            // Transforms start at a cell's corner, places at its centre.
            let [row, col] = [0, 1].map(|axis| first[axis] + 0.5 - 0.5 * scale[axis]);
            let transform = [
                x0 + xc * col + xr * row,
                xc * scale[1],
                xr * scale[0],
                y0 + yc * col + yr * row,
                yc * scale[1],
                yr * scale[0],
            ];
            Arc::new(Georef { transform, crs: georef.crs })
        });
        Ok(grid)
    }

    /// The georeference whose transform starts at this grid's own first cell, as a file wants it.
    #[must_use]
    pub fn georef_here(&self) -> Option<Georef> {
        let georef = self.georef.as_deref()?;
        let [x0, xc, xr, y0, yc, yr] = georef.transform;
        let (row, col) = (self.row0 as f64, self.col0 as f64);
        let transform = [x0 + xc * col + xr * row, xc, xr, y0 + yc * col + yr * row, yc, yr];
        Some(Georef { transform, crs: georef.crs.clone() })
    }

    /// # Errors
    /// [`Error::DimensionMismatch`] when `other` has another number of rows or columns.
    pub fn match_size(&self, name: &str, other: &Self, other_name: &str) -> Result<()> {
        if self.size() == other.size() {
            return Ok(());
        }
        Err(Error::DimensionMismatch {
            first: name.into(),
            first_size: self.size(),
            second: other_name.into(),
            second_size: other.size(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crop_keeps_the_bits_of_positions_and_moves_the_georeference() {
        let mut grid = Grid::new(10, 20, CellSize { x: 0.1, y: 0.3 }).unwrap();
        grid.origin = DVec2::new(1000.7, 2000.3);
        let transform = [500.0, 2.0, 0.0, 900.0, 0.0, -3.0];
        grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
        let crop = grid.crop(3, 7, 5, 6).unwrap().crop(1, 1, 2, 2).unwrap();
        assert_eq!(crop.position(1, 1), grid.position(5, 9));
        assert_eq!(crop.georef_here().unwrap().transform, [516.0, 2.0, 0.0, 888.0, 0.0, -3.0]);
        let (row, col) = crop.locate(grid.position(4, 8));
        assert!(row.abs() < 1e-9 && col.abs() < 1e-9);
    }

    #[test]
    fn resizing_keeps_the_outer_edges() {
        let grid = Grid::new(10, 20, CellSize::square(2.0)).unwrap();
        let half = grid.resized(5, 10).unwrap();
        assert_eq!(half.cell, CellSize::square(4.0));
        assert_eq!(half.position(0, 0), DVec2::new(1.0, -1.0));
    }

    #[test]
    fn sampled_cells_lie_where_they_are_said_to() {
        let mut grid = Grid::new(10, 20, CellSize { x: 2.0, y: 3.0 }).unwrap();
        let transform = [500.0, 2.0, 0.0, 900.0, 0.0, -3.0];
        grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
        let coarse = grid.crop(2, 4, 6, 8).unwrap().sampled(4, 5, [2.0, 2.0], [-0.5, -0.5]).unwrap();
        // Its first cell is centred between rows 1 and 2 and columns 3 and 4 of the whole.
        assert_eq!(coarse.position(0, 0), DVec2::new(7.0, -4.5));
        assert_eq!(coarse.cell, CellSize { x: 4.0, y: 6.0 });
        // Its corner is that of row 1 and column 3.
        assert_eq!(coarse.georef_here().unwrap().transform, [506.0, 4.0, 0.0, 897.0, 0.0, -6.0]);
        assert_eq!(grid.sampled(10, 20, [1.0; 2], [0.0; 2]).unwrap(), grid);
    }

    #[test]
    fn absurd_sizes_are_refused_before_memory_is_taken() {
        assert!(matches!(Grid::new(usize::MAX, 3, CellSize::square(1.0)), Err(Error::TooLarge { .. })));
        assert!(matches!(Grid::new(1 << 20, 1 << 20, CellSize::square(1.0)), Err(Error::TooLarge { .. })));
        assert!(Grid::new(3, 3, CellSize::square(0.0)).is_err());
        assert!(Grid::new(3, 3, CellSize::square(f64::NAN)).is_err());
        assert!(Grid::new(3, 3, CellSize::square(1.0)).unwrap().crop(2, 2, 2, 1).is_err());
    }
}
