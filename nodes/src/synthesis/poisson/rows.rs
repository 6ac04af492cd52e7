//! Work on framed arrays, some rows at a time: several lots at once where that pays, each in the widest registers there
//! are. Frames are worked on like cells that are not free, as breaks at every row cost more.

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Values in an array from which lots of rows are worked on in parallel.
pub(super) const PARALLEL: usize = 1 << 16;
/// Rows of a lot. A number of its own, so that no sum depends on that of threads.
const ROWS: usize = 16;

/// What `f` gives for each lot of rows, by where it starts, in order.
pub(super) fn each<T: Send, R: Send>(
    values: &mut [T],
    stride: usize,
    f: impl Fn(usize, &mut [T]) -> R + Sync,
) -> Vec<R> {
    let lot = ROWS * stride;
    if values.len() < PARALLEL {
        values.chunks_mut(lot).enumerate().map(|(i, values)| f(i * lot, values)).collect()
    } else {
        values.par_chunks_mut(lot).enumerate().map(|(i, values)| f(i * lot, values)).collect()
    }
}

/// `n` values, made by where they lie.
pub(super) fn made<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    if n < PARALLEL {
        (0..n).map(f).collect()
    } else {
        (0..n).into_par_iter().with_min_len(PARALLEL / 4).map(f).collect()
    }
}

/// [`each`] of two arrays side by side.
pub(super) fn each_two<T: Send, U: Send>(
    (values, others): (&mut [T], &mut [U]),
    stride: usize,
    f: impl Fn(usize, &mut [T], &mut [U]) + Sync,
) {
    let lot = ROWS * stride;
    if values.len() < PARALLEL {
        let lots = values.chunks_mut(lot).zip(others.chunks_mut(lot)).enumerate();
        lots.for_each(|(i, (values, others))| f(i * lot, values, others));
    } else {
        let lots = values.par_chunks_mut(lot).zip(others.par_chunks_mut(lot)).enumerate();
        lots.for_each(|(i, (values, others))| f(i * lot, values, others));
    }
}

/// What is left, in single precision and as a share of its largest.
pub(super) struct Scaled<'a> {
    pub(super) rest: &'a [f64],
    pub(super) scale: f64,
    pub(super) out: &'a mut [f32],
}

impl NullaryFnOnce for Scaled<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (out, rest) in self.out.iter_mut().zip(self.rest) {
            *out = (rest * self.scale) as f32;
        }
    }
}

/// The way that was found goes into the solution, and turns by a correction.
pub(super) struct Turn<'a> {
    pub(super) along: &'a mut [f64],
    pub(super) solution: &'a mut [f64],
    /// How far the solution goes along.
    pub(super) length: f64,
    pub(super) correction: &'a [f32],
    /// What the correction is to be taken times.
    pub(super) largest: f64,
    /// How much of the way before stays.
    pub(super) share: f64,
}

impl NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { along, solution, length, correction, largest, share } = self;
        for ((along, solution), correction) in along.iter_mut().zip(solution).zip(correction) {
            *solution += length * *along;
            *along = f64::from(*correction) * largest + share * *along;
        }
    }
}

/// Some rows of a matrix times `x`.
pub(super) struct Apply<'a> {
    pub(super) x: &'a [f64],
    pub(super) diagonal: &'a [f64],
    pub(super) weights: [f64; 2],
    pub(super) stride: usize,
    /// Where they start in the framed arrays.
    pub(super) first: usize,
    pub(super) out: &'a mut [f64],
}

impl NullaryFnOnce for Apply<'_> {
    /// The scalar product of what went in and what came out.
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { x, diagonal, weights: [across, down], stride, first, out } = self;
        let n = out.len();
        let shifted = |start: usize| &x[start..][..n];
        let (west, own, east) = (shifted(first - 1), shifted(first), shifted(first + 1));
        let (north, south) = (shifted(first - stride), shifted(first + stride));
        let diagonal = &diagonal[first..][..n];
        for k in 0..n {
            let value = diagonal[k] * own[k] - across * (west[k] + east[k]) - down * (north[k] + south[k]);
            out[k] = if diagonal[k] == 0.0 { 0.0 } else { value };
        }
        sum_of_products(out, own)
    }
}

/// In eight sums side by side, whatever the width of the registers.
#[inline(always)]
fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

struct Dot<'a>(&'a [f64], &'a [f32]);

impl NullaryFnOnce for Dot<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn call(self) -> (f64, f64) {
        let (mut sums, mut most) = ([0.0; 8], [0.0_f32; 8]);
        let (a, b) = (self.0.chunks_exact(8), self.1.chunks_exact(8));
        let rests = a.remainder().iter().zip(b.remainder());
        let rest =
            rests.fold((0.0, 0.0), |(sum, most), (a, &b)| (sum + a * f64::from(b), larger(most, b.abs())));
        for (a, b) in a.zip(b) {
            for lane in 0..8 {
                sums[lane] += a[lane] * f64::from(b[lane]);
                most[lane] = larger(most[lane], b[lane].abs());
            }
        }
        (sums.iter().sum::<f64>() + rest.0, f64::from(most.into_iter().fold(rest.1, larger)))
    }
}

/// Takes `length` times `image` from `rest`.
pub(super) struct Subtract<'a> {
    pub(super) rest: &'a mut [f64],
    pub(super) image: &'a [f64],
    pub(super) length: f64,
}

impl NullaryFnOnce for Subtract<'_> {
    /// The largest size of what is left.
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut most = [0.0; 8];
        let (rest, last) = self.rest.as_chunks_mut::<8>();
        let (image, last_image) = self.image.as_chunks::<8>();
        for (rest, image) in rest.iter_mut().zip(image) {
            for lane in 0..8 {
                rest[lane] -= self.length * image[lane];
                most[lane] = larger(most[lane], rest[lane].abs());
            }
        }
        for (rest, image) in last.iter_mut().zip(last_image) {
            *rest -= self.length * image;
            most[0] = larger(most[0], rest.abs());
        }
        most.into_iter().fold(0.0, larger)
    }
}

/// The larger, by one comparison.
#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Of each lot of rows, the scalar product with `b` and the largest size in `b`.
pub(super) fn dot(a: &[f64], b: &[f32], stride: usize) -> Vec<(f64, f64)> {
    let (arch, lot) = (Arch::new(), ROWS * stride);
    let of_lot = |(a, b): (&[f64], &[f32])| arch.dispatch(Dot(a, b));
    if a.len() < PARALLEL {
        a.chunks(lot).zip(b.chunks(lot)).map(of_lot).collect()
    } else {
        a.par_chunks(lot).zip(b.par_chunks(lot)).map(of_lot).collect()
    }
}

/// The largest of sizes; 0 of none.
pub(super) fn greatest(sizes: impl IntoIterator<Item = f64>) -> f64 {
    sizes.into_iter().fold(0.0, larger)
}
