//! What the levels of a multigrid keep of each cell besides its value.

use pulp::{Arch, NullaryFnOnce};

use super::{
    masked::Cell,
    network::{Around, Finest, Joint, Size, shares},
    rows::{ROWS, each},
};

/// The inverse of the matrix's diagonal, and how much of what the coarser level spreads the cell takes. They are 0 for
/// cells that are not free.
pub(super) const INVERSE: usize = 0;
pub(super) const SHARE: usize = 1;
/// On coarser levels also what flows to the next cell of the row and of the column.
pub(super) const EAST: usize = 2;
pub(super) const SOUTH: usize = 3;

/// Where a level's terms come from.
pub(super) trait Terms: Sync {
    /// How many terms a cell has.
    const COUNT: usize;
    /// Those of a row, counted with the frame, one term after the other.
    fn row(&self, size: Size, row: usize, out: &mut [f32]);
}

/// The terms of a level, a row after the other.
pub(super) fn terms<T: Terms>(size: Size, source: &T) -> Vec<f32> {
    let (arch, len) = (Arch::new(), T::COUNT * size.stride());
    let mut terms = vec![0.0; T::COUNT * size.framed()];
    let inner = len..len * (size.rows + 1);
    each(&mut terms[inner], ROWS * len, |start, out| {
        for (row, out) in (start / len + 1..).zip(out.chunks_mut(len)) {
            arch.dispatch(Fill { source, size, row, out });
        }
    });
    terms
}

struct Fill<'a, T> {
    source: &'a T,
    size: Size,
    row: usize,
    out: &'a mut [f32],
}

impl<T: Terms> NullaryFnOnce for Fill<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.source.row(self.size, self.row, self.out);
    }
}

/// Of the finest level, under `coarser`.
pub(super) struct OfCells<'a> {
    pub(super) domain: Finest<'a>,
    pub(super) coarser: &'a [Joint],
}

impl Terms for OfCells<'_> {
    const COUNT: usize = 2;

    #[inline(always)]
    fn row(&self, size: Size, row: usize, out: &mut [f32]) {
        if self.domain.holds.is_empty() {
            self.fill::<false>(size, row, out);
        } else {
            self.fill::<true>(size, row, out);
        }
    }
}

impl OfCells<'_> {
    #[inline(always)]
    fn fill<const HELD: bool>(&self, size: Size, row: usize, out: &mut [f32]) {
        let Finest { stride, cells, holds, weights } = self.domain;
        let (first, n) = (row * stride + 1, size.cols);
        let (inverses, spread) = out.split_at_mut(stride);
        let (inverses, spread) = (&mut inverses[1..][..n], &mut spread[1..][..n]);
        shares(row, self.coarser, size.halved().stride(), spread);
        let cells = Around::new(cells, first, n, stride);
        let holds = if HELD { &holds[first..][..n] } else { holds };
        for k in 0..n {
            let sides = cells.sides(k, weights);
            let inverse = inverse(if HELD { sides + holds[k] } else { sides });
            // A cell that is held firmly hardly moves, so that little is spread to it, as to a fixed one nothing is.
            let share = spread[k] * (sides * inverse) as f32;
            let free = cells.own[k] == Cell::Free;
            inverses[k] = if free { inverse as f32 } else { 0.0 };
            spread[k] = if free { share } else { 0.0 };
        }
    }
}

/// Of a coarser level, under `coarser`.
pub(super) struct OfJoints<'a> {
    pub(super) joints: &'a [Joint],
    pub(super) coarser: &'a [Joint],
}

impl Terms for OfJoints<'_> {
    const COUNT: usize = 4;

    #[inline(always)]
    fn row(&self, size: Size, row: usize, out: &mut [f32]) {
        let (stride, n) = (size.stride(), size.cols);
        let mut terms = out.chunks_mut(stride).map(|term| &mut term[1..][..n]);
        let [Some(inverses), Some(spread), Some(easts), Some(souths)] = [(); 4].map(|()| terms.next()) else {
            return;
        };
        shares(row, self.coarser, size.halved().stride(), spread);
        let first = row * stride + 1;
        let (own, west) = (&self.joints[first..][..n], &self.joints[first - 1..][..n]);
        let north = &self.joints[first - stride..][..n];
        for k in 0..n {
            let Joint { cell, east, south, ground } = own[k];
            let diagonal = east + south + ground + west[k].east + north[k].south;
            let free = cell == Cell::Free;
            inverses[k] = inverse(diagonal.into()) as f32;
            spread[k] = if free { spread[k] } else { 0.0 };
            (easts[k], souths[k]) = (east, south);
        }
    }
}

/// 0 of 0: a cell from which nothing leads stays where it is.
#[inline(always)]
fn inverse(diagonal: f64) -> f64 {
    if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 }
}
