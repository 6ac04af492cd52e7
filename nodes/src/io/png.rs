//! PNG pictures as numbers: grey levels for heights and masks, colours for textures.
//!
//! The filter of each row is `Up` and packing is the `png` crate's fast mode: PNG of terrain is an exchange
//! format, not an archive, and a fixed filter spares trying all five on every row. docs/performance.md has the
//! speed of this pair; no other has been measured.

use std::io::{Cursor, Write};

use orograph_core::prelude::*;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Filter, Limits, Transformations};

/// A picture's pixels, `channels` samples each.
pub(crate) struct Picture {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    /// 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha.
    pub(crate) channels: usize,
    /// 8-bit samples, or 16-bit ones as big-endian pairs.
    pub(crate) samples: Vec<u8>,
    /// Whether samples have 16 bits.
    pub(crate) deep: bool,
}

impl Picture {
    /// Unpacks a picture. Palettes and fewer than 8 bits are widened.
    pub(crate) fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Self> {
        let fail = |error: png::DecodingError| Error::format(name, error);
        // Sums of what the decoder takes beside the pixels, which it does not take itself.
        let limits = Limits { bytes: usize::try_from(job.memory_limit()).unwrap_or(usize::MAX) };
        let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
        decoder.set_transformations(Transformations::EXPAND);
        // Nobody reads these, and both may be packed small to unpack large.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let (width, height) = decoder.read_header_info().map_err(fail)?.size();
        let Grid { rows, cols, .. } = Grid::new(height as usize, width as usize, CellSize::square(1.0))?;
        let mut reader = decoder.read_info().map_err(fail)?;
        // The decoder takes three bytes a colour for granted.
        if reader.info().palette.as_ref().is_some_and(|palette| !palette.len().is_multiple_of(3)) {
            return Err(Error::format(name, "its palette ends amid a colour"));
        }
        let len = reader.output_buffer_size().unwrap_or(usize::MAX);
        let packed_len = reader.info().raw_row_length().saturating_mul(rows);
        // Deflate never does better than 1032 to 1, so a header that promises more lies.
        if packed_len > bytes.len().saturating_mul(1032) {
            return Err(Error::format(
                name,
                format!("it promises {cols} × {rows} pixels, but holds too few bytes"),
            ));
        }
        job.admit(len as u64, || format!("the picture {name}"))?;
        let (color, depth) = reader.output_color_type();
        let mut samples = vec![0; len];
        if reader.info().interlaced {
            reader.next_frame(&mut samples).map_err(fail)?;
        } else {
            let row_len = reader.output_line_size(width).unwrap_or(len).max(1);
            let done = job.stage(rows as u64);
            for row in samples.chunks_exact_mut(row_len) {
                job.check()?;
                reader.read_row(row).map_err(fail)?;
                done.advance(1);
            }
        }
        Ok(Self { rows, cols, channels: color.samples(), samples, deep: depth == BitDepth::Sixteen })
    }

    /// Bytes of one sample.
    fn sample_len(&self) -> usize {
        if self.deep { 2 } else { 1 }
    }

    /// Bytes of one row.
    fn row_len(&self) -> usize {
        self.cols * self.channels * self.sample_len()
    }

    fn share(&self, sample: &[u8]) -> f64 {
        match sample {
            [high, low] => f64::from(u16::from_be_bytes([*high, *low])) / 65535.0,
            [byte] => f64::from(*byte) / 255.0,
            _ => 0.0,
        }
    }

    /// Grey levels of a row as shares of white; a transparent pixel is `None`.
    pub(crate) fn greys(&self, row: usize) -> impl Iterator<Item = Option<f64>> + '_ {
        let len = self.sample_len();
        let row = self.samples.get(row * self.row_len()..).unwrap_or_default();
        row.chunks_exact(len * self.channels).take(self.cols).map(move |pixel| {
            let channel = |i: usize| self.share(&pixel[i * len..][..len]);
            let grey = match self.channels {
                // Rec. 709 luma; equal channels give themselves.
                3 | 4 if pixel[..len] == pixel[len..2 * len] && pixel[..len] == pixel[2 * len..3 * len] => {
                    channel(0)
                }
                3 | 4 => 0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2),
                _ => channel(0),
            };
            let transparent = matches!(self.channels, 2 | 4) && channel(self.channels - 1) == 0.0;
            (!transparent).then_some(grey)
        })
    }

    /// A row of the commonest kind of height map: 16-bit grey; `None` for other kinds.
    pub(crate) fn grey16(&self, row: usize) -> Option<&[[u8; 2]]> {
        let row = self.samples.get(row * self.row_len()..)?.get(..self.row_len())?;
        (self.deep && self.channels == 1).then_some(row.as_chunks().0)
    }

    /// Colours of a row.
    pub(crate) fn colours(&self, row: usize) -> impl Iterator<Item = [u8; 4]> + '_ {
        let len = self.sample_len();
        let row = self.samples.get(row * self.row_len()..).unwrap_or_default();
        row.chunks_exact(len * self.channels).take(self.cols).map(move |pixel| {
            // The high byte of a 16-bit sample is its 8-bit value but for rounding.
            let channel = |i: usize| pixel[i * len];
            match self.channels {
                1 => [channel(0), channel(0), channel(0), 255],
                2 => [channel(0), channel(0), channel(0), channel(1)],
                3 => [channel(0), channel(1), channel(2), 255],
                _ => [channel(0), channel(1), channel(2), channel(3)],
            }
        })
    }

    /// Whether the picture has colours, alpha aside.
    pub(crate) fn is_coloured(&self) -> bool {
        self.channels >= 3 && {
            let len = self.sample_len();
            self.samples
                .chunks_exact(len * self.channels)
                .any(|pixel| pixel[..len] != pixel[len..2 * len] || pixel[..len] != pixel[2 * len..3 * len])
        }
    }
}

/// What a row of a picture being written holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pixels {
    Grey8,
    Grey16,
    Rgb,
    Rgba,
}

impl Pixels {
    fn png(self) -> (ColorType, BitDepth, usize) {
        match self {
            Self::Grey8 => (ColorType::Grayscale, BitDepth::Eight, 1),
            Self::Grey16 => (ColorType::Grayscale, BitDepth::Sixteen, 2),
            Self::Rgb => (ColorType::Rgb, BitDepth::Eight, 3),
            Self::Rgba => (ColorType::Rgba, BitDepth::Eight, 4),
        }
    }
}

/// Writes a picture; `fill` appends the bytes of a row, 16-bit samples big-endian.
pub(crate) fn write(
    out: &mut impl Write,
    grid: &Grid,
    pixels: Pixels,
    name: &str,
    job: &Job,
    mut fill: impl FnMut(usize, &mut Vec<u8>) -> Result<()>,
) -> Result<()> {
    let failed = |error: png::EncodingError| Error::writing(name, error);
    let (Ok(width), Ok(height)) = (u32::try_from(grid.cols), u32::try_from(grid.rows)) else {
        return Err(Error::invalid("a PNG picture has at most 2147483647 pixels a side", "crop the terrain"));
    };
    let (color, depth, bytes) = pixels.png();
    let len = grid.len() as u64 * bytes as u64;
    job.admit(len, || format!("the picture {name}"))?;
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(FILTER);
    let mut writer = encoder.write_header().map_err(failed)?;
    let mut samples = Vec::with_capacity(grid.len() * bytes);
    for row in 0..grid.rows {
        job.check()?;
        fill(row, &mut samples)?;
    }
    writer.write_image_data(&samples).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// Writes a picture into as few bytes as its colours allow: grey, with a palette, or with the best filter of each row.
pub(crate) fn write_small(out: &mut impl Write, texture: &Texture, name: &str, job: &Job) -> Result<()> {
    let failed = |error: png::EncodingError| Error::writing(name, error);
    let grid = texture.grid();
    let (Ok(width), Ok(height)) = (u32::try_from(grid.cols), u32::try_from(grid.rows)) else {
        return Err(Error::invalid("a PNG picture has at most 2147483647 pixels a side", "crop the terrain"));
    };
    job.admit(grid.len() as u64 * 4, || format!("the picture {name}"))?;
    let cells = texture.cells();
    let is_opaque = cells.iter().all(|colour| colour[3] == 255);
    let is_grey = is_opaque && cells.iter().all(|colour| colour[0] == colour[1] && colour[0] == colour[2]);
    let palette = if is_grey { None } else { palette(cells) };
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_filter(Filter::Adaptive);
    let mut samples: Vec<u8> = Vec::with_capacity(grid.len());
    if is_grey {
        encoder.set_color(ColorType::Grayscale);
        samples.extend(cells.iter().map(|colour| colour[0]));
    } else if let Some(palette) = palette {
        encoder.set_color(ColorType::Indexed);
        // Neighbouring numbers of a palette are no neighbouring colours.
        encoder.set_filter(Filter::NoFilter);
        encoder.set_palette(
            palette.iter().flat_map(|colour| [colour[0], colour[1], colour[2]]).collect::<Vec<_>>(),
        );
        if !is_opaque {
            encoder.set_trns(palette.iter().map(|colour| colour[3]).collect::<Vec<_>>());
        }
        samples.extend(cells.iter().map(|colour| palette.binary_search(colour).unwrap_or(0) as u8));
    } else if is_opaque {
        encoder.set_color(ColorType::Rgb);
        samples.extend(cells.iter().flat_map(|colour| [colour[0], colour[1], colour[2]]));
    } else {
        encoder.set_color(ColorType::Rgba);
        samples.extend_from_slice(cells.as_flattened());
    }
    job.check()?;
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&samples).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// The colours of a picture in order, if a palette can hold them.
fn palette(cells: &[[u8; 4]]) -> Option<Vec<[u8; 4]>> {
    let mut colours: Vec<[u8; 4]> = Vec::new();
    let mut last = None;
    for colour in cells {
        if last == Some(colour) {
            continue;
        }
        last = Some(colour);
        if let Err(place) = colours.binary_search(colour) {
            if colours.len() == 256 {
                return None;
            }
            colours.insert(place, *colour);
        }
    }
    Some(colours)
}

/// See the module's docs.
const FILTER: Filter = Filter::Up;
