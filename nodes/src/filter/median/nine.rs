//! The median of three by three cells, which needs no ranks: columns are sorted once, and three of them have the middle
//! height of all nine as the middle one of the largest low, the middle middle and the smallest high.

use orograph_core::prelude::*;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::{ordered, unordered};

/// As [`super::median`] with a radius of 1.
pub(super) fn median(terrain: &Heightfield, job: &Job<'_>) -> Result<Heightfield> {
    let (rows, cols) = terrain.grid().size();
    let arch = Arch::new();
    let none_void = |row: &[f32]| !row.iter().fold(false, |any, height| any | height.is_nan());
    let known: Vec<bool> = terrain.cells().par_chunks(cols.max(1)).with_min_len(16).map(none_void).collect();
    Heightfield::build_lots(terrain.grid().clone(), 1, job, |row, out| {
        let inner = row > 0 && row + 1 < rows && cols > 2;
        if inner && known[row - 1..=row + 1] == [true; 3] {
            let lines = [terrain.row(row - 1), terrain.row(row), terrain.row(row + 1)];
            arch.dispatch(Line { lines, out: &mut *out });
            out[0] = at(terrain, row, 0);
            out[cols - 1] = at(terrain, row, cols - 1);
        } else {
            out.iter_mut().enumerate().for_each(|(col, out)| *out = at(terrain, row, col));
        }
        Ok(())
    })
}

/// The median around one cell, wherever it lies.
fn at(terrain: &Heightfield, row: usize, col: usize) -> f32 {
    if terrain.at(row, col).is_nan() {
        return f32::NAN;
    }
    let (mut seen, mut n) = ([0; 9], 0);
    for row in row.saturating_sub(1)..(row + 2).min(terrain.rows()) {
        for col in col.saturating_sub(1)..(col + 2).min(terrain.cols()) {
            let height = terrain.at(row, col);
            if !height.is_nan() {
                seen[n] = ordered(height);
                n += 1;
            }
        }
    }
    seen[..n].sort_unstable();
    let (lower, upper) = (unordered(seen[(n - 1) / 2]), unordered(seen[n / 2]));
    if lower == upper { lower } else { ((f64::from(lower) + f64::from(upper)) / 2.0) as f32 }
}

/// A line of cells between two others, without voids and without its ends.
struct Line<'a> {
    lines: [&'a [f32]; 3],
    out: &'a mut [f32],
}

/// Columns that are sorted together.
const SPAN: usize = 64;

impl NullaryFnOnce for Line<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let [above, here, below] = self.lines;
        let cols = here.len();
        let (mut low, mut middle, mut high) = ([0_u32; SPAN + 2], [0_u32; SPAN + 2], [0_u32; SPAN + 2]);
        for start in (1..cols - 1).step_by(SPAN) {
            let n = SPAN.min(cols - 1 - start);
            let seen = start - 1..start + n + 1;
            let columns = above[seen.clone()].iter().zip(&here[seen.clone()]).zip(&below[seen]);
            for (((low, middle), high), ((&a, &b), &c)) in
                low.iter_mut().zip(&mut middle).zip(&mut high).zip(columns)
            {
                let (a, b, c) = (ordered(a), ordered(b), ordered(c));
                let (small, large) = (a.min(b), a.max(b));
                *low = small.min(c);
                *middle = middle_of(a, b, c);
                *high = large.max(c);
            }
            for (i, out) in self.out[start..start + n].iter_mut().enumerate() {
                let lowest = low[i].max(low[i + 1]).max(low[i + 2]);
                let highest = high[i].min(high[i + 1]).min(high[i + 2]);
                *out =
                    unordered(middle_of(lowest, middle_of(middle[i], middle[i + 1], middle[i + 2]), highest));
            }
        }
    }
}

#[inline(always)]
fn middle_of(a: u32, b: u32, c: u32) -> u32 {
    a.max(b).min(c).max(a.min(b))
}
