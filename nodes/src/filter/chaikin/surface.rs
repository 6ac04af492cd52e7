//! Surfaces taken apart along both axes.

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
    #[must_use]
    pub fn details(&self, levels: u32, boundary: Boundary) -> Self {
        let smooth = self.smoothed(levels, boundary);
        let cells = self.cells.iter().zip(&smooth.cells).map(|(own, smooth)| own - smooth).collect();
        Self { size: self.size, cells }
    }

    fn smoothed(&self, levels: u32, boundary: Boundary) -> Self {
        if levels == 0 || !self.is_divisible() {
            return self.clone();
        }
        let mut bands = self.decompose(boundary);
        bands.coarse = bands.coarse.smoothed(levels - 1, boundary);
        for band in [&mut bands.across, &mut bands.down, &mut bands.diagonal] {
            band.cells.fill(0.0);
        }
        bands.compose(boundary)
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.cells[row * self.size.1..(row + 1) * self.size.1]
    }

    pub(in crate::filter) fn transposed(&self) -> Self {
        let (rows, cols) = self.size;
        let cells = (0..rows * cols).map(|i| self.cells[i % rows * cols + i / rows]).collect();
        Self { size: (cols, rows), cells }
    }

    /// Its rows taken apart.
    pub(in crate::filter) fn halved(&self, boundary: Boundary) -> [Self; 2] {
        let n = coarse_len(self.size.1);
        let [mut coarse, mut details] = [n, n - 2]
            .map(|cols| Self { size: (self.size.0, cols), cells: Vec::with_capacity(self.size.0 * cols) });
        let (mut line, mut extra) = Default::default();
        for row in 0..self.size.0 {
            decompose(self.row(row), boundary, &mut line, &mut extra);
            coarse.cells.extend_from_slice(&line);
            details.cells.extend_from_slice(&extra);
        }
        [coarse, details]
    }

    /// Rows of `cols` cells put together again.
    pub(in crate::filter) fn doubled(&self, details: &Self, boundary: Boundary, cols: usize) -> Self {
        let mut out = Self { size: (self.size.0, cols), cells: Vec::with_capacity(self.size.0 * cols) };
        let mut line = Vec::new();
        for row in 0..self.size.0 {
            compose(self.row(row), details.row(row), boundary, cols, &mut line);
            out.cells.extend_from_slice(&line);
        }
        out
    }

    /// Takes the surface apart, down columns and then along rows. It must be [divisible](Self::is_divisible).
    #[must_use]
    pub fn decompose(&self, boundary: Boundary) -> Bands {
        let [coarse, details] = self.transposed().halved(boundary).map(|half| half.transposed());
        let [[coarse, across], [down, diagonal]] = [coarse, details].map(|half| half.halved(boundary));
        Bands { size: self.size, coarse, across, down, diagonal }
    }
}

impl Bands {
    /// The surface that was taken apart.
    #[must_use]
    pub fn compose(&self, boundary: Boundary) -> Surface {
        let cols = self.size.1;
        let coarse = self.coarse.doubled(&self.across, boundary, cols);
        let details = self.down.doubled(&self.diagonal, boundary, cols);
        coarse.transposed().doubled(&details.transposed(), boundary, self.size.0).transposed()
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
                let bands = surface.decompose(boundary);
                let (n, m) = (coarse_len(size.0), coarse_len(size.1));
                assert_eq!(bands.coarse.size, (n, m));
                assert_eq!(
                    [bands.across.size, bands.down.size, bands.diagonal.size],
                    [(n, m - 2), (n - 2, m), (n - 2, m - 2)]
                );
                let again = bands.compose(boundary);
                assert_eq!(again.size, size);
                assert!(again.cells.iter().zip(&surface.cells).all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn transposition_goes_through() {
        let size = (12, 9);
        let surface = Surface { size, cells: (0..108).map(|i| gaussian(5, 5, i, 0)).collect() };
        let (bands, turned) =
            [&surface, &surface.transposed()].map(|surface| surface.decompose(Boundary::Natural)).into();
        let same = |a: &Surface, b: &Surface| {
            let b = b.transposed();
            a.size == b.size && a.cells.iter().zip(&b.cells).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(same(&bands.coarse, &turned.coarse) && same(&bands.diagonal, &turned.diagonal));
        assert!(same(&bands.across, &turned.down) && same(&bands.down, &turned.across));
    }
}
