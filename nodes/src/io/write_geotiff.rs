//! Write GeoTIFF: the format that loses nothing.

use orograph_core::{Metres, prelude::*};

use super::{
    file,
    geotiff::{self, Compression, GeotiffSink, Layout, Options, SampleType},
};

/// Writes terrain as GeoTIFF with its georeference; BigTIFF by itself where 4 GiB would not do.
///
/// Integer types round to the nearest metre and refuse heights that they cannot hold.
#[derive(Params, Clone, Debug)]
pub struct WriteGeotiff {
    /// The file to write.
    #[param(default = "terrain.tif")]
    pub file: OutputPath,
    /// How heights are stored.
    #[param(default = SampleType::Float32)]
    pub sample: SampleType,
    /// How bytes are packed; the fitting predictor is chosen by itself.
    #[param(default = Compression::Deflate)]
    pub compression: Compression,
    /// Effort of deflate: 1 is fast, 9 is small.
    #[param(default = 1u32, range = 1..=9, unit = "1")]
    pub level: u32,
    /// How cells are grouped.
    #[param(default = Layout::Tiles)]
    pub layout: Layout,
    /// Written for voids, and named in the file as such.
    #[param(default = -32768, range = -3.4e38..=3.4e38, slider = -32768.0..=65535.0, unit = "m")]
    pub nodata: f64,
}

/// Inputs of [`WriteGeotiff`].
#[derive(Inputs)]
pub struct WriteGeotiffIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl WriteGeotiff {
    fn options(&self) -> Options {
        let Self { sample, compression, level, layout, nodata, .. } = *self;
        Options { sample, compression, level, layout, nodata, big: false }
    }
}

impl Node for WriteGeotiff {
    const ID: &'static str = "io.write_geotiff";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    const DEFAULT_WRITER: bool = true;
    type Inputs<'a> = WriteGeotiffIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["tif", "tiff"])?;
        self.options().check()
    }

    fn takes_bands(&self) -> bool {
        true
    }

    fn sink(&self, grid: &Grid, job: &Job) -> Result<Box<dyn BandSink>> {
        let begin = |out| geotiff::heights(grid, &self.options(), out, &self.file.0);
        Ok(Box::new(GeotiffSink::<Metres, _>::new(&self.file, job, begin)?))
    }

    fn run(&self, inputs: WriteGeotiffIn<'_>, job: &Job) -> Result<()> {
        file::save(&self.file, job, |out| {
            geotiff::write(inputs.terrain, &self.options(), out, &self.file.0, job)
        })
    }
}
