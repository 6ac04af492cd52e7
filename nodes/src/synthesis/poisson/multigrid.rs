//! Multigrid: a good guess at the solution of Poisson's equation, symmetric in its input.
//!
//! Each coarser level halves the cells ([`network`](super::network)). Corrections are spread bilinearly and residuals
//! gathered by the transpose. A level is smoothed by two Jacobi sweeps with Chebyshev's weights before and, in reverse,
//! after, which rows can do in parallel and without branches: values are 0 wherever a cell is not free. A guess needs no
//! more than single precision; what it misses the next one finds.
//!
//! Memory is what a cycle waits for. So all that is done on a level on the way down goes through its rows once, each step a
//! row behind the one before ([`Descent`]), and so does all on the way up ([`Ascent`]).

use pulp::{Arch, NullaryFnOnce};

use super::{
    network::{Finest, Size, halved, parents},
    rolling::Rolling,
    rows::{each, each_two},
    stencil::{Alike, Line, Own, Row, gather},
    terms::{EAST, INVERSE, OfCells, OfJoints, SHARE, SOUTH, Terms, terms},
};

/// Weights of the two sweeps, the zeros of Chebyshev's polynomial on the part of the spectrum from 0.3 to 2.
const SWEEPS: [f32; 2] = [0.571_1, 1.821_6];

struct Level<M> {
    size: Size,
    matrix: M,
    terms: Vec<f32>,
    value: Vec<f32>,
    spare: Vec<f32>,
    right: Vec<f32>,
}

/// The levels over a domain. All arrays have a frame one cell wide.
pub(super) struct Levels {
    finest: Level<Alike>,
    /// The next one first, the last a single cell.
    coarser: Vec<Level<Varied>>,
}

/// What decides the flow between cells.
trait Matrix: Sync + 'static {
    /// How many terms a cell has.
    const TERMS: usize;
    type Row<'a>: Row;
    /// Row `row`, counted with the frame.
    fn row<'a>(&self, terms: &'a [f32], row: usize, stride: usize) -> Self::Row<'a>;
}

impl Matrix for Alike {
    const TERMS: usize = OfCells::COUNT;
    type Row<'a> = Self;

    #[inline(always)]
    fn row(&self, _: &[f32], _: usize, _: usize) -> Self {
        *self
    }
}

/// Flows of each cell's own, which are among its terms.
struct Varied;

impl Matrix for Varied {
    const TERMS: usize = OfJoints::COUNT;
    type Row<'a> = Own<'a>;

    #[inline(always)]
    fn row<'a>(&self, terms: &'a [f32], row: usize, stride: usize) -> Own<'a> {
        let from = |term: usize, row: usize, col: usize| {
            &terms[(row * Self::TERMS + term) * stride + col..][..stride - 2]
        };
        Own {
            west: from(EAST, row, 0),
            east: from(EAST, row, 1),
            north: from(SOUTH, row - 1, 1),
            south: from(SOUTH, row, 1),
        }
    }
}

impl Levels {
    /// Over a domain.
    pub(super) fn new(domain: Finest<'_>) -> Self {
        let weights = domain.weights;
        let mean = (0.5 * (weights[0] + weights[1])) as f32;
        let mut size = domain.size();
        let mut joints = halved(size, |i| domain.joint(i), mean);
        let matrix = Alike(weights.map(|weight| weight as f32));
        let finest = Level::new(size, matrix, terms(size, &OfCells { domain, coarser: &joints }));
        let mut coarser = Vec::new();
        while !size.is_single() {
            size = size.halved();
            let next = halved(size, |i| joints[i], mean);
            coarser.push(Level::new(
                size,
                Varied,
                terms(size, &OfJoints { joints: &joints, coarser: &next }),
            ));
            joints = next;
        }
        Self { finest, coarser }
    }

    /// What was found last, and the right side that it was found for, which is 0 where cells are not free.
    pub(super) fn found(&mut self) -> (&[f32], &mut [f32]) {
        (&self.finest.value, &mut self.finest.right)
    }

    /// One cycle, from zero.
    pub(super) fn precondition(&mut self) {
        self.finest.cycle(&mut self.coarser);
    }

    /// A first guess, once, before any cycle: every level starts from what the coarser one found.
    pub(super) fn guess(&mut self) {
        self.finest.nest(&mut self.coarser);
    }
}

/// Rows of the coarser level that are made together on the way down, and half the rows that are on the way up.
const LOT: usize = 16;

impl<M: Matrix> Level<M> {
    fn new(size: Size, matrix: M, terms: Vec<f32>) -> Self {
        let zeros = || vec![0.0; size.framed()];
        Self { size, matrix, terms, value: zeros(), spare: zeros(), right: zeros() }
    }

    /// A row of what does not change in a cycle, counted with the frame.
    #[inline(always)]
    fn line(&self, row: usize) -> Line<'_, M::Row<'_>> {
        let stride = self.size.stride();
        let term = |term: usize| &self.terms[(row * M::TERMS + term) * stride + 1..][..stride - 2];
        Line {
            matrix: self.matrix.row(&self.terms, row, stride),
            inverse: term(INVERSE),
            share: term(SHARE),
            right: &self.right[row * stride + 1..][..stride - 2],
        }
    }

    /// One cycle through this level and the `coarser` ones, from zero.
    fn cycle(&mut self, coarser: &mut [Level<Varied>]) {
        let Some((next, others)) = coarser.split_first_mut() else { return self.settle() };
        self.descend(Start::Zero, next);
        next.cycle(others);
        self.ascend(next);
    }

    /// A solution from what the coarser level finds for the same right side, improved by one cycle.
    fn nest(&mut self, coarser: &mut [Level<Varied>]) {
        let Some((next, others)) = coarser.split_first_mut() else { return self.settle() };
        self.pass_on(next);
        next.nest(others);
        self.ascend(next);
        self.descend(Start::Value, next);
        next.cycle(others);
        self.ascend(next);
    }

    /// The right side as that of the coarser level.
    fn pass_on(&self, coarse: &mut Level<Varied>) {
        let (stride, coarse_stride) = (self.size.stride(), coarse.size.stride());
        let rows = self.size.rows;
        let inner = coarse_stride..coarse.right.len() - coarse_stride;
        each(&mut coarse.right[inner], LOT * coarse_stride, |start, out| {
            let mut taken = [(); 4].map(|()| vec![0.0; stride]);
            for (row, out) in out.chunks_mut(coarse_stride).enumerate() {
                let first = 2 * (start / coarse_stride + row);
                for (row, taken) in (first..).zip(&mut taken) {
                    if (1..=rows).contains(&row) {
                        self.line(row).take(taken);
                    } else {
                        taken.fill(0.0);
                    }
                }
                gather(taken.each_ref().map(|row| &row[..]), out);
            }
        });
    }

    /// Two sweeps, and what they leave of the right side as that of the coarser level.
    fn descend(&mut self, start: Start, coarse: &mut Level<Varied>) {
        let (stride, coarse_stride, arch) = (self.size.stride(), coarse.size.stride(), Arch::new());
        let (mut swept, mut gathered) = (std::mem::take(&mut self.spare), std::mem::take(&mut coarse.right));
        let (inner, coarse_inner) =
            (stride..swept.len() - stride, coarse_stride..gathered.len() - coarse_stride);
        each_two(
            (&mut swept[inner], 2 * LOT * stride),
            (&mut gathered[coarse_inner], LOT * coarse_stride),
            |at, swept, gathered| {
                arch.dispatch(Descent { level: self, start, first: at / stride + 1, value: swept, gathered });
            },
        );
        self.spare = std::mem::replace(&mut self.value, swept);
        coarse.right = gathered;
    }

    /// The coarser level's values added, and two sweeps.
    fn ascend(&mut self, coarse: &Level<Varied>) {
        let (stride, arch) = (self.size.stride(), Arch::new());
        let mut next = std::mem::take(&mut self.spare);
        let inner = stride..next.len() - stride;
        each(&mut next[inner], 2 * LOT * stride, |start, next| {
            arch.dispatch(Ascent { level: self, coarse, first: start / stride + 1, next });
        });
        self.spare = std::mem::replace(&mut self.value, next);
    }

    /// The solution, of a single cell.
    fn settle(&mut self) {
        let at = self.size.stride() + 1;
        self.value[at] = self.right[at] * self.line(1).inverse[0];
    }
}

/// What sweeps start from.
#[derive(Clone, Copy)]
enum Start {
    Zero,
    /// The level's value.
    Value,
}

/// The way down through some rows of a level.
struct Descent<'a, M> {
    level: &'a Level<M>,
    start: Start,
    /// The first of the rows, an odd one as the frame counts.
    first: usize,
    /// Their values after two sweeps.
    value: &'a mut [f32],
    /// The right side of the coarser rows over them.
    gathered: &'a mut [f32],
}

impl<M: Matrix> NullaryFnOnce for Descent<'_, M> {
    type Output = ();

    /// Rows beyond the lot that its own ones look at are made here, too, which costs less than to wait for other lots.
    #[inline(always)]
    fn call(self) {
        let Self { level, start, first, value, gathered } = self;
        let stride = level.size.stride();
        let rows = value.len() / stride;
        let coarse_stride = level.size.halved().stride();
        let within = |row: usize| (1..=level.size.rows).contains(&row);
        let mut started = Rolling::<3>::new(stride);
        let mut swept = Rolling::<3>::new(stride);
        let mut rest = Rolling::<4>::new(stride);
        let last = first + 2 * (gathered.len() / coarse_stride);
        // Three rows before the first one is the earliest that matters; none lies before the frame.
        for row in first.saturating_sub(3)..=last + 2 {
            match started.row(row) {
                out if within(row) => match start {
                    Start::Zero => level.line(row).start(SWEEPS[0], out),
                    Start::Value => {
                        let near = [row - 1, row, row + 1].map(|row| &level.value[row * stride..][..stride]);
                        level.line(row).sweep(SWEEPS[0], near, out);
                    }
                },
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match swept.row(row) {
                out if within(row) => {
                    level.line(row).sweep(SWEEPS[1], started.around(row), out);
                    if (first..first + rows).contains(&row) {
                        value[(row - first) * stride..][..stride].copy_from_slice(out);
                    }
                }
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match rest.row(row) {
                out if within(row) => level.line(row).rest(swept.around(row), out),
                out => out.fill(0.0),
            }
            // A coarse row over this one and the one before gathers from one more on either side.
            if row >= first + 2 && (row - first).is_multiple_of(2) {
                let out = &mut gathered[((row - first) / 2 - 1) * coarse_stride..][..coarse_stride];
                let four = [rest.made(row - 3), rest.made(row - 2), rest.made(row - 1), rest.made(row)];
                gather(four, out);
            }
        }
    }
}

/// The way up through some rows of a level.
struct Ascent<'a, M> {
    level: &'a Level<M>,
    coarse: &'a Level<Varied>,
    /// The first of the rows, as the frame counts.
    first: usize,
    next: &'a mut [f32],
}

impl<M: Matrix> NullaryFnOnce for Ascent<'_, M> {
    type Output = ();

    /// As on the way down.
    #[inline(always)]
    fn call(self) {
        let Self { level, coarse, first, next } = self;
        let (stride, coarse_stride) = (level.size.stride(), coarse.size.stride());
        let rows = next.len() / stride;
        let within = |row: usize| (1..=level.size.rows).contains(&row);
        let mut lifted = Rolling::<3>::new(stride);
        let mut swept = Rolling::<3>::new(stride);
        let mut blend = vec![0.0; coarse_stride];
        for row in first.saturating_sub(2)..first + rows + 2 {
            match lifted.row(row) {
                out if within(row) => {
                    // A row lies a quarter of a coarse one off the middle of its own, towards the one before or after.
                    let (own, other) = parents(row);
                    let [own, other] =
                        [own, other].map(|row| &coarse.value[row * coarse_stride..][..coarse_stride]);
                    for ((blend, own), other) in blend.iter_mut().zip(own).zip(other) {
                        *blend = 0.75 * own + 0.25 * other;
                    }
                    level.line(row).spread(&blend, &level.value[row * stride..][..stride], out);
                }
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1) else { continue };
            match swept.row(row) {
                out if within(row) => level.line(row).sweep(SWEEPS[1], lifted.around(row), out),
                out => out.fill(0.0),
            }
            let Some(row) = row.checked_sub(1).filter(|row| *row >= first) else { continue };
            let out = &mut next[(row - first) * stride..][..stride];
            level.line(row).sweep(SWEEPS[0], swept.around(row), out);
        }
    }
}
