//! Read mask: a PNG picture as shares.

use orograph_core::prelude::*;

use super::{file, png::Picture};

/// Reads a PNG picture as a mask: black is 0, white is 1, transparent is 0.
#[derive(Params, Clone, Debug)]
pub struct ReadMask {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// Side of a cell.
    #[param(default = 10, range = 0.001..=100_000.0, slider = 0.1..=100.0, unit = "m")]
    pub cell: f64,
}

/// Outputs of [`ReadMask`].
#[derive(Outputs)]
pub struct ReadMaskOut {
    /// The shares in the picture.
    pub mask: Mask,
}

impl Node for ReadMask {
    const ID: &'static str = "io.read_mask";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadMaskOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadMaskOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let picture = Picture::read(&bytes, &name, job)?;
        let grid = Grid::new(picture.rows, picture.cols, CellSize::square(self.cell))?;
        let mask = Mask::build(grid, job, |row, out| {
            out.iter_mut().zip(picture.greys(row)).for_each(|(out, grey)| *out = grey.unwrap_or(0.0) as f32);
            Ok(())
        })?;
        Ok(ReadMaskOut { mask })
    }
}
