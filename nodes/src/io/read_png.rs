//! placeholder
use orograph_core::prelude::*;
/// Reads.
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
    fn run(&self, (): (), _: &Job) -> Result<ReadPngOut> {
        Err(Error::EmptyInput { what: String::new() })
    }
}
