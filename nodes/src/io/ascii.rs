//! ESRI ASCII grid: a header of named numbers, then heights as text, north to south.

use std::io::Write;

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    file::refuse_infinite,
    ground::{MapUnit, cell_size, looks_like_degrees},
};

/// What the header says.
#[derive(Default)]
struct Header {
    cols: Option<f64>,
    rows: Option<f64>,
    x: Option<(f64, bool)>,
    y: Option<(f64, bool)>,
    dx: Option<f64>,
    dy: Option<f64>,
    nodata: Option<f64>,
}

impl Header {
    /// Takes a named number; `false` for a name that the format does not have.
    fn set(&mut self, key: &str, value: f64) -> bool {
        match key.to_ascii_lowercase().as_str() {
            "ncols" => self.cols = Some(value),
            "nrows" => self.rows = Some(value),
            "xllcorner" => self.x = Some((value, false)),
            "yllcorner" => self.y = Some((value, false)),
            "xllcenter" => self.x = Some((value, true)),
            "yllcenter" => self.y = Some((value, true)),
            "cellsize" => (self.dx, self.dy) = (Some(value), Some(value)),
            "dx" => self.dx = Some(value),
            "dy" => self.dy = Some(value),
            "nodata_value" => self.nodata = Some(value),
            _ => return false,
        }
        true
    }
}

/// Whether the bytes begin as an ASCII grid does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"ncols") || word.eq_ignore_ascii_case(b"nrows"))
}

/// The heights in an ASCII grid, in metres; `name` names the file in errors. The format knows no coordinate
/// system: coordinates that can only be degrees are taken as such, with a remark, and all others as metres.
///
/// # Errors
/// [`Error::Format`] for a header without what is needed, for text that is no number and for missing or
/// surplus numbers; [`Error::NonFinite`]; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    let mut words = bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).peekable();
    let fail = |reason: String| Error::format(name, reason);
    let mut header = Header::default();
    while let Some(key) = words.next_if(|word| word[0].is_ascii_alphabetic() && !is_nan(word)) {
        let key = String::from_utf8_lossy(key);
        let value = words.next().and_then(number).ok_or_else(|| fail(format!("`{key}` has no number")))?;
        if !header.set(&key, value) {
            return Err(fail(format!("`{key}` is no part of an ASCII grid's header")));
        }
    }
    let need = |value: Option<f64>, key: &str| value.ok_or_else(|| fail(format!("`{key}` is missing")));
    let count = |value: Option<f64>, key: &str| {
        let value = need(value, key)?;
        let whole = (0.0..=9e15).contains(&value) && value.fract() == 0.0;
        if whole { Ok(value as usize) } else { Err(fail(format!("`{key}` {value} is no count"))) }
    };
    let size = (count(header.rows, "nrows")?, count(header.cols, "ncols")?);
    let (dx, dy) = (need(header.dx, "cellsize")?, need(header.dy, "cellsize")?);
    let ((x, x_centre), (y, y_centre)) = (header.x.unwrap_or((0.0, false)), header.y.unwrap_or((0.0, false)));
    let west = if x_centre { x - dx / 2.0 } else { x };
    let south = if y_centre { y - dy / 2.0 } else { y };
    let transform = [west, dx, 0.0, south + dy * size.0 as f64, 0.0, -dy];
    let unit = if looks_like_degrees(&transform, size) {
        job.warn(format!("{name}: the coordinates are taken as degrees"));
        MapUnit::Degrees(1.0)
    } else {
        MapUnit::Metres(1.0)
    };
    let mut grid = Grid::new(size.0, size.1, cell_size(&transform, size, unit, name)?)?;
    if grid.is_empty() {
        return Err(Error::EmptyInput { what: name.into() });
    }
    grid.georef = Some(Georef { transform, crs: String::new() }.into());
    let wanted = grid.len();
    // Each height takes a digit and, but for the last, a space.
    if wanted > bytes.len() / 2 + 1 {
        return Err(fail(format!("it promises {wanted} heights but is too short for them")));
    }
    let mut terrain = Heightfield::filled(grid, f32::NAN, job)?;
    let cols = terrain.cols();
    let mut read = 0;
    let done = job.stage(size.0 as u64);
    for row in terrain.cells_mut().chunks_exact_mut(cols) {
        job.check()?;
        for cell in row {
            let Some(word) = words.next() else {
                return Err(fail(format!("it ends after {read} of {wanted} heights")));
            };
            let value = number(word).ok_or_else(|| {
                fail(format!("`{}` is no height", String::from_utf8_lossy(&word[..word.len().min(30)])))
            })?;
            *cell = if Some(value) == header.nodata { f32::NAN } else { value as f32 };
            read += 1;
        }
        done.advance(1);
    }
    if words.next().is_some() {
        return Err(fail(format!("it goes on after its {wanted} heights")));
    }
    refuse_infinite(&terrain, name)?;
    Ok(terrain)
}

fn is_nan(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"nan")
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// What stands for a void.
const NODATA: f32 = -9999.0;

/// Writes an ASCII grid with heights at full precision and -9999 for voids.
///
/// # Errors
/// [`Error::EmptyInput`]; [`Error::Invalid`] for a rotated grid or a height of exactly -9999; [`Error::NonFinite`];
/// [`Error::Io`] from the stream; [`Error::Cancelled`].
pub fn write(terrain: &Heightfield, out: &mut impl Write, name: &str, job: &Job) -> Result<()> {
    super::file::refuse_empty(terrain, "terrain")?;
    let grid = terrain.grid();
    let transform = grid.georef_here().map_or_else(
        || {
            let first = grid.position(0, 0);
            let (x, y) = (grid.cell.x, grid.cell.y);
            [first.x - x / 2.0, x, 0.0, first.y + y / 2.0, 0.0, -y]
        },
        |georef| georef.transform,
    );
    let [x0, xc, xr, y0, yc, yr] = transform;
    if xr != 0.0 || yc != 0.0 || xc <= 0.0 || yr >= 0.0 {
        return Err(Error::invalid("an ASCII grid cannot be rotated or mirrored", "write a GeoTIFF instead"));
    }
    let failed = |reason: std::io::Error| Error::writing(name, reason);
    let south = y0 + yr * grid.rows as f64;
    write!(out, "ncols {}\nnrows {}\nxllcorner {x0}\nyllcorner {south}\n", grid.cols, grid.rows)
        .map_err(failed)?;
    if (xc + yr).abs() <= 1e-12 * xc {
        writeln!(out, "cellsize {xc}").map_err(failed)?;
    } else {
        write!(out, "dx {xc}\ndy {}\n", -yr).map_err(failed)?;
    }
    writeln!(out, "NODATA_value {NODATA}").map_err(failed)?;
    let done = job.stage(grid.rows as u64);
    for first in (0..grid.rows).step_by(ROWS_AT_ONCE) {
        let rows = first..(first + ROWS_AT_ONCE).min(grid.rows);
        let lines: Vec<Result<String>> = rows.into_par_iter().map(|row| line(terrain, row, job)).collect();
        for line in lines {
            out.write_all(line?.as_bytes()).map_err(failed)?;
            done.advance(1);
        }
    }
    Ok(())
}

/// Rows that are put into words side by side, and then wait to be written.
const ROWS_AT_ONCE: usize = 64;

/// A row of heights in words, -9999 for voids.
fn line(terrain: &Heightfield, row: usize, job: &Job) -> Result<String> {
    job.check()?;
    let mut line = String::with_capacity(terrain.cols() * 8);
    for (col, &height) in terrain.row(row).iter().enumerate() {
        if height.is_infinite() {
            return Err(Error::NonFinite { what: "terrain".into(), row, col });
        }
        if height == NODATA {
            let message = format!("the height at row {row}, column {col} is -9999, which stands for voids");
            return Err(Error::invalid(message, "write a GeoTIFF instead"));
        }
        let height = if height.is_nan() { NODATA } else { height };
        let gap = if col > 0 { " " } else { "" };
        // Writing to a string cannot fail.
        let _ = std::fmt::Write::write_fmt(&mut line, format_args!("{gap}{height}"));
    }
    line.push('\n');
    Ok(line)
}
