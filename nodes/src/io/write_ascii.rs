//! Write ASCII grid: heights as text.

use orograph_core::prelude::*;

use super::{ascii, file};

/// Writes terrain as ESRI ASCII grid: text that anything reads, large and slow.
///
/// The format knows no coordinate system; voids become -9999. Heights keep their full precision.
#[derive(Params, Clone, Debug)]
pub struct WriteAscii {
    /// The file to write.
    #[param(default = "terrain.asc")]
    pub file: OutputPath,
}

/// Inputs of [`WriteAscii`].
#[derive(Inputs)]
pub struct WriteAsciiIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl Node for WriteAscii {
    const ID: &'static str = "io.write_ascii";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteAsciiIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["asc", "txt"])
    }

    fn run(&self, inputs: WriteAsciiIn<'_>, job: &Job) -> Result<()> {
        file::save(&self.file, job, |out| ascii::write(inputs.terrain, out, &self.file.0, job))
    }
}
