//! Coarser equations, as of a network of resistors: cells are nodes, the weight of a step is what its wire conducts, and
//! fixed cells and holds are ground.
//!
//! A coarse cell stands for the free ones among its four. Wires from it to the next are side by side, and twice as long
//! as the finer ones; what leads to ground lies side by side, too, and in series with the way there from the middle of
//! the coarse cell. So the domain's edge stays where it is, ragged or not, and cells outside conduct nothing.

use super::{
    masked::Cell,
    rows::{ROWS, each},
};

/// A cell and what leads from it: 0 where it is not free.
#[derive(Clone, Copy)]
pub(super) struct Joint {
    pub(super) cell: Cell,
    /// To the next cell of the row and of the column, where that is free.
    pub(super) east: f32,
    pub(super) south: f32,
    /// To ground.
    pub(super) ground: f32,
}

impl Joint {
    const OUTSIDE: Self = Self { cell: Cell::Outside, east: 0.0, south: 0.0, ground: 0.0 };
}

/// The way from the middle of a coarse cell to ground below it, as a share of the inverse of a step's mean weight: half
/// of what a line of ground at the cell's edge has, as ground may be anywhere in it.
const WAY_TO_GROUND: f32 = 0.125;

/// The finest level: the framed cells of a domain, their holds, if any, and the weights of steps along a row and along a
/// column.
#[derive(Clone, Copy)]
pub(super) struct Finest<'a> {
    pub(super) stride: usize,
    pub(super) cells: &'a [Cell],
    pub(super) holds: &'a [f64],
    pub(super) weights: [f64; 2],
}

impl Finest<'_> {
    pub(super) fn size(&self) -> Size {
        Size { rows: self.cells.len() / self.stride - 2, cols: self.stride - 2 }
    }

    pub(super) fn joint(&self, i: usize) -> Joint {
        let cell = self.cells[i];
        if cell != Cell::Free {
            return Joint { cell, ..Joint::OUTSIDE };
        }
        let [across, down] = self.weights.map(|weight| weight as f32);
        let is = |cell: Cell, i: usize, weight: f32| if self.cells[i] == cell { weight } else { 0.0 };
        let fixed = is(Cell::Fixed, i - 1, across)
            + is(Cell::Fixed, i + 1, across)
            + is(Cell::Fixed, i - self.stride, down)
            + is(Cell::Fixed, i + self.stride, down);
        let hold = self.holds.get(i).map_or(0.0, |&hold| hold as f32);
        let (east, south) = (is(Cell::Free, i + 1, across), is(Cell::Free, i + self.stride, down));
        Joint { cell, east, south, ground: fixed + hold }
    }
}

/// The cells of some in a row, and of their neighbours.
pub(super) struct Around<'a> {
    pub(super) own: &'a [Cell],
    west: &'a [Cell],
    east: &'a [Cell],
    north: &'a [Cell],
    south: &'a [Cell],
}

impl<'a> Around<'a> {
    /// Of `n` cells from `first` on, as the frame counts.
    #[inline(always)]
    pub(super) fn new(cells: &'a [Cell], first: usize, n: usize, stride: usize) -> Self {
        let from = |first: usize| &cells[first..][..n];
        Self {
            own: from(first),
            west: from(first - 1),
            east: from(first + 1),
            north: from(first - stride),
            south: from(first + stride),
        }
    }

    /// The sum of the weights of the steps from cell `k` to cells that are not outside.
    #[inline(always)]
    pub(super) fn sides(&self, k: usize, [across, down]: [f64; 2]) -> f64 {
        let conducts = |cells: &[Cell]| f64::from(u8::from(cells[k] != Cell::Outside));
        across * (conducts(self.west) + conducts(self.east))
            + down * (conducts(self.north) + conducts(self.south))
    }
}

/// Rows and columns of a level, without the frame.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) rows: usize,
    pub(super) cols: usize,
}

impl Size {
    pub(super) fn stride(self) -> usize {
        self.cols + 2
    }

    pub(super) fn framed(self) -> usize {
        (self.rows + 2) * self.stride()
    }

    pub(super) fn halved(self) -> Self {
        Self { rows: self.rows.div_ceil(2), cols: self.cols.div_ceil(2) }
    }

    pub(super) fn is_single(self) -> bool {
        self.rows.max(self.cols) <= 1
    }
}

/// The joints of the level over `joint`'s, where the mean weight of a step is `weight`.
pub(super) fn halved(size: Size, joint: impl Fn(usize) -> Joint + Sync, weight: f32) -> Vec<Joint> {
    let (stride, coarse) = (size.stride(), size.halved());
    let mut out = vec![Joint::OUTSIDE; coarse.framed()];
    let inner = coarse.stride()..out.len() - coarse.stride();
    each(&mut out[inner], ROWS * coarse.stride(), |start, out| {
        for (row, out) in out.chunks_mut(coarse.stride()).enumerate() {
            // The frame lends the missing half of an odd last row or column.
            let first = (2 * (start / coarse.stride() + row) + 1) * stride + 1;
            for (col, out) in out[1..=coarse.cols].iter_mut().enumerate() {
                let at = first + 2 * col;
                let four = [joint(at), joint(at + 1), joint(at + stride), joint(at + stride + 1)];
                *out = joined(four, weight);
            }
        }
    });
    out
}

fn joined(four: [Joint; 4], weight: f32) -> Joint {
    let any = |cell: Cell| four.iter().any(|joint| joint.cell == cell);
    let [_, north_east, south_west, south_east] = four;
    if any(Cell::Free) {
        let east = 0.5 * (north_east.east + south_east.east);
        let south = 0.5 * (south_west.south + south_east.south);
        let ground: f32 = four.iter().map(|joint| joint.ground).sum();
        // Firm ground conducts without end, and the way to it does not.
        Joint { cell: Cell::Free, east, south, ground: 1.0 / (1.0 / ground + WAY_TO_GROUND / weight) }
    } else {
        Joint { cell: if any(Cell::Fixed) { Cell::Fixed } else { Cell::Outside }, ..Joint::OUTSIDE }
    }
}

/// By which of the three coarse cells that a fine one lies next to are outside, 1 or 0: along the row, across, and both.
#[inline(always)]
fn share(beside: f32, across: f32, corner: f32) -> f32 {
    1.0 / (1.0 - (0.1875 * beside + 0.1875 * across) - 0.0625 * corner)
}

/// How much of the correction that the coarser level spreads bilinearly the cells of a row take, so that an even one stays
/// even beside cells outside. The row is counted with the frame, `out` is without.
#[inline(always)]
pub(super) fn shares(row: usize, coarser: &[Joint], coarse_stride: usize, out: &mut [f32]) {
    let (own, other) = parents(row);
    let joints = |row: usize| &coarser[row * coarse_stride..][..coarse_stride];
    let (own, other) = (joints(own), joints(other));
    let mut lost = vec![0.0; 2 * coarse_stride];
    let (beside, across) = lost.split_at_mut(coarse_stride);
    for col in 0..coarse_stride {
        beside[col] = f32::from(u8::from(own[col].cell == Cell::Outside));
        across[col] = f32::from(u8::from(other[col].cell == Cell::Outside));
    }
    let (pairs, last) = out.as_chunks_mut::<2>();
    let n = pairs.len();
    let (before, own, after) = (0..n, 1..n + 1, 2..n + 2);
    let (beside_before, beside_after) = (&beside[before.clone()], &beside[after.clone()]);
    let (across_before, across_own, across_after) = (&across[before], &across[own], &across[after]);
    for k in 0..n {
        pairs[k] = [
            share(beside_before[k], across_own[k], across_before[k]),
            share(beside_after[k], across_own[k], across_after[k]),
        ];
    }
    if let [last] = last {
        *last = share(beside[n], across[n + 1], across[n]);
    }
}

/// The coarse rows that a fine one lies in and lies next to, counted with the frame.
pub(super) fn parents(row: usize) -> (usize, usize) {
    let own = row.div_ceil(2);
    (own, if row.is_multiple_of(2) { own + 1 } else { own - 1 })
}
