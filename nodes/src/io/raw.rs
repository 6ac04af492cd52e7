//! Headerless heights: 16-bit integers between two levels, or 32-bit floats in metres, row by row.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::file::refuse_infinite;

/// How a height is stored.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawFormat {
    /// 16 bits, low byte first: `.r16`, and `.raw` for Unity on Windows.
    R16Little,
    /// 16 bits, high byte first: `.raw` for Unity on old Macs.
    R16Big,
    /// 32-bit floating point in metres, low byte first: `.r32`.
    R32,
}

impl RawFormat {
    fn size(self) -> usize {
        if self == Self::R32 { 4 } else { 2 }
    }
}

/// What a headerless file does not say of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawLayout {
    /// How a height is stored.
    pub format: RawFormat,
    /// Heights in metres of the lowest and the highest 16-bit level.
    pub range: (f64, f64),
    /// Whether the first row is the southern one.
    pub south_first: bool,
}

/// Rows and columns of a file of `bytes` bytes; a side of 0 is inferred.
///
/// # Errors
/// [`Error::Invalid`] when the sides do not give that length, or no square does and neither side is known.
pub fn size(bytes: usize, format: RawFormat, rows: usize, cols: usize, name: &str) -> Result<(usize, usize)> {
    let cells = bytes / format.size();
    let found = match (rows, cols) {
        (0, 0) => {
            let side = cells.isqrt();
            (side, side)
        }
        (0, cols) => (cells / cols, cols),
        (rows, 0) => (rows, cells / rows),
        both => both,
    };
    let fits = found.0.checked_mul(found.1).and_then(|cells| cells.checked_mul(format.size())) == Some(bytes);
    if fits && bytes > 0 {
        return Ok(found);
    }
    let width = format.size();
    if (rows, cols) == (0, 0) {
        return Err(Error::invalid(
            format!("{name} has {bytes} bytes, which no square of {width}-byte heights fills"),
            "set `cols` (and check `format`)",
        ));
    }
    Err(Error::invalid(
        format!(
            "{name} has {bytes} bytes, but {} × {} heights of {width} bytes do not fill them",
            found.0, found.1
        ),
        "correct `rows`, `cols` or `format`",
    ))
}

/// The heights in a headerless file. NaN in a float file is a void; 16-bit files have none.
///
/// # Errors
/// As [`size`]; [`Error::NonFinite`]; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, grid: Grid, layout: &RawLayout, job: &Job) -> Result<Heightfield> {
    let (rows, cols) = size(bytes.len(), layout.format, grid.rows, grid.cols, name)?;
    let row_len = cols * layout.format.size();
    let (lowest, step) = (layout.range.0, (layout.range.1 - layout.range.0) / 65535.0);
    let height = |level: u16| (lowest + f64::from(level) * step) as f32;
    let terrain = Heightfield::build(grid, job, |row, out| {
        let row = if layout.south_first { rows - 1 - row } else { row };
        let bytes = &bytes[row * row_len..][..row_len];
        let pairs = bytes.as_chunks::<2>().0;
        match layout.format {
            RawFormat::R16Little => {
                out.iter_mut().zip(pairs).for_each(|(out, &pair)| *out = height(u16::from_le_bytes(pair)));
            }
            RawFormat::R16Big => {
                out.iter_mut().zip(pairs).for_each(|(out, &pair)| *out = height(u16::from_be_bytes(pair)));
            }
            RawFormat::R32 => {
                let quads = bytes.as_chunks::<4>().0;
                out.iter_mut().zip(quads).for_each(|(out, &quad)| *out = f32::from_le_bytes(quad));
            }
        }
        Ok(())
    })?;
    refuse_infinite(&terrain, name)?;
    Ok(terrain)
}

/// The bytes of a headerless file. A void becomes level 0 in a 16-bit file and stays NaN in a float one;
/// heights outside the range are clipped, so callers check it first.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn write(terrain: &Heightfield, layout: &RawLayout, job: &Job) -> Result<Vec<u8>> {
    let (rows, cols) = terrain.grid().size();
    let row_len = cols * layout.format.size();
    job.admit((row_len * rows) as u64, || "the file".into())?;
    let mut bytes = vec![0; row_len * rows];
    if row_len == 0 {
        return Ok(bytes);
    }
    let (lowest, scale) = (layout.range.0, 65535.0 / (layout.range.1 - layout.range.0));
    // A cast takes NaN to 0 and clips what rounding pushed over an edge.
    let level = |height: f32| ((f64::from(height) - lowest) * scale + 0.5) as u16;
    bytes.par_chunks_mut(row_len).enumerate().try_for_each(|(row, out)| {
        job.check()?;
        let heights = terrain.row(if layout.south_first { rows - 1 - row } else { row });
        match layout.format {
            RawFormat::R16Little => out
                .as_chunks_mut::<2>()
                .0
                .iter_mut()
                .zip(heights)
                .for_each(|(out, &height)| *out = level(height).to_le_bytes()),
            RawFormat::R16Big => out
                .as_chunks_mut::<2>()
                .0
                .iter_mut()
                .zip(heights)
                .for_each(|(out, &height)| *out = level(height).to_be_bytes()),
            RawFormat::R32 => out
                .as_chunks_mut::<4>()
                .0
                .iter_mut()
                .zip(heights)
                .for_each(|(out, &height)| *out = height.to_le_bytes()),
        }
        Ok(())
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn heights_round_trip_in_every_format() {
        let terrain = field(3, 5, |row, col| (row * 5 + col) as f64 * 100.0);
        for format in [RawFormat::R16Little, RawFormat::R16Big, RawFormat::R32] {
            for south_first in [false, true] {
                let layout = RawLayout { format, range: (0.0, 6553.5), south_first };
                let bytes = write(&terrain, &layout, &Job::detached()).unwrap();
                let back = read(&bytes, "x", terrain.grid().clone(), &layout, &Job::detached()).unwrap();
                assert_eq!(back.cells(), terrain.cells(), "{format:?}");
            }
        }
    }

    #[test]
    fn a_length_that_no_square_fills_asks_for_the_columns() {
        assert_eq!(size(32, RawFormat::R16Little, 0, 0, "x").unwrap(), (4, 4));
        assert_eq!(size(30, RawFormat::R16Little, 0, 5, "x").unwrap(), (3, 5));
        let error = size(30, RawFormat::R16Little, 0, 0, "x").unwrap_err();
        assert!(error.hint().unwrap().contains("cols"));
        for (bytes, rows, cols) in
            [(31, 0, 0), (30, 4, 0), (30, 4, 4), (0, 0, 0), (30, usize::MAX, usize::MAX)]
        {
            assert!(size(bytes, RawFormat::R16Little, rows, cols, "x").is_err());
        }
    }
}
