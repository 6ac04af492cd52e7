//! Priority-flood: closed depressions filled to their spill level.
//!
//! Barnes, R., Lehman, C. and Mulla, D. (2014), "Priority-flood: an optimal depression-filling and
//! watershed-labeling algorithm for digital elevation models", Computers & Geosciences 62, the improved variant: a
//! plain queue for cells at or below the water, a heap for the others. Water leaves over the border and into voids.

use std::{
    cmp::Reverse,
    collections::{BinaryHeap, VecDeque},
};

use orograph_core::prelude::*;

/// Steps of row and column to the eight neighbours; the one across is four further on.
pub(crate) const NEIGHBOURS: [(isize, isize); 8] =
    [(-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1)];
/// The direction of a cell from which water leaves the terrain.
pub(crate) const OUT: u8 = 8;
/// The direction of a void.
pub(super) const VOID: u8 = 9;

/// A terrain after the flood.
#[derive(Debug)]
pub struct Flood {
    /// The terrain with every closed depression filled to its spill level; infinite heights are voids.
    pub filled: Heightfield,
    /// Known cells in the order in which the flood reached them: never from higher to lower filled ground.
    pub(super) order: Vec<u32>,
    /// For each cell, which neighbour the flood came from.
    pub(crate) came_from: Vec<u8>,
}

/// The cell a step away; `None` outside.
#[inline]
pub(crate) fn beside((rows, cols): (usize, usize), cell: usize, direction: usize) -> Option<usize> {
    let (down, right) = NEIGHBOURS[direction];
    let row = (cell / cols).checked_add_signed(down).filter(|&row| row < rows)?;
    let col = (cell % cols).checked_add_signed(right).filter(|&col| col < cols)?;
    Some(row * cols + col)
}

/// The neighbours of a cell, each with the direction in which it lies. Away from the border that takes no checks, and
/// there most cells are.
#[inline]
pub(crate) fn around(size: (usize, usize), cell: usize) -> impl Iterator<Item = (usize, usize)> {
    let (rows, cols) = size;
    let (row, col) = (cell / cols, cell % cols);
    let is_inside = row > 0 && col > 0 && row + 1 < rows && col + 1 < cols;
    NEIGHBOURS.into_iter().enumerate().filter_map(move |(direction, (down, right))| {
        let other = if is_inside {
            cell.checked_add_signed(down * cols as isize + right)
        } else {
            beside(size, cell, direction)
        };
        Some((direction, other?))
    })
}

/// Whether water leaves the terrain from a cell: it lies at the border or beside a void.
pub(crate) fn leaves(terrain: &Heightfield, cell: usize) -> bool {
    let known = |(_, other): (usize, usize)| terrain.cells()[other].is_finite();
    around(terrain.grid().size(), cell).filter(|&near| known(near)).count() < NEIGHBOURS.len()
}

/// Floods a terrain from its border and its voids.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory or cells are too many to count, [`Error::Cancelled`].
pub fn flood(terrain: &Heightfield, job: &Job) -> Result<Flood> {
    flood_to(terrain, |_| false, job)
}

/// [`flood`] where water may also end at the cells that `is_sink`, which stay at their heights.
///
/// # Errors
/// Those of [`flood`].
pub fn flood_to(terrain: &Heightfield, is_sink: impl Fn(usize) -> bool, job: &Job) -> Result<Flood> {
    flood_by(terrain, is_sink, false, job)
}

/// [`flood_to`] that goes on at the lowest ground under water, too, not just anywhere: the way from a cell to the outlet
/// passes over the lowest saddles between its basin's parts.
///
/// # Errors
/// Those of [`flood`].
pub(crate) fn flood_along_lows(
    terrain: &Heightfield,
    is_sink: impl Fn(usize) -> bool,
    job: &Job,
) -> Result<Flood> {
    flood_by(terrain, is_sink, true, job)
}

fn flood_by(
    terrain: &Heightfield,
    is_sink: impl Fn(usize) -> bool,
    along_lows: bool,
    job: &Job,
) -> Result<Flood> {
    let grid = terrain.grid();
    let size = grid.size();
    let count = u32::try_from(grid.len()).map_err(|_| Error::TooLarge {
        what: format!("a flood over {} × {} cells", grid.rows, grid.cols),
        bytes: grid.len() as u64 * 13,
        limit: u64::from(u32::MAX) * 13,
    })?;
    job.admit(u64::from(count) * 13, || format!("a flood over {} × {} cells", grid.rows, grid.cols))?;
    let mut filled: Heightfield =
        terrain.map(job, |height| if height.is_finite() { height } else { f32::NAN })?;
    const UNSEEN: u8 = 255;
    let mut came_from = vec![UNSEEN; grid.len()];
    let mut order = Vec::with_capacity(grid.len());
    let mut heap = BinaryHeap::new();

    let known = |cell: usize| terrain.cells()[cell].is_finite();
    for (cell, from) in came_from.iter_mut().enumerate() {
        if cell.is_multiple_of(1 << 16) {
            job.check()?;
        }
        if !known(cell) {
            *from = VOID;
        } else if is_sink(cell) || leaves(terrain, cell) {
            *from = OUT;
            heap.push(Reverse(rank(terrain.cells()[cell], cell)));
        }
    }

    let done = job.stage(u64::from(count));
    let heights = filled.cells_mut();
    let mut under_water: VecDeque<u32> = VecDeque::new();
    loop {
        let cell = match under_water.pop_front() {
            Some(cell) => cell as usize,
            None => match heap.pop() {
                Some(Reverse(rank)) => (rank & u64::from(u32::MAX)) as usize,
                None => break,
            },
        };
        order.push(cell as u32);
        if order.len().is_multiple_of(1 << 14) {
            job.check()?;
            done.advance(1 << 14);
        }
        let level = heights[cell];
        for (direction, other) in around(size, cell) {
            if came_from[other] != UNSEEN {
                continue;
            }
            came_from[other] = ((direction + 4) % 8) as u8;
            let own = heights[other];
            heights[other] = own.max(level);
            if own > level || along_lows {
                heap.push(Reverse(rank(own, other)));
            } else {
                under_water.push_back(other as u32);
            }
        }
    }
    Ok(Flood { filled, order, came_from })
}

/// Orders cells by height, then by index.
pub(crate) fn rank(height: f32, cell: usize) -> u64 {
    // Adding zero makes one number of both zeros; the bits of negative numbers run backwards.
    let bits = (height + 0.0).to_bits();
    let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(ascending) << 32 | cell as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    /// The least level at which each cell can drain, by relaxation until nothing changes.
    fn by_relaxation(terrain: &Heightfield) -> Vec<f32> {
        let size = terrain.grid().size();
        let cells = terrain.cells();
        let mut levels: Vec<f32> =
            cells.iter().map(|z| if z.is_nan() { *z } else { f32::INFINITY }).collect();
        loop {
            let mut changed = false;
            for cell in (0..cells.len()).filter(|&cell| !cells[cell].is_nan()) {
                let over = |direction| match beside(size, cell, direction) {
                    Some(other) if !cells[other].is_nan() => levels[other],
                    _ => f32::NEG_INFINITY,
                };
                let least = (0..8).map(over).fold(f32::INFINITY, f32::min).max(cells[cell]);
                if least < levels[cell] {
                    levels[cell] = least;
                    changed = true;
                }
            }
            if !changed {
                return levels;
            }
        }
    }

    #[test]
    fn levels_are_the_least_at_which_water_gets_out() {
        for seed in 0..20 {
            let noise = |row: usize, col: usize| orograph_core::gaussian(seed, 1, row as i64, col as i64);
            let terrain = field(17, 23, |row, col| {
                let void = orograph_core::key(seed, 9, row as i64, col as i64).is_multiple_of(41);
                if void { f64::NAN } else { (noise(row, col) * 4.0).round() }
            });
            let flood = flood(&terrain, &Job::detached()).unwrap();
            let expected = by_relaxation(&terrain);
            for (found, expected) in flood.filled.cells().iter().zip(&expected) {
                assert!(found == expected || found.is_nan() && expected.is_nan());
            }
            assert_eq!(flood.order.len() + terrain.void_count(), 17 * 23);
            let heights: Vec<f32> = flood.order.iter().map(|&i| flood.filled.cells()[i as usize]).collect();
            assert!(heights.windows(2).all(|pair| pair[0] <= pair[1]));
        }
    }

    #[test]
    fn ways_along_lows_pass_over_the_lowest_saddles_under_water_too() {
        for seed in 0..20 {
            let noise = |row: usize, col: usize| orograph_core::gaussian(seed, 2, row as i64, col as i64);
            let terrain = field(17, 23, |row, col| {
                let rim = row.min(16 - row).min(col.min(22 - col)) < 2;
                noise(row, col) + if rim { 8.0 } else { 0.0 }
            });
            let job = Job::detached();
            let (plain, lows) =
                (flood(&terrain, &job).unwrap(), flood_along_lows(&terrain, |_| false, &job).unwrap());
            assert_eq!(plain.filled.cells(), lows.filled.cells());
            // To each cell of a way from the lowest one no other way stays lower.
            let cells = terrain.cells();
            let start = (0..cells.len()).min_by(|&a, &b| cells[a].total_cmp(&cells[b])).unwrap();
            let mut levels = vec![f32::INFINITY; cells.len()];
            levels[start] = cells[start];
            for _ in 0..cells.len() {
                for cell in 0..cells.len() {
                    let nearest = around((17, 23), cell).map(|(_, other)| levels[other]);
                    levels[cell] = levels[cell].min(nearest.fold(f32::INFINITY, f32::min).max(cells[cell]));
                }
            }
            let (mut cell, mut highest) = (start, cells[start]);
            while lows.came_from[cell] < OUT {
                cell = beside((17, 23), cell, lows.came_from[cell].into()).unwrap();
                highest = highest.max(cells[cell]);
                assert_eq!(highest, levels[cell]);
            }
            assert!(lows.came_from[cell] == OUT && highest > cells[start]);
        }
    }

    #[test]
    fn ranks_ascend_with_height() {
        let heights = [-1e9, -2.0, -0.5, 0.0, 1e-30, 3.0, 9e9];
        assert!(heights.windows(2).all(|pair| rank(pair[0], 7) < rank(pair[1], 0)));
        assert_eq!(rank(-0.0, 3), rank(0.0, 3));
    }
}
