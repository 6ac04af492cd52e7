//! The cells of a file being written: what they are to its readers, and their bytes.

use orograph_core::prelude::*;
use pulp::{Arch, NullaryFnOnce};

use super::{
    sample::{self, Bits},
    write::{Options, SampleType},
};
use crate::io::whole::nearest;

/// What the tags of a file say of its cells.
pub struct Described {
    /// Bits of each of a cell's samples.
    pub(super) bits: Vec<u16>,
    /// 1 for a grey scale from black, 2 for red, green and blue.
    pub(super) photometric: u16,
    /// 1 for unsigned, 2 for signed integers, 3 for floating point.
    pub(super) format: u16,
    /// 2 for differences, 3 for sorted bytes.
    pub(super) predictor: u16,
    /// The fourth sample is alpha, by which the others are not multiplied.
    pub(super) alpha: bool,
    /// What a cell without value holds.
    pub(super) nodata: Option<f64>,
}

/// Cells of a kind, on their way into a file.
pub trait Cells: Sync {
    /// One cell.
    type Cell: Copy + Send + Sync;
    /// What errors call the raster.
    const NAME: &'static str;
    /// Bytes of a cell in the file.
    fn size(&self) -> usize;
    /// What the tags say.
    fn described(&self) -> Described;
    /// Appends rows of at most `cols` cells as rows of just so many, by their predictor where `predict` says so; the row
    /// and column of a cell that cannot be written otherwise.
    ///
    /// # Errors
    /// That cell's row and column.
    fn bytes<'a>(
        &self,
        rows: impl Iterator<Item = &'a [Self::Cell]>,
        cols: usize,
        predict: bool,
        bytes: &mut Vec<u8>,
    ) -> Result<(), (usize, usize)>
    where
        Self::Cell: 'a;
    /// Why the cell at (`row`, `col`) cannot be written.
    fn refusal(&self, cell: Self::Cell, row: usize, col: usize) -> Error;
}

/// Heights, stored as the options say.
pub struct Heights(pub(super) Options);

impl Cells for Heights {
    type Cell = f32;
    const NAME: &'static str = "terrain";

    fn size(&self) -> usize {
        self.0.sample.size()
    }

    fn described(&self) -> Described {
        let (format, predictor) = match self.0.sample {
            SampleType::Uint16 => (1, 2),
            SampleType::Int16 | SampleType::Int32 => (2, 2),
            SampleType::Float32 | SampleType::Float64 => (3, 3),
        };
        let bits = vec![self.0.sample.size() as u16 * 8];
        let nodata = Some(self.0.stored_nodata());
        Described { bits, photometric: 1, format, predictor, alpha: false, nodata }
    }

    fn bytes<'a>(
        &self,
        rows: impl Iterator<Item = &'a [f32]>,
        cols: usize,
        predict: bool,
        bytes: &mut Vec<u8>,
    ) -> Result<(), (usize, usize)> {
        let (rows, options) = (rows.enumerate(), Row { options: &self.0, cols, predict });
        match self.0.sample {
            SampleType::Float32 => floats(rows, &options, |height| height.to_bits(), bytes),
            SampleType::Float64 => floats(rows, &options, |height| f64::from(height).to_bits(), bytes),
            SampleType::Int16 | SampleType::Uint16 => integers(rows, &options, |whole| whole as u16, bytes),
            SampleType::Int32 => integers(rows, &options, |whole| whole as u32, bytes),
        }
    }

    fn refusal(&self, height: f32, row: usize, col: usize) -> Error {
        let options = &self.0;
        if height.is_infinite() {
            return Error::NonFinite { what: Self::NAME.into(), row, col };
        }
        let place = format!("height {height} m at row {row}, column {col}");
        if f64::from(height).round() == options.stored_nodata()
            || f64::from(height) == options.stored_nodata()
        {
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
}

/// Colours, red, green and blue of 8 bits each, with alpha where that is wanted.
pub struct Colours {
    /// Whether alpha is stored.
    pub alpha: bool,
}

impl Cells for Colours {
    type Cell = [u8; 4];
    const NAME: &'static str = "texture";

    fn size(&self) -> usize {
        if self.alpha { 4 } else { 3 }
    }

    fn described(&self) -> Described {
        let bits = vec![8; self.size()];
        Described { bits, photometric: 2, format: 1, predictor: 2, alpha: self.alpha, nodata: None }
    }

    fn bytes<'a>(
        &self,
        rows: impl Iterator<Item = &'a [[u8; 4]]>,
        cols: usize,
        predict: bool,
        bytes: &mut Vec<u8>,
    ) -> Result<(), (usize, usize)> {
        let samples = self.size();
        for row in rows {
            let end = bytes.len() + cols * samples;
            let mut before = [0; 4];
            for &colour in row {
                let stored = |sample: usize| match predict {
                    true => colour[sample].wrapping_sub(before[sample]),
                    false => colour[sample],
                };
                bytes.extend((0..samples).map(stored));
                before = colour;
            }
            bytes.resize(end, 0);
        }
        Ok(())
    }

    fn refusal(&self, _: [u8; 4], row: usize, col: usize) -> Error {
        Error::invalid(format!("the colour at row {row}, column {col} cannot be written"), "report it")
    }
}

/// How a row is stored.
struct Row<'a> {
    options: &'a Options,
    cols: usize,
    predict: bool,
}

/// Appends rows of floating-point samples; the row and column of one that cannot be written otherwise.
fn floats<'a, B: Bits>(
    lines: impl Iterator<Item = (usize, &'a [f32])>,
    to: &Row<'_>,
    bits: impl Fn(f32) -> B,
    bytes: &mut Vec<u8>,
) -> Result<(), (usize, usize)> {
    let nodata = to.options.nodata as f32;
    let refused = |height: f32| (height == nodata) | height.is_infinite();
    let mut samples = vec![bits(nodata); to.cols];
    for (row, heights) in lines {
        let mut stray = false;
        for (out, &height) in samples.iter_mut().zip(heights) {
            stray |= refused(height);
            *out = bits(if height.is_nan() { nodata } else { height });
        }
        let stray = if stray { heights.iter().position(|&height| refused(height)) } else { None };
        if let Some(col) = stray {
            return Err((row, col));
        }
        // Beyond the raster; what the row before left there is its bytes, no samples.
        samples[heights.len()..].fill(bits(nodata));
        if to.predict {
            sample::sort_bytes(&samples, bytes);
        } else {
            sample::plain(&mut samples, bytes);
        }
    }
    Ok(())
}

/// Appends rows of whole samples; the row and column of one that cannot be written otherwise.
fn integers<'a, B: Bits>(
    lines: impl Iterator<Item = (usize, &'a [f32])>,
    to: &Row<'_>,
    bits: impl Fn(i32) -> B + Copy,
    bytes: &mut Vec<u8>,
) -> Result<(), (usize, usize)> {
    let (low, high) = to.options.sample.limits();
    let (low, high, nodata) = (low as i32, high as i32, to.options.nodata as i32);
    let stored = |height: f32| {
        let (whole, fits) = nearest(height, low, high);
        let known = !height.is_nan();
        (if known { whole } else { nodata }, !known | (fits & (whole != nodata)))
    };
    let arch = Arch::new();
    let mut samples = vec![bits(nodata); to.cols];
    for (row, heights) in lines {
        if !arch.dispatch(Stored { heights, stored, bits, samples: &mut samples }) {
            let stray = heights.iter().position(|&height| !stored(height).1);
            return Err((row, stray.unwrap_or_default()));
        }
        // Beyond the raster; what the row before left there is differences.
        samples[heights.len()..].fill(bits(nodata));
        if to.predict {
            sample::difference(&mut samples);
        }
        sample::plain(&mut samples, bytes);
    }
    Ok(())
}

/// Heights on their way to being samples: `stored` tells the whole number of one and whether it may stand for it.
struct Stored<'a, B, F, G> {
    heights: &'a [f32],
    stored: F,
    bits: G,
    samples: &'a mut [B],
}

impl<B, F: Fn(f32) -> (i32, bool), G: Fn(i32) -> B> NullaryFnOnce for Stored<'_, B, F, G> {
    type Output = bool;

    /// Whether all may. All are made before any is judged: a way out of the loop would keep it from taking many at once.
    #[inline(always)]
    fn call(self) -> bool {
        let mut fit = true;
        for (out, &height) in self.samples.iter_mut().zip(self.heights) {
            let (whole, fits) = (self.stored)(height);
            *out = (self.bits)(whole);
            fit &= fits;
        }
        fit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_raster_every_row_of_a_tile_holds_nodata() {
        let options = Options { sample: SampleType::Int16, nodata: -9999.0, ..Options::default() };
        let rows = [[1.0, 2.0, 30.0], [4.0, f32::NAN, 6.0], [7.0, 8.0, 9.0]];
        let mut bytes = Vec::new();
        Heights(options).bytes(rows.iter().map(|row| &row[..]), 6, true, &mut bytes).unwrap();
        for (row, bytes) in rows.iter().zip(bytes.chunks(12)) {
            let mut sum = 0_i16;
            let stored: Vec<i16> = bytes
                .as_chunks::<2>()
                .0
                .iter()
                .map(|&step| {
                    sum = sum.wrapping_add(i16::from_le_bytes(step));
                    sum
                })
                .collect();
            let wanted = row.map(|height| if height.is_nan() { -9999 } else { height as i16 });
            assert_eq!(stored[..3], wanted);
            assert_eq!(stored[3..], [-9999; 3]);
        }
    }
}
