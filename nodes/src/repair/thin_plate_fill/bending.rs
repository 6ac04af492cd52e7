//! The bending energy of a plate of cells, and its derivative.
//!
//! The sum of f_xx² + 2 f_xy² + f_yy² over all differences that lie wholly on the plate, whose edges are free, and of the
//! square of the slope divided by that of a length: the tension. Differences are taken per metre; the whole is scaled by the
//! square of a cell's area, which changes no minimum.

use std::{
    iter::Sum,
    ops::{Add, Mul, Sub},
};

use orograph_core::CellSize;
use rayon::prelude::*;

/// What surfaces are counted in: `f64` for heights, `f32` for corrections to them.
pub(super) trait Real:
    Copy + Send + Sync + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Sum
{
    /// The nearest such number.
    fn of(number: f64) -> Self;
}

impl Real for f32 {
    fn of(number: f64) -> Self {
        number as Self
    }
}

impl Real for f64 {
    fn of(number: f64) -> Self {
        number
    }
}

/// Rows that one task takes at least, so that small plates stay on one thread.
pub(super) fn rows_per_task(cols: usize) -> usize {
    16_384_usize.div_ceil(cols.max(1))
}

/// A plate of `rows` × `cols` cells.
#[derive(Clone, Debug)]
pub(super) struct Bending {
    pub(super) size: (usize, usize),
    /// Weights of the squares of f_xx, f_xy and f_yy.
    weights: [f64; 3],
    /// Weights of the squares of f_x and f_y.
    tension: [f64; 2],
}

impl Bending {
    /// A plate that is bent over less than `stiff` metres, and hangs like a membrane over more.
    pub(super) fn new(size: (usize, usize), cell: CellSize, stiff: f64) -> Self {
        let slender = cell.y / cell.x;
        let tension = [cell.y, cell.x].map(|side| (side / stiff) * (side / stiff));
        Self { size, weights: [slender * slender, 2.0, 1.0 / (slender * slender)], tension }
    }

    /// Energy of a surface that is the product of a function of the row and the same of the column, by the sums of squares
    /// of that function and of its first and second differences.
    pub(super) fn of_product(&self, [value, first, second]: [f64; 3]) -> f64 {
        let [xx, xy, yy] = self.weights;
        (xx + yy) * value * second + xy * first * first + (self.tension[0] + self.tension[1]) * value * first
    }

    /// Half the derivative of the energy at `surface`, row by row; `each` hears the number of a row and its derivative,
    /// and what it returns comes back in the order of rows.
    pub(super) fn derivative<R: Real, T: Send>(
        &self,
        surface: &[R],
        out: &mut [R],
        each: impl Fn(usize, &mut [R]) -> T + Sync,
    ) -> Vec<T> {
        let cols = self.size.1;
        out.par_chunks_mut(cols)
            .with_min_len(rows_per_task(cols))
            .enumerate()
            .map(|(row, out)| {
                self.row(surface, row, out);
                each(row, out)
            })
            .collect()
    }

    fn row<R: Real>(&self, surface: &[R], row: usize, out: &mut [R]) {
        let (rows, cols) = self.size;
        let [xx, xy, yy] = self.weights;
        // Beyond the plate every coefficient is zero, so that any row serves.
        let line = |offset: usize| {
            let row = (row + offset).saturating_sub(2).min(rows - 1);
            &surface[row * cols..(row + 1) * cols]
        };
        let lines = [0, 1, 2, 3, 4].map(line);
        let [along, across] = self.tension;
        let beside = second(rows, row);
        let mut down = fourth(rows, row).map(|c| c * yy);
        (0..3).for_each(|k| down[k + 1] += across * beside[k]);
        let cross = beside.map(|c| c * xy);
        let inner = 2..cols.saturating_sub(2).max(2);
        for col in (0..inner.start.min(cols)).chain(inner.end.min(cols)..cols) {
            let beside =
                |col: usize| cross.iter().zip(&lines[1..4]).map(|(c, line)| R::of(*c) * line[col]).sum::<R>();
            let mut sum: R = down.iter().zip(lines).map(|(c, line)| R::of(*c) * line[col]).sum();
            for (k, c) in second(cols, col).into_iter().enumerate().filter(|(_, c)| *c != 0.0) {
                sum = sum + R::of(c) * (beside(col + k - 1) + R::of(along) * lines[2][col + k - 1]);
            }
            for (k, c) in fourth(cols, col).into_iter().enumerate().filter(|(_, c)| *c != 0.0) {
                sum = sum + R::of(xx * c) * lines[2][col + k - 2];
            }
            out[col] = sum;
        }
        if inner.is_empty() {
            return;
        }
        // The same sum with its coefficients gathered, free of branches.
        let [above, middle, below] = cross;
        let [two_above, one_above, here, one_below, two_below] = [
            down[0],
            down[1] + 2.0 * above,
            down[2] + 6.0 * xx + 2.0 * (middle + along),
            down[3] + 2.0 * below,
            down[4],
        ]
        .map(R::of);
        let [above, below, near, far] = [above, below, -4.0 * xx - middle - along, xx].map(R::of);
        let [far_above, near_above, line, near_below, far_below] = lines;
        let ends = far_above[2..].iter().zip(&far_below[2..]);
        let sides = near_above[1..].windows(3).zip(near_below[1..].windows(3));
        for (((out, (up, down)), (a, b)), c) in
            out[inner].iter_mut().zip(ends).zip(sides).zip(line.windows(5))
        {
            *out = two_above * *up + two_below * *down + one_above * a[1] + one_below * b[1]
                - above * (a[0] + a[2])
                - below * (b[0] + b[2])
                + far * (c[0] + c[4])
                + near * (c[1] + c[3])
                + here * c[2];
        }
    }
}

/// One row of DᵀD with D the second differences along `n` cells: coefficients of the cells from two before to two after.
fn fourth(n: usize, at: usize) -> [f64; 5] {
    let mut out = [0.0; 5];
    for (k, own) in [1.0, -2.0, 1.0].into_iter().enumerate() {
        // The difference whose middle lies one before, at, or one after the cell.
        let Some(middle) = (at + k).checked_sub(1) else { continue };
        if middle >= 1 && middle + 1 < n {
            [1.0, -2.0, 1.0].into_iter().enumerate().for_each(|(j, c)| out[k + j] += own * c);
        }
    }
    out
}

/// One row of DᵀD with D the first differences along `n` cells.
fn second(n: usize, at: usize) -> [f64; 3] {
    let mut out = [0.0; 3];
    if at > 0 {
        (out[0], out[1]) = (out[0] - 1.0, out[1] + 1.0);
    }
    if at + 1 < n {
        (out[2], out[1]) = (out[2] - 1.0, out[1] + 1.0);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::gaussian;

    const STIFF: f64 = 45.0;

    fn energy(surface: &[f64], (rows, cols): (usize, usize), cell: CellSize) -> f64 {
        let at = |row: usize, col: usize| surface[row * cols + col];
        let mut sum = 0.0;
        for row in 0..rows {
            for col in 0..cols {
                if col > 0 && col + 1 < cols {
                    let xx = (at(row, col - 1) - 2.0 * at(row, col) + at(row, col + 1)) / (cell.x * cell.x);
                    sum += xx * xx;
                }
                if row > 0 && row + 1 < rows {
                    let yy = (at(row - 1, col) - 2.0 * at(row, col) + at(row + 1, col)) / (cell.y * cell.y);
                    sum += yy * yy;
                }
                if row + 1 < rows {
                    sum += ((at(row + 1, col) - at(row, col)) / (cell.y * STIFF)).powi(2);
                }
                if col + 1 < cols {
                    sum += ((at(row, col + 1) - at(row, col)) / (cell.x * STIFF)).powi(2);
                }
                if row + 1 < rows && col + 1 < cols {
                    let xy = at(row + 1, col + 1) - at(row + 1, col) - at(row, col + 1) + at(row, col);
                    sum += 2.0 * (xy / (cell.x * cell.y)).powi(2);
                }
            }
        }
        sum * (cell.x * cell.y).powi(2)
    }

    #[test]
    fn the_derivative_is_that_of_the_energy() {
        let cell = CellSize { x: 20.0, y: 30.0 };
        for size in [(9, 11), (1, 1), (1, 7), (7, 1), (2, 2), (3, 4), (5, 5), (4, 6)] {
            let n = size.0 * size.1;
            let surface: Vec<f64> = (0..n as i64).map(|i| gaussian(1, 0, i, 0)).collect();
            let bending = Bending::new(size, cell, STIFF);
            let mut out = vec![0.0; n];
            bending.derivative(&surface, &mut out, |_, _| ());
            // The energy is a quadratic form: its derivative along a direction tells the whole.
            for turn in 0..n {
                let mut moved = surface.clone();
                moved[turn] += 1.0;
                let mut back = surface.clone();
                back[turn] -= 1.0;
                let slope = (energy(&moved, size, cell) - energy(&back, size, cell)) / 4.0;
                assert!((out[turn] - slope).abs() < 1e-9, "{size:?} {turn}: {} {slope}", out[turn]);
            }
        }
    }

    #[test]
    fn products_have_the_energy_that_is_said() {
        let (n, cell) = (11, CellSize { x: 1.0, y: 2.0 });
        let shape: Vec<f64> =
            (0..n).map(|i| if (4..7).contains(&i) { 1.0 + (i % 2) as f64 } else { 0.0 }).collect();
        let surface: Vec<f64> = (0..n * n).map(|i| shape[i / n] * shape[i % n]).collect();
        let squares = |values: Vec<f64>| values.iter().map(|value| value * value).sum::<f64>();
        let first = shape.windows(2).map(|w| w[1] - w[0]).collect();
        let second = shape.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]).collect();
        let said =
            Bending::new((n, n), cell, STIFF).of_product([squares(shape), squares(first), squares(second)]);
        assert!((said - energy(&surface, (n, n), cell)).abs() < 1e-9);
    }
}
