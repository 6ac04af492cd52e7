//! Rivers: walkers that run down the surface between the ridges, and into one another.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use orograph_core::prelude::*;
use orograph_core::{key, unit};

use crate::mcmd::skeleton::diagonal;

/// Stream of the springs.
const STREAM: u64 = 0x7269_7672;

/// Cells from a ridge to a spring beside it.
const BESIDE: f64 = 3.0;

/// Springs tried for each river before it is given up.
const TRIES: i64 = 16;

/// How much of the old heading a river keeps at each cell.
const INERTIA: f64 = 0.6;

/// Cells that a river runs without finding lower ground before it takes the place for a pit and makes for the border.
const PATIENCE: usize = 8;

/// Share of the diagonal that it goes on like that before it ends as a lake.
const PERSISTENCE: f64 = 0.5;

/// Cells to either side between which the slope is taken.
const SLOPE_REACH: usize = 4;

/// Cells of all rivers.
#[derive(Debug, Default)]
pub(super) struct Rivers {
    /// Height of each cell.
    pub(super) heights: BTreeMap<usize, f32>,
    /// The cell that each flows into; a mouth flows nowhere.
    pub(super) downstream: BTreeMap<usize, usize>,
}

/// Traces `count` rivers down `surface` between `ridges`.
///
/// # Errors
/// Cancellation.
pub(super) fn trace(
    ridges: &Heightfield,
    surface: &Heightfield,
    relief: f64,
    count: u32,
    seed: u64,
    job: &Job<'_>,
) -> Result<Rivers> {
    let crest: Vec<usize> = (0..ridges.cells().len()).filter(|&i| !ridges.cells()[i].is_nan()).collect();
    // A thousandth of the relief a cell, and no more than the relief along the diagonal of a large grid.
    let fall = relief * (1.0 / diagonal(ridges.grid())).min(1e-3);
    let mut land = Land { ridges, surface, fall, rivers: Rivers::default() };
    for river in 0..i64::from(count) {
        let spring = (0..TRIES).find_map(|attempt| {
            let draw = |what: i64| unit(key(seed, STREAM, river, attempt * 4 + what));
            let ridge = crest.get((draw(0) * crest.len() as f64) as usize)?;
            land.spring(*ridge, draw(1) * TAU)
        });
        if let Some((cell, heading)) = spring {
            land.run(cell, heading, job)?;
        }
    }
    Ok(land.rivers)
}

struct Land<'a> {
    ridges: &'a Heightfield,
    surface: &'a Heightfield,
    fall: f64,
    rivers: Rivers,
}

type Cell = (usize, usize);

impl Land<'_> {
    fn index(&self, (row, col): Cell) -> usize {
        row * self.ridges.cols() + col
    }

    fn cell_at(&self, row: f64, col: f64) -> Option<Cell> {
        let (row, col) = (row.round(), col.round());
        let inside =
            row >= 0.0 && col >= 0.0 && row < self.ridges.rows() as f64 && col < self.ridges.cols() as f64;
        inside.then_some((row as usize, col as usize))
    }

    fn is_ridge(&self, (row, col): Cell) -> bool {
        !self.ridges.at(row, col).is_nan()
    }

    /// A free cell beside a ridge, and the direction that leads away from it.
    fn spring(&self, ridge: usize, direction: f64) -> Option<(Cell, (f64, f64))> {
        let (row, col) = (ridge / self.ridges.cols(), ridge % self.ridges.cols());
        let heading = (libm::sin(direction), libm::cos(direction));
        let cell = self.cell_at(row as f64 + BESIDE * heading.0, col as f64 + BESIDE * heading.1)?;
        let free = !self.is_ridge(cell) && !self.rivers.heights.contains_key(&self.index(cell));
        free.then_some((cell, heading))
    }

    /// Direction of steepest descent (rows, columns); none on level ground.
    fn descent(&self, (row, col): Cell) -> Option<(f64, f64)> {
        let (rows, cols) = self.surface.grid().size();
        let (up, down) = (row.saturating_sub(SLOPE_REACH), (row + SLOPE_REACH).min(rows - 1));
        let (west, east) = (col.saturating_sub(SLOPE_REACH), (col + SLOPE_REACH).min(cols - 1));
        let height = |row, col| f64::from(self.surface.at(row, col));
        let along_rows = (height(up, col) - height(down, col)) / down.abs_diff(up).max(1) as f64;
        let along_cols = (height(row, west) - height(row, east)) / east.abs_diff(west).max(1) as f64;
        unit_vector((along_rows, along_cols))
    }

    /// Direction of the nearest border.
    fn outward(&self, (row, col): Cell) -> (f64, f64) {
        let (rows, cols) = self.ridges.grid().size();
        let ways = [
            (row, (-1.0, 0.0)),
            (rows - 1 - row, (1.0, 0.0)),
            (col, (0.0, -1.0)),
            (cols - 1 - col, (0.0, 1.0)),
        ];
        ways.into_iter().min_by_key(|way| way.0).map_or((0.0, 0.0), |way| way.1)
    }

    /// The next cell from a place under a heading, turned as little as needed past ridges and the river itself; none
    /// at the border or where there is no way on.
    fn step(&self, here: (f64, f64), heading: (f64, f64), own: &[usize]) -> Option<Step> {
        let from = self.cell_at(here.0, here.1)?;
        for turn in (0..25).map(|k| f64::from((k + 1) / 2) * if k % 2 == 0 { 1.0 } else { -1.0 }) {
            let (sin, cos) = libm::sincos(turn * TAU / 24.0);
            let turned = (heading.0 * cos - heading.1 * sin, heading.0 * sin + heading.1 * cos);
            let place = (here.0 + turned.0, here.1 + turned.1);
            // Beyond the border lies the sea: the river ends in its last cell.
            let to = self.cell_at(place.0, place.1)?;
            let blocked = |cell: Cell| self.is_ridge(cell);
            let squeezed =
                to.0 != from.0 && to.1 != from.1 && blocked((to.0, from.1)) && blocked((from.0, to.1));
            if to == from || !(blocked(to) || squeezed || own.contains(&self.index(to))) {
                return Some(Step { place, cell: to, heading: turned });
            }
        }
        None
    }

    fn run(&mut self, spring: Cell, heading: (f64, f64), job: &Job<'_>) -> Result<()> {
        let mut place = (spring.0 as f64, spring.1 as f64);
        let mut cell = spring;
        let mut heading = heading;
        let mut height = f64::from(self.surface.at(cell.0, cell.1));
        let mut course = vec![self.index(cell)];
        self.rivers.heights.insert(course[0], height as f32);
        let patience = PATIENCE + (PERSISTENCE * diagonal(self.ridges.grid())) as usize;
        let (mut lowest, mut in_vain, mut way_out) = (height, 0, None);
        while in_vain < patience {
            job.check()?;
            let ground = f64::from(self.surface.at(cell.0, cell.1));
            if ground < lowest {
                (lowest, in_vain, way_out) = (ground, 0, None);
            } else {
                in_vain += 1;
            }
            if in_vain > PATIENCE && way_out.is_none() {
                way_out = Some(self.outward(cell));
            }
            if let Some(goal) = way_out.or_else(|| self.descent(cell)) {
                let bent = |old: f64, goal: f64| INERTIA * old + (1.0 - INERTIA) * goal;
                let bent = (bent(heading.0, goal.0), bent(heading.1, goal.1));
                heading = unit_vector(bent).unwrap_or(goal);
            }
            let Some(step) = self.step(place, heading, &course) else { break };
            (place, heading) = (step.place, step.heading);
            if step.cell == cell {
                continue;
            }
            cell = step.cell;
            let at = self.index(cell);
            if let Some(&last) = course.last() {
                self.rivers.downstream.insert(last, at);
            }
            if self.rivers.heights.contains_key(&at) {
                self.lower_downstream(at, height);
                break;
            }
            height = self.below(height).min(f64::from(self.surface.at(cell.0, cell.1)));
            self.rivers.heights.insert(at, height as f32);
            course.push(at);
        }
        Ok(())
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

/// A step of a river.
struct Step {
    place: (f64, f64),
    cell: Cell,
    heading: (f64, f64),
}

fn unit_vector((a, b): (f64, f64)) -> Option<(f64, f64)> {
    let length = libm::hypot(a, b);
    (length > 1e-12).then(|| (a / length, b / length))
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
            let surface = spanned(&ridges, &job).unwrap();
            let rivers = trace(&ridges, &surface, 2000.0, 60, seed, &job).unwrap();
            let mut joined = 0;
            for (&cell, &height) in &rivers.heights {
                assert!(ridges.cells()[cell].is_nan());
                assert!((0.0..=2000.0).contains(&height));
                if let Some(next) = rivers.downstream.get(&cell) {
                    assert!(rivers.heights[next] < height, "{} after {height}", rivers.heights[next]);
                    joined += 1;
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
}
