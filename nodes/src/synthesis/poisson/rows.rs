//! Work on framed arrays, some rows at a time: several lots at once where that pays, each in the widest registers there
//! are. Frames are worked on like cells that are not free, as breaks at every row cost more.

use std::ops::Range;

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Values in an array from which lots of rows are worked on in parallel.
const PARALLEL: usize = 1 << 16;
/// Rows of a lot. A number of its own, so that no sum depends on that of threads.
const ROWS: usize = 16;

/// Makes the values that lie at `range` of a framed array.
pub(super) trait Kernel: Sync {
    /// Whether it needs to be given rows one by one, without their frame.
    const BY_ROW: bool = false;

    fn run(&self, range: Range<usize>, out: &mut [f32]);
}

struct Lot<'a, K> {
    kernel: &'a K,
    cols: usize,
    start: usize,
    out: &'a mut [f32],
}

impl<K: Kernel> NullaryFnOnce for Lot<'_, K> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { kernel, cols, start, out } = self;
        if !K::BY_ROW {
            return kernel.run(start..start + out.len(), out);
        }
        for (row, out) in out.chunks_mut(cols + 2).enumerate() {
            let first = start + row * (cols + 2) + 1;
            kernel.run(first..first + cols, &mut out[1..=cols]);
        }
    }
}

/// Makes all rows of an array with `cols` columns in its frame but the frame's own.
pub(super) fn fill(out: &mut [f32], cols: usize, kernel: &impl Kernel) {
    let (stride, arch) = (cols + 2, Arch::new());
    let inner = stride..out.len() - stride;
    each(&mut out[inner], stride, |start, out| {
        arch.dispatch(Lot { kernel, cols, start: start + stride, out });
    });
}

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
        for (rest, image) in self.rest.chunks_mut(8).zip(self.image.chunks(8)) {
            for ((rest, image), most) in rest.iter_mut().zip(image).zip(&mut most) {
                *rest -= self.length * image;
                *most = larger(*most, rest.abs());
            }
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
