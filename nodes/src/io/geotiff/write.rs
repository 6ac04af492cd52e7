//! Writing: the order of the parts, whether the rows come all at once or a few at a time.

use std::io::{Seek, SeekFrom, Write};

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    cells::{Cells, Heights},
    codec,
    directory::Directory,
};
use crate::io::file::refuse_empty;

/// How heights are stored.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    /// 32-bit floating point: every height as it is.
    Float32,
    /// Whole metres from -32768 to 32767.
    Int16,
    /// Whole metres from 0 to 65535.
    Uint16,
    /// Whole metres beyond that.
    Int32,
    /// 64-bit floating point, for software that wants it; heights have 32 bits here.
    Float64,
}

/// How bytes are packed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Deflate, which every GIS reads.
    Deflate,
    /// LZW, for very old software.
    Lzw,
    /// None.
    None,
}

/// How cells are grouped.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Tiles of 256 × 256 cells: quick to view in part.
    Tiles,
    /// Strips of whole rows: what the simplest readers expect.
    Strips,
}

/// How to write a GeoTIFF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How heights are stored.
    pub sample: SampleType,
    /// How bytes are packed.
    pub compression: Compression,
    /// Effort of deflate, 1 (fast) to 9 (small).
    pub level: u32,
    /// How cells are grouped.
    pub layout: Layout,
    /// The value written for voids.
    pub nodata: f64,
    /// Writes BigTIFF even where 4 GiB would do.
    pub big: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            sample: SampleType::Float32,
            compression: Compression::Deflate,
            level: 1,
            layout: Layout::Tiles,
            nodata: -32768.0,
            big: false,
        }
    }
}

/// Sides of a tile, and about how many bytes a strip should have.
const TILE: usize = 256;
const STRIP_BYTES: usize = 1 << 18;
/// Chunks that each thread packs before the next are begun; bounds the memory for packed bytes. A few, so that it stays
/// close at hand and is used again.
const BATCH: usize = 8;
/// A classic file's offsets end at 4 GiB; this leaves room for the tags and for what does not compress.
const CLASSIC_LIMIT: u64 = 4_000_000_000;

impl SampleType {
    pub(super) fn size(self) -> usize {
        match self {
            Self::Float64 => 8,
            Self::Float32 | Self::Int32 => 4,
            Self::Int16 | Self::Uint16 => 2,
        }
    }

    /// Lowest and highest value; for floats those of f32.
    pub(super) fn limits(self) -> (f64, f64) {
        match self {
            Self::Float32 | Self::Float64 => (f64::from(f32::MIN), f64::from(f32::MAX)),
            Self::Int32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::Int16 => (-32768.0, 32767.0),
            Self::Uint16 => (0.0, 65535.0),
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::Float32 | Self::Float64)
    }

    pub(super) fn name(self) -> &'static str {
        Choice::name(&self)
    }
}

impl Options {
    /// # Errors
    /// [`Error::Invalid`] when the nodata value is none of the sample type.
    pub fn check(&self) -> Result<()> {
        let (low, high) = self.sample.limits();
        let whole = self.sample.is_float() || self.nodata == f64::from(self.nodata as i32);
        if (low..=high).contains(&self.nodata) && whole {
            return Ok(());
        }
        let mend = if self.sample == SampleType::Uint16 { "use 65535 or 0" } else { "use -32768" };
        Err(Error::invalid(format!("`nodata` {} is no {} value", self.nodata, self.sample.name()), mend))
    }

    /// The nodata value as cells of the file hold it.
    pub(super) fn stored_nodata(&self) -> f64 {
        if self.sample.is_float() { f64::from(self.nodata as f32) } else { self.nodata }
    }

    /// How the cells are grouped and packed.
    fn storage(&self) -> Storage {
        let Self { compression, level, layout, big, .. } = *self;
        Storage { compression, level, layout, big }
    }
}

/// How the cells of a file are grouped and packed, whatever they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storage {
    /// How bytes are packed.
    pub compression: Compression,
    /// Effort of deflate, 1 (fast) to 9 (small).
    pub level: u32,
    /// How cells are grouped.
    pub layout: Layout,
    /// Writes BigTIFF even where 4 GiB would do.
    pub big: bool,
}

impl Storage {
    /// Rows and columns of a chunk of cells of so many bytes.
    fn chunk(&self, grid: &Grid, cell: usize) -> (usize, usize) {
        match self.layout {
            Layout::Tiles => (TILE, TILE),
            Layout::Strips => {
                let rows = STRIP_BYTES / (grid.cols * cell).max(1);
                (rows.clamp(1, grid.rows.max(1)), grid.cols)
            }
        }
    }

    fn pack(&self, bytes: Vec<u8>, predictor: u16) -> Vec<u8> {
        match self.compression {
            Compression::None => bytes,
            Compression::Lzw => codec::lzw(&bytes),
            Compression::Deflate if self.level == 1 && predictor == 2 => codec::deflate_differences(&bytes),
            Compression::Deflate => codec::deflate(&bytes, self.level),
        }
    }
}

/// Writes a heightfield as GeoTIFF with its georeference, and as BigTIFF where 4 GiB may not do.
///
/// Integers are rounded to the nearest, halves away from zero. Voids become the nodata value.
///
/// # Errors
/// [`Error::EmptyInput`]; [`Error::Invalid`] for a height that the sample type cannot hold or that equals the
/// nodata value; [`Error::NonFinite`]; [`Error::Io`] with `name` from the stream; [`Error::Cancelled`].
pub fn write(
    terrain: &Heightfield,
    options: &Options,
    out: &mut (impl Write + Seek),
    name: &str,
    job: &Job,
) -> Result<()> {
    refuse_empty(terrain, "terrain")?;
    let mut writer = heights(terrain.grid(), options, out, name)?;
    writer.take(terrain.cells(), job)?;
    writer.finish(job)?;
    Ok(())
}

/// Begins a file of heights on `grid`, as [`write()`] writes it; rows are given to [`Writer::take`].
///
/// # Errors
/// [`Error::Invalid`] for options that do not go together, [`Error::EmptyInput`], [`Error::Io`].
pub fn heights<W: Write + Seek>(
    grid: &Grid,
    options: &Options,
    out: W,
    name: &str,
) -> Result<Writer<W, Heights>> {
    options.check()?;
    Writer::begin(grid, Heights(*options), options.storage(), out, name)
}

/// A file under way, which takes its rows from the first to the last.
pub struct Writer<W, C: Cells> {
    out: W,
    name: String,
    image: Image<C>,
    directory: Directory,
    /// Bytes written.
    position: u64,
    offsets: Vec<u64>,
    counts: Vec<u64>,
    /// Rows in chunks that are written.
    written: usize,
    /// The rows after them, too few for a chunk.
    rest: Vec<C::Cell>,
}

/// What a file holds, and how.
struct Image<C> {
    grid: Grid,
    cells: C,
    storage: Storage,
    /// Rows and columns of a chunk.
    chunk: (usize, usize),
}

impl<W: Write + Seek, C: Cells> Writer<W, C> {
    /// Begins a file of such cells on `grid`.
    ///
    /// # Errors
    /// [`Error::EmptyInput`]; [`Error::Io`] with `name` from the stream.
    pub fn begin(grid: &Grid, cells: C, storage: Storage, out: W, name: &str) -> Result<Self> {
        if grid.is_empty() {
            return Err(Error::EmptyInput { what: C::NAME.into() });
        }
        let (rows, cols) = storage.chunk(grid, cells.size());
        let chunks = grid.rows.div_ceil(rows) * grid.cols.div_ceil(cols);
        let raw = chunks as u64 * (rows * cols * cells.size() + 16) as u64;
        let mut writer = Self {
            out,
            name: name.to_owned(),
            image: Image { grid: grid.clone(), cells, storage, chunk: (rows, cols) },
            directory: Directory::new(storage.big || raw > CLASSIC_LIMIT),
            position: 0,
            offsets: Vec::new(),
            counts: Vec::new(),
            written: 0,
            rest: Vec::new(),
        };
        writer.put(&writer.directory.header(0))?;
        Ok(writer)
    }

    /// Takes the rows that follow those taken before.
    ///
    /// # Errors
    /// As [`write()`]; [`Error::Invalid`] for other than whole rows of the grid.
    pub fn take(&mut self, cells: &[C::Cell], job: &Job) -> Result<()> {
        let cols = self.image.grid.cols;
        let rest = std::mem::take(&mut self.rest);
        let lines: Vec<&[C::Cell]> = rest.chunks(cols).chain(cells.chunks(cols)).collect();
        let taken = self.written + lines.len();
        if !cells.len().is_multiple_of(cols) || taken > self.image.grid.rows {
            return Err(Error::invalid("these are not the rows that the file needs", "report it"));
        }
        let whole = if taken == self.image.grid.rows {
            lines.len()
        } else {
            lines.len() / self.image.chunk.0 * self.image.chunk.0
        };
        let (lines, left) = lines.split_at(whole);
        self.write_chunks(lines, job)?;
        self.rest = left.concat();
        Ok(())
    }

    /// Writes rows that fill chunks, or end with the last one.
    fn write_chunks(&mut self, lines: &[&[C::Cell]], job: &Job) -> Result<()> {
        let across = self.image.grid.cols.div_ceil(self.image.chunk.1);
        let chunks: Vec<usize> = (0..lines.len().div_ceil(self.image.chunk.0) * across).collect();
        let done = job.stage(chunks.len() as u64);
        for batch in chunks.chunks(BATCH * rayon::current_num_threads()) {
            let (image, written) = (&self.image, self.written);
            let pack = |&index: &usize| {
                job.check()?;
                let bytes = image.packed(lines, written, (index / across, index % across))?;
                done.advance(1);
                Ok(bytes)
            };
            for bytes in batch.par_iter().map(pack).collect::<Result<Vec<_>>>()? {
                self.offsets.push(self.position);
                self.counts.push(bytes.len() as u64);
                self.put(&bytes)?;
            }
        }
        self.written += lines.len();
        Ok(())
    }

    /// Ends the file after the last row.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] when rows are missing.
    pub fn finish(mut self, job: &Job) -> Result<W> {
        if self.written < self.image.grid.rows {
            return Err(Error::invalid("rows that the file needs are missing", "report it"));
        }
        if self.position % 2 == 1 {
            self.put(&[0])?;
        }
        let mut directory = std::mem::replace(&mut self.directory, Directory::new(false));
        let what = self.image.cells.described();
        directory.describe(
            &self.image.grid,
            &what,
            &self.image.storage,
            self.image.chunk,
            (&self.offsets, &self.counts),
            job,
        );
        let position = self.position;
        self.put(&directory.bytes(position))?;
        let failed = |reason: std::io::Error| Error::writing(&self.name, reason);
        self.out.seek(SeekFrom::Start(0)).map_err(failed)?;
        self.out.write_all(&directory.header(position)).map_err(failed)?;
        self.out.seek(SeekFrom::End(0)).map_err(failed)?;
        Ok(self.out)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.out.write_all(bytes).map_err(|reason| Error::writing(&self.name, reason))?;
        self.position += bytes.len() as u64;
        Ok(())
    }
}

impl<C: Cells> Image<C> {
    /// The packed bytes of the chunk at (`down`, `across`) of `lines`, the first of which is row `first`.
    fn packed(&self, lines: &[&[C::Cell]], first: usize, (down, across): (usize, usize)) -> Result<Vec<u8>> {
        let (rows, cols) = self.chunk;
        let (row0, col0) = (down * rows, across * cols);
        let width = cols.min(self.grid.cols - col0);
        let lines = &lines[row0..(row0 + rows).min(lines.len())];
        let whole = rows * cols * self.cells.size();
        let mut bytes = Vec::with_capacity(whole);
        let predict = self.storage.compression != Compression::None;
        let parts = lines.iter().map(|line| &line[col0..][..width]);
        self.cells.bytes(parts, cols, predict, &mut bytes).map_err(|(row, col)| {
            let cell = lines[row][col0 + col];
            self.cells.refusal(cell, first + row0 + row, col0 + col)
        })?;
        // Tiles are stored whole; below the last row they repeat nothing and cost almost nothing.
        if self.storage.layout == Layout::Tiles {
            bytes.resize(whole, 0);
        }
        Ok(self.storage.pack(bytes, self.cells.described().predictor))
    }
}
