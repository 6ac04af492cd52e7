//! Read DEM: an elevation model in whichever of the usual formats it comes.
//!
//! The format is told from the first bytes, and from the length for SRTM tiles, which have no header: the
//! extension lies too often to be asked first.

use std::io::{Read, Seek};

use orograph_core::prelude::*;

use super::{
    archive, ascii, file,
    geotiff::{self, GeotiffSource},
    hgt,
};

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

    /// A GeoTIFF can be read a few rows at a time.
    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        let (mut opened, name) = file::open(&self.file, job)?;
        let mut magic = Vec::new();
        let looked = (&mut opened).take(4).read_to_end(&mut magic).and_then(|_| opened.rewind());
        looked.map_err(|reason| Error::reading(&self.file.0, reason))?;
        if !geotiff::looks_like(&magic) {
            return Ok(None);
        }
        let Some(source) = GeotiffSource::open(opened, &self.file.0, &name, job)? else { return Ok(None) };
        let grid = self.placed(source.grid().clone());
        Ok(Some(Box::new(source.with_grid(grid))))
    }

    fn run(&self, (): (), job: &Job) -> Result<ReadDemOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let terrain = read(&bytes, &name, job)?;
        let grid = self.placed(terrain.grid().clone());
        Ok(ReadDemOut { terrain: terrain.with_grid(grid)? })
    }
}

impl ReadDem {
    /// The grid with the cell size of the settings, where the file tells none.
    fn placed(&self, grid: Grid) -> Grid {
        if self.cell > 0.0 && grid.georef.is_none() {
            return Grid { cell: CellSize::square(self.cell), ..grid };
        }
        grid
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
    if geotiff::looks_like(bytes) {
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
