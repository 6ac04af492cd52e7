//! The terrain in the making: what is known of it, where it came from, and how a patch is added.

use orograph_core::prelude::*;
use orograph_core::{Patch, Placement};

use super::{
    cut::{Keep, Overlay, Seam, seam},
    exemplar::Exemplar,
    poisson::seam::{Composite, correction},
    settings::Rules,
    tps::Point,
};

/// A stretch of the output, clipped to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First row.
    pub top: usize,
    /// First column.
    pub left: usize,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
}

impl Window {
    /// The part of the square of `side` cells around (`row`, `col`) that lies on a grid of that size.
    #[must_use]
    pub fn around(row: i64, col: i64, side: usize, (rows, cols): (usize, usize)) -> Self {
        let clip = |center: i64, n: usize| {
            let start = center - side as i64 / 2;
            let end = (start + side as i64).clamp(0, n as i64);
            let start = start.clamp(0, n as i64);
            (start as usize, (end - start).max(0) as usize)
        };
        let ((top, rows), (left, cols)) = (clip(row, rows), clip(col, cols));
        Self { top, left, rows, cols }
    }

    /// The same, `by` cells larger on each side where there are cells.
    #[must_use]
    pub fn grown(&self, by: usize, (rows, cols): (usize, usize)) -> Self {
        let (top, left) = (self.top.saturating_sub(by), self.left.saturating_sub(by));
        let (bottom, right) = ((self.top + self.rows + by).min(rows), (self.left + self.cols + by).min(cols));
        Self { top, left, rows: bottom - top, cols: right - left }
    }

    /// The same, one cell larger on each side where there are cells.
    #[must_use]
    pub fn framed(&self, size: (usize, usize)) -> Self {
        self.grown(1, size)
    }

    /// Whether a cell of the output lies in it.
    #[must_use]
    pub fn holds(&self, (row, col): (usize, usize)) -> bool {
        (self.top..self.top + self.rows).contains(&row) && (self.left..self.left + self.cols).contains(&col)
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Row and column in the output of the window's cell `i`.
    #[must_use]
    pub fn cell(&self, i: usize) -> (usize, usize) {
        (self.top + i / self.cols, self.left + i % self.cols)
    }

    /// Whether both share a cell.
    #[must_use]
    pub fn touches(&self, other: &Self) -> bool {
        self.top < other.top + other.rows
            && other.top < self.top + self.rows
            && self.left < other.left + other.cols
            && other.left < self.left + self.cols
    }
}

/// Cells within `band` cells, along rows and columns added up, of an open one, open ones included.
fn near_open(open: &[bool], cols: usize, band: usize) -> Vec<bool> {
    let far = u32::MAX / 2;
    let mut distance: Vec<u32> = open.iter().map(|&open| if open { 0 } else { far }).collect();
    let rows = distance.len().checked_div(cols).unwrap_or(0);
    for row in 0..rows {
        for col in 0..cols {
            let i = row * cols + col;
            let west = if col > 0 { distance[i - 1] } else { far };
            let north = if row > 0 { distance[i - cols] } else { far };
            distance[i] = distance[i].min(west.min(north) + 1);
        }
    }
    for row in (0..rows).rev() {
        for col in (0..cols).rev() {
            let i = row * cols + col;
            let east = if col + 1 < cols { distance[i + 1] } else { far };
            let south = if row + 1 < rows { distance[i + cols] } else { far };
            distance[i] = distance[i].min(east.min(south) + 1);
        }
    }
    distance.into_iter().map(|distance| distance as usize <= band).collect()
}

/// The terrain so far.
#[derive(Clone, Debug)]
pub struct Canvas {
    /// Rows and columns.
    pub size: (usize, usize),
    /// Heights; NaN where nothing is known yet.
    pub heights: Vec<f32>,
    /// Number of the patch that each cell came from, plus one.
    pub labels: Vec<u32>,
    /// Steps to the cell on the right and to the one below as the patches had them, their mean across a seam.
    pub(super) steps: Vec<[f32; 2]>,
    /// Row and column in the exemplar of each cell.
    pub sources: Vec<[f32; 2]>,
    /// Number of the patch, plus one, whose core each cell is.
    cores: Vec<u32>,
    /// Cells that never change.
    frozen: Vec<bool>,
    /// The patches so far.
    pub patches: Vec<Patch>,
    /// Centres of the patches, for cells that two cores claim.
    centers: Vec<Point>,
}

/// A patch in its framed window, ready to be pasted.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Where it goes, frame included.
    pub window: Window,
    /// Heights, offset included; NaN where it has none.
    pub heights: Vec<f32>,
    /// Which of its cells must come.
    pub core: Vec<bool>,
}

/// A patch cut to the ground in its window.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The patch.
    pub sheet: Sheet,
    /// What is there now.
    pub old: Vec<f32>,
    /// The seam between.
    pub seam: Seam,
    /// Where the patch came from.
    pub patch: Patch,
    /// Row and column in the exemplar of each of its cells.
    pub sources: Vec<Point>,
}

impl Canvas {
    /// Nothing known.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the memory is refused.
    pub fn new(size: (usize, usize), job: &Job<'_>) -> Result<Self> {
        let n = size.0 * size.1;
        job.admit(n as u64 * 29, || format!("a synthesis of {} × {} cells", size.0, size.1))?;
        Ok(Self {
            size,
            heights: vec![f32::NAN; n],
            labels: vec![0; n],
            steps: vec![[f32::NAN; 2]; n],
            sources: vec![[f32::NAN; 2]; n],
            cores: vec![0; n],
            frozen: vec![false; n],
            patches: Vec::new(),
            centers: Vec::new(),
        })
    }

    /// Takes over the known cells of `terrain`, which patches may still replace.
    pub fn lay(&mut self, terrain: &Heightfield) {
        for (own, &height) in self.heights.iter_mut().zip(terrain.cells()) {
            if height.is_finite() {
                *own = height;
            }
        }
    }

    /// Takes over the known cells of `terrain`, for good.
    pub fn freeze(&mut self, terrain: &Heightfield) {
        for (i, &height) in terrain.cells().iter().enumerate().take(self.heights.len()) {
            if height.is_finite() {
                self.heights[i] = height;
                self.frozen[i] = true;
            }
        }
    }

    /// Index of a window's cell.
    #[must_use]
    pub fn index(&self, window: &Window, i: usize) -> usize {
        let (row, col) = window.cell(i);
        row * self.size.1 + col
    }

    /// Whether a cell never changes.
    #[must_use]
    pub fn is_frozen(&self, i: usize) -> bool {
        self.frozen[i]
    }

    /// The heights in a window.
    #[must_use]
    pub fn part(&self, window: &Window) -> Vec<f32> {
        (0..window.rows)
            .flat_map(|row| &self.heights[(window.top + row) * self.size.1 + window.left..][..window.cols])
            .copied()
            .collect()
    }

    /// Which cells of `window`, where `old` is known, are still to be made in its `inner` part, and which of its cells a
    /// patch for them reaches: these and known ones within `band` cells of one.
    #[must_use]
    pub fn reached(
        &self,
        window: &Window,
        inner: &Window,
        old: &[f32],
        band: usize,
    ) -> (Vec<bool>, Vec<bool>) {
        let is_open = |i: usize| old[i].is_nan() && inner.holds(window.cell(i));
        let open: Vec<bool> = (0..window.len()).map(is_open).collect();
        let mut near = near_open(&open, window.cols, band);
        near.iter_mut().zip(&open).zip(old).for_each(|((near, open), old)| *near &= *open || !old.is_nan());
        (open, near)
    }

    /// The core that cell `i` belongs to: the centre of its patch.
    fn core(&self, i: usize) -> Option<Point> {
        (self.cores[i] as usize).checked_sub(1).map(|patch| self.centers[patch])
    }

    /// The seam between `new` heights in a framed window, which keep their `core`, and the `old` ones there.
    ///
    /// # Errors
    /// Those of [`seam`].
    #[expect(clippy::too_many_arguments, reason = "both surfaces come in parts that are made apart")]
    pub fn seam(
        &self,
        window: &Window,
        new: &[f32],
        core: &[bool],
        old: &[f32],
        center: Point,
        rules: &Rules,
        job: &Job<'_>,
    ) -> Result<Seam> {
        let cell = |row: usize, col: usize, is_core: bool| {
            let at = row * self.size.1 + col;
            let square = |p: Point| {
                let (down, across) = (row as f64 - p[0], col as f64 - p[1]);
                down * down + across * across
            };
            match (self.core(at), is_core) {
                _ if self.frozen[at] => Keep::Old,
                (None, false) => Keep::Either,
                (None, true) => Keep::New,
                (Some(other), true) if square(center) < square(other) => Keep::New,
                (Some(_), _) => Keep::Old,
            }
        };
        let mut core = core.iter().copied();
        let mut keep = Vec::with_capacity(window.len());
        for row in window.top..window.top + window.rows {
            let cols = window.left..window.left + window.cols;
            keep.extend(cols.map(|col| cell(row, col, core.next().unwrap_or(false))));
        }
        let overlay = Overlay { cols: window.cols, old, new, keep: &keep };
        seam(&overlay, rules.seam_weight, job)
    }

    /// What spreads the step along the seam of `piece`, for each cell of its window.
    ///
    /// # Errors
    /// Those of [`correction`].
    pub fn fit(&self, piece: &Piece, rules: &Rules, job: &Job<'_>) -> Result<Vec<f64>> {
        let Piece { sheet, old, seam, .. } = piece;
        // What stays is not to move for the patch's sake, so there the patch has no say.
        let movable =
            |i: usize| if self.frozen[self.index(&sheet.window, i)] { f32::NAN } else { sheet.heights[i] };
        let new: Vec<f32> = (0..sheet.window.len()).map(movable).collect();
        let composite = Composite { cols: sheet.window.cols, old, new: &new, is_new: &seam.new };
        correction(&composite, rules.seam_gradient, rules.grow, job)
    }

    /// Pastes `piece` with what [`fit`](Self::fit) `added`. The number of cells that were unknown before.
    pub fn paste(&mut self, piece: Piece, added: &[f64]) -> usize {
        let Piece { sheet, old, seam, patch, sources } = piece;
        let composite =
            Composite { cols: sheet.window.cols, old: &old, new: &sheet.heights, is_new: &seam.new };
        self.take_steps(&sheet, &seam.new);
        self.centers.push(patch.target_center);
        self.patches.push(patch);
        let label = self.patches.len() as u32;
        let mut filled = 0;
        for (i, added) in added.iter().enumerate() {
            let at = self.index(&sheet.window, i);
            if self.frozen[at] {
                continue;
            }
            let height = composite.height(i);
            if *added != 0.0 {
                self.heights[at] = (f64::from(height) + added) as f32;
            } else if seam.new[i] && !sheet.heights[i].is_nan() {
                self.heights[at] = height;
            }
            if seam.new[i] && !sheet.heights[i].is_nan() {
                filled += usize::from(old[i].is_nan());
                self.labels[at] = label;
                self.sources[at] = sources[i].map(|x| x as f32);
                if sheet.core.get(i).copied().unwrap_or(false) {
                    self.cores[at] = label;
                }
            }
        }
        filled
    }

    /// Keeps the steps of a patch's own surface: within its cells as they are, across its seam half and half.
    fn take_steps(&mut self, sheet: &Sheet, is_new: &[bool]) {
        let window = &sheet.window;
        for row in 0..window.rows {
            for col in 0..window.cols {
                let i = row * window.cols + col;
                let at = (window.top + row) * self.size.1 + window.left + col;
                let (right, below) = (col + 1 < window.cols, row + 1 < window.rows);
                for (axis, inside, j) in [(0, right, i + 1), (1, below, i + window.cols)] {
                    if !inside || !(is_new[i] || is_new[j]) {
                        continue;
                    }
                    let own = sheet.heights[j] - sheet.heights[i];
                    let before = self.steps[at][axis];
                    if is_new[i] && is_new[j] || before.is_nan() {
                        self.steps[at][axis] = own;
                    } else if !own.is_nan() {
                        self.steps[at][axis] = f32::midpoint(before, own);
                    }
                }
            }
        }
    }

    /// The terrain and its provenance.
    ///
    /// # Errors
    /// None that a canvas of the grid's size meets.
    pub fn finish(self, grid: Grid, exemplars: &[Exemplar]) -> Result<(Heightfield, Placement)> {
        let cols = self.size.1;
        let mut seams = Vec::new();
        for (i, &label) in self.labels.iter().enumerate() {
            let mut edge = |j: usize| {
                if label != self.labels[j] {
                    seams.push([i as u32, j as u32]);
                }
            };
            if (i + 1) % cols != 0 {
                edge(i + 1);
            }
            if i + cols < self.labels.len() {
                edge(i + cols);
            }
        }
        let terrain = Heightfield::new(grid.clone(), self.heights)?;
        let placement = Placement {
            grid,
            scales: exemplars.iter().map(|exemplar| exemplar.scale).collect(),
            patches: self.patches,
            labels: self.labels,
            sources: self.sources,
            seams,
        };
        Ok((terrain, placement))
    }
}
