//! Work cell by cell, in registers as wide as the machine has.
//!
//! The loops stand here and not in closures of the nodes: what is to run in wide registers must be inlined into
//! the function that switches them on, and closures with loops in them escape that. No result depends on the
//! width: each cell is worked out by itself, with the same operations in the same order.

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use crate::{Job, Kind, Raster, Result};

impl<K: Kind> Raster<K> {
    /// A raster of another kind (or the same) made cell by cell, in parallel.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn map<T: Kind>(&self, job: &Job, f: impl Fn(K::Cell) -> T::Cell + Sync) -> Result<Raster<T>> {
        let arch = Arch::new();
        Raster::<T>::build_over(self.grid().clone(), job, |row, out| {
            arch.dispatch(One { out, a: self.row(row), f: &f });
        })
    }

    /// A raster made of each cell and the cell of `other` at the same row and column, in parallel. It lies where
    /// this one lies.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`](crate::Error::DimensionMismatch) when `other` has another size, and as
    /// [`build`](Self::build).
    pub fn map_with<B: Kind, T: Kind>(
        &self,
        other: &Raster<B>,
        job: &Job,
        f: impl Fn(K::Cell, B::Cell) -> T::Cell + Sync,
    ) -> Result<Raster<T>> {
        self.grid().match_size("a", other.grid(), "b")?;
        let arch = Arch::new();
        Raster::<T>::build_over(self.grid().clone(), job, |row, out| {
            arch.dispatch(Two { out, a: self.row(row), b: other.row(row), f: &f });
        })
    }

    /// As [`map_with`](Self::map_with), with a mask beside.
    ///
    /// # Errors
    /// As [`map_with`](Self::map_with).
    pub fn map_with_mask<B: Kind, T: Kind>(
        &self,
        other: &Raster<B>,
        mask: &crate::Mask,
        job: &Job,
        f: impl Fn(K::Cell, B::Cell, f32) -> T::Cell + Sync,
    ) -> Result<Raster<T>> {
        self.grid().match_size("a", other.grid(), "b")?;
        self.grid().match_size("a", mask.grid(), "mask")?;
        let arch = Arch::new();
        Raster::<T>::build_over(self.grid().clone(), job, |row, out| {
            arch.dispatch(Three { out, a: self.row(row), b: other.row(row), mask: mask.row(row), f: &f });
        })
    }
}

struct One<'a, A, T, F> {
    out: &'a mut [T],
    a: &'a [A],
    f: &'a F,
}

impl<A: Copy, T, F: Fn(A) -> T> NullaryFnOnce for One<'_, A, T, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (out, &a) in self.out.iter_mut().zip(self.a) {
            *out = (self.f)(a);
        }
    }
}

struct Two<'a, A, B, T, F> {
    out: &'a mut [T],
    a: &'a [A],
    b: &'a [B],
    f: &'a F,
}

impl<A: Copy, B: Copy, T, F: Fn(A, B) -> T> NullaryFnOnce for Two<'_, A, B, T, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for ((out, &a), &b) in self.out.iter_mut().zip(self.a).zip(self.b) {
            *out = (self.f)(a, b);
        }
    }
}

struct Three<'a, A, B, T, F> {
    out: &'a mut [T],
    a: &'a [A],
    b: &'a [B],
    mask: &'a [f32],
    f: &'a F,
}

impl<A: Copy, B: Copy, T, F: Fn(A, B, f32) -> T> NullaryFnOnce for Three<'_, A, B, T, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (((out, &a), &b), &share) in self.out.iter_mut().zip(self.a).zip(self.b).zip(self.mask) {
            *out = (self.f)(a, b, share);
        }
    }
}

/// Cells that one task goes through.
const PART: usize = 1 << 16;
/// Running results kept apart, one for each lane of the widest register.
const LANES: usize = 16;

/// Lowest and highest of the cells that are no voids. No order counts here, so that the threads' does not either.
pub(crate) fn range(cells: &[f32]) -> Option<(f32, f32)> {
    let arch = Arch::new();
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    let join = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    let (low, high) = cells.par_chunks(PART).map(|part| arch.dispatch(Range(part))).reduce(|| none, join);
    // Of two zeros either may have won: both are 0 from here on.
    (low <= high).then_some((low + 0.0, high + 0.0))
}

/// How many cells are voids.
pub(crate) fn count_voids(cells: &[f32]) -> usize {
    let arch = Arch::new();
    cells.par_chunks(PART).map(|part| arch.dispatch(Voids(part))).sum()
}

struct Range<'a>(&'a [f32]);

impl NullaryFnOnce for Range<'_> {
    type Output = (f32, f32);

    #[inline(always)]
    fn call(self) -> (f32, f32) {
        let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        let lanes = self.0.chunks_exact(LANES);
        let rest = lanes.remainder();
        for cells in lanes {
            for ((low, high), &cell) in low.iter_mut().zip(&mut high).zip(cells) {
                // A void is neither lower nor higher.
                *low = if cell < *low { cell } else { *low };
                *high = if cell > *high { cell } else { *high };
            }
        }
        let low = low.iter().chain(rest).fold(f32::INFINITY, |low, &cell| low.min(cell));
        let high = high.iter().chain(rest).fold(f32::NEG_INFINITY, |high, &cell| high.max(cell));
        (low, high)
    }
}

struct Voids<'a>(&'a [f32]);

impl NullaryFnOnce for Voids<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        // A part's count fits 32 bits, which leaves more lanes than 64 would.
        self.0.iter().map(|cell| u32::from(cell.is_nan())).sum::<u32>() as usize
    }
}
