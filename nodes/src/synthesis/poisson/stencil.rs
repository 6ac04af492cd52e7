//! What a multigrid cycle does to one row of a level. Rows have a frame, one cell at either end, that stays 0.

/// The values of the cells of a row, without the frame, and of their neighbours.
pub(super) struct Near<'a> {
    here: &'a [f32],
    west: &'a [f32],
    east: &'a [f32],
    north: &'a [f32],
    south: &'a [f32],
}

impl<'a> Near<'a> {
    /// Of the middle one of three rows that have `n` cells within the frame.
    #[inline(always)]
    fn new([north, own, south]: [&'a [f32]; 3], n: usize) -> Self {
        Self {
            here: &own[1..][..n],
            west: &own[..n],
            east: &own[2..][..n],
            north: &north[1..][..n],
            south: &south[1..][..n],
        }
    }
}

/// What flows between the cells of a row and their neighbours.
pub(super) trait Row: Copy {
    /// Itself with room for `n` cells said, which spares looking at each.
    fn cut(self, n: usize) -> Self;
    /// What flows into cell `k`.
    fn flow(&self, near: &Near<'_>, k: usize) -> f32;
}

/// The same everywhere: the weights of steps along a row and along a column.
#[derive(Clone, Copy)]
pub(super) struct Alike(pub(super) [f32; 2]);

impl Row for Alike {
    #[inline(always)]
    fn cut(self, _: usize) -> Self {
        self
    }

    #[inline(always)]
    fn flow(&self, near: &Near<'_>, k: usize) -> f32 {
        let [across, down] = self.0;
        across * (near.west[k] + near.east[k]) + down * (near.north[k] + near.south[k])
    }
}

/// Weights of each cell's own.
#[derive(Clone, Copy)]
pub(super) struct Own<'a> {
    pub(super) west: &'a [f32],
    pub(super) east: &'a [f32],
    pub(super) north: &'a [f32],
    pub(super) south: &'a [f32],
}

impl Row for Own<'_> {
    #[inline(always)]
    fn cut(self, n: usize) -> Self {
        let Self { west, east, north, south } = self;
        Self { west: &west[..n], east: &east[..n], north: &north[..n], south: &south[..n] }
    }

    #[inline(always)]
    fn flow(&self, near: &Near<'_>, k: usize) -> f32 {
        self.west[k] * near.west[k]
            + self.east[k] * near.east[k]
            + self.north[k] * near.north[k]
            + self.south[k] * near.south[k]
    }
}

/// A row of what does not change in a cycle; all without the frame.
pub(super) struct Line<'a, R> {
    pub(super) matrix: R,
    pub(super) inverse: &'a [f32],
    /// How much of the coarser level's correction a cell takes; 0 for cells that are not free.
    pub(super) share: &'a [f32],
    pub(super) right: &'a [f32],
}

impl<R: Row> Line<'_, R> {
    /// The first sweep, from zero.
    #[inline(always)]
    pub(super) fn start(&self, weight: f32, out: &mut [f32]) {
        let (n, out) = within(out);
        let (inverse, right) = (&self.inverse[..n], &self.right[..n]);
        for k in 0..n {
            out[k] = weight * inverse[k] * right[k];
        }
    }

    /// A sweep over the middle one of three rows. Cells that are not free stay 0.
    #[inline(always)]
    pub(super) fn sweep(&self, weight: f32, rows: [&[f32]; 3], out: &mut [f32]) {
        let (n, out) = within(out);
        let (near, matrix) = (Near::new(rows, n), self.matrix.cut(n));
        let (inverse, right) = (&self.inverse[..n], &self.right[..n]);
        for k in 0..n {
            let exact = (right[k] + matrix.flow(&near, k)) * inverse[k];
            out[k] = near.here[k] + weight * (exact - near.here[k]);
        }
    }

    /// What is left of the right side for the coarser level to correct.
    #[inline(always)]
    pub(super) fn rest(&self, rows: [&[f32]; 3], out: &mut [f32]) {
        let (n, out) = within(out);
        let (near, matrix) = (Near::new(rows, n), self.matrix.cut(n));
        let (inverse, share, right) = (&self.inverse[..n], &self.share[..n], &self.right[..n]);
        for k in 0..n {
            let rest = right[k] - near.here[k] / inverse[k] + matrix.flow(&near, k);
            out[k] = if inverse[k] == 0.0 { 0.0 } else { share[k] * rest };
        }
    }

    /// The right side for the coarser level.
    pub(super) fn take(&self, out: &mut [f32]) {
        let (_, out) = within(out);
        out.iter_mut().zip(self.share).zip(self.right).for_each(|((out, share), right)| *out = share * right);
    }

    /// The values of a row with a row of the coarser level added, `coarse`, between whose cells they lie. A cell lies a
    /// quarter of a coarse one off the middle of its own, towards the one before or after.
    #[inline(always)]
    pub(super) fn spread(&self, coarse: &[f32], value: &[f32], out: &mut [f32]) {
        let (n, out) = within(out);
        let (share, value) = (&self.share[..n], &value[1..][..n]);
        let (pairs, rest) = out.as_chunks_mut::<2>();
        let (values, shares) = (value.as_chunks::<2>().0, share.as_chunks::<2>().0);
        let m = pairs.len();
        let (before, own, after) = (&coarse[..m], &coarse[1..][..m], &coarse[2..][..m]);
        for k in 0..m {
            let moved = [0.75 * own[k] + 0.25 * before[k], 0.75 * own[k] + 0.25 * after[k]];
            for i in 0..2 {
                pairs[k][i] = values[k][i] + shares[k][i] * moved[i];
            }
        }
        if let [last] = rest {
            *last = value[n - 1] + share[n - 1] * (0.75 * coarse[m + 1] + 0.25 * coarse[m]);
        }
    }
}

/// A row without its frame, and its length.
#[inline(always)]
fn within(row: &mut [f32]) -> (usize, &mut [f32]) {
    let n = row.len() - 2;
    (n, &mut row[1..][..n])
}

/// Four rows of a level gathered as one of the coarser level: the transpose of [`Line::spread`].
#[inline(always)]
pub(super) fn gather(rows: [&[f32]; 4], out: &mut [f32]) {
    const DOWN: [f32; 4] = [0.25, 0.75, 0.75, 0.25];
    // The last cell of an odd row has no cell beyond the frame.
    let whole = (rows[0].len() - 2) / 2;
    let pairs = |i: usize| &rows[i].as_chunks::<2>().0[..=whole];
    let pairs = [pairs(0), pairs(1), pairs(2), pairs(3)];
    let cells = &mut out[1..=whole];
    for k in 0..whole {
        let along = |i: usize| {
            let ([before, first], [second, after]) = (pairs[i][k], pairs[i][k + 1]);
            DOWN[i] * (0.25 * (before + after) + 0.75 * (first + second))
        };
        cells[k] = 0.0 + along(0) + along(1) + along(2) + along(3);
    }
    if !rows[0].len().is_multiple_of(2) {
        let [before, first, frame] = [2 * whole, 2 * whole + 1, 2 * whole + 2];
        let along = |i: usize| {
            let row = rows[i];
            DOWN[i] * (0.25 * row[before] + 0.75 * (row[first] + row[frame]))
        };
        out[whole + 1] = 0.0 + along(0) + along(1) + along(2) + along(3);
    }
}
