//! Write GeoTIFF texture: colours that lie where their terrain does.

use orograph_core::{Rgba, prelude::*};

use super::{
    file,
    geotiff::{Colours, Compression, GeotiffSink, Layout, Storage, Writer},
};

/// Writes a texture, such as a hillshade, as GeoTIFF with its georeference.
///
/// For maps, and for pictures too large for PNG; BigTIFF by itself where 4 GiB would not do.
#[derive(Params, Clone, Debug)]
pub struct WriteGeotiffTexture {
    /// The file to write.
    #[param(default = "texture.tif")]
    pub file: OutputPath,
    /// Writes transparency as a fourth channel, by which colours are not multiplied.
    #[param(default = false)]
    pub alpha: bool,
    /// How bytes are packed.
    #[param(default = Compression::Deflate)]
    pub compression: Compression,
    /// Effort of deflate: 1 is fast, 9 is small.
    #[param(default = 1u32, range = 1..=9, unit = "1")]
    pub level: u32,
    /// How cells are grouped.
    #[param(default = Layout::Tiles)]
    pub layout: Layout,
}

/// Inputs of [`WriteGeotiffTexture`].
#[derive(Inputs)]
pub struct WriteGeotiffTextureIn<'a> {
    /// Texture to write.
    pub texture: &'a Texture,
}

impl WriteGeotiffTexture {
    fn begin<W: std::io::Write + std::io::Seek>(&self, grid: &Grid, out: W) -> Result<Writer<W, Colours>> {
        let Self { compression, level, layout, alpha, .. } = *self;
        Writer::begin(
            grid,
            Colours { alpha },
            Storage { compression, level, layout, big: false },
            out,
            &self.file.0,
        )
    }
}

impl Node for WriteGeotiffTexture {
    const ID: &'static str = "io.write_geotiff_texture";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteGeotiffTextureIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["tif", "tiff"])
    }

    fn takes_bands(&self) -> bool {
        true
    }

    fn sink(&self, grid: &Grid, job: &Job) -> Result<Box<dyn BandSink>> {
        Ok(Box::new(GeotiffSink::<Rgba, _>::new(&self.file, job, |out| self.begin(grid, out))?))
    }

    fn run(&self, inputs: WriteGeotiffTextureIn<'_>, job: &Job) -> Result<()> {
        file::save(&self.file, job, |out| {
            let mut writer = self.begin(inputs.texture.grid(), out)?;
            writer.take(inputs.texture.cells(), job)?;
            writer.finish(job).map(drop)
        })
    }
}
