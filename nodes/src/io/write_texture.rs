//! Write texture: colours as a picture.

use orograph_core::prelude::*;

use super::{
    file,
    png::{self, Pixels},
};

/// Writes a texture as a PNG picture, with alpha only where a pixel is not opaque.
#[derive(Params, Clone, Debug)]
pub struct WriteTexture {
    /// The file to write.
    #[param(default = "texture.png")]
    pub file: OutputPath,
}

/// Inputs of [`WriteTexture`].
#[derive(Inputs)]
pub struct WriteTextureIn<'a> {
    /// Texture to write.
    pub texture: &'a Texture,
}

impl Node for WriteTexture {
    const ID: &'static str = "io.write_texture";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    const DEFAULT_WRITER: bool = true;
    type Inputs<'a> = WriteTextureIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["png"])
    }

    fn run(&self, inputs: WriteTextureIn<'_>, job: &Job) -> Result<()> {
        let texture = inputs.texture;
        file::refuse_empty(texture, "texture")?;
        let opaque = texture.cells().iter().all(|colour| colour[3] == 255);
        let pixels = if opaque { Pixels::Rgb } else { Pixels::Rgba };
        file::save(&self.file, job, |out| {
            png::write(out, texture.grid(), pixels, &self.file.0, job, |row, bytes| {
                if opaque {
                    bytes.extend(
                        texture.row(row).iter().flat_map(|&[red, green, blue, _]| [red, green, blue]),
                    );
                } else {
                    bytes.extend_from_slice(texture.row(row).as_flattened());
                }
                Ok(())
            })
        })
    }
}
