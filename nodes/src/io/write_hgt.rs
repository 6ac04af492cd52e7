//! Write HGT: an SRTM tile.

use orograph_core::prelude::*;

use super::{file, ground::is_in_degrees, hgt};

/// Writes terrain as an SRTM tile of 1201 or 3601 samples a side, in whole metres.
///
/// The name must be that of the tile's south-west corner, such as `N44W072.hgt`, or no reader finds its place.
#[derive(Params, Clone, Debug)]
pub struct WriteHgt {
    /// The file to write.
    #[param(default = "N00E000.hgt")]
    pub file: OutputPath,
}

/// Inputs of [`WriteHgt`].
#[derive(Inputs)]
pub struct WriteHgtIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl Node for WriteHgt {
    const ID: &'static str = "io.write_hgt";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteHgtIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["hgt"])?;
        if hgt::corner(&self.file.0).is_some() {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`{}` does not say where the tile lies", self.file.0),
            "name the file after its south-west corner, such as `N44W072.hgt`",
        ))
    }

    fn run(&self, inputs: WriteHgtIn<'_>, job: &Job) -> Result<()> {
        job.check()?;
        let bytes = hgt::write(inputs.terrain, job)?;
        let here = inputs.terrain.grid().georef_here();
        let georef = here.filter(is_in_degrees);
        if let (Some(Georef { transform, .. }), Some(named)) = (georef, hgt::corner(&self.file.0)) {
            let rows = inputs.terrain.rows() as f64;
            let corner = (
                (transform[3] + transform[5] * (rows - 0.5)).round() as i32,
                (transform[0] + transform[1] / 2.0).round() as i32,
            );
            if corner != named {
                let name = hgt::tile_name(corner.0, corner.1);
                job.warn(format!("the terrain lies at {name}, but the file is named {}", self.file.0));
            }
        }
        file::save_bytes(&self.file, &bytes, job)
    }
}
