//! The channel out of a depression that cuts least.

use std::{cmp::Reverse, collections::BinaryHeap};

use orograph_core::prelude::*;

use super::Ground;
use crate::measure::drainage::flood::{NEIGHBOURS, around, beside};

/// Dijkstra's algorithm from one cell after another, on memory taken once.
pub(super) struct Search {
    cols: usize,
    cell: CellSize,
    far: [f64; 8],
    /// Deepest cut allowed, in metres.
    pub(super) max_depth: f64,
    max_length: f64,
    /// Metres cut and metres gone to each cell.
    costs: Vec<[f64; 2]>,
    came_from: Vec<u8>,
    /// Which search saw a cell last.
    round: Vec<u32>,
    rounds: u32,
    heap: BinaryHeap<Reverse<[u64; 3]>>,
}

/// The direction of the cell where a search began.
const START: u8 = 8;

impl Search {
    /// Limits of depth and length in metres; 0 for none.
    pub(super) fn new(grid: &Grid, [max_depth, max_length]: [f64; 2], job: &Job) -> Result<Self> {
        let n = grid.len();
        let bytes = n as u64 * 21;
        if n > u32::MAX as usize {
            let limit = u64::from(u32::MAX) * 21;
            return Err(Error::TooLarge { what: format!("the ways over {n} cells"), bytes, limit });
        }
        job.admit(bytes, || format!("the ways over {n} cells"))?;
        let cell = grid.cell;
        let unlimited = |limit: f64| if limit > 0.0 { limit } else { f64::INFINITY };
        Ok(Self {
            cols: grid.cols,
            cell,
            far: NEIGHBOURS.map(|(down, right)| libm::hypot(down as f64 * cell.y, right as f64 * cell.x)),
            max_depth: unlimited(max_depth),
            max_length: unlimited(max_length),
            costs: vec![[0.0; 2]; n],
            came_from: vec![START; n],
            round: vec![0; n],
            rounds: 0,
            heap: BinaryHeap::new(),
        })
    }

    /// The cells from `start` to the first lower cell or outlet, by the way that cuts the least sum of depths below
    /// level ground; of equals by the shortest. `None` when the limits allow none.
    pub(super) fn channel(
        &mut self,
        heights: &[f32],
        ground: &Ground<'_>,
        start: usize,
        job: &Job,
    ) -> Result<Option<Vec<usize>>> {
        let bottom = heights[start];
        self.rounds += 1;
        self.heap.clear();
        self.reach(start, [0.0; 2], START);
        let mut n_done = 0_u64;
        while let Some(Reverse([cut, gone, cell])) = self.heap.pop() {
            n_done += 1;
            if n_done.is_multiple_of(1 << 12) {
                job.check()?;
            }
            let (cell, cost) = (cell as usize, [cut, gone].map(f64::from_bits));
            if cost != self.costs[cell] {
                continue;
            }
            if heights[cell] < bottom || ground.is_outlet[cell] {
                return Ok(Some(self.way(ground.size, cell)));
            }
            for (direction, other) in around(ground.size, cell) {
                // A void gives NaN, which is within no limit.
                let depth = f64::from(heights[other]) - f64::from(bottom);
                let within = depth <= self.max_depth && self.away(start, other) <= self.max_length;
                if !within || depth > 0.0 && ground.lakes.at(other) {
                    continue;
                }
                let cost = [cost[0] + depth.max(0.0), cost[1] + self.far[direction]];
                if self.round[other] != self.rounds || cost < self.costs[other] {
                    self.reach(other, cost, ((direction + 4) % 8) as u8);
                }
            }
        }
        Ok(None)
    }

    fn reach(&mut self, cell: usize, cost: [f64; 2], from: u8) {
        (self.costs[cell], self.came_from[cell], self.round[cell]) = (cost, from, self.rounds);
        // Costs are not negative, so their bits ascend as they do.
        self.heap.push(Reverse([cost[0].to_bits(), cost[1].to_bits(), cell as u64]));
    }

    /// Metres between two cells, straight.
    fn away(&self, a: usize, b: usize) -> f64 {
        let down = (a / self.cols).abs_diff(b / self.cols) as f64 * self.cell.y;
        let right = (a % self.cols).abs_diff(b % self.cols) as f64 * self.cell.x;
        (down * down + right * right).sqrt()
    }

    fn way(&self, size: (usize, usize), end: usize) -> Vec<usize> {
        let mut way = vec![end];
        let mut cell = end;
        while let Some(before) = Some(self.came_from[cell])
            .filter(|&from| from != START)
            .and_then(|from| beside(size, cell, from.into()))
        {
            way.push(before);
            cell = before;
        }
        way.reverse();
        way
    }
}

/// Lowers the cells of a channel so that it falls evenly from its bottom to its end, or less where that would cut deeper
/// than `max_depth` metres, and nowhere rises.
pub(super) fn cut(heights: &mut [f32], channel: &[usize], max_depth: f64) {
    let (Some(&start), Some(&end)) = (channel.first(), channel.last()) else { return };
    let bottom = heights[start];
    // Ground as level as the bottom needs no channel.
    let level = channel.iter().take_while(|&&cell| heights[cell] == bottom).count();
    let rest = &channel[level.min(channel.len() - 1)..];
    let fall = f64::from(bottom) - f64::from(heights[end].min(bottom));
    // Backwards, as what may not be cut keeps up all that lies above it.
    let mut least = f64::NEG_INFINITY;
    for (i, &cell) in rest.iter().enumerate().rev() {
        let share = (i + 1) as f64 / rest.len() as f64;
        least = least.max(f64::from(heights[cell]) - max_depth);
        heights[cell] = heights[cell].min((f64::from(bottom) - fall * share).max(least) as f32);
    }
}

#[cfg(test)]
mod tests {
    use orograph_core::{gaussian, key};

    use super::*;
    use crate::{
        repair::{breach_depressions::outlets, lakes::Lakes},
        test_fields::field,
    };

    /// The least cost from `start` to lower ground or an outlet, by relaxation until nothing changes.
    fn by_relaxation(heights: &[f32], ground: &Ground<'_>, start: usize, max_depth: f64) -> f64 {
        let n = heights.len();
        let mut costs = vec![f64::INFINITY; n];
        costs[start] = 0.0;
        let ends = |cell: usize| heights[cell] < heights[start] || ground.is_outlet[cell];
        loop {
            let mut changed = false;
            for cell in (0..n).filter(|&cell| !ends(cell)) {
                for other in (0..8).filter_map(|d| beside(ground.size, cell, d)) {
                    let depth = f64::from(heights[other]) - f64::from(heights[start]);
                    let cost = costs[cell] + depth.max(0.0);
                    if depth <= max_depth && cost < costs[other] {
                        costs[other] = cost;
                        changed = true;
                    }
                }
            }
            if !changed {
                return (0..n)
                    .filter(|&cell| ends(cell))
                    .map(|cell| costs[cell])
                    .fold(f64::INFINITY, f64::min);
            }
        }
    }

    #[test]
    fn no_channel_cuts_less() {
        for seed in 0..30 {
            let terrain = field(12, 15, |row, col| {
                let (r, c) = (row as i64, col as i64);
                let void = key(seed, 9, r, c).is_multiple_of(60);
                if void { f64::NAN } else { (8.0 * gaussian(seed, 1, r, c)).round() }
            });
            let job = Job::detached();
            let lakes = Lakes::new(&terrain, None).unwrap();
            let is_outlet = outlets(&terrain, lakes, &job).unwrap();
            let ground = Ground { size: (12, 15), is_outlet, lakes };
            let heights = terrain.cells();
            for max_depth in [0.0, 6.0] {
                let mut search = Search::new(terrain.grid(), [max_depth, 0.0], &job).unwrap();
                for start in (0..180).filter(|&i| heights[i].is_finite() && !ground.is_outlet[i]) {
                    let limit = if max_depth > 0.0 { max_depth } else { f64::INFINITY };
                    let least = by_relaxation(heights, &ground, start, limit);
                    let Some(way) = search.channel(heights, &ground, start, &job).unwrap() else {
                        assert_eq!(least, f64::INFINITY);
                        continue;
                    };
                    let depth = |&cell: &usize| f64::from(heights[cell] - heights[start]).max(0.0);
                    assert_eq!(way.iter().map(depth).sum::<f64>(), least, "{seed} {start}");
                    assert!(
                        way[0] == start
                            && way.windows(2).all(|pair| {
                                (0..8).any(|d| beside(ground.size, pair[0], d) == Some(pair[1]))
                            })
                    );
                    let mut after = heights.to_vec();
                    cut(&mut after, &way, limit);
                    assert!(
                        heights
                            .iter()
                            .zip(&after)
                            .all(|(old, new)| old.is_nan() || f64::from(old - new) <= limit)
                    );
                    assert!(way.windows(2).all(|pair| after[pair[0]] >= after[pair[1]]));
                }
            }
        }
    }
}
