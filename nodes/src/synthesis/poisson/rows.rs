//! Work on framed arrays, some rows at a time: several lots at once where that pays, each in the widest registers there
//! are. Frames are worked on like cells that are not free, as breaks at every row cost more.

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::{
    masked::Cell,
    network::{Around, Finest},
};

/// Values in an array from which lots of rows are worked on in parallel.
pub(super) const PARALLEL: usize = 1 << 15;
/// Rows of a lot. A number of its own, so that no sum depends on that of threads.
pub(super) const ROWS: usize = 16;

/// What `f` gives for each `lot` of values, by where it starts, in order.
pub(super) fn each<T: Send, R: Send>(
    values: &mut [T],
    lot: usize,
    f: impl Fn(usize, &mut [T]) -> R + Sync,
) -> Vec<R> {
    if values.len() < PARALLEL {
        values.chunks_mut(lot).enumerate().map(|(i, values)| f(i * lot, values)).collect()
    } else {
        values.par_chunks_mut(lot).enumerate().map(|(i, values)| f(i * lot, values)).collect()
    }
}

/// [`each`] of two arrays side by side, by where the lot of the first starts.
pub(super) fn each_two<T: Send, U: Send, R: Send>(
    (values, lot): (&mut [T], usize),
    (others, other_lot): (&mut [U], usize),
    f: impl Fn(usize, &mut [T], &mut [U]) -> R + Sync,
) -> Vec<R> {
    if values.len() < PARALLEL {
        let lots = values.chunks_mut(lot).zip(others.chunks_mut(other_lot)).enumerate();
        lots.map(|(i, (values, others))| f(i * lot, values, others)).collect()
    } else {
        let lots = values.par_chunks_mut(lot).zip(others.par_chunks_mut(other_lot)).enumerate();
        lots.map(|(i, (values, others))| f(i * lot, values, others)).collect()
    }
}

/// What is left, in single precision.
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
    pub(super) along: &'a mut [f32],
    pub(super) solution: &'a mut [f64],
    /// How far the solution goes along.
    pub(super) length: f64,
    pub(super) correction: &'a [f32],
    /// What the correction is to be taken times.
    pub(super) scale: f32,
    /// How much of the way before stays.
    pub(super) share: f32,
}

impl NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { along, solution, length, correction, scale, share } = self;
        for ((along, solution), correction) in along.iter_mut().zip(solution).zip(correction) {
            *solution += length * f64::from(*along);
            *along = correction * scale + share * *along;
        }
    }
}

/// The matrix of the finest level, in double precision. `HELD` says whether there are holds.
#[derive(Clone, Copy)]
pub(super) struct Equations<'a, const HELD: bool>(pub(super) Finest<'a>);

impl<const HELD: bool> Equations<'_, HELD> {
    /// The matrix times `x` for as many cells as `out` has, from `first` on, as the frame counts.
    #[inline(always)]
    fn times(&self, x: &[f32], first: usize, out: &mut [f64]) {
        let Finest { cells, holds, weights, stride } = self.0;
        let [across, down] = weights;
        let n = out.len();
        let cells = Around::new(cells, first, n, stride);
        let own = &x[first..][..n];
        let (west, east) = (&x[first - 1..][..n], &x[first + 1..][..n]);
        let (north, south) = (&x[first - stride..][..n], &x[first + stride..][..n]);
        let holds = if HELD { &holds[first..][..n] } else { holds };
        for k in 0..n {
            let sides = cells.sides(k, weights);
            let diagonal = if HELD { sides + holds[k] } else { sides };
            let flow = across * (f64::from(west[k]) + f64::from(east[k]))
                + down * (f64::from(north[k]) + f64::from(south[k]));
            let value = diagonal * f64::from(own[k]) - flow;
            out[k] = if cells.own[k] == Cell::Free { value } else { 0.0 };
        }
    }
}

/// The scalar product of a way with the matrix times it, over `rows` rows.
pub(super) struct Curvature<'a, const HELD: bool> {
    pub(super) equations: Equations<'a, HELD>,
    pub(super) along: &'a [f32],
    /// Where they start, as the frame counts.
    pub(super) first: usize,
    pub(super) rows: usize,
}

impl<const HELD: bool> NullaryFnOnce for Curvature<'_, HELD> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { equations, along, first, rows } = self;
        let stride = equations.0.stride;
        let mut image = vec![0.0; stride];
        let mut sum = 0.0;
        for row in 0..rows {
            let first = first + row * stride;
            equations.times(along, first, &mut image);
            sum += products(&image, &along[first..][..stride]).0;
        }
        sum
    }
}

/// Takes `length` times the matrix times a way from what is left of some rows.
pub(super) struct Subtract<'a, const HELD: bool> {
    pub(super) equations: Equations<'a, HELD>,
    pub(super) along: &'a [f32],
    /// Where they start, as the frame counts.
    pub(super) first: usize,
    pub(super) length: f64,
    pub(super) rest: &'a mut [f64],
    /// What is left in single precision, times `scale`.
    pub(super) scale: f64,
    pub(super) scaled: &'a mut [f32],
}

impl<const HELD: bool> NullaryFnOnce for Subtract<'_, HELD> {
    /// The largest size of what is left.
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { equations, along, first, length, rest, scale, scaled } = self;
        let stride = equations.0.stride;
        let mut image = vec![0.0; stride];
        let mut most = 0.0;
        for (row, (rest, scaled)) in rest.chunks_mut(stride).zip(scaled.chunks_mut(stride)).enumerate() {
            equations.times(along, first + row * stride, &mut image);
            for ((rest, scaled), image) in rest.iter_mut().zip(scaled).zip(&image) {
                *rest -= length * image;
                *scaled = (*rest * scale) as f32;
            }
            most = larger(most, largest(rest));
        }
        most
    }
}

struct Dot<'a>(&'a [f64], &'a [f32]);

impl NullaryFnOnce for Dot<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn call(self) -> (f64, f64) {
        products(self.0, self.1)
    }
}

/// The scalar product, in eight sums side by side, whatever the width of the registers, and the largest size in `b`.
#[inline(always)]
fn products(a: &[f64], b: &[f32]) -> (f64, f64) {
    let (mut sums, mut most) = ([0.0; 8], [0.0_f32; 8]);
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rests = a.remainder().iter().zip(b.remainder());
    let rest = rests.fold((0.0, 0.0), |(sum, most), (a, &b)| (sum + a * f64::from(b), larger(most, b.abs())));
    for (a, b) in a.zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * f64::from(b[lane]);
            most[lane] = larger(most[lane], b[lane].abs());
        }
    }
    (sums.iter().sum::<f64>() + rest.0, f64::from(most.into_iter().fold(rest.1, larger)))
}

/// The larger, by one comparison.
#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The largest size, in eight lanes side by side.
#[inline(always)]
pub(super) fn largest(values: &[f64]) -> f64 {
    let mut most = [0.0; 8];
    let (lanes, last) = values.as_chunks::<8>();
    for values in lanes {
        for lane in 0..8 {
            most[lane] = larger(most[lane], values[lane].abs());
        }
    }
    greatest(most.into_iter().chain(last.iter().map(|value| value.abs())))
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
