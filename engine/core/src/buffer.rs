//! Memory for the cells of a raster.
//!
//! A fresh large allocation comes from the kernel a 4 KiB page at a time, and for quick work on whole rasters
//! those page faults cost as much as the work. Linux hands out 2 MiB at a time to who asks for it.

use std::{
    fmt,
    ops::{Deref, DerefMut},
};

use bytemuck::{Pod, allocation::try_zeroed_vec};

/// A fixed number of cells.
pub(crate) struct Buffer<T: 'static>(Store<T>);

enum Store<T: 'static> {
    Heap(Vec<T>),
    /// Memory of someone else that stays. A copy of it is memory of our own.
    Lent(&'static [T]),
    #[cfg(target_os = "linux")]
    Pages {
        pages: memmap2::MmapMut,
        cell: std::marker::PhantomData<T>,
    },
}

/// From how many bytes on pages of their own are worth asking for: a few huge pages.
#[cfg(target_os = "linux")]
const LARGE: usize = 8 << 20;

impl<T: Pod> Buffer<T> {
    /// `len` cells of zero bits, which take no memory until they are touched; `None` where there is not enough.
    pub(crate) fn zeroed(len: usize) -> Option<Self> {
        #[cfg(target_os = "linux")]
        if let Some(bytes) = len.checked_mul(size_of::<T>()).filter(|&bytes| bytes >= LARGE) {
            let pages = memmap2::MmapMut::map_anon(bytes).ok()?;
            // Advice: where the kernel does not take it, small pages do as well.
            let _ = pages.advise(memmap2::Advice::HugePage);
            return Some(Self(Store::Pages { pages, cell: std::marker::PhantomData }));
        }
        Some(Self(Store::Heap(try_zeroed_vec(len).ok()?)))
    }

    /// The cells that `bytes` hold, which need not be aligned; `None` where the memory is lacking.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let mut cells = Self::zeroed(bytes.len() / size_of::<T>())?;
        let filled = size_of_val::<[T]>(&cells);
        bytemuck::cast_slice_mut::<T, u8>(&mut cells).copy_from_slice(&bytes[..filled]);
        Some(cells)
    }

    /// Cells that someone else keeps.
    pub(crate) const fn lent(cells: &'static [T]) -> Self {
        Self(Store::Lent(cells))
    }

    /// The cells as a vector.
    pub(crate) fn into_vec(self) -> Vec<T> {
        match self.0 {
            Store::Heap(cells) => cells,
            Store::Lent(cells) => cells.to_vec(),
            #[cfg(target_os = "linux")]
            Store::Pages { pages, .. } => bytemuck::cast_slice(&pages).to_vec(),
        }
    }
}

impl<T> From<Vec<T>> for Buffer<T> {
    fn from(cells: Vec<T>) -> Self {
        Self(Store::Heap(cells))
    }
}

impl<T: Pod> Deref for Buffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Store::Heap(cells) => cells,
            Store::Lent(cells) => cells,
            #[cfg(target_os = "linux")]
            Store::Pages { pages, .. } => bytemuck::cast_slice(pages),
        }
    }
}

impl<T: Pod> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        if let Store::Lent(cells) = self.0 {
            self.0 = Store::Heap(cells.to_vec());
        }
        match &mut self.0 {
            Store::Heap(cells) => cells,
            // Made our own above.
            Store::Lent(_) => &mut [],
            #[cfg(target_os = "linux")]
            Store::Pages { pages, .. } => bytemuck::cast_slice_mut(pages),
        }
    }
}

impl<T: Pod> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        match Self::zeroed(self.len()) {
            Some(mut copy) => {
                copy.copy_from_slice(self);
                copy
            }
            // The allocator's own way of saying that there is no memory.
            None => self.to_vec().into(),
        }
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_buffers_behave_alike() {
        for len in [0, 1, 1000, (8 << 20) / 4 - 1, (8 << 20) / 4, 3_000_001] {
            let mut cells = Buffer::<f32>::zeroed(len).unwrap();
            assert_eq!(cells.len(), len);
            assert!(cells.iter().all(|&cell| cell == 0.0));
            if let Some(last) = cells.last_mut() {
                *last = 7.0;
            }
            let again = Buffer::<f32>::of_bytes(bytemuck::cast_slice(&cells)).unwrap();
            assert_eq!(again[..], cells[..]);
            assert_eq!(cells.clone().into_vec(), again.into_vec());
        }
    }

    #[test]
    fn lent_cells_are_read_in_place_and_written_elsewhere() {
        static CELLS: [f32; 3] = [1.0, 2.0, 3.0];
        let mut lent = Buffer::lent(&CELLS);
        assert!(std::ptr::eq(&*lent, &CELLS[..]));
        assert!(!std::ptr::eq(&*lent.clone(), &CELLS[..]));
        lent[1] = 7.0;
        assert_eq!((lent.into_vec(), CELLS), (vec![1.0, 7.0, 3.0], [1.0, 2.0, 3.0]));
    }

    #[test]
    fn absurd_sizes_are_refused() {
        assert!(Buffer::<f32>::zeroed(usize::MAX).is_none());
        assert!(Buffer::<f32>::zeroed(usize::MAX / 8).is_none());
    }
}
