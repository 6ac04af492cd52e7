//! Write mask: shares as a grey picture.

use orograph_core::prelude::*;

use super::{
    file,
    png::{self, Pixels},
    target::Target,
    write_png::Depth,
};

/// Writes a mask as a grey PNG picture: 0 is black, 1 is white.
#[derive(Params, Clone, Debug)]
pub struct WriteMask {
    /// The file to write.
    #[param(default = "mask.png")]
    pub file: OutputPath,
    /// Bits of a grey level.
    #[param(default = Depth::Sixteen)]
    pub depth: Depth,
    /// The program that the file is for; its size is checked. Unreal's weight maps have as many cells as the landscape.
    #[param(default = Target::Any)]
    pub target: Target,
}

/// Inputs of [`WriteMask`].
#[derive(Inputs)]
pub struct WriteMaskIn<'a> {
    /// Mask to write.
    pub mask: &'a Mask,
}

impl Node for WriteMask {
    const ID: &'static str = "io.write_mask";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    const DEFAULT_WRITER: bool = true;
    type Inputs<'a> = WriteMaskIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["png"])
    }

    fn run(&self, inputs: WriteMaskIn<'_>, job: &Job) -> Result<()> {
        let mask = inputs.mask;
        file::refuse_empty(mask, "mask")?;
        self.target.check_size(mask.grid())?;
        let pixels = if self.depth == Depth::Sixteen { Pixels::Grey16 } else { Pixels::Grey8 };
        file::save(&self.file, job, |out| {
            png::write(out, mask.grid(), pixels, &self.file.0, job, |row, bytes| {
                // A cast takes NaN to 0 and clips what lies outside.
                let shares = mask.row(row).iter().map(|&share| f64::from(share));
                match self.depth {
                    Depth::Sixteen => {
                        bytes.extend(shares.flat_map(|share| ((share * 65535.0 + 0.5) as u16).to_be_bytes()));
                    }
                    Depth::Eight => bytes.extend(shares.map(|share| (share * 255.0 + 0.5) as u8)),
                }
                Ok(())
            })
        })
    }
}
