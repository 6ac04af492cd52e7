//! Write PNG: heights as grey levels.

use std::io::Write;

use orograph_core::prelude::*;

use super::{
    file,
    png::{self, Pixels},
    target::Target,
};

/// Bits of a grey level.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 65536 levels.
    Sixteen,
    /// 256 levels: steps show on any slope.
    Eight,
}

/// Writes heights as a grey PNG picture, black lowest and white highest.
///
/// Voids become black, with a remark. Heights outside an explicit range are an error, never clipped.
#[derive(Params, Clone, Debug)]
pub struct WritePng {
    /// The file to write.
    #[param(default = "terrain.png")]
    pub file: OutputPath,
    /// Bits of a grey level.
    #[param(default = Depth::Sixteen)]
    pub depth: Depth,
    /// The program that the file is for.
    #[param(default = Target::Any)]
    pub target: Target,
    /// Takes the range from the terrain and tells it; turn it off to set the range.
    #[param(default = true)]
    pub automatic: bool,
    /// Height of black, unless automatic.
    #[param(default = 0, range = -20_000.0..=100_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Height of white, unless automatic.
    #[param(default = 1000, range = -20_000.0..=100_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
}

/// Inputs of [`WritePng`].
#[derive(Inputs)]
pub struct WritePngIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl Node for WritePng {
    const ID: &'static str = "io.write_png";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WritePngIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["png"])?;
        if self.target != Target::Any && self.depth == Depth::Eight {
            return Err(Error::invalid("landscapes take heights of 16 bits", "set `depth` to sixteen"));
        }
        check_range(self.automatic, (self.lowest, self.highest))
    }

    fn run(&self, inputs: WritePngIn<'_>, job: &Job) -> Result<()> {
        self.target.check_size(inputs.terrain.grid())?;
        let range = choose_range(inputs.terrain, self.automatic, (self.lowest, self.highest), job)?;
        self.target.tell_scale(inputs.terrain.grid(), range, job);
        file::save(&self.file, job, |out| write(inputs.terrain, self.depth, range, out, &self.file.0, job))
    }
}

/// Refuses an explicit range that is none.
pub(crate) fn check_range(automatic: bool, (lowest, highest): (f64, f64)) -> Result<()> {
    if automatic || lowest < highest {
        return Ok(());
    }
    Err(Error::invalid(format!("`lowest` ({lowest} m) is not below `highest` ({highest} m)"), "swap them"))
}

/// The heights of the lowest and highest level: as set, or the terrain's own, which the user is told.
pub(crate) fn choose_range(
    terrain: &Heightfield,
    automatic: bool,
    range: (f64, f64),
    job: &Job,
) -> Result<(f64, f64)> {
    file::refuse_infinite(terrain, "terrain")?;
    let (low, high) = terrain.known_range("terrain")?;
    let (low, high) = (f64::from(low), f64::from(high));
    if automatic {
        // A flat terrain still needs a range to be read back with.
        let high = if high > low { high } else { low + 1.0 };
        job.warn(format!("height range {low} to {high} m: read the file back with these"));
        return Ok((low, high));
    }
    if low < range.0 || high > range.1 {
        return Err(Error::invalid(
            format!("heights from {low} to {high} m leave the range {} to {} m", range.0, range.1),
            "widen the range, or clamp the heights first",
        ));
    }
    Ok(range)
}

/// Writes heights between `range` as grey levels; voids become black, with a remark.
///
/// # Errors
/// [`Error::EmptyInput`]; [`Error::Io`] from the stream, with `name`; [`Error::Cancelled`].
pub fn write(
    terrain: &Heightfield,
    depth: Depth,
    (lowest, highest): (f64, f64),
    out: &mut impl Write,
    name: &str,
    job: &Job,
) -> Result<()> {
    file::refuse_empty(terrain, "terrain")?;
    let voids = terrain.void_count();
    if voids > 0 {
        job.warn(format!("{voids} voids are written as {lowest} m"));
    }
    let (white, pixels) = match depth {
        Depth::Sixteen => (65535.0, Pixels::Grey16),
        Depth::Eight => (255.0, Pixels::Grey8),
    };
    let scale = white / (highest - lowest);
    // A cast takes NaN to 0 and clips what rounding pushed over an edge.
    let level = move |height: f32| ((f64::from(height) - lowest) * scale + 0.5) as u16;
    png::write(out, terrain.grid(), pixels, name, job, |row, bytes| {
        let heights = terrain.row(row).iter();
        match depth {
            Depth::Sixteen => {
                let start = bytes.len();
                bytes.resize(start + terrain.cols() * 2, 0);
                for (out, &height) in bytes[start..].as_chunks_mut().0.iter_mut().zip(heights) {
                    *out = level(height).to_be_bytes();
                }
            }
            Depth::Eight => bytes.extend(heights.map(|&height| level(height).min(255) as u8)),
        }
        Ok(())
    })
}
