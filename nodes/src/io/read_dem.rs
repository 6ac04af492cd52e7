//! Read DEM: an elevation model in whichever of the usual formats it comes.
//!
//! The format is told from the first bytes, and from the length for SRTM tiles, which have no header: the
//! extension lies too often to be asked first.

use orograph_core::prelude::*;

use super::{archive, ascii, file, geotiff, hgt};

/// Reads an elevation model: GeoTIFF, SRTM `.hgt`, ESRI ASCII grid, or a zip of one.
///
/// Heights come in metres, voids as voids. The georeference is kept, and cells get their true size in metres:
/// degrees are turned into metres at the grid's centre.
#[derive(Params, Clone, Debug)]
pub struct ReadDem {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// Side of a cell where the file has no georeference; 0 takes what the file says.
    #[param(default = 0, range = 0.0..=100_000.0, slider = 0.0..=100.0, unit = "m")]
    pub cell: f64,
}

/// Outputs of [`ReadDem`].
#[derive(Outputs)]
pub struct ReadDemOut {
    /// The heights in the file.
    pub terrain: Heightfield,
}

impl Node for ReadDem {
    const ID: &'static str = "io.read_dem";
    const VERSION: u32 = 2; // 2 knows feet by the number of the system, and keeps bars in names
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadDemOut;

    fn run(&self, (): (), job: &Job) -> Result<ReadDemOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let mut terrain = read(&bytes, &name, job)?;
        if self.cell > 0.0 && terrain.grid().georef.is_none() {
            let grid = Grid { cell: CellSize::square(self.cell), ..terrain.grid().clone() };
            terrain = terrain.with_grid(grid)?;
        }
        Ok(ReadDemOut { terrain })
    }
}

/// The heights in an elevation file of any supported format; `name` names it in errors and places SRTM tiles.
///
/// # Errors
/// [`Error::Format`] when the format is unknown or the file broken; else as the format's own reader.
pub fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    if bytes.is_empty() {
        return Err(Error::format(name, "the file is empty"));
    }
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        let (bytes, entry) = archive::only_entry(bytes, name, job)?;
        return read_plain(&bytes, &entry, job);
    }
    read_plain(bytes, name, job)
}

fn read_plain(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    if matches!(bytes.get(..4), Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+")) {
        return geotiff::read(bytes, name, job);
    }
    if ascii::looks_like(bytes) {
        return ascii::read(bytes, name, job);
    }
    if file::has_extension(name, "hgt") || hgt::corner(name).is_some() {
        return hgt::read(bytes, name, job);
    }
    let other = match bytes {
        [0x89, b'P', b'N', b'G', ..] => "a PNG picture: use `io.read_png`",
        [0x76, 0x2f, 0x31, 0x01, ..] => "an OpenEXR picture: use `io.read_exr`",
        _ => "no GeoTIFF, SRTM tile, ASCII grid or zip of one; for headerless heights use `io.read_raw`",
    };
    Err(Error::format(name, format!("this is {other}")))
}
