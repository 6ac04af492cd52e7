//! The last few rows of something that is made row by row.

/// The last `N` rows, over each other in turn.
pub(super) struct Rolling<const N: usize> {
    rows: Vec<f32>,
    len: usize,
}

impl<const N: usize> Rolling<N> {
    /// Rows of `len` values, all zero.
    pub(super) fn new(len: usize) -> Self {
        Self { rows: vec![0.0; N * len], len }
    }

    /// Row `row`, to be made; it takes the place of the one `N` before.
    #[inline(always)]
    pub(super) fn row(&mut self, row: usize) -> &mut [f32] {
        &mut self.rows[row % N * self.len..][..self.len]
    }

    /// Row `row`, which was made.
    #[inline(always)]
    pub(super) fn made(&self, row: usize) -> &[f32] {
        &self.rows[row % N * self.len..][..self.len]
    }

    /// Row `row` between its neighbours.
    #[inline(always)]
    pub(super) fn around(&self, row: usize) -> [&[f32]; 3] {
        [row + N - 1, row, row + 1].map(|row| self.made(row))
    }
}
