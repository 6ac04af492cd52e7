//! What a multigrid cycle does to one row of a level. Rows have a frame, one cell at either end, that stays 0.

/// A row of what does not change in a cycle.
pub(super) struct Line<'a> {
    pub(super) diagonal: &'a [f32],
    pub(super) inverse: &'a [f32],
    pub(super) right: &'a [f32],
}

impl Line<'_> {
    /// The first sweep, from zero.
    #[inline(always)]
    pub(super) fn start(&self, weight: f32, out: &mut [f32]) {
        for ((out, inverse), right) in out.iter_mut().zip(self.inverse).zip(self.right) {
            *out = weight * inverse * right;
        }
    }
}

/// Values along three rows and the weights of steps along a row and along a column.
pub(super) struct Stencil<'a> {
    pub(super) near: [&'a [f32]; 3],
    pub(super) weights: [f32; 2],
}

impl Stencil<'_> {
    /// Makes the cells within the frame from the flow from their neighbours, their value and where they lie.
    #[inline(always)]
    fn each(&self, out: &mut [f32], make: impl Fn(f32, f32, usize) -> f32) {
        let ([north, own, south], [across, down]) = (self.near, self.weights);
        let n = out.len() - 2;
        let (west, here, east) = (&own[..n], &own[1..][..n], &own[2..][..n]);
        let (north, south, out) = (&north[1..][..n], &south[1..][..n], &mut out[1..][..n]);
        for k in 0..n {
            let flow = across * (west[k] + east[k]) + down * (north[k] + south[k]);
            out[k] = make(flow, here[k], k);
        }
    }

    /// A sweep. Cells that are not free stay 0.
    #[inline(always)]
    pub(super) fn sweep(&self, weight: f32, line: &Line<'_>, out: &mut [f32]) {
        let n = out.len() - 2;
        let (inverse, right) = (&line.inverse[1..][..n], &line.right[1..][..n]);
        self.each(out, |flow, value, k| {
            let exact = (right[k] + flow) * inverse[k];
            value + weight * (exact - value)
        });
    }

    /// What is left of the right side.
    #[inline(always)]
    pub(super) fn residual(&self, line: &Line<'_>, out: &mut [f32]) {
        let n = out.len() - 2;
        let (diagonal, right) = (&line.diagonal[1..][..n], &line.right[1..][..n]);
        self.each(out, |flow, value, k| {
            let rest = right[k] - diagonal[k] * value + flow;
            if diagonal[k] == 0.0 { 0.0 } else { rest }
        });
    }
}

/// Four rows of a level gathered as one of the coarser level: the transpose of [`spread`].
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

/// The values of a row with a row of the coarser level added, `coarse`, between whose cells they lie. A cell lies a quarter
/// of a coarse one off the middle of its own, towards the one before or after.
#[inline(always)]
pub(super) fn spread(coarse: &[f32], free: &[f32], value: &[f32], out: &mut [f32]) {
    let n = out.len() - 2;
    let (free, value, out) = (&free[1..][..n], &value[1..][..n], &mut out[1..][..n]);
    let lift = |value: f32, free: f32, moved: f32| value + if free == 0.0 { 0.0 } else { moved };
    let (pairs, rest) = out.as_chunks_mut::<2>();
    let (values, frees) = (value.as_chunks::<2>().0, free.as_chunks::<2>().0);
    let m = pairs.len();
    let (before, own, after) = (&coarse[..m], &coarse[1..][..m], &coarse[2..][..m]);
    for k in 0..m {
        let moved = [0.75 * own[k] + 0.25 * before[k], 0.75 * own[k] + 0.25 * after[k]];
        for i in 0..2 {
            pairs[k][i] = lift(values[k][i], frees[k][i], moved[i]);
        }
    }
    if let [last] = rest {
        *last = lift(value[n - 1], free[n - 1], 0.75 * coarse[m + 1] + 0.25 * coarse[m]);
    }
}
