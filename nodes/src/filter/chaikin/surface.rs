//! Surfaces taken apart along both axes.

use orograph_core::{Job, Result};
use rayon::prelude::*;

use super::{Boundary, FEWEST, coarse_len, compose, decompose};

/// Rows × columns of numbers, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Rows and columns.
    pub size: (usize, usize),
    /// One number for each cell.
    pub cells: Vec<f64>,
}

/// A surface taken apart once.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    /// Rows and columns of the whole.
    pub size: (usize, usize),
    /// The coarse surface.
    pub coarse: Surface,
    /// Details along rows of what is coarse down columns.
    pub across: Surface,
    /// Details down columns of what is coarse along rows.
    pub down: Surface,
    /// Details along both.
    pub diagonal: Surface,
}

impl Surface {
    /// A surface of zeros.
    #[must_use]
    pub fn zeros(size: (usize, usize)) -> Self {
        Self { size, cells: vec![0.0; size.0 * size.1] }
    }

    /// Whether it is large enough to be taken apart.
    #[must_use]
    pub fn is_divisible(&self) -> bool {
        self.size.0.min(self.size.1) >= FEWEST
    }

    /// What the surface loses when it is halved `levels` times and rounded out again; as often as it is divisible.
    ///
    /// # Errors
    /// [`Error::Cancelled`](orograph_core::Error::Cancelled).
    pub fn details(&self, levels: u32, boundary: Boundary, job: &Job<'_>) -> Result<Self> {
        let smooth = self.smoothed(levels, boundary, job)?;
        let cells = self.cells.iter().zip(&smooth.cells).map(|(own, smooth)| own - smooth).collect();
        Ok(Self { size: self.size, cells })
    }

    fn smoothed(&self, levels: u32, boundary: Boundary, job: &Job<'_>) -> Result<Self> {
        if levels == 0 || !self.is_divisible() {
            return Ok(self.clone());
        }
        let mut bands = self.decompose(boundary, job)?;
        bands.coarse = bands.coarse.smoothed(levels - 1, boundary, job)?;
        for band in [&mut bands.across, &mut bands.down, &mut bands.diagonal] {
            band.cells.fill(0.0);
        }
        bands.compose(boundary, job)
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.cells[row * self.size.1..(row + 1) * self.size.1]
    }

    pub(in crate::filter) fn transposed(&self, job: &Job<'_>) -> Result<Self> {
        /// Columns that are turned into rows together, so that what is read of a row is read at once.
        const BAND: usize = 32;
        let (rows, cols) = self.size;
        let mut out = Self::zeros((cols, rows));
        out.cells.par_chunks_mut((BAND * rows).max(1)).enumerate().try_for_each(|(band, cells)| {
            job.check()?;
            let first = band * BAND;
            let width = BAND.min(cols - first);
            for row in 0..rows {
                let line = &self.row(row)[first..first + width];
                line.iter().enumerate().for_each(|(col, cell)| cells[col * rows + row] = *cell);
            }
            Ok(())
        })?;
        Ok(out)
    }

    /// Its rows taken apart.
    pub(in crate::filter) fn halved(&self, boundary: Boundary, job: &Job<'_>) -> Result<[Self; 2]> {
        let n = coarse_len(self.size.1);
        let [mut coarse, mut details] = [n, n - 2].map(|cols| Self::zeros((self.size.0, cols)));
        let rows = coarse.cells.par_chunks_mut(n).zip(details.cells.par_chunks_mut(n - 2)).enumerate();
        rows.try_for_each_init(Default::default, |(line, extra), (row, (coarse, details))| {
            job.check()?;
            decompose(self.row(row), boundary, line, extra);
            coarse.copy_from_slice(line);
            details.copy_from_slice(extra);
            Ok(())
        })?;
        Ok([coarse, details])
    }

    /// Rows of `cols` cells put together again.
    pub(in crate::filter) fn doubled(
        &self,
        details: &Self,
        boundary: Boundary,
        cols: usize,
        job: &Job<'_>,
    ) -> Result<Self> {
        let mut out = Self::zeros((self.size.0, cols));
        let rows = out.cells.par_chunks_mut(cols.max(1)).enumerate();
        rows.try_for_each_init(Vec::new, |line, (row, out)| {
            job.check()?;
            compose(self.row(row), details.row(row), boundary, cols, line);
            out.copy_from_slice(line);
            Ok(())
        })?;
        Ok(out)
    }

    /// Takes the surface apart, down columns and then along rows. It must be [divisible](Self::is_divisible).
    ///
    /// # Errors
    /// [`Error::Cancelled`](orograph_core::Error::Cancelled).
    pub fn decompose(&self, boundary: Boundary, job: &Job<'_>) -> Result<Bands> {
        let [coarse, details] = self.transposed(job)?.halved(boundary, job)?;
        let [coarse, across] = coarse.transposed(job)?.halved(boundary, job)?;
        let [down, diagonal] = details.transposed(job)?.halved(boundary, job)?;
        Ok(Bands { size: self.size, coarse, across, down, diagonal })
    }
}

impl Bands {
    /// The surface that was taken apart.
    ///
    /// # Errors
    /// [`Error::Cancelled`](orograph_core::Error::Cancelled).
    pub fn compose(&self, boundary: Boundary, job: &Job<'_>) -> Result<Surface> {
        let cols = self.size.1;
        let coarse = self.coarse.doubled(&self.across, boundary, cols, job)?.transposed(job)?;
        let details = self.down.doubled(&self.diagonal, boundary, cols, job)?.transposed(job)?;
        coarse.doubled(&details, boundary, self.size.0, job)?.transposed(job)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::gaussian;

    #[test]
    fn surfaces_of_any_size_are_composed_again() {
        for boundary in [Boundary::Natural, Boundary::Clamped] {
            for size in [(4, 4), (5, 9), (10, 7), (18, 26), (33, 4)] {
                let cells = (0..size.0 * size.1).map(|i| gaussian(1, 1, i as i64, 0)).collect();
                let surface = Surface { size, cells };
                let bands = surface.decompose(boundary, &Job::detached()).unwrap();
                let (n, m) = (coarse_len(size.0), coarse_len(size.1));
                assert_eq!(bands.coarse.size, (n, m));
                assert_eq!(
                    [bands.across.size, bands.down.size, bands.diagonal.size],
                    [(n, m - 2), (n - 2, m), (n - 2, m - 2)]
                );
                let again = bands.compose(boundary, &Job::detached()).unwrap();
                assert_eq!(again.size, size);
                assert!(again.cells.iter().zip(&surface.cells).all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn transposition_goes_through() {
        let size = (12, 9);
        let surface = Surface { size, cells: (0..108).map(|i| gaussian(5, 5, i, 0)).collect() };
        let job = Job::detached();
        let across = surface.transposed(&job).unwrap();
        let (bands, turned) =
            [&surface, &across].map(|surface| surface.decompose(Boundary::Natural, &job).unwrap()).into();
        let same = |a: &Surface, b: &Surface| {
            let b = b.transposed(&job).unwrap();
            a.size == b.size && a.cells.iter().zip(&b.cells).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(same(&bands.coarse, &turned.coarse) && same(&bands.diagonal, &turned.diagonal));
        assert!(same(&bands.across, &turned.down) && same(&bands.down, &turned.across));
    }
}
