//! Write RAW: headerless heights for game engines, with the scale that the engine must be told.

use orograph_core::prelude::*;

use super::{
    file,
    raw::{self, RawFormat, RawLayout, is_unity_side, is_unreal_side},
    write_png::{check_range, choose_range},
};

/// The program that the file is for.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawTarget {
    /// Any: no size is refused.
    Any,
    /// Unreal landscapes: the size is checked and the scale told.
    Unreal,
    /// Unity terrains: the size is checked and the scale told.
    Unity,
}

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
    #[param(default = RawTarget::Any)]
    pub target: RawTarget,
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
            return Ok(());
        }
        check_range(self.automatic, (self.lowest, self.highest))
    }

    fn run(&self, inputs: WriteRawIn<'_>, job: &Job) -> Result<()> {
        let terrain = inputs.terrain;
        file::refuse_empty(terrain, "terrain")?;
        self.check_size(terrain.grid())?;
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
    fn check_size(&self, grid: &Grid) -> Result<()> {
        let (rows, cols) = grid.size();
        let (fits, whose, sizes) = match self.target {
            RawTarget::Any => return Ok(()),
            RawTarget::Unreal => (
                is_unreal_side(rows) && is_unreal_side(cols),
                "an Unreal landscape",
                "505, 1009, 2017, 4033 or 8129",
            ),
            RawTarget::Unity => (
                rows == cols && is_unity_side(rows),
                "a Unity terrain",
                "513, 1025, 2049 or 4097 in both directions",
            ),
        };
        if fits {
            return Ok(());
        }
        Err(Error::invalid(
            format!("{rows} × {cols} is no size of {whose}"),
            format!("resize the terrain to {sizes} cells a side"),
        ))
    }

    /// Tells what the engine's import dialogue asks for.
    fn tell_scale(&self, grid: &Grid, (lowest, highest): (f64, f64), job: &Job) {
        let (rows, cols, cell) = (grid.rows, grid.cols, grid.cell);
        match self.target {
            RawTarget::Any => {
                job.warn(format!("{cols} columns, {rows} rows, cells of {} × {} m", cell.x, cell.y))
            }
            RawTarget::Unreal => {
                // A landscape of scale 100 spans 512 m, 256 m on either side of its actor; sides are in cm.
                let (x, y, z) = (cell.x * 100.0, cell.y * 100.0, (highest - lowest) * 100.0 / 512.0);
                let middle = f64::midpoint(lowest, highest) * 100.0;
                job.warn(format!("Unreal: set the landscape's scale to {x}, {y}, {z} and its z to {middle}"));
            }
            RawTarget::Unity => {
                let (x, y) = (cell.x * (cols - 1) as f64, cell.y * (rows - 1) as f64);
                job.warn(format!(
                    "Unity: resolution {cols}, width {x}, length {y}, height {}",
                    highest - lowest
                ));
            }
        }
    }
}
