//! Write texture: colours as a picture.

use std::io::Write;

use orograph_core::prelude::*;

use super::{
    file,
    png::{self, Pixels},
};

/// How a picture is packed. Every pixel comes back as it was.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// At once.
    Fast,
    /// Into a smaller file, which takes longer: for the web, or to be kept. Grey pictures become grey, and pictures of
    /// at most 256 colours a palette.
    Small,
}

/// Writes a texture as a PNG picture, with alpha only where a pixel is not opaque.
#[derive(Params, Clone, Debug)]
pub struct WriteTexture {
    /// The file to write.
    #[param(default = "texture.png")]
    pub file: OutputPath,
    /// How the picture is packed.
    #[param(default = Packing::Fast)]
    pub packing: Packing,
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
        if self.packing == Packing::Small {
            return file::save(&self.file, job, |out| png::write_small(out, texture, &self.file.0, job));
        }
        file::save(&self.file, job, |out| write(texture, out, &self.file.0, job))
    }
}

/// Writes a texture, without alpha where every pixel is opaque. Colours are not multiplied with alpha.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Io`] from the stream, with `name`; [`Error::Cancelled`].
pub(crate) fn write(texture: &Texture, out: &mut impl Write, name: &str, job: &Job) -> Result<()> {
    let opaque = texture.cells().iter().all(|colour| colour[3] == 255);
    let pixels = if opaque { Pixels::Rgb } else { Pixels::Rgba };
    png::write(out, texture.grid(), pixels, name, job, |row, bytes| {
        if opaque {
            bytes.extend(texture.row(row).iter().flat_map(|&[red, green, blue, _]| [red, green, blue]));
        } else {
            bytes.extend_from_slice(texture.row(row).as_flattened());
        }
        Ok(())
    })
}
