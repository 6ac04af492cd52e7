//! Read EXR: heights from an OpenEXR picture.

use orograph_core::prelude::*;

use super::{exr, file};

/// Reads heights in metres from an OpenEXR picture; NaN is a void.
///
/// The channel named `height`, `Y`, `Z` or `R` is read, or else the first.
#[derive(Params, Clone, Debug)]
pub struct ReadExr {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// Side of a cell.
    #[param(default = 1, range = 0.001..=100_000.0, slider = 0.1..=100.0, unit = "m")]
    pub cell: f64,
}

/// Outputs of [`ReadExr`].
#[derive(Outputs)]
pub struct ReadExrOut {
    /// The heights in the picture.
    pub terrain: Heightfield,
}

impl Node for ReadExr {
    const ID: &'static str = "io.read_exr";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadExrOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadExrOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        Ok(ReadExrOut { terrain: exr::read(&bytes, &name, CellSize::square(self.cell), job)? })
    }
}
