//! Write RAW: headerless heights for game engines, with the scale that the engine must be told.

use orograph_core::prelude::*;

use super::{
    file,
    raw::{self, RawFormat, RawLayout},
    target::Target,
    write_png::{check_range, choose_range},
};

/// Writes headerless heights: `.r16`, `.r32`, `.raw`.
///
/// In 16-bit formats voids become the lowest level, with a remark; heights outside an explicit range are an
/// error, never clipped. The size and the height range are told, since the file cannot say them.
#[derive(Params, Clone, Debug)]
pub struct WriteRaw {
    /// The file to write.
    #[param(default = "terrain.r16")]
    pub file: OutputPath,
    /// How a height is stored.
    #[param(default = RawFormat::R16Little)]
    pub format: RawFormat,
    /// The program that the file is for.
    #[param(default = Target::Any)]
    pub target: Target,
    /// Takes the range from the terrain and tells it; turn it off to set the range.
    #[param(default = true)]
    pub automatic: bool,
    /// Height of the lowest 16-bit level, unless automatic.
    #[param(default = 0, range = -20_000.0..=100_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Height of the highest 16-bit level, unless automatic.
    #[param(default = 1000, range = -20_000.0..=100_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
    /// Writes the southern row first, as Unity has it.
    #[param(default = false)]
    pub south_first: bool,
}

/// Inputs of [`WriteRaw`].
#[derive(Inputs)]
pub struct WriteRawIn<'a> {
    /// Terrain to write.
    pub terrain: &'a Heightfield,
}

impl Node for WriteRaw {
    const ID: &'static str = "io.write_raw";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = WriteRawIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        file::check_extension(&self.file, &["r16", "r32", "raw"])?;
        if self.format == RawFormat::R32 {
            if self.target != Target::Any {
                return Err(Error::invalid(
                    "landscapes take heights of 16 bits",
                    "set `format` to r16_little",
                ));
            }
            return Ok(());
        }
        check_range(self.automatic, (self.lowest, self.highest))
    }

    fn run(&self, inputs: WriteRawIn<'_>, job: &Job) -> Result<()> {
        let terrain = inputs.terrain;
        file::refuse_empty(terrain, "terrain")?;
        self.target.check_size(terrain.grid())?;
        let range = if self.format == RawFormat::R32 {
            file::refuse_infinite(terrain, "terrain")?;
            (0.0, 1.0)
        } else {
            choose_range(terrain, self.automatic, (self.lowest, self.highest), job)?
        };
        let voids = terrain.void_count();
        if voids > 0 && self.format != RawFormat::R32 {
            job.warn(format!("{voids} voids are written as {} m", range.0));
        }
        self.tell_scale(terrain.grid(), range, job);
        let layout = RawLayout { format: self.format, range, south_first: self.south_first };
        file::save_bytes(&self.file, &raw::write(terrain, &layout, job)?, job)
    }
}

impl WriteRaw {
    /// Tells what the file does not say of itself.
    fn tell_scale(&self, grid: &Grid, range: (f64, f64), job: &Job) {
        if self.target == Target::Any {
            let (rows, cols, cell) = (grid.rows, grid.cols, grid.cell);
            job.warn(format!("{cols} columns, {rows} rows, cells of {} × {} m", cell.x, cell.y));
        }
        self.target.tell_scale(grid, range, job);
    }
}
