//! Ways for water out of closed depressions.

use std::collections::BTreeMap;

use orograph_core::prelude::*;

use crate::{
    adjust::elevation_constraints::Wanted,
    measure::drainage::flood::{Flood, OUT, beside, rank},
};

/// The cell that a way ends at leads nowhere.
const ROOT: u32 = u32::MAX;

/// Ways out of depressions, as trees of cells.
#[derive(Default)]
pub(super) struct Ways {
    /// The cells, and for each the place in this list of the one that it leads to.
    cells: Vec<usize>,
    next: Vec<u32>,
}

impl Ways {
    /// From each of `lows` that is more than `limit` metres below the way from it, the way of the flood as far as lower ground
    /// or another way. The lowest come first: what is on a way that starts lower is to be lower, too.
    pub(super) fn from(
        mut lows: Vec<usize>,
        limit: f64,
        terrain: &Heightfield,
        flooded: &Flood,
        job: &Job<'_>,
    ) -> Result<Self> {
        let (heights, size) = (terrain.cells(), terrain.grid().size());
        lows.sort_unstable_by_key(|&cell| rank(heights[cell], cell));
        let before = |&cell: &usize| {
            let from = flooded.came_from[cell];
            if from < OUT { beside(size, cell, from.into()) } else { None }
        };
        let mut ways = Self::default();
        let mut places: BTreeMap<usize, u32> = BTreeMap::new();
        for bottom in lows {
            job.check()?;
            let (mut way, mut highest) = (Vec::new(), heights[bottom]);
            for cell in std::iter::successors(Some(bottom), before) {
                way.push(cell);
                highest = highest.max(heights[cell]);
                if heights[cell] < heights[bottom] || places.contains_key(&cell) {
                    break;
                }
            }
            if f64::from(highest) - f64::from(heights[bottom]) <= limit {
                continue;
            }
            let mut next = ROOT;
            for cell in way.into_iter().rev() {
                next = *places.entry(cell).or_insert_with(|| {
                    ways.cells.push(cell);
                    ways.next.push(next);
                    (ways.cells.len() - 1) as u32
                });
            }
        }
        Ok(ways)
    }

    /// Heights along the ways that never rise, and are nowhere higher than the terrain; the cells of `kept` stay.
    pub(super) fn falling(&self, terrain: &Heightfield, kept: &[bool]) -> Result<Wanted> {
        let mut heights: Vec<f32> = self.cells.iter().map(|&cell| terrain.cells()[cell]).collect();
        // A cell comes after the one that it leads to.
        for (i, &next) in self.next.iter().enumerate().rev() {
            if next != ROOT {
                heights[next as usize] = heights[next as usize].min(heights[i]);
            }
        }
        let kept =
            (0..kept.len()).filter(|&cell| kept[cell]).map(|cell| (cell, f64::from(terrain.cells()[cell])));
        Wanted::new(self.cells.iter().copied().zip(heights.into_iter().map(f64::from)).chain(kept).collect())
    }
}
