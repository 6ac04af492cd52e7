//! Work cell by cell, in registers as wide as the machine has.
//!
//! The loops stand here and not in closures of the nodes: what is to run in wide registers must be inlined into
//! the function that switches them on, and closures with loops in them escape that. No result depends on the
//! width: each cell is worked out by itself, with the same operations in the same order.

use pulp::{Arch, NullaryFnOnce};

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
