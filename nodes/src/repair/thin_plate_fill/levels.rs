//! Preconditioning by quadratic B-splines of doubling size (Bramble, Pasciak and Xu 1990; for plates Oswald 1992).
//!
//! Chaikin's corner cutting takes a spline on coarse cells to the same on cells of half the size. A spline counts where it
//! lies on free cells alone, so that wide ones work in the middle of a void and narrow ones along its rim.

use rayon::prelude::*;

use super::bending::{Bending, rows_per_task};

/// Splines of one size: how many, and what each is weighed by.
struct Level {
    size: (usize, usize),
    weights: Vec<f32>,
}

/// All sizes of splines on a plate.
pub(super) struct Levels {
    finest: f32,
    size: (usize, usize),
    coarse: Vec<Level>,
    /// One buffer for each coarse level.
    values: Vec<Vec<f32>>,
}

impl Levels {
    /// Bytes for each cell of the plate.
    pub(super) const BYTES: u64 = 4;

    pub(super) fn new(bending: &Bending, free: &[bool]) -> Self {
        let mut shape = vec![1.0];
        let finest = (1.0 / bending.of_product(squares(&shape))) as f32;
        let mut coarse: Vec<Level> = Vec::new();
        let (mut size, mut usable) = (bending.size, free.to_vec());
        while size.0.min(size.1) >= 4 {
            let next = (coarser(size.0), coarser(size.1));
            usable = on_free_alone(&usable, size, next);
            if !usable.contains(&true) {
                break;
            }
            shape = refined(&shape);
            let weight = (1.0 / bending.of_product(squares(&shape))) as f32;
            let weights = usable.iter().map(|&usable| if usable { weight } else { 0.0 }).collect();
            coarse.push(Level { size: next, weights });
            size = next;
        }
        let values = coarse.iter().map(|level| vec![0.0; level.weights.len()]).collect();
        Self { finest, size: bending.size, coarse, values }
    }

    /// Approximates the inverse of the bending operator: `out` from `residual`, row by row; `each` hears the number of a
    /// row, its residual and its outcome, and what it returns comes back in the order of rows.
    pub(super) fn apply<T: Send>(
        &mut self,
        residual: &[f32],
        out: &mut [f32],
        each: impl Fn(usize, &[f32], &mut [f32]) -> T + Sync,
    ) -> Vec<T> {
        let sizes: Vec<(usize, usize)> =
            std::iter::once(self.size).chain(self.coarse.iter().map(|level| level.size)).collect();
        for l in 0..self.coarse.len() {
            let (before, after) = self.values.split_at_mut(l);
            match before.last() {
                None => restrict(residual, sizes[l], &mut after[0], sizes[l + 1]),
                Some(finer) => restrict(finer, sizes[l], &mut after[0], sizes[l + 1]),
            }
        }
        for l in (0..self.coarse.len()).rev() {
            let (finer, coarser) = self.values.split_at_mut(l + 1);
            let weights = &self.coarse[l].weights;
            let size = sizes[l + 1];
            let values = &mut finer[l];
            let above = coarser.first().map(|values| (values.as_slice(), sizes[l + 2]));
            values
                .par_chunks_mut(size.1)
                .zip(weights.par_chunks(size.1))
                .with_min_len(rows_per_task(size.1))
                .enumerate()
                .for_each_init(Vec::new, |buffer, (row, (values, weights))| {
                    values.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight);
                    if let Some((coarse, size)) = above {
                        prolong_row(
                            coarse,
                            size,
                            row,
                            buffer,
                            |col, value| values[col] += value,
                            weights.len(),
                        );
                    }
                });
        }
        let cols = self.size.1;
        let coarse = self.values.first().map(|values| (values.as_slice(), sizes[1]));
        let finest = self.finest;
        out.par_chunks_mut(cols)
            .zip(residual.par_chunks(cols))
            .with_min_len(rows_per_task(cols))
            .enumerate()
            .map_init(Vec::new, |buffer, (row, (out, residual))| {
                out.iter_mut().zip(residual).for_each(|(out, residual)| *out = finest * residual);
                if let Some((coarse, size)) = coarse {
                    prolong_row(coarse, size, row, buffer, |col, value| out[col] += value, cols);
                }
                each(row, residual, out)
            })
            .collect()
    }
}

/// Number of splines over `n` cells of half their size.
fn coarser(n: usize) -> usize {
    n.div_ceil(2) + 1
}

/// A spline on cells of half the size.
fn refined(shape: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; 2 * shape.len() + 2];
    for (j, value) in shape.iter().enumerate() {
        for (k, c) in [0.25, 0.75, 0.75, 0.25].into_iter().enumerate() {
            out[2 * j + k] += c * value;
        }
    }
    out
}

/// Sums of squares of a function of one variable, and of its first and second differences.
fn squares(shape: &[f64]) -> [f64; 3] {
    let mut values = vec![0.0; shape.len() + 4];
    values[2..2 + shape.len()].copy_from_slice(shape);
    let sum = |values: &[f64]| values.iter().map(|value| value * value).sum();
    let differences = |values: &[f64]| values.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>();
    let first = differences(&values);
    [sum(&values), sum(&first), sum(&differences(&first))]
}

/// The finer cells that a spline reaches: two before twice its number, and one after.
fn reached(coarse: usize, n: usize) -> std::ops::Range<usize> {
    (2 * coarse).saturating_sub(2)..(2 * coarse + 2).min(n)
}

/// Which splines reach usable finer ones alone.
fn on_free_alone(usable: &[bool], size: (usize, usize), coarse: (usize, usize)) -> Vec<bool> {
    let mut out = vec![false; coarse.0 * coarse.1];
    out.par_chunks_mut(coarse.1).with_min_len(rows_per_task(size.1)).enumerate().for_each(|(row, out)| {
        for (col, out) in out.iter_mut().enumerate() {
            let cols = reached(col, size.1);
            *out = reached(row, size.0)
                .all(|row| usable[row * size.1 + cols.start..row * size.1 + cols.end].iter().all(|&u| u));
        }
    });
    out
}

/// Products of a function with all splines of a level.
fn restrict(fine: &[f32], (rows, cols): (usize, usize), coarse: &mut [f32], size: (usize, usize)) {
    coarse.par_chunks_mut(size.1).with_min_len(rows_per_task(cols)).enumerate().for_each_init(
        Vec::new,
        |sums: &mut Vec<f32>, (row, out)| {
            // Two cells of margin before and after spare the ends their own rule.
            sums.clear();
            sums.resize(2 * size.1 + 2, 0.0);
            for (k, c) in [0.25_f32, 0.75, 0.75, 0.25].into_iter().enumerate() {
                let Some(fine_row) = (2 * row + k).checked_sub(2).filter(|&row| row < rows) else { continue };
                let line = &fine[fine_row * cols..(fine_row + 1) * cols];
                for (sum, &value) in sums[2..].iter_mut().zip(line) {
                    *sum += c * value;
                }
            }
            for (out, w) in out.iter_mut().zip(sums.windows(4).step_by(2)) {
                *out = 0.25 * (w[0] + w[3]) + 0.75 * (w[1] + w[2]);
            }
        },
    );
}

/// One row of the splines of a level, on cells of half their size.
fn prolong_row(
    coarse: &[f32],
    size: (usize, usize),
    row: usize,
    buffer: &mut Vec<f32>,
    mut hear: impl FnMut(usize, f32),
    cols: usize,
) {
    let line = |row: usize| &coarse[row * size.1..(row + 1) * size.1];
    let (near, far) = if row.is_multiple_of(2) { (row / 2, row / 2 + 1) } else { (row / 2 + 1, row / 2) };
    buffer.clear();
    buffer.extend(line(near).iter().zip(line(far)).map(|(near, far)| 0.75 * near + 0.25 * far));
    for (j, pair) in buffer.windows(2).enumerate() {
        let col = 2 * j;
        if col < cols {
            hear(col, 0.75 * pair[0] + 0.25 * pair[1]);
        }
        if col + 1 < cols {
            hear(col + 1, 0.25 * pair[0] + 0.75 * pair[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::{CellSize, gaussian};

    /// A plate whose free cells are a disc.
    fn disc(size: (usize, usize), radius: f64) -> Vec<bool> {
        let middle = [size.0 as f64 / 2.0, size.1 as f64 / 2.0];
        (0..size.0 * size.1)
            .map(|i| libm::hypot((i / size.1) as f64 - middle[0], (i % size.1) as f64 - middle[1]) < radius)
            .collect()
    }

    #[test]
    fn the_preconditioner_is_symmetric_positive_and_bounded() {
        let size = (37, 45);
        let free = disc(size, 15.0);
        let bending = Bending::new(size, CellSize { x: 20.0, y: 25.0 }, 100.0);
        let mut levels = Levels::new(&bending, &free);
        assert!(levels.coarse.len() >= 2);
        let mut apply = |x: &[f32]| {
            let mut out = vec![0.0; x.len()];
            levels.apply(x, &mut out, |_, _, _| ());
            (0..x.len()).for_each(|i| out[i] *= f32::from(u8::from(free[i])));
            out
        };
        let random = |which: u64| -> Vec<f32> {
            let number = |i: usize| gaussian(7, which, i as i64, 0) as f32;
            (0..free.len()).map(|i| if free[i] { number(i) } else { 0.0 }).collect()
        };
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
        let (a, b) = (random(1), random(2));
        let (left, right) = (dot(&apply(&a), &b), dot(&a, &apply(&b)));
        assert!((left - right).abs() < 1e-4 * left.abs().max(1.0), "{left} {right}");
        assert!(dot(&apply(&a), &a) > 0.0);
        assert!(free.iter().zip(apply(&a)).all(|(free, value)| *free || value == 0.0));
    }

    #[test]
    fn restriction_is_the_transpose_of_prolongation() {
        for (rows, cols) in [(9, 12), (10, 7), (4, 5)] {
            let size = (coarser(rows), coarser(cols));
            let fine: Vec<f32> = (0..rows * cols).map(|i| gaussian(3, 1, i as i64, 0) as f32).collect();
            let coarse: Vec<f32> = (0..size.0 * size.1).map(|i| gaussian(3, 2, i as i64, 0) as f32).collect();
            let mut restricted = vec![0.0; coarse.len()];
            restrict(&fine, (rows, cols), &mut restricted, size);
            let mut sum = 0.0;
            for row in 0..rows {
                prolong_row(
                    &coarse,
                    size,
                    row,
                    &mut Vec::new(),
                    |col, v| sum += f64::from(fine[row * cols + col] * v),
                    cols,
                );
            }
            let other: f64 = restricted.iter().zip(&coarse).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
            assert!((sum - other).abs() < 1e-4, "{sum} {other}");
        }
    }
}
