//! The bending energy of a plate of cells, and its derivative.
//!
//! The sum of f_xx² + 2 f_xy² + f_yy² over all differences that lie wholly on the plate, whose edges are free, and of the
//! square of the slope divided by that of a length: the tension. Differences are taken per metre; the whole is scaled by the
//! square of a cell's area, which changes no minimum.

use std::ops::{Add, Mul, Sub};

use orograph_core::CellSize;
use rayon::prelude::*;

/// What surfaces are counted in: `f64` for heights, `f32` for corrections to them.
pub(super) trait Real:
    Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
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

    /// Sums of whole multiples of heights, weighed afterwards: rounded coefficients would not sum to zero, and over wide
    /// plates that outweighs all bending.
    fn row<R: Real>(&self, surface: &[R], row: usize, out: &mut [R]) {
        let (rows, cols) = self.size;
        let [xx, xy, yy] = self.weights.map(R::of);
        let [along, across] = self.tension.map(R::of);
        // Beyond the plate every coefficient is zero, so that any row serves.
        let line = |offset: usize| {
            let row = (row + offset).saturating_sub(2).min(rows - 1);
            &surface[row * cols..(row + 1) * cols]
        };
        let lines = [0, 1, 2, 3, 4].map(line);
        let (down, beside) = (fourth(rows, row).map(R::of), second(rows, row).map(R::of));
        let bend = |col: usize| {
            let [a, b, c, d, e] = lines.map(|line| line[col]);
            down[0] * a + down[1] * b + down[2] * c + down[3] * d + down[4] * e
        };
        let slope = |col: usize| {
            let [_, b, c, d, _] = lines.map(|line| line[col]);
            beside[0] * b + beside[1] * c + beside[2] * d
        };
        let inner = 2..cols.saturating_sub(2).max(2);
        for col in (0..inner.start.min(cols)).chain(inner.end.min(cols)..cols) {
            let mut sum = yy * bend(col) + across * slope(col);
            for (k, c) in second(cols, col).into_iter().enumerate().filter(|(_, c)| *c != 0.0) {
                sum = sum + R::of(c) * (xy * slope(col + k - 1) + along * lines[2][col + k - 1]);
            }
            for (k, c) in fourth(cols, col).into_iter().enumerate().filter(|(_, c)| *c != 0.0) {
                sum = sum + xx * (R::of(c) * lines[2][col + k - 2]);
            }
            out[col] = sum;
        }
        if inner.is_empty() {
            return;
        }
        // The same free of branches.
        let [two, four, six] = [2.0, 4.0, 6.0].map(R::of);
        let [far_above, above, line, below, far_below] = lines;
        let ends = far_above[2..].iter().zip(&far_below[2..]);
        let sides = above[1..].windows(3).zip(below[1..].windows(3));
        for (((out, (up, low)), (a, b)), c) in out[inner].iter_mut().zip(ends).zip(sides).zip(line.windows(5))
        {
            let bend = down[0] * *up + down[1] * a[1] + down[2] * c[2] + down[3] * b[1] + down[4] * *low;
            let slope = |k: usize| beside[0] * a[k] + beside[1] * c[k + 1] + beside[2] * b[k];
            let middle = slope(1);
            *out = yy * bend
                + xx * (c[0] + c[4] - four * (c[1] + c[3]) + six * c[2])
                + xy * (two * middle - slope(0) - slope(2))
                + along * (two * c[2] - c[1] - c[3])
                + across * middle;
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

    fn square(value: f64) -> f64 {
        value * value
    }

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
                    sum += square((at(row + 1, col) - at(row, col)) / (cell.y * STIFF));
                }
                if col + 1 < cols {
                    sum += square((at(row, col + 1) - at(row, col)) / (cell.x * STIFF));
                }
                if row + 1 < rows && col + 1 < cols {
                    let xy = at(row + 1, col + 1) - at(row + 1, col) - at(row, col + 1) + at(row, col);
                    sum += 2.0 * square(xy / (cell.x * cell.y));
                }
            }
        }
        sum * square(cell.x * cell.y)
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
