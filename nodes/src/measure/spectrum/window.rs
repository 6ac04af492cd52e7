//! The part of a terrain whose spectrum is taken, made ready for the transform.

use std::f64::consts::TAU;

use orograph_core::prelude::*;
use rustfft::num_complex::Complex;

use crate::measure::sums::per_row;

/// The largest centred part of a terrain that is square on the ground.
pub(super) struct Window<'a> {
    terrain: &'a Heightfield,
    pub(super) row: usize,
    col: usize,
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) cell: CellSize,
}

impl<'a> Window<'a> {
    pub(super) fn of(terrain: &'a Heightfield) -> Self {
        let (rows, cols) = terrain.grid().size();
        let cell = terrain.grid().cell;
        let side = (rows as f64 * cell.y).min(cols as f64 * cell.x);
        // Rounding must not lose the last row of a terrain that is as long as wide.
        let fit = |size: f64, all: usize| ((side / size + 1e-6) as usize).min(all);
        let (high, wide) = (fit(cell.y, rows), fit(cell.x, cols));
        Self { terrain, row: (rows - high) / 2, col: (cols - wide) / 2, rows: high, cols: wide, cell }
    }

    /// The shorter side in metres.
    pub(super) fn side(&self) -> f64 {
        (self.rows as f64 * self.cell.y).min(self.cols as f64 * self.cell.x)
    }

    pub(super) fn area(&self) -> f64 {
        self.rows as f64 * self.cell.y * self.cols as f64 * self.cell.x
    }

    /// Sum of the squared weights of the Hann window.
    pub(super) fn weight(&self) -> f64 {
        let of = |n: usize| (0..n).map(|i| hann(i, n) * hann(i, n)).sum::<f64>();
        of(self.rows) * of(self.cols)
    }

    /// Heights less their plane, times the Hann window, and the share of voids, which lie on the plane.
    pub(super) fn prepared(&self, job: &Job) -> Result<(Vec<Complex<f64>>, f64)> {
        let line = |row: usize| &self.terrain.row(self.row + row)[self.col..self.col + self.cols];
        let (middle_row, middle_col) = ((self.rows - 1) as f64 / 2.0, (self.cols - 1) as f64 / 2.0);
        // Sums of 1, x, y, xx, xy, yy, z, xz, yz over the known cells.
        let sums = per_row(self.rows, job, |row| {
            let y = row as f64 - middle_row;
            let mut sums = [0.0; 9];
            for (col, &height) in line(row).iter().enumerate().filter(|(_, height)| height.is_finite()) {
                let (x, z) = (col as f64 - middle_col, f64::from(height));
                let terms = [1.0, x, y, x * x, x * y, y * y, z, x * z, y * z];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            }
            Ok(sums)
        })?;
        let mut all = [0.0; 9];
        for of_row in sums {
            all.iter_mut().zip(of_row).for_each(|(all, own)| *all += own);
        }
        let plane = plane(all);
        let across: Vec<f64> = (0..self.cols).map(|col| hann(col, self.cols)).collect();
        let rows = per_row(self.rows, job, |row| {
            let (y, down) = (row as f64 - middle_row, hann(row, self.rows));
            let above = |(col, &height): (usize, &f32)| {
                let over = f64::from(height) - plane[0] - plane[1] * (col as f64 - middle_col) - plane[2] * y;
                Complex::new(if height.is_finite() { over * down * across[col] } else { 0.0 }, 0.0)
            };
            Ok(line(row).iter().enumerate().map(above).collect::<Vec<_>>())
        })?;
        let void_share = 1.0 - all[0] / (self.rows * self.cols) as f64;
        Ok((rows.concat(), void_share))
    }
}

/// The Hann window, zero just beyond both ends.
fn hann(i: usize, n: usize) -> f64 {
    0.5 - 0.5 * libm::cos(TAU * (i as f64 + 0.5) / n as f64)
}

/// Height in the middle and rise along x and y of the least-squares plane; level where the cells lie on a line.
fn plane([n, x, y, xx, xy, yy, z, xz, yz]: [f64; 9]) -> [f64; 3] {
    if n == 0.0 {
        return [0.0; 3];
    }
    let (cxx, cxy, cyy) = (xx - x * x / n, xy - x * y / n, yy - y * y / n);
    let (cxz, cyz) = (xz - x * z / n, yz - y * z / n);
    let det = cxx * cyy - cxy * cxy;
    if det <= 1e-9 * cxx * cyy {
        return [z / n, 0.0, 0.0];
    }
    let (p, q) = ((cxz * cyy - cyz * cxy) / det, (cyz * cxx - cxz * cxy) / det);
    [(z - p * x - q * y) / n, p, q]
}
