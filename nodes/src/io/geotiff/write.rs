//! Writing: the order of the parts, and the bytes of a strip or tile.

use std::io::{Seek, SeekFrom, Write};

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    codec,
    directory::Directory,
    sample::{self, Bits},
};

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
/// Chunks packed before the next are begun; bounds the memory for packed bytes.
const BATCH: usize = 64;
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
    fn limits(self) -> (f64, f64) {
        match self {
            Self::Float32 | Self::Float64 => (f64::from(f32::MIN), f64::from(f32::MAX)),
            Self::Int32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::Int16 => (-32768.0, 32767.0),
            Self::Uint16 => (0.0, 65535.0),
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::Float32 | Self::Float64)
    }

    fn name(self) -> &'static str {
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

    /// Rows and columns of a chunk.
    fn chunk(&self, grid: &Grid) -> (usize, usize) {
        match self.layout {
            Layout::Tiles => (TILE, TILE),
            Layout::Strips => {
                let rows = STRIP_BYTES / (grid.cols * self.sample.size()).max(1);
                (rows.clamp(1, grid.rows.max(1)), grid.cols)
            }
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
    options.check()?;
    let grid = terrain.grid();
    crate::io::file::refuse_empty(terrain, "terrain")?;
    let failed = |reason: std::io::Error| Error::writing(name, reason);
    let (rows, cols) = options.chunk(grid);
    let (down, across) = (grid.rows.div_ceil(rows), grid.cols.div_ceil(cols));
    let raw = (down * across) as u64 * (rows * cols * options.sample.size() + 16) as u64;
    let big = options.big || raw > CLASSIC_LIMIT;
    let mut directory = Directory::new(big);
    out.write_all(&directory.header(0)).map_err(failed)?;
    let mut position = directory.header(0).len() as u64;
    let (mut offsets, mut counts) = (Vec::new(), Vec::new());
    let done = job.stage((down * across) as u64);
    for batch in (0..down * across).collect::<Vec<_>>().chunks(BATCH) {
        let pack = |&index: &usize| {
            job.check()?;
            let bytes = encode_chunk(terrain, options, (rows, cols), (index / across, index % across))?;
            done.advance(1);
            Ok(bytes)
        };
        for bytes in batch.par_iter().map(pack).collect::<Result<Vec<_>>>()? {
            out.write_all(&bytes).map_err(failed)?;
            offsets.push(position);
            counts.push(bytes.len() as u64);
            position += bytes.len() as u64;
        }
    }
    if position % 2 == 1 {
        out.write_all(&[0]).map_err(failed)?;
        position += 1;
    }
    directory.describe(grid, options, (rows, cols), (&offsets, &counts), job);
    out.write_all(&directory.bytes(position)).map_err(failed)?;
    out.seek(SeekFrom::Start(0)).map_err(failed)?;
    out.write_all(&directory.header(position)).map_err(failed)?;
    out.seek(SeekFrom::End(0)).map_err(failed)?;
    Ok(())
}

/// The packed bytes of the chunk at (`down`, `across`).
fn encode_chunk(
    terrain: &Heightfield,
    options: &Options,
    (rows, cols): (usize, usize),
    (down, across): (usize, usize),
) -> Result<Vec<u8>> {
    let (row0, col0) = (down * rows, across * cols);
    let last_row = (row0 + rows).min(terrain.rows());
    let width = cols.min(terrain.cols() - col0);
    let mut bytes = Vec::with_capacity(rows * cols * options.sample.size());
    let lines = (row0..last_row).map(|row| (row, &terrain.row(row)[col0..][..width]));
    let fault = |(row, col): (usize, usize)| refusal(terrain, options, row, col0 + col);
    match options.sample {
        SampleType::Float32 => floats(lines, cols, options, |height| height.to_bits(), &mut bytes),
        SampleType::Float64 => floats(lines, cols, options, |height| f64::from(height).to_bits(), &mut bytes),
        SampleType::Int16 | SampleType::Uint16 => {
            integers(lines, cols, options, |whole| whole as u16, &mut bytes)
        }
        SampleType::Int32 => integers(lines, cols, options, |whole| whole as u32, &mut bytes),
    }
    .map_err(fault)?;
    // Tiles are stored whole; below the last row they repeat nothing and cost almost nothing.
    if options.layout == Layout::Tiles {
        bytes.resize(rows * cols * options.sample.size(), 0);
    }
    Ok(match options.compression {
        Compression::None => bytes,
        Compression::Lzw => codec::lzw(&bytes),
        Compression::Deflate => codec::deflate(&bytes, options.level),
    })
}

/// Appends rows of floating-point samples; the row and column of one that cannot be written otherwise.
fn floats<'a, B: Bits>(
    lines: impl Iterator<Item = (usize, &'a [f32])>,
    cols: usize,
    options: &Options,
    bits: impl Fn(f32) -> B,
    bytes: &mut Vec<u8>,
) -> Result<(), (usize, usize)> {
    let nodata = options.nodata as f32;
    let mut samples = vec![bits(nodata); cols];
    for (row, heights) in lines {
        for (col, (out, &height)) in samples.iter_mut().zip(heights).enumerate() {
            if height == nodata || height.is_infinite() {
                return Err((row, col));
            }
            *out = bits(if height.is_nan() { nodata } else { height });
        }
        append(&samples, options, sample::sort_bytes, bytes);
    }
    Ok(())
}

/// Appends rows of whole samples; the row and column of one that cannot be written otherwise.
fn integers<'a, B: Bits>(
    lines: impl Iterator<Item = (usize, &'a [f32])>,
    cols: usize,
    options: &Options,
    bits: impl Fn(i64) -> B,
    bytes: &mut Vec<u8>,
) -> Result<(), (usize, usize)> {
    let (low, high) = options.sample.limits();
    let (low, high, nodata) = (low as i64, high as i64, options.nodata as i64);
    let mut samples = vec![bits(nodata); cols];
    for (row, heights) in lines {
        for (col, (out, &height)) in samples.iter_mut().zip(heights).enumerate() {
            // f64 holds the sum exactly, so halves are told from what lies just below them.
            let whole = (f64::from(height) + 0.5_f64.copysign(f64::from(height))) as i64;
            let known = !height.is_nan();
            if known && (whole < low || whole > high || whole == nodata) {
                return Err((row, col));
            }
            *out = bits(if known { whole } else { nodata });
        }
        append(&samples, options, sample::differences, bytes);
    }
    Ok(())
}

/// Appends a row, by its predictor where bytes are packed.
fn append<B: Bits>(
    samples: &[B],
    options: &Options,
    predict: impl Fn(&[B], &mut Vec<u8>),
    bytes: &mut Vec<u8>,
) {
    if options.compression == Compression::None {
        samples.iter().for_each(|sample| sample.add_to(bytes));
    } else {
        predict(samples, bytes);
    }
}

/// Why the height at (`row`, `col`) cannot be written.
fn refusal(terrain: &Heightfield, options: &Options, row: usize, col: usize) -> Error {
    let height = terrain.at(row, col);
    if height.is_infinite() {
        return Error::NonFinite { what: "terrain".into(), row, col };
    }
    let place = format!("height {height} m at row {row}, column {col}");
    if f64::from(height).round() == options.stored_nodata() || f64::from(height) == options.stored_nodata() {
        return Error::invalid(
            format!("{place} equals the nodata value"),
            "choose a `nodata` that no cell has",
        );
    }
    Error::invalid(
        format!("{place} does not fit {}", options.sample.name()),
        "write float32, or remap the heights first",
    )
}
