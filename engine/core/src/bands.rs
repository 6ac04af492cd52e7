//! Bands: rasters that come and go some whole rows at a time, so that none of them is ever there as a whole.

use std::sync::Arc;

use crate::{
    Error, Grid, Heightfield, Job, Kind, Mask, Metres, Raster, Result, Rgba, Share, Texture, Value,
    ValueType, Wire,
};

/// What a node makes, band by band.
pub trait BandSource: Send + Sync {
    /// Where the cells of the whole lie.
    fn grid(&self) -> &Grid;
    /// How many rows come together: bands that end at a multiple of it cost least.
    fn step(&self) -> usize {
        1
    }
    /// The `rows` rows from row `first` on, with the very bits and the place that they have in the whole.
    ///
    /// # Errors
    /// What making the whole would return.
    fn band(&self, first: usize, rows: usize, job: &Job) -> Result<Value>;
}

/// A file that is written band by band.
pub trait BandSink: Send {
    /// Takes the rows that follow those taken before.
    ///
    /// # Errors
    /// What writing the whole would return.
    fn take(&mut self, band: &Value, job: &Job) -> Result<()>;
    /// Puts the file in its place, after the last row.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    fn finish(self: Box<Self>, job: &Job) -> Result<()>;
}

impl Value {
    /// Where the cells of a raster lie; `None` for what is no raster.
    #[must_use]
    pub fn grid(&self) -> Option<&Grid> {
        match self {
            Self::Heightfield(raster) => Some(raster.grid()),
            Self::Mask(raster) => Some(raster.grid()),
            Self::Texture(raster) => Some(raster.grid()),
            _ => None,
        }
    }
}

impl ValueType {
    /// Whether it has one cell for each cell of a grid.
    #[must_use]
    pub fn is_raster(self) -> bool {
        matches!(self, Self::Heightfield | Self::Mask | Self::Texture)
    }
}

/// Some rows of a raster that is not there as a whole.
#[derive(Clone, Debug)]
pub struct Band {
    /// Row of the whole that is the value's first.
    pub first: usize,
    /// The rows.
    pub value: Value,
}

impl Band {
    /// The row after its last one.
    #[must_use]
    pub fn end(&self) -> usize {
        self.first + self.value.grid().map_or(0, |grid| grid.rows)
    }
}

/// The rows from `first` to before `end`, put together from `bands`, which follow each other and cover them. A band
/// that has just these rows is handed on as it is.
///
/// # Errors
/// [`Error::Invalid`] unless they do, [`Error::TooLarge`], [`Error::Cancelled`].
pub fn rows_of(bands: &[Band], first: usize, end: usize, job: &Job) -> Result<Value> {
    let touched = |band: &&Band| band.first < end && band.end() > first;
    let bands: Vec<&Band> = bands.iter().filter(touched).collect();
    let Some(&some) = bands.first() else { return Err(gap(first, end)) };
    if bands.len() == 1 && (some.first, some.end()) == (first, end) {
        return Ok(some.value.clone());
    }
    match some.value.value_type() {
        ValueType::Heightfield => joined::<Metres>(&bands, first, end, job),
        ValueType::Mask => joined::<Share>(&bands, first, end, job),
        ValueType::Texture => joined::<Rgba>(&bands, first, end, job),
        _ => Err(gap(first, end)),
    }
}

fn joined<K: Kind>(bands: &[&Band], first: usize, end: usize, job: &Job) -> Result<Value>
where
    Raster<K>: Wire,
{
    let mut rows: Vec<&[K::Cell]> = Vec::with_capacity(end - first);
    let mut place = None;
    for band in bands {
        let raster = Raster::<K>::borrow(&band.value).ok_or_else(|| gap(first, end))?;
        let from = (first + rows.len()).checked_sub(band.first).ok_or_else(|| gap(first, end))?;
        if place.is_none() {
            let grid = raster.grid();
            place = Some(Grid { rows: end - first, row0: grid.row0 + from as i64, ..grid.clone() });
        }
        rows.extend((from..band.end().min(end) - band.first).map(|row| raster.row(row)));
    }
    let place = place.filter(|place| place.rows == rows.len()).ok_or_else(|| gap(first, end))?;
    let whole = Raster::<K>::build(place, &job.silent(), |row, out| {
        if rows[row].len() != out.len() {
            return Err(gap(first, end));
        }
        out.copy_from_slice(rows[row]);
        Ok(())
    })?;
    Ok(whole.into_value())
}

fn gap(first: usize, end: usize) -> Error {
    Error::invalid(
        format!("rows {first} to {end} of a raster are not there"),
        "report it to the node's author",
    )
}

/// A raster that is put together from bands.
#[derive(Debug)]
pub struct Collected {
    whole: Value,
    rows: usize,
}

impl Collected {
    /// Room for a raster of this type on `grid`; `None` for what is no raster.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn new(of: ValueType, grid: Grid, job: &Job) -> Result<Option<Self>> {
        let whole = match of {
            ValueType::Heightfield => Value::Heightfield(Arc::new(Heightfield::zeroed(grid, job)?)),
            ValueType::Mask => Value::Mask(Arc::new(Mask::zeroed(grid, job)?)),
            ValueType::Texture => Value::Texture(Arc::new(Texture::zeroed(grid, job)?)),
            _ => return Ok(None),
        };
        Ok(Some(Self { whole, rows: 0 }))
    }

    /// Takes the rows that follow those taken before.
    ///
    /// # Errors
    /// [`Error::Invalid`] for rows of another type or width, or more than there is room for.
    pub fn take(&mut self, band: &Value) -> Result<()> {
        let first = self.rows;
        let taken = match (&mut self.whole, band) {
            (Value::Heightfield(whole), Value::Heightfield(band)) => put(whole, first, band),
            (Value::Mask(whole), Value::Mask(band)) => put(whole, first, band),
            (Value::Texture(whole), Value::Texture(band)) => put(whole, first, band),
            _ => None,
        };
        self.rows += taken.ok_or_else(|| gap(first, first + 1))?;
        Ok(())
    }

    /// The whole, after the last row.
    #[must_use]
    pub fn into_value(self) -> Value {
        self.whole
    }
}

/// Writes the rows of `band` into `whole` from row `first` on; how many they are.
fn put<K: Kind>(whole: &mut Arc<Raster<K>>, first: usize, band: &Raster<K>) -> Option<usize> {
    let whole = Arc::get_mut(whole)?;
    let cols = whole.cols();
    let room = whole.cells_mut().get_mut(first * cols..)?.get_mut(..band.cells().len())?;
    (band.cols() == cols).then(|| room.copy_from_slice(band.cells()))?;
    Some(band.rows())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellSize;

    fn raster(rows: usize) -> Heightfield {
        let grid = Grid::new(rows, 3, CellSize::square(2.0)).unwrap();
        Heightfield::new(grid, (0..rows * 3).map(|i| i as f32).collect()).unwrap()
    }

    fn band(whole: &Heightfield, first: usize, rows: usize) -> Band {
        let part = whole.crop(first, 0, rows, 3, &Job::detached()).unwrap();
        Band { first, value: Value::Heightfield(Arc::new(part)) }
    }

    #[test]
    fn any_rows_come_from_the_bands_that_cover_them() {
        let (whole, job) = (raster(10), Job::detached());
        let bands = [band(&whole, 2, 3), band(&whole, 5, 1), band(&whole, 6, 4)];
        for first in 2..10 {
            for end in first + 1..=10 {
                let found = rows_of(&bands, first, end, &job).unwrap();
                let expected = band(&whole, first, end - first).value;
                assert_eq!(found.digest(), expected.digest(), "{first}..{end}");
            }
        }
        let Value::Heightfield(same) = rows_of(&bands, 5, 6, &job).unwrap() else { unreachable!() };
        let Value::Heightfield(given) = &bands[1].value else { unreachable!() };
        assert!(Arc::ptr_eq(&same, given), "a band that fits is not copied");
    }

    #[test]
    fn rows_that_are_not_there_are_refused() {
        let (whole, job) = (raster(10), Job::detached());
        let bands = [band(&whole, 2, 3), band(&whole, 6, 4)];
        for (first, end) in [(0, 3), (4, 7), (9, 11), (5, 6)] {
            assert!(rows_of(&bands, first, end, &job).is_err(), "{first}..{end}");
        }
    }

    #[test]
    fn what_is_collected_is_the_whole() {
        let (whole, job) = (raster(10), Job::detached());
        let mut all = Collected::new(ValueType::Heightfield, whole.grid().clone(), &job).unwrap().unwrap();
        for (first, rows) in [(0, 1), (1, 6), (7, 3)] {
            all.take(&band(&whole, first, rows).value).unwrap();
        }
        assert!(all.take(&band(&whole, 0, 1).value).is_err(), "there is no room left");
        assert_eq!(all.into_value().digest(), Value::Heightfield(Arc::new(whole)).digest());
        assert!(Collected::new(ValueType::Table, raster(1).grid().clone(), &job).unwrap().is_none());
    }
}
