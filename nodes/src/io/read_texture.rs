//! Read texture: a PNG picture as colours.

use orograph_core::prelude::*;

use super::{file, png::Picture};

/// Reads a PNG picture as a texture.
#[derive(Params, Clone, Debug)]
pub struct ReadTexture {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// Side of a cell.
    #[param(default = 10, range = 0.001..=100_000.0, slider = 0.1..=100.0, unit = "m")]
    pub cell: f64,
}

/// Outputs of [`ReadTexture`].
#[derive(Outputs)]
pub struct ReadTextureOut {
    /// The colours in the picture.
    pub texture: Texture,
}

impl Node for ReadTexture {
    const ID: &'static str = "io.read_texture";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadTextureOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadTextureOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        Ok(ReadTextureOut { texture: read(&bytes, &name, CellSize::square(self.cell), job)? })
    }
}

/// The colours in a PNG picture.
///
/// # Errors
/// [`Error::Format`] for what is no sound PNG; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, cell: CellSize, job: &Job) -> Result<Texture> {
    let picture = Picture::read(bytes, name, job)?;
    let grid = Grid::new(picture.rows, picture.cols, cell)?;
    Texture::build(grid, job, |row, out| {
        out.iter_mut().zip(picture.colours(row)).for_each(|(out, colour)| *out = colour);
        Ok(())
    })
}
