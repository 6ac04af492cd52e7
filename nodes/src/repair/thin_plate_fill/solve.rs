//! The plate through known cells: corrections by preconditioned conjugate gradients, to a surface of more digits.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    bending::{Bending, rows_per_task},
    levels::Levels,
    start::start,
};

/// Bytes for each cell of a plate: the surface and its derivative, four vectors of the iteration, the means that the first
/// guess is made of, and the splines.
pub(super) const BYTES: u64 = 2 * 8 + 4 * 4 + 2 + 24 + Levels::BYTES;

/// Share of the bending energy at the start that the error may have at the end, and that of a correction's own.
const ERROR: f64 = 1e-9;
const CORRECTION: f64 = 1e-6;

/// Most corrections, and steps in each. Two dozen steps reduce the error tenfold on plates of any size.
const CORRECTIONS: usize = 8;
const STEPS: usize = 300;

/// Fills the cells of a plate that are `free` with the surface that bends least; the others are known. `tell` hears which
/// share of the digits is found.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn solve(
    heights: &[f64],
    free: &[bool],
    size: (usize, usize),
    cell: CellSize,
    stiff: f64,
    job: &Job<'_>,
    mut tell: impl FnMut(f64),
) -> Result<Vec<f64>> {
    let cols = size.1;
    let bending = Bending::new(size, cell, stiff);
    let mut iteration = Iteration::new(&bending, free);
    let mut surface = start(heights, free, size, job)?;
    let mut derivative = vec![0.0; surface.len()];
    let (mut first, mut before) = (None, f64::INFINITY);
    for _ in 0..CORRECTIONS {
        let residual = &mut iteration.residual;
        bending.derivative(&surface, &mut derivative, |_, _| ());
        for (((residual, value), &free), image) in
            residual.iter_mut().zip(&derivative).zip(free).zip(&mut iteration.correction)
        {
            *residual = if free { -*value as f32 } else { 0.0 };
            *image = 0.0;
        }
        let error = iteration.begin();
        let all = *first.get_or_insert(error);
        let wanted = ERROR * all;
        // NaN ends it, too, and so does what cannot be bettered with the digits that there are.
        if !(error > wanted && error < before) {
            break;
        }
        before = error;
        iteration.run(error, wanted.max(CORRECTION * error), job, |left| {
            tell(libm::log(left / all) / libm::log(ERROR));
        })?;
        surface
            .par_chunks_mut(cols)
            .zip(iteration.correction.par_chunks(cols))
            .with_min_len(rows_per_task(cols))
            .for_each(|(surface, correction)| {
                surface.iter_mut().zip(correction).for_each(|(height, by)| *height += f64::from(*by));
            });
    }
    Ok(surface)
}

/// Conjugate gradients for a correction.
struct Iteration<'a> {
    bending: &'a Bending,
    free: &'a [bool],
    levels: Levels,
    correction: Vec<f32>,
    residual: Vec<f32>,
    direction: Vec<f32>,
    image: Vec<f32>,
}

impl<'a> Iteration<'a> {
    fn new(bending: &'a Bending, free: &'a [bool]) -> Self {
        let levels = Levels::new(bending, free);
        let [correction, residual, direction, image] = [(); 4].map(|()| vec![0.0; free.len()]);
        Self { bending, free, levels, correction, residual, direction, image }
    }

    /// Sets out for the residual; returns an estimate of the error's bending energy.
    fn begin(&mut self) -> f64 {
        let error = self.precondition();
        self.direction.copy_from_slice(&self.image);
        error
    }

    /// Steps until the error has at most the energy `wanted`; `tell` hears what it has after each.
    fn run(&mut self, mut error: f64, wanted: f64, job: &Job<'_>, mut tell: impl FnMut(f64)) -> Result<()> {
        let cols = self.bending.size.1;
        for _ in 0..STEPS {
            job.check()?;
            let bent = self.bend();
            if bent.is_nan() || bent <= 0.0 {
                break;
            }
            let step = (error / bent) as f32;
            let lines = self.correction.par_chunks_mut(cols).zip(self.residual.par_chunks_mut(cols));
            lines
                .zip(self.direction.par_chunks(cols).zip(self.image.par_chunks(cols)))
                .with_min_len(rows_per_task(cols))
                .for_each(|((correction, residual), (direction, image))| {
                    let pairs = direction.iter().zip(image);
                    for ((correction, residual), (direction, image)) in
                        correction.iter_mut().zip(residual).zip(pairs)
                    {
                        *correction += step * direction;
                        *residual -= step * image;
                    }
                });
            let next = self.precondition();
            if next.is_nan() || next <= wanted {
                break;
            }
            tell(next);
            let turn = (next / error) as f32;
            error = next;
            self.direction
                .par_chunks_mut(cols)
                .zip(self.image.par_chunks(cols))
                .with_min_len(rows_per_task(cols))
                .for_each(|(direction, image)| {
                    let pairs = direction.iter_mut().zip(image);
                    pairs.for_each(|(direction, image)| *direction = image + turn * *direction);
                });
        }
        Ok(())
    }

    /// The derivative along the direction, into `image`; their product.
    fn bend(&mut self) -> f64 {
        let (cols, free) = (self.bending.size.1, self.free);
        let direction = &self.direction;
        let rows = self.bending.derivative(direction, &mut self.image, |row, out| {
            hold(out, &free[row * cols..]);
            dot(&direction[row * cols..(row + 1) * cols], out)
        });
        rows.into_iter().sum()
    }

    /// The preconditioned residual, into `image`; their product.
    fn precondition(&mut self) -> f64 {
        let (cols, free) = (self.bending.size.1, self.free);
        let rows = self.levels.apply(&self.residual, &mut self.image, |row, residual, out| {
            hold(out, &free[row * cols..]);
            dot(residual, out)
        });
        rows.into_iter().sum()
    }
}

/// Zero where the plate is held.
fn hold(values: &mut [f32], free: &[bool]) {
    values.iter_mut().zip(free).for_each(|(value, &free)| *value = if free { *value } else { 0.0 });
}

/// Products summed in sixteen lanes, in a fixed order.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let mut sums = [0.0_f32; 16];
    let (left, right) = (a.chunks_exact(16), b.chunks_exact(16));
    let rest: f32 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum::<f64>() + f64::from(rest)
}
