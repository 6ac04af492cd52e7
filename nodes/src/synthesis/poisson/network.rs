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
    /// The sum of the weights of a free cell's steps to cells that are not outside; 0 for other cells.
    pub(super) fn sides(&self, i: usize) -> f64 {
        if self.cells[i] != Cell::Free {
            return 0.0;
        }
        let conducts = |i: usize| f64::from(u8::from(self.cells[i] != Cell::Outside));
        let [across, down] = self.weights;
        across * (conducts(i - 1) + conducts(i + 1))
            + down * (conducts(i - self.stride) + conducts(i + self.stride))
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

/// Where a cell is, counted with the frame.
#[derive(Clone, Copy)]
pub(super) struct At {
    pub(super) row: usize,
    pub(super) col: usize,
}

impl At {
    pub(super) fn index(self, size: Size) -> usize {
        self.row * size.stride() + self.col
    }
}

/// How much of the correction that the coarser level spreads bilinearly a cell takes, so that an even one stays even beside
/// cells outside: 0 if it is not free.
#[inline(always)]
pub(super) fn share(size: Size, at: At, cell: Cell, coarser: &[Joint]) -> f32 {
    if cell != Cell::Free {
        return 0.0;
    }
    let coarse_stride = size.halved().stride();
    let ((own_row, other_row), (own_col, other_col)) = (parents(at.row), parents(at.col));
    let lost = |row: usize, col: usize, weight: f32| match coarser[row * coarse_stride + col].cell {
        Cell::Outside => weight,
        Cell::Free | Cell::Fixed => 0.0,
    };
    let beside = lost(own_row, other_col, 0.1875) + lost(other_row, own_col, 0.1875);
    1.0 / (1.0 - beside - lost(other_row, other_col, 0.0625))
}

/// The coarse rows that a fine one lies in and lies next to, counted with the frame.
pub(super) fn parents(row: usize) -> (usize, usize) {
    let own = row.div_ceil(2);
    (own, if row.is_multiple_of(2) { own + 1 } else { own - 1 })
}
