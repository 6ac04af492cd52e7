//! Rivers: from springs beside the ridges along the lowest ways to the border, and into one another.
//!
//! From every cell there is one best way out to the border that crosses no ridge, where high ground costs more than
//! low ground. The ways of all cells make a forest (Dijkstra 1959), so rivers that meet stay together, and none runs in a circle.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap},
    f64::consts::TAU,
};

use orograph_core::prelude::*;
use orograph_core::{key, unit};
use rayon::prelude::*;

use crate::mcmd::skeleton::diagonal;

/// Stream of the springs.
const STREAM: u64 = 0x7269_7672;

/// Cells from a ridge to a spring beside it.
const BESIDE: f64 = 3.0;

/// Springs tried for each river before it is given up.
const TRIES: i64 = 16;

/// How dear high ground is: a cell at the height of the relief costs e to this times as much as one at 0 m.
const DEARNESS: f64 = 6.0;

/// Bound of that exponent, for ground that lies far outside the relief.
const DEAREST: f64 = 20.0;

/// Height of a spring as a share of that of the ridge beside it.
const CUT: f64 = 0.6;

/// Share of a river's fall that is spread evenly; the rest is steeper the nearer the spring.
const EVEN: f64 = 0.3;

/// Cells between two questions whether the run was cancelled.
const ROUND: usize = 4096;

/// Cells of all rivers.
#[derive(Debug, Default)]
pub(super) struct Rivers {
    /// Height of each cell.
    pub(super) heights: BTreeMap<usize, f32>,
    /// The cell that each flows into; a mouth flows nowhere.
    pub(super) downstream: BTreeMap<usize, usize>,
}

/// Traces `count` rivers over `surface` between `ridges`.
///
/// # Errors
/// Cancellation, and too little memory for the ways.
pub(super) fn trace(
    ridges: &Heightfield,
    surface: &Heightfield,
    relief: f64,
    count: u32,
    seed: u64,
    job: &Job<'_>,
) -> Result<Rivers> {
    let crest: Vec<usize> = (0..ridges.cells().len()).filter(|&i| !ridges.cells()[i].is_nan()).collect();
    let ways = ways_out(ridges, surface, relief, job)?;
    // A thousandth of the relief a cell, and no more than the relief along the diagonal of a large grid.
    let fall = relief * (1.0 / diagonal(ridges.grid())).min(1e-3);
    let mut land = Land { ridges, fall, ways, rivers: Rivers::default() };
    for river in 0..i64::from(count) {
        job.check()?;
        let spring = (0..TRIES).find_map(|attempt| {
            let draw = |what: i64| unit(key(seed, STREAM, river, attempt * 4 + what));
            let ridge = crest.get((draw(0) * crest.len() as f64) as usize)?;
            Some((land.spring(*ridge, draw(1) * TAU)?, f64::from(ridges.cells()[*ridge])))
        });
        if let Some((spring, crest)) = spring {
            land.run(spring, CUT * crest);
        }
    }
    Ok(land.rivers)
}

/// The next cell on the way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Ridges bar every way.
    None,
    /// The cell lies on the border.
    Out,
    /// Over that cell.
    Over(usize),
}

/// The best way out from every cell.
fn ways_out(ridges: &Heightfield, surface: &Heightfield, relief: f64, job: &Job<'_>) -> Result<Vec<Way>> {
    let (rows, cols) = ridges.grid().size();
    let n = rows * cols;
    job.admit(n as u64 * 56, || format!("the ways of rivers over {rows} × {cols} cells"))?;
    let is_ridge = |at: usize| !ridges.cells()[at].is_nan();
    // Each cell is looked at from up to eight others, so its cost is told beforehand.
    let cost = |&height: &f32| {
        let height = DEARNESS * f64::from(height) / relief;
        libm::exp(height.clamp(-DEAREST, DEAREST))
    };
    let costs: Vec<f64> = surface.cells().par_iter().with_min_len(ROUND).map(cost).collect();
    job.check()?;
    let mut ways = vec![Way::None; n];
    let mut best = vec![f64::INFINITY; n];
    // Costs are positive, so their bits sort as they do; the cell's place settles ties.
    let mut queue = BinaryHeap::new();
    for at in 0..n {
        let (row, col) = (at / cols, at % cols);
        let border = row == 0 || col == 0 || row + 1 == rows || col + 1 == cols;
        if border && !is_ridge(at) {
            (ways[at], best[at]) = (Way::Out, costs[at]);
            queue.push(Reverse((costs[at].to_bits(), at)));
        }
    }
    let mut taken = 0_usize;
    while let Some(Reverse((bits, at))) = queue.pop() {
        taken += 1;
        if taken.is_multiple_of(ROUND) {
            job.check()?;
        }
        let so_far = f64::from_bits(bits);
        if so_far > best[at] {
            continue;
        }
        let (row, col) = (at / cols, at % cols);
        for to_row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
            for to_col in col.saturating_sub(1)..=(col + 1).min(cols - 1) {
                let to = to_row * cols + to_col;
                let aslant = to_row != row && to_col != col;
                let squeezed = aslant && is_ridge(row * cols + to_col) && is_ridge(to_row * cols + col);
                if to == at || is_ridge(to) || squeezed {
                    continue;
                }
                let length = if aslant { std::f64::consts::SQRT_2 } else { 1.0 };
                let reached = so_far + length * costs[to];
                if reached < best[to] {
                    (ways[to], best[to]) = (Way::Over(at), reached);
                    queue.push(Reverse((reached.to_bits(), to)));
                }
            }
        }
    }
    Ok(ways)
}

struct Land<'a> {
    ridges: &'a Heightfield,
    fall: f64,
    ways: Vec<Way>,
    rivers: Rivers,
}

impl Land<'_> {
    /// A free cell beside a ridge, from which there is a way out.
    fn spring(&self, ridge: usize, direction: f64) -> Option<usize> {
        let (rows, cols) = self.ridges.grid().size();
        let row = ((ridge / cols) as f64 + BESIDE * libm::sin(direction)).round();
        let col = ((ridge % cols) as f64 + BESIDE * libm::cos(direction)).round();
        let inside = row >= 0.0 && col >= 0.0 && row < rows as f64 && col < cols as f64;
        let at = inside.then_some(row as usize * cols + col as usize)?;
        let free = self.ways[at] != Way::None && !self.rivers.heights.contains_key(&at);
        free.then_some(at)
    }

    /// Leads a river from its spring, at the height `start`, to the border or into another.
    fn run(&mut self, spring: usize, start: f64) {
        let mut course = vec![spring];
        let mut at = spring;
        let joined = loop {
            let Way::Over(next) = self.ways[at] else { break None };
            self.rivers.downstream.insert(at, next);
            if self.rivers.heights.contains_key(&next) {
                break Some(next);
            }
            course.push(next);
            at = next;
        };
        let end = joined.and_then(|at| self.rivers.heights.get(&at)).map_or(0.0, |&height| f64::from(height));
        let mut height = start;
        for (i, &at) in course.iter().enumerate() {
            let left = 1.0 - i as f64 / course.len() as f64;
            let graded = end + (start - end).max(0.0) * left * (EVEN + (1.0 - EVEN) * left);
            if i > 0 {
                height = graded.min(self.below(height));
            }
            self.rivers.heights.insert(at, height as f32);
        }
        if let Some(at) = joined {
            self.lower_downstream(at, height);
        }
    }

    /// The highest that a river may be one cell further down; it nears 0 m and never sinks below.
    fn below(&self, height: f64) -> f64 {
        height - self.fall.min(height * 0.01)
    }

    /// Lowers a river from the cell where another joins it, as far as it lies above what flows in.
    fn lower_downstream(&mut self, mut at: usize, mut height: f64) {
        loop {
            height = self.below(height);
            match self.rivers.heights.get_mut(&at) {
                Some(old) if f64::from(*old) > height => *old = height as f32,
                _ => return,
            }
            match self.rivers.downstream.get(&at) {
                Some(&next) => at = next,
                None => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcmd::skeleton::{Skeleton, spanned};

    #[test]
    fn rivers_fall_to_their_mouths_and_never_touch_a_ridge() {
        let job = Job::detached();
        for seed in 0..8 {
            let node = Skeleton { ridges: 10, ..Skeleton::default() };
            let grid = Grid::new(150, 180, CellSize::square(10.0)).unwrap();
            let ridges = node.draw_ridges(grid, seed, &job).unwrap();
            let surface = spanned(&ridges, 2000.0, seed, &job).unwrap();
            let rivers = trace(&ridges, &surface, 2000.0, 60, seed, &job).unwrap();
            let mut joined = 0;
            for (&cell, &height) in &rivers.heights {
                assert!(ridges.cells()[cell].is_nan());
                assert!((0.0..=2000.0).contains(&height));
                match rivers.downstream.get(&cell) {
                    Some(next) => {
                        assert!(rivers.heights[next] < height, "{} after {height}", rivers.heights[next]);
                        joined += 1;
                    }
                    // A river without a way on has come to the border.
                    None => {
                        let (row, col) = (cell / 180, cell % 180);
                        assert!(row % 149 == 0 || col % 179 == 0, "a mouth at {row}, {col}");
                    }
                }
            }
            // Following the water ends at a mouth.
            for &cell in rivers.heights.keys() {
                let mut at = cell;
                let mut steps = 0;
                while let Some(&next) = rivers.downstream.get(&at) {
                    at = next;
                    steps += 1;
                    assert!(steps <= rivers.heights.len());
                }
            }
            assert!(joined > 500, "{joined}");
        }
    }

    #[test]
    fn ways_keep_to_the_valley_and_off_the_ridge() {
        let job = Job::detached();
        let grid = Grid::new(9, 21, CellSize::square(1.0)).unwrap();
        // A trough along row 4, barred by a ridge across its western end; everything else is high.
        let mut surface = Heightfield::filled(grid.clone(), 900.0, &job).unwrap();
        surface.cells_mut()[4 * 21..5 * 21].fill(0.0);
        let mut ridges = Heightfield::filled(grid, f32::NAN, &job).unwrap();
        (0..8).for_each(|row| ridges.cells_mut()[row * 21 + 2] = 1000.0);
        let ways = ways_out(&ridges, &surface, 1000.0, &job).unwrap();
        assert!(ways[4 * 21 + 2] == Way::None);
        for col in 3..20 {
            assert_eq!(ways[4 * 21 + col], Way::Over(4 * 21 + col + 1));
        }
        assert_eq!(ways[4 * 21 + 20], Way::Out);
    }
}
