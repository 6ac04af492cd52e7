//! Read PNG: grey levels as heights between two levels.

use orograph_core::prelude::*;

use super::{file, png::Picture};

/// Reads heights from a PNG picture, 8 or 16 bits of grey.
///
/// Black is the lowest height and white the highest. Transparent pixels become voids. A coloured picture is
/// read by its brightness, with a remark.
#[derive(Params, Clone, Debug)]
pub struct ReadPng {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// Height of black.
    #[param(default = 0, range = -20_000.0..=100_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Height of white.
    #[param(default = 1000, range = -20_000.0..=100_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
    /// Side of a cell.
    #[param(default = 10, range = 0.001..=100_000.0, slider = 0.1..=100.0, unit = "m")]
    pub cell: f64,
}

/// Outputs of [`ReadPng`].
#[derive(Outputs)]
pub struct ReadPngOut {
    /// The heights in the picture.
    pub terrain: Heightfield,
}

impl Node for ReadPng {
    const ID: &'static str = "io.read_png";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadPngOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadPngOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let terrain = read(&bytes, &name, (self.lowest, self.highest), CellSize::square(self.cell), job)?;
        Ok(ReadPngOut { terrain })
    }
}

/// The heights in a PNG picture: `range` gives those of black and white in metres.
///
/// # Errors
/// [`Error::Format`] for what is no sound PNG; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, range: (f64, f64), cell: CellSize, job: &Job) -> Result<Heightfield> {
    let picture = Picture::read(bytes, name, job)?;
    if picture.is_coloured() {
        job.warn(format!("{name} is coloured: its brightness is read as height"));
    }
    let grid = Grid::new(picture.rows, picture.cols, cell)?;
    let (lowest, span) = (range.0, range.1 - range.0);
    Heightfield::build(grid, job, |row, out| {
        if let Some(greys) = picture.grey16(row) {
            let step = span / 65535.0;
            for (out, &grey) in out.iter_mut().zip(greys) {
                *out = (lowest + f64::from(u16::from_be_bytes(grey)) * step) as f32;
            }
            return Ok(());
        }
        for (out, grey) in out.iter_mut().zip(picture.greys(row)) {
            *out = grey.map_or(f32::NAN, |grey| (lowest + grey * span) as f32);
        }
        Ok(())
    })
}
