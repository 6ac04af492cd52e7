//! MDBU, the bottom-up pass: known cells tell their unknown ascendants, round by round.

use orograph_core::{Heightfield, Job, Result};

use crate::mcmd::{
    axis::Axis,
    settings::{Falloff, Scheme, Settings},
};

/// Calls `visit` with (column, row) of each ascendant of the cell at (`x`, `y`), in the order that sums keep.
pub(crate) fn ascendants(
    scheme: Scheme,
    (cols, rows): (&Axis, &Axis),
    (x, y): (u32, u32),
    mut visit: impl FnMut(u32, u32),
) {
    let (i, j) = (x as usize, y as usize);
    let (level_x, level_y) = (cols.level[i], rows.level[j]);
    let level = level_x.max(level_y);
    if level == 0 {
        return;
    }
    let (x0, x1, y0, y1) = (cols.low[i], cols.high[i], rows.low[j], rows.high[j]);
    let squares = scheme == Scheme::DiamondSquare;
    if level_x < level {
        visit(x, y0);
        visit(x, y1);
        if squares {
            let (before, after) = cols.neighbours(x, level as usize);
            before.into_iter().chain(after).for_each(|mid| visit(mid, y));
        }
    } else if level_y < level {
        visit(x0, y);
        visit(x1, y);
        if squares {
            let (before, after) = rows.neighbours(y, level as usize);
            before.into_iter().chain(after).for_each(|mid| visit(x, mid));
        }
    } else {
        visit(x0, y0);
        visit(x1, y0);
        visit(x0, y1);
        visit(x1, y1);
    }
}

/// A set of cells that is walked in row-major order however it was filled.
struct CellSet {
    words: Vec<u64>,
    words_per_row: usize,
    /// Cells in each row, so that empty rows cost nothing.
    in_row: Vec<u32>,
}

impl CellSet {
    fn new(rows: usize, cols: usize) -> Self {
        let words_per_row = cols.div_ceil(64);
        Self { words: vec![0; rows * words_per_row], words_per_row, in_row: vec![0; rows] }
    }

    fn insert(&mut self, x: u32, y: u32) {
        self.words[y as usize * self.words_per_row + x as usize / 64] |= 1 << (x % 64);
        self.in_row[y as usize] += 1;
    }

    /// Takes each cell of row `y` out, from left to right.
    fn drain_row(&mut self, y: usize, mut visit: impl FnMut(u32)) {
        if std::mem::take(&mut self.in_row[y]) == 0 {
            return;
        }
        let row = &mut self.words[y * self.words_per_row..(y + 1) * self.words_per_row];
        for (i, word) in row.iter_mut().enumerate() {
            let mut bits = std::mem::take(word);
            while bits != 0 {
                visit(i as u32 * 64 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
    }
}

/// What the pass did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct BottomUp {
    /// Rounds until no cell was active any more.
    pub(crate) rounds: u64,
    /// Cells that became known.
    pub(crate) found: u64,
}

/// Makes every ascendant of a known cell known, at its children's mean height under equation (3) of the paper.
///
/// A cell becomes known in the first round in which one of its children is active, from the children that are
/// active in that round, summed in row-major order. Each cell is active once, so the work is linear in the
/// number of cells found.
///
/// # Errors
/// [`orograph_core::Error::TooLarge`] when the sums do not fit, or cancellation.
pub(crate) fn bottom_up(
    field: &mut Heightfield,
    (cols, rows): (&Axis, &Axis),
    settings: &Settings,
    job: &Job<'_>,
) -> Result<BottomUp> {
    let (n_rows, n_cols) = field.grid().size();
    let n = field.grid().len();
    job.admit(n as u64 * 11, || format!("the bottom-up sums of {n_rows} × {n_cols} cells"))?;
    let falloff = Falloff::new(cols, rows, settings.shape.l_bu, settings.datum);
    let heights = field.cells_mut();
    let mut active = CellSet::new(n_rows, n_cols);
    for (y, row) in heights.chunks(n_cols).enumerate() {
        job.check()?;
        for (x, _) in row.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
            active.insert(x as u32, y as u32);
        }
    }
    let mut next = CellSet::new(n_rows, n_cols);
    let mut sums = vec![0.0_f64; n];
    let mut counts = vec![0_u16; n];
    let mut done = BottomUp::default();
    while active.in_row.iter().any(|&cells| cells > 0) {
        done.rounds += 1;
        for y in 0..n_rows {
            job.check()?;
            let level_y = rows.level[y];
            active.drain_row(y, |x| {
                let height = heights[y * n_cols + x as usize];
                let level = cols.level[x as usize].max(level_y) as usize;
                let factors = falloff.level(level);
                ascendants(settings.scheme, (cols, rows), (x, y as u32), |ax, ay| {
                    let at = ay as usize * n_cols + ax as usize;
                    if heights[at].is_nan() {
                        let step_x = cols.step(level, ax.abs_diff(x));
                        let step_y = rows.step(level, ay.abs_diff(y as u32));
                        sums[at] += falloff.apply(height, factors[step_x][step_y]);
                        if counts[at] == 0 {
                            next.insert(ax, ay);
                        }
                        counts[at] += 1;
                    }
                });
            });
        }
        // The parents stay in the set: they are the next round's children.
        for y in 0..n_rows {
            if next.in_row[y] == 0 {
                continue;
            }
            next.drain_row(y, |x| {
                let at = y * n_cols + x as usize;
                let mean = sums[at] / f64::from(counts[at]);
                heights[at] = settings.limit(mean) as f32;
                done.found += 1;
                active.insert(x, y as u32);
            });
        }
    }
    Ok(done)
}
