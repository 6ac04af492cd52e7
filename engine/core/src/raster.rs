//! Rasters: the grids of heights, shares and colours that travel along wires.

use bytemuck::Pod;
use rayon::prelude::*;

use crate::{Error, Grid, Job, Result, ValueType, buffer::Buffer, pointwise};

/// What the cells of a [`Raster`] mean.
pub trait Kind: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// One cell.
    type Cell: Pod + Send + Sync + PartialEq + std::fmt::Debug;
    /// The type of a wire that carries such a raster.
    const TYPE: ValueType;
    /// What a cell holds before anything is known of it.
    const BLANK: Self::Cell;
}

/// Heights in metres; NaN is a void.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metres;
impl Kind for Metres {
    type Cell = f32;
    const TYPE: ValueType = ValueType::Heightfield;
    const BLANK: f32 = f32::NAN;
}

/// Shares from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share;
impl Kind for Share {
    type Cell = f32;
    const TYPE: ValueType = ValueType::Mask;
    const BLANK: f32 = 0.0;
}

/// Colours: red, green, blue and alpha, 8 bits each, sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgba;
impl Kind for Rgba {
    type Cell = [u8; 4];
    const TYPE: ValueType = ValueType::Texture;
    const BLANK: [u8; 4] = [0; 4];
}

/// Rows × columns of heights in metres, row-major; NaN is a void.
pub type Heightfield = Raster<Metres>;
/// Rows × columns of shares in 0..=1, row-major.
pub type Mask = Raster<Share>;
/// Rows × columns of colours, row-major, lying over a heightfield of the same grid.
pub type Texture = Raster<Rgba>;

/// A grid with one value per cell, row-major.
#[derive(Clone, Debug)]
pub struct Raster<K: Kind> {
    grid: Grid,
    cells: Buffer<K::Cell>,
}

impl<K: Kind> Raster<K> {
    /// A raster of the given cells, row-major.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless there is one value for each cell of the grid.
    pub fn new(grid: Grid, cells: Vec<K::Cell>) -> Result<Self> {
        Self::match_cells(&grid, cells.len())?;
        Ok(Self { grid, cells: cells.into() })
    }

    /// A raster over cells that someone else keeps, row-major. It is read in place; a clone, and the first change,
    /// make a copy.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn lent(grid: Grid, cells: &'static [K::Cell]) -> Result<Self> {
        Self::match_cells(&grid, cells.len())?;
        Ok(Self { grid, cells: Buffer::lent(cells) })
    }

    fn match_cells(grid: &Grid, cells: usize) -> Result<()> {
        if cells == grid.len() {
            return Ok(());
        }
        Err(Error::invalid(
            format!("{cells} values for a grid of {} × {} cells", grid.rows, grid.cols),
            "give one value for each cell, row by row",
        ))
    }

    /// A raster with the same value everywhere.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory.
    pub fn filled(grid: Grid, value: K::Cell, job: &Job) -> Result<Self> {
        let mut raster = Self::zeroed(grid, job)?;
        raster.cells.par_chunks_mut(1 << 16).for_each(|cells| cells.fill(value));
        Ok(raster)
    }

    /// Builds a raster row by row, in parallel: `fill` writes row `row` into the slice, which holds
    /// [`Kind::BLANK`] before. Stops between rows when the job is cancelled, and reports progress.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`], and what `fill` returns.
    pub fn build(
        grid: Grid,
        job: &Job,
        fill: impl Fn(usize, &mut [K::Cell]) -> Result<()> + Sync,
    ) -> Result<Self> {
        Self::build_rows(grid, job, |row, cells| {
            cells.fill(K::BLANK);
            fill(row, cells)
        })
    }

    /// [`build`](Self::build) for a `fill` that writes every cell of its row and cannot fail.
    pub(crate) fn build_over(
        grid: Grid,
        job: &Job,
        fill: impl Fn(usize, &mut [K::Cell]) + Sync,
    ) -> Result<Self> {
        Self::build_rows(grid, job, |row, cells| {
            fill(row, cells);
            Ok(())
        })
    }

    fn build_rows(
        grid: Grid,
        job: &Job,
        fill: impl Fn(usize, &mut [K::Cell]) -> Result<()> + Sync,
    ) -> Result<Self> {
        Self::build_lots(grid, 1, job, fill)
    }

    /// [`build`](Self::build) for a `fill` that makes `lot` rows at a time, fewer at the end, and writes every cell of them:
    /// it gets the first row and the cells, which hold zeros before.
    ///
    /// # Errors
    /// Those of [`build`](Self::build).
    pub fn build_lots(
        grid: Grid,
        lot: usize,
        job: &Job,
        fill: impl Fn(usize, &mut [K::Cell]) -> Result<()> + Sync,
    ) -> Result<Self> {
        let mut raster = Self::zeroed(grid, job)?;
        let ((rows, cols), lot) = (raster.grid.size(), lot.max(1));
        if !raster.grid.is_empty() {
            let done = job.stage(rows as u64);
            let least = min_rows(cols).div_ceil(lot);
            raster
                .cells
                .par_chunks_mut(lot.saturating_mul(cols))
                .with_min_len(least)
                .enumerate()
                .try_for_each(|(i, cells)| {
                    job.check()?;
                    fill(i * lot, cells)?;
                    done.advance((cells.len() / cols) as u64);
                    Ok(())
                })?;
        }
        Ok(raster)
    }

    /// A raster of zero bytes, for cells that will all be written. Untouched zeros cost nothing: each page comes when its
    /// row is filled, in parallel where that is, which spares a walk over the whole memory before.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory.
    pub fn zeroed(grid: Grid, job: &Job) -> Result<Self> {
        Self::admit(&grid, job)?;
        let cells = Buffer::zeroed(grid.len()).ok_or_else(|| Self::too_large(&grid))?;
        Ok(Self { grid, cells })
    }

    /// A raster of a copy of the cells that `bytes` hold, which need not be aligned; `None` where they are not as
    /// many, or the memory is lacking.
    #[must_use]
    pub fn of_bytes(grid: Grid, bytes: &[u8]) -> Option<Self> {
        Self::takes(&grid, bytes.len()).then_some(())?;
        Some(Self { grid, cells: Buffer::of_bytes(bytes)? })
    }

    /// Whether the cells of `grid` take so many bytes. It may come from anywhere: its size may not even be a number.
    pub(crate) fn takes(grid: &Grid, bytes: usize) -> bool {
        let cells = grid.rows.checked_mul(grid.cols);
        cells.and_then(|cells| cells.checked_mul(size_of::<K::Cell>())) == Some(bytes)
    }

    /// A raster whose cells' bytes `fill` brings; `None` where the memory is lacking or `fill` gives `false`.
    pub(crate) fn of_filled(grid: Grid, fill: impl FnOnce(&mut [u8]) -> bool) -> Option<Self> {
        let mut cells = Buffer::<K::Cell>::zeroed(grid.len())?;
        fill(bytemuck::cast_slice_mut(&mut cells)).then_some(())?;
        Some(Self { grid, cells })
    }

    fn bytes(grid: &Grid) -> u64 {
        (grid.len() as u64).saturating_mul(size_of::<K::Cell>() as u64)
    }

    fn name(grid: &Grid) -> String {
        format!("a {} of {} × {} cells", K::TYPE, grid.rows, grid.cols)
    }

    fn admit(grid: &Grid, job: &Job) -> Result<()> {
        job.admit(Self::bytes(grid), || Self::name(grid))
    }

    /// What to say when the machine has not the memory that the job admits.
    fn too_large(grid: &Grid) -> Error {
        let bytes = Self::bytes(grid);
        Error::TooLarge { what: Self::name(grid), bytes, limit: bytes }
    }

    /// The part of `rows` × `cols` cells that starts at (`row`, `col`), with its place in the world kept.
    ///
    /// # Errors
    /// As [`Grid::crop`], and [`Error::TooLarge`].
    pub fn crop(&self, row: usize, col: usize, rows: usize, cols: usize, job: &Job) -> Result<Self> {
        let grid = self.grid.crop(row, col, rows, cols)?;
        Self::build(grid, job, |r, out| {
            out.copy_from_slice(&self.row(row + r)[col..col + cols]);
            Ok(())
        })
    }

    /// Where the cells lie.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The same cells at another place.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`] when `grid` has another size.
    pub fn with_grid(self, grid: Grid) -> Result<Self> {
        self.grid.match_size("the raster", &grid, "its new grid")?;
        Ok(Self { grid, cells: self.cells })
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.grid.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.grid.cols
    }

    /// All cells, row by row.
    #[must_use]
    pub fn cells(&self) -> &[K::Cell] {
        &self.cells
    }

    /// All cells, row by row, to be changed while the raster is being made.
    #[must_use]
    pub fn cells_mut(&mut self) -> &mut [K::Cell] {
        &mut self.cells
    }

    /// The cells alone.
    #[must_use]
    pub fn into_cells(self) -> Vec<K::Cell> {
        self.cells.into_vec()
    }

    /// One row of cells.
    ///
    /// # Panics
    /// Beyond the last row, as slices do.
    #[must_use]
    pub fn row(&self, row: usize) -> &[K::Cell] {
        &self.cells[row * self.grid.cols..(row + 1) * self.grid.cols]
    }

    /// The cell at (`row`, `col`).
    ///
    /// # Panics
    /// Outside the grid, as slices do.
    #[must_use]
    pub fn at(&self, row: usize, col: usize) -> K::Cell {
        debug_assert!(col < self.grid.cols);
        self.cells[row * self.grid.cols + col]
    }
}

/// Rows that one parallel task should take at least, so that narrow rasters do not drown in tasks.
fn min_rows(cols: usize) -> usize {
    (8192 / cols.max(1)).max(1)
}

impl Heightfield {
    /// Lowest and highest height; `None` when every cell is a void.
    #[must_use]
    pub fn range(&self) -> Option<(f32, f32)> {
        pointwise::range(&self.cells)
    }

    /// Number of voids.
    #[must_use]
    pub fn void_count(&self) -> usize {
        pointwise::count_voids(&self.cells)
    }

    /// Lowest and highest height.
    ///
    /// # Errors
    /// [`Error::EmptyInput`] without cells, [`Error::AllVoid`] without a measured one; `what` names the input.
    pub fn known_range(&self, what: &str) -> Result<(f32, f32)> {
        if self.grid.is_empty() {
            return Err(Error::EmptyInput { what: what.into() });
        }
        self.range().ok_or_else(|| Error::AllVoid { what: what.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellSize;

    #[test]
    fn ranges_pass_over_voids() {
        let grid = Grid::new(2, 2, CellSize::square(1.0)).unwrap();
        let field = Heightfield::new(grid.clone(), vec![f32::NAN, 3.0, -1.0, f32::NAN]).unwrap();
        assert_eq!(field.range(), Some((-1.0, 3.0)));
        let long: Vec<f32> = (0..200_000).map(|i| if i % 7 == 0 { f32::NAN } else { i as f32 }).collect();
        let long = Heightfield::new(Grid::new(1, 200_000, CellSize::square(1.0)).unwrap(), long).unwrap();
        assert_eq!((long.range(), long.void_count()), (Some((1.0, 199_999.0)), 28_572));
        assert_eq!(field.void_count(), 2);
        let voids = Heightfield::new(grid, vec![f32::NAN; 4]).unwrap();
        assert_eq!(voids.range(), None);
        assert!(matches!(voids.known_range("dem"), Err(Error::AllVoid { .. })));
    }

    #[test]
    fn the_number_of_cells_must_fit() {
        let grid = Grid::new(2, 2, CellSize::square(1.0)).unwrap();
        assert!(Heightfield::new(grid, vec![0.0; 3]).is_err());
    }
}
