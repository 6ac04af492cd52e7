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
        Ok(ReadMaskOut { mask: read(&bytes, &name, CellSize::square(self.cell), job)? })
    }
}

/// The shares in a PNG picture: its brightness, 0 where it is transparent.
///
/// # Errors
/// [`Error::Format`] for what is no sound PNG; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, cell: CellSize, job: &Job) -> Result<Mask> {
    let picture = Picture::read(bytes, name, job)?;
    let grid = Grid::new(picture.rows, picture.cols, cell)?;
    Mask::build(grid, job, |row, out| {
        out.iter_mut().zip(picture.greys(row)).for_each(|(out, grey)| *out = grey.unwrap_or(0.0) as f32);
        Ok(())
    })
}
