//! Reading, all at once or a few rows at a time.

use std::fs::File;

use orograph_core::{Wire, prelude::*};
use rayon::prelude::*;

use super::{
    bytes::Bytes,
    codec::Packing,
    geokeys::{Placed, place},
    ifd::Ifd,
    sample::{Encoding, Row},
    tag,
};
use crate::io::file::refuse_infinite;

/// The strips or tiles of the image, and how to unpack them.
struct Layout<'a> {
    ifd: Ifd<'a>,
    name: String,
    rows: usize,
    cols: usize,
    /// Rows and columns of a chunk; a strip is as wide as the image.
    chunk: (usize, usize),
    /// Chunks side by side.
    across: usize,
    packing: Packing,
    row: Row,
    offsets: Vec<u64>,
    byte_counts: Vec<u64>,
    /// Whether edge chunks are stored whole, as tiles are.
    padded: bool,
}

/// The heights in a GeoTIFF, in metres, on its grid; `name` names the file in errors.
///
/// The first band of the first image is read; cells that hold the nodata value become voids. Heights in feet,
/// and stored values with a scale and an offset, become metres.
///
/// # Errors
/// [`Error::Format`] for what is no TIFF, is cut short, corrupt or of an unsupported kind (which it names),
/// [`Error::NonFinite`] for an infinite height, [`Error::TooLarge`], [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    let (layout, grid) = Layout::open(Bytes::Memory(bytes), name, job)?;
    let mut terrain = Heightfield::zeroed(grid, job)?;
    let cols = layout.cols;
    let bands = terrain.rows().div_ceil(layout.chunk.0);
    let done = job.stage(bands as u64);
    terrain.cells_mut().par_chunks_mut(layout.chunk.0.saturating_mul(cols)).enumerate().try_for_each_init(
        Vec::new,
        |scratch, (band, out)| {
            layout.read_band(band, out, scratch, job)?;
            done.advance(1);
            Ok(())
        },
    )?;
    if layout.row.may_be_infinite() {
        refuse_infinite(&terrain, name)?;
    }
    Ok(terrain)
}

/// The heights in a GeoTIFF file that is read a few rows at a time.
pub struct GeotiffSource {
    layout: Layout<'static>,
    grid: Grid,
}

/// Bytes of the rows of strips or tiles side by side beyond which a file is better read as a whole.
const LARGEST_STEP: usize = 256 << 20;

impl GeotiffSource {
    /// The heights in `file`, known to the user as `shown`; `name` names it in other errors. `None` for a file whose rows
    /// come too many at a time.
    ///
    /// # Errors
    /// As [`read`], as far as the header tells.
    pub fn open(file: File, shown: &str, name: &str, job: &Job) -> Result<Option<Self>> {
        let (layout, grid) = Layout::open(Bytes::of_file(file, shown)?, name, job)?;
        let step = layout.chunk.0.saturating_mul(layout.cols).saturating_mul(layout.row.encoding.size());
        Ok((step <= LARGEST_STEP).then_some(Self { layout, grid }))
    }

    /// The same heights with other cells.
    #[must_use]
    pub fn with_grid(self, grid: Grid) -> Self {
        Self { grid, ..self }
    }
}

impl BandSource for GeotiffSource {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn step(&self) -> usize {
        self.layout.chunk.0
    }

    fn band(&self, first: usize, rows: usize, job: &Job) -> Result<Value> {
        let (layout, cols, step) = (&self.layout, self.layout.cols, self.layout.chunk.0);
        let mut band = Heightfield::zeroed(self.grid.crop(first, 0, rows, cols)?, job)?;
        // Rows of the band that lie in one row of strips or tiles are filled together.
        let lead = (first.next_multiple_of(step) - first).min(rows);
        let (head, rest) = band.cells_mut().split_at_mut(lead * cols);
        let parts = head.par_chunks_mut((lead * cols).max(1)).chain(rest.par_chunks_mut(step * cols));
        parts.enumerate().try_for_each_init(
            Default::default,
            |scratch: &mut (Vec<f32>, Vec<u8>), (part, out)| {
                let row = if part == 0 || lead == 0 {
                    first + part * step
                } else {
                    first + lead + (part - 1) * step
                };
                let (index, skip) = (row / step, row % step);
                let stored = step.min(layout.rows - index * step);
                if (skip, out.len()) == (0, stored * cols) {
                    return layout.read_band(index, out, &mut scratch.1, job);
                }
                scratch.0.resize(stored * cols, 0.0);
                layout.read_band(index, &mut scratch.0, &mut scratch.1, job)?;
                out.copy_from_slice(&scratch.0[skip * cols..][..out.len()]);
                Ok(())
            },
        )?;
        if layout.row.may_be_infinite() {
            refuse_infinite(&band, &layout.name).map_err(|error| match error {
                Error::NonFinite { what, row, col } => Error::NonFinite { what, row: row + first, col },
                other => other,
            })?;
        }
        Ok(band.into_value())
    }
}

impl<'a> Layout<'a> {
    /// The cells that a file holds, and where they lie.
    fn open(bytes: Bytes<'a>, name: &str, job: &Job) -> Result<(Self, Grid)> {
        let mut layout = Self::parse(bytes, name, job)?;
        let Placed { grid, height_unit } = place(&layout.ifd, name, (layout.rows, layout.cols), job)?;
        layout.apply_unit(height_unit, job)?;
        Ok((layout, grid))
    }

    fn parse(bytes: Bytes<'a>, name: &str, job: &Job) -> Result<Self> {
        let ifd = Ifd::parse(bytes, name)?;
        let fail = |reason: String| Error::format(name, reason);
        let need = |tag, what: &str| {
            let missing = || Error::format(name, format!("the {what} is missing"));
            ifd.integer(tag)?.ok_or_else(missing)
        };
        let (rows, cols) = (need(tag::IMAGE_LENGTH, "image length")?, need(tag::IMAGE_WIDTH, "image width")?);
        // Refuses what no raster may be before anything is made of the numbers.
        let size = (usize::try_from(rows).unwrap_or(usize::MAX), usize::try_from(cols).unwrap_or(usize::MAX));
        let Grid { rows, cols, .. } = Grid::new(size.0, size.1, CellSize::square(1.0))?;
        if rows == 0 || cols == 0 {
            return Err(Error::EmptyInput { what: name.into() });
        }
        let bits = ifd.integer(tag::BITS_PER_SAMPLE)?.unwrap_or(1);
        let format = ifd.integer(tag::SAMPLE_FORMAT)?.unwrap_or(1);
        let encoding = Encoding::from_tags(format, bits).ok_or_else(|| {
            fail(format!("samples of {bits} bits with sample format {format} are not supported"))
        })?;
        let packing = Packing::from_code(ifd.integer(tag::COMPRESSION)?.unwrap_or(1))
            .map_err(|what| fail(format!("{what} compression is not supported; use deflate, LZW or none")))?;
        if ifd.integer(tag::FILL_ORDER)?.unwrap_or(1) != 1 {
            return Err(fail("reversed bit order is not supported".into()));
        }
        let bands = ifd.integer(tag::SAMPLES_PER_PIXEL)?.unwrap_or(1).max(1);
        if bands > 1 {
            job.warn(format!("{name} has {bands} bands; the first is read as heights"));
        }
        let planar = ifd.integer(tag::PLANAR_CONFIGURATION)?.unwrap_or(1) == 2;
        let bands = if planar { 1 } else { usize::try_from(bands).unwrap_or(usize::MAX) };
        let predictor = match packing {
            Packing::None => 1,
            _ => ifd.integer(tag::PREDICTOR)?.unwrap_or(1),
        };
        let float = matches!(encoding, Encoding::F32 | Encoding::F64);
        if !(1..=3).contains(&predictor) || (predictor == 3 && !float) {
            return Err(fail(format!("predictor {predictor} does not go with its samples")));
        }
        let tiles = ifd.integers(tag::TILE_OFFSETS)?;
        let padded = tiles.is_some();
        let missing = |what: &str| fail(format!("the {what} are missing"));
        let (chunk, offsets, byte_counts) = if let Some(offsets) = tiles {
            let counts = ifd.integers(tag::TILE_BYTE_COUNTS)?.ok_or_else(|| missing("tile byte counts"))?;
            ((need(tag::TILE_LENGTH, "tile length")?, need(tag::TILE_WIDTH, "tile width")?), offsets, counts)
        } else {
            let offsets = ifd.integers(tag::STRIP_OFFSETS)?.ok_or_else(|| missing("strip offsets"))?;
            let counts = ifd.integers(tag::STRIP_BYTE_COUNTS)?.ok_or_else(|| missing("strip byte counts"))?;
            let strip = ifd.integer(tag::ROWS_PER_STRIP)?.unwrap_or(u64::MAX).min(rows as u64);
            ((strip, cols as u64), offsets, counts)
        };
        let chunk_cells = chunk.0.checked_mul(chunk.1).and_then(|cells| cells.checked_mul(bands as u64));
        let bytes = chunk_cells.and_then(|cells| cells.checked_mul(encoding.size() as u64));
        let sound = |&bytes: &u64| bytes > 0 && bytes <= 1 << 40;
        bytes.filter(sound).ok_or_else(|| fail("its strips or tiles have an absurd size".into()))?;
        let chunk = (chunk.0 as usize, chunk.1 as usize);
        let across = cols.div_ceil(chunk.1);
        let chunks = across.saturating_mul(rows.div_ceil(chunk.0));
        if offsets.len() < chunks || byte_counts.len() < chunks {
            return Err(fail(format!("only {} of {chunks} strips or tiles are listed", offsets.len())));
        }
        let nodata = ifd.text(tag::GDAL_NODATA)?.and_then(|text| text.trim().parse().ok());
        let scale = ifd.text(tag::GDAL_METADATA)?.and_then(|text| scale_and_offset(&text));
        let row = Row { encoding, big_endian: ifd.big_endian, predictor, bands, nodata, scale };
        let layout = Self {
            ifd,
            name: name.to_owned(),
            rows,
            cols,
            chunk,
            across,
            packing,
            row,
            offsets,
            byte_counts,
            padded,
        };
        layout.admit(chunks)?;
        // Its bytes may be packed four thousand times smaller, and it may reach far beyond the image.
        job.admit(bytes.unwrap_or(u64::MAX), || format!("a strip or tile of {name}"))?;
        Ok(layout)
    }

    /// Refuses a file whose bytes cannot possibly unpack to the cells that its header promises.
    fn admit(&self, chunks: usize) -> Result<()> {
        let (mut most, mut sparse) = (0usize, false);
        for &count in &self.byte_counts[..chunks] {
            sparse |= count == 0;
            most = most.saturating_add(self.packing.most(usize::try_from(count).unwrap_or(usize::MAX)));
        }
        let wanted = self.rows.saturating_mul(self.cols).saturating_mul(self.row.encoding.size());
        if !sparse && most < wanted {
            return Err(Error::format(
                &self.name,
                format!("it promises {} × {} cells, but holds too few bytes", self.rows, self.cols),
            ));
        }
        Ok(())
    }

    /// Lets stored values become metres.
    fn apply_unit(&mut self, metres: f64, job: &Job) -> Result<()> {
        if metres != 1.0 {
            let (factor, offset) = self.row.scale.unwrap_or((1.0, 0.0));
            self.row.scale = Some((factor * metres, offset * metres));
            job.warn(format!("{}: heights are turned into metres ({metres} m per unit)", self.name));
        }
        Ok(())
    }

    /// Reads one row of chunks into `out`, the rows of the image that they cover; every cell is written.
    fn read_band(&self, band: usize, out: &mut [f32], scratch: &mut Vec<u8>, job: &Job) -> Result<()> {
        let rows = out.len() / self.cols;
        let stored_rows = if self.padded { self.chunk.0 } else { rows };
        let row_len = self.chunk.1 * self.row.bands * self.row.encoding.size();
        for across in 0..self.across {
            job.check()?;
            let index = band * self.across + across;
            let (offset, count) = (self.offsets[index], self.byte_counts[index]);
            let first = across * self.chunk.1;
            let last = (first + self.chunk.1).min(self.cols);
            if count == 0 {
                // A sparse file leaves out what holds nothing.
                out.chunks_exact_mut(self.cols).for_each(|row| row[first..last].fill(f32::NAN));
                continue;
            }
            let number = index + 1;
            let packed = self.ifd.slice(offset, count)?.ok_or_else(|| {
                Error::format(
                    &self.name,
                    format!("the file is truncated: strip or tile {number} is not there"),
                )
            })?;
            let len = row_len.saturating_mul(stored_rows);
            let corrupt =
                || Error::format(&self.name, format!("strip or tile {number} is corrupt or cut short"));
            if self.packing.most(packed.len()) < len {
                return Err(corrupt());
            }
            scratch.resize(len, 0);
            if !self.packing.unpack(&packed, scratch) {
                return Err(corrupt());
            }
            for (bytes, out) in scratch.chunks_exact_mut(row_len).zip(out.chunks_exact_mut(self.cols)) {
                self.row.heights(bytes, &mut out[first..last]);
            }
        }
        Ok(())
    }
}

/// Scale and offset of the first band in GDAL's metadata; `None` when they change nothing.
fn scale_and_offset(metadata: &str) -> Option<(f64, f64)> {
    let number = |role: &str| {
        let item = metadata.split("<Item").find(|item| {
            item.contains(&format!("role=\"{role}\""))
                && (item.contains("sample=\"0\"") || !item.contains("sample="))
        })?;
        item.split_once('>')?.1.split('<').next()?.trim().parse::<f64>().ok().filter(|x| x.is_finite())
    };
    let pair =
        (number("scale").filter(|&scale| scale != 0.0).unwrap_or(1.0), number("offset").unwrap_or(0.0));
    (pair != (1.0, 0.0)).then_some(pair)
}
