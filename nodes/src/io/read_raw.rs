//! Read RAW: headerless heights, as game engines exchange them.

use orograph_core::prelude::*;

use super::{
    file,
    raw::{self, RawFormat, RawLayout},
};

/// Reads headerless heights: `.r16`, `.r32`, `.raw`.
#[derive(Params, Clone, Debug)]
pub struct ReadRaw {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// How a height is stored.
    #[param(default = RawFormat::R16Little)]
    pub format: RawFormat,
    /// Number of columns; 0 infers a square, or the rest from the rows.
    #[param(default = 0u32, range = 0..=1_000_000, slider = 0..=8129, unit = "cells")]
    pub cols: u32,
    /// Number of rows; 0 infers a square, or the rest from the columns.
    #[param(default = 0u32, range = 0..=1_000_000, slider = 0..=8129, unit = "cells")]
    pub rows: u32,
    /// Height of the lowest 16-bit level.
    #[param(default = 0, range = -20_000.0..=100_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Height of the highest 16-bit level.
    #[param(default = 1000, range = -20_000.0..=100_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
    /// Side of a cell.
    #[param(default = 1, range = 0.001..=100_000.0, slider = 0.1..=100.0, unit = "m")]
    pub cell: f64,
    /// The first row is the southern one, as Unity has it.
    #[param(default = false)]
    pub south_first: bool,
}

/// Outputs of [`ReadRaw`].
#[derive(Outputs)]
pub struct ReadRawOut {
    /// The heights in the file.
    pub terrain: Heightfield,
}

impl Node for ReadRaw {
    const ID: &'static str = "io.read_raw";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadRawOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadRawOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let (rows, cols) =
            raw::size(bytes.len(), self.format, self.rows as usize, self.cols as usize, &name)?;
        let grid = Grid::new(rows, cols, CellSize::square(self.cell))?;
        let layout = RawLayout {
            format: self.format,
            range: (self.lowest, self.highest),
            south_first: self.south_first,
        };
        Ok(ReadRawOut { terrain: raw::read(&bytes, &name, grid, &layout, job)? })
    }
}
