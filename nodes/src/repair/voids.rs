//! Connected voids: which cells belong together, and where they lie.

use orograph_core::prelude::*;

/// Cells to fill that hang together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Void {
    /// Its cells as row-major indices, ascending.
    pub cells: Vec<usize>,
    /// First row and column.
    pub first: [usize; 2],
    /// Last row and column.
    pub last: [usize; 2],
    /// Columns of the raster.
    pub cols: usize,
}

impl Void {
    /// Rows and columns of its box.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [0, 1].map(|axis| self.last[axis] - self.first[axis] + 1)
    }

    /// Row and column of a cell.
    #[must_use]
    pub fn place(&self, cell: usize) -> [usize; 2] {
        [cell / self.cols, cell % self.cols]
    }
}

/// The cells west, north, east and south of a cell, in a raster of `rows` × `cols`.
#[must_use]
pub fn around(i: usize, (rows, cols): (usize, usize)) -> [Option<usize>; 4] {
    let (row, col) = (i / cols, i % cols);
    [
        (col > 0).then(|| i - 1),
        (row > 0).then(|| i - cols),
        (col + 1 < cols).then_some(i + 1),
        (row + 1 < rows).then_some(i + cols),
    ]
}

/// The voids of a raster, by their first cells in row-major order. Cells hang together when one lies within `reach` rows
/// and columns of the other, or beside it when `reach` is zero.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub fn find(
    (rows, cols): (usize, usize),
    reach: usize,
    is_void: impl Fn(usize) -> bool,
    job: &Job<'_>,
) -> Result<Vec<Void>> {
    job.admit((rows * cols) as u64, || "the search for voids".into())?;
    let mut seen = vec![false; rows * cols];
    let mut found = Vec::new();
    let mut stack = Vec::new();
    for start in 0..rows * cols {
        if start % cols == 0 {
            job.check()?;
        }
        if seen[start] || !is_void(start) {
            continue;
        }
        let mut void = Void { cells: Vec::new(), first: [start / cols, start % cols], last: [0, 0], cols };
        seen[start] = true;
        stack.push(start);
        while let Some(i) = stack.pop() {
            if void.cells.len().is_multiple_of(1 << 14) {
                job.check()?;
            }
            void.cells.push(i);
            let at = [i / cols, i % cols];
            for axis in [0, 1] {
                void.first[axis] = void.first[axis].min(at[axis]);
                void.last[axis] = void.last[axis].max(at[axis]);
            }
            let mut visit = |next: usize| {
                if !seen[next] && is_void(next) {
                    seen[next] = true;
                    stack.push(next);
                }
            };
            if reach == 0 {
                around(i, (rows, cols)).into_iter().flatten().for_each(visit);
                continue;
            }
            for row in at[0].saturating_sub(reach)..(at[0] + reach + 1).min(rows) {
                let row = row * cols;
                (row + at[1].saturating_sub(reach)..row + (at[1] + reach + 1).min(cols)).for_each(&mut visit);
            }
        }
        void.cells = in_order(void.cells, void.first[0], void.last[0], cols, job)?;
        found.push(void);
    }
    Ok(found)
}

/// Cells of rows `first` to `last` in ascending order. Row by row, so that the sorting of a large void can be cancelled.
fn in_order(cells: Vec<usize>, first: usize, last: usize, cols: usize, job: &Job<'_>) -> Result<Vec<usize>> {
    const FEW: usize = 1 << 16;
    if cells.len() <= FEW {
        let mut cells = cells;
        cells.sort_unstable();
        return Ok(cells);
    }
    let mut ends = vec![0; last - first + 1];
    cells.iter().for_each(|cell| ends[cell / cols - first] += 1);
    let mut end = 0;
    for row in &mut ends {
        end += std::mem::replace(row, end);
    }
    job.check()?;
    let mut sorted = vec![0; cells.len()];
    for (i, cell) in cells.into_iter().enumerate() {
        if i.is_multiple_of(FEW) {
            job.check()?;
        }
        let end = &mut ends[cell / cols - first];
        sorted[*end] = cell;
        *end += 1;
    }
    let mut start = 0;
    for end in ends {
        job.check()?;
        sorted[start..end].sort_unstable();
        start = end;
    }
    Ok(sorted)
}

/// Known heights kept, voids filled by row and column.
///
/// # Errors
/// Those of [`Heightfield::build`](orograph_core::Raster::build).
pub(super) fn fill_by_cell(
    terrain: &Heightfield,
    job: &Job<'_>,
    fill: impl Fn(usize, usize) -> f32 + Sync,
) -> Result<Heightfield> {
    Heightfield::build(terrain.grid().clone(), job, |row, out| {
        for (col, (out, &height)) in out.iter_mut().zip(terrain.row(row)).enumerate() {
            *out = if height.is_nan() { fill(row, col) } else { height };
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: [&str; 6] = ["..#....", ".##..#.", "....#..", "#......", "#.....#", "......#"];

    fn voids(reach: usize) -> Vec<Void> {
        let is_void = |i: usize| PICTURE[i / 7].as_bytes()[i % 7] == b'#';
        find((6, 7), reach, is_void, &Job::detached()).unwrap()
    }

    #[test]
    fn cells_that_touch_hang_together() {
        let found = voids(0);
        assert_eq!(found.len(), 5);
        assert_eq!(found[0], Void { cells: vec![2, 8, 9], first: [0, 1], last: [1, 2], cols: 7 });
        assert_eq!(found[0].size(), [2, 2]);
        assert_eq!(found[3], Void { cells: vec![21, 28], first: [3, 0], last: [4, 0], cols: 7 });
        assert_eq!(found.iter().map(|void| void.cells.len()).sum::<usize>(), 9);
    }

    #[test]
    fn reach_joins_what_lies_near() {
        assert_eq!(voids(1).len(), 4);
        assert_eq!(voids(2)[0].cells.len(), 9);
        assert_eq!(voids(6).len(), 1);
        assert!(find((0, 0), 1, |_| true, &Job::detached()).unwrap().is_empty());
    }
}
