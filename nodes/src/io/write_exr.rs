//! Write EXR: heights as an OpenEXR picture.

use orograph_core::prelude::*;

use super::{exr, file};

/// Writes heights in metres as an OpenEXR picture of one channel, `Y`; voids are NaN.
///
/// Every height is kept as it is; the format has no place for cell size and georeference.
#[derive(Params, Clone, Debug)]
pub struct WriteExr {
    /// The file to write.
    #[param(default = "terrain.exr")]
    pub file: OutputPath,
}

/// Inputs of [`WriteExr`].
#[derive(Inputs)]
pub struct WriteExrIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl Node for WriteExr {
    const ID: &'static str = "io.write_exr";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteExrIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["exr"])
    }

    fn run(&self, inputs: WriteExrIn<'_>, job: &Job) -> Result<()> {
        file::save(&self.file, job, |out| exr::write(inputs.terrain, out, &self.file.0, job))
    }
}
