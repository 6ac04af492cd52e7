//! The band along the edge of a mask.

use orograph_core::prelude::*;

/// 1 where the window of `reach` cells to each side holds cells inside (of at least one half) and outside the mask;
/// linear in the number of cells, whatever the reach.
pub(super) fn rim(mask: &Mask, reach: usize, job: &Job) -> Result<Mask> {
    let (rows, cols) = mask.grid().size();
    let mut rim = Mask::filled(mask.grid().clone(), 0.0, job)?;
    if rim.grid().is_empty() {
        return Ok(rim);
    }
    let span = |at: usize, n: usize| (at.saturating_sub(reach), at.saturating_add(reach + 1).min(n));
    // How many cells of each window are inside, over the rows from `first` to before `last`.
    let (mut inside, mut first, mut last) = (vec![0_u32; cols], 0, 0);
    let mut before = vec![0_u32; cols + 1];
    for row in 0..rows {
        job.check()?;
        let (top, bottom) = span(row, rows);
        let mut each = |row: usize, change: fn(u32, u32) -> u32| {
            for (col, &share) in mask.row(row).iter().enumerate() {
                before[col + 1] = before[col] + u32::from(share >= 0.5);
            }
            for (col, inside) in inside.iter_mut().enumerate() {
                let (left, right) = span(col, cols);
                *inside = change(*inside, before[right] - before[left]);
            }
        };
        while last < bottom {
            each(last, |sum, part| sum + part);
            last += 1;
        }
        while first < top {
            each(first, |sum, part| sum - part);
            first += 1;
        }
        let out = &mut rim.cells_mut()[row * cols..][..cols];
        for (col, (out, &inside)) in out.iter_mut().zip(&inside).enumerate() {
            let (left, right) = span(col, cols);
            let all = ((bottom - top) * (right - left)) as u32;
            *out = if inside > 0 && inside < all { 1.0 } else { 0.0 };
        }
    }
    Ok(rim)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rim_is_where_a_window_holds_both_kinds() {
        for (rows, cols) in [(0, 3), (1, 1), (1, 9), (7, 1), (13, 11)] {
            for reach in [1, 2, 8] {
                for limit in [0.3, 0.5, 0.97, 2.0] {
                    let grid = Grid::new(rows, cols, CellSize::square(1.0)).unwrap();
                    let noise =
                        |i: usize| orograph_core::unit(orograph_core::key(1, 2, i as i64, reach as i64));
                    let cells = (0..rows * cols).map(|i| if noise(i) < limit { 0.2 } else { 0.5 }).collect();
                    let mask = Mask::new(grid, cells).unwrap();
                    let found = rim(&mask, reach, &Job::detached()).unwrap();
                    let near = |a: usize, b: usize| a.abs_diff(b) <= reach;
                    for at in 0..rows * cols {
                        let own = mask.cells()[at];
                        let other = (0..rows * cols).any(|i| {
                            near(i / cols, at / cols) && near(i % cols, at % cols) && mask.cells()[i] != own
                        });
                        assert_eq!(
                            found.cells()[at],
                            f32::from(u8::from(other)),
                            "{rows} × {cols}, {reach}, {at}"
                        );
                    }
                }
            }
        }
    }
}
