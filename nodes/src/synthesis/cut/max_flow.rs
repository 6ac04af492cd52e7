//! Minimum cuts of a grid of cells whose only terminals are pinned cells.
//!
//! After Boykov and Kolmogorov 2004: two search trees, one from each set of pins, grow towards each other; where they
//! touch, flow is pushed, and cells cut off from their tree look for another parent instead of the trees being grown
//! anew. Departures: neighbours are implicit, four to a cell; as pins are infinitely strong they are roots that never run
//! dry, so no cell needs terminal capacities; and the trees begin with the flow of `potential_flow`, which is often
//! maximal already.

mod potential_flow;

use std::collections::VecDeque;

use orograph_core::{Error, Job, Result};

/// Which side a cell must be on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pin {
    /// Either.
    Free,
    /// The source's.
    Source,
    /// The sink's.
    Sink,
}

/// A grid with a capacity on each edge between neighbouring cells.
#[derive(Clone, Debug)]
pub struct Network<'a> {
    /// Number of columns.
    pub cols: usize,
    /// Capacity between each cell and the one to its right; that of the last column does not count.
    pub right: &'a [u32],
    /// Capacity between each cell and the one below it; that of the last row does not count.
    pub down: &'a [u32],
    /// Which cells are held on a side.
    pub pins: &'a [Pin],
}

/// A minimum cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MinCut {
    /// Whether each cell is on the source's side: exactly those that the source still reaches, the least such set.
    pub source_side: Vec<bool>,
    /// The maximal flow, which is the sum of the capacities cut.
    pub flow: u64,
}

const FREE: u8 = 0;
const SOURCE: u8 = 1;
const SINK: u8 = 2;

/// Directions to neighbours. The opposite of `d` is `d ^ 2`.
const WEST: usize = 0;
const NORTH: usize = 1;
const EAST: usize = 2;
const SOUTH: usize = 3;

/// Parents that are none.
const NONE: u8 = 4;
const ROOT: u8 = 5;
const ORPHAN: u8 = 6;

#[derive(Clone, Copy)]
struct Cell {
    /// What each direction can still carry, starting here.
    rest: [u32; 4],
    /// When the distance to the root was last known to hold.
    stamp: u32,
    distance: u32,
    tree: u8,
    parent: u8,
    active: bool,
}

struct Search {
    cells: Vec<Cell>,
    step: [isize; 4],
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    clock: u32,
}

/// Cells grown between two looks at whether the job was cancelled.
const CHECK_EVERY: u32 = 1 << 14;

/// The minimum cut of `network`: its labels do not depend on how it was found.
///
/// Slices that are too short for a whole number of rows are cut off there. About 50 bytes a cell.
///
/// # Errors
/// Cancellation, and refusal of the memory.
pub fn min_cut(network: &Network<'_>, job: &Job<'_>) -> Result<MinCut> {
    job.check()?;
    let cols = network.cols;
    let n = network.pins.len().min(network.right.len()).min(network.down.len());
    let rows = n.checked_div(cols).unwrap_or(0);
    let padded = (rows as u64 + 2) * (cols as u64 + 2);
    // The search's cells and queue; the distances of the flow to begin with, whose they are, and which are tips.
    let bytes = padded * (size_of::<Cell>() as u64 + 20);
    job.admit(bytes, || format!("a cut of {rows} × {cols} cells"))?;
    if padded > u64::from(u32::MAX) {
        let what = format!("a cut of {rows} × {cols} cells");
        return Err(Error::TooLarge { what, bytes, limit: u64::from(u32::MAX) });
    }
    let mut search = Search::new(network, rows, cols, job)?;
    potential_flow::set(&mut search.cells, cols + 2, job)?;
    search.run(job)?;
    let stride = cols + 2;
    let mut source_side = Vec::with_capacity(rows * cols);
    for row in search.cells.chunks(stride).skip(1).take(rows) {
        job.check()?;
        source_side.extend(row[1..=cols].iter().map(|cell| cell.tree == SOURCE));
    }
    let flow = across(network, &source_side);
    Ok(MinCut { source_side, flow })
}

/// The capacity between both sides.
fn across(network: &Network<'_>, side: &[bool]) -> u64 {
    let of_row = |(row, cells): (usize, &[bool])| {
        let right = &network.right[row * network.cols..];
        let down = &network.down[row * network.cols..];
        let below = &side[(row + 1) * network.cols..];
        let across = cells.windows(2).zip(right).filter(|(pair, _)| pair[0] != pair[1]);
        let across: u64 = across.map(|(_, &capacity)| u64::from(capacity)).sum();
        let down = cells.iter().zip(below).zip(down).filter(|((a, b), _)| a != b);
        across + down.map(|(_, &capacity)| u64::from(capacity)).sum::<u64>()
    };
    side.chunks(network.cols.max(1)).enumerate().map(of_row).sum()
}

impl Search {
    /// The cells stand in a frame one cell wide that nothing flows into, so that every cell has four neighbours.
    fn new(network: &Network<'_>, rows: usize, cols: usize, job: &Job<'_>) -> Result<Self> {
        let stride = cols + 2;
        let outside = Cell { rest: [0; 4], stamp: 0, distance: 0, tree: FREE, parent: NONE, active: false };
        let mut cells = Vec::with_capacity(stride * (rows + 2));
        let mut active = VecDeque::new();
        cells.resize(stride, outside);
        for row in 0..rows {
            job.check()?;
            cells.push(outside);
            for col in 0..cols {
                let i = row * cols + col;
                let rest = [
                    if col > 0 { network.right[i - 1] } else { 0 },
                    if row > 0 { network.down[i - cols] } else { 0 },
                    if col + 1 < cols { network.right[i] } else { 0 },
                    if row + 1 < rows { network.down[i] } else { 0 },
                ];
                let tree = match network.pins[i] {
                    Pin::Free => FREE,
                    Pin::Source => SOURCE,
                    Pin::Sink => SINK,
                };
                let parent = if tree == FREE { NONE } else { ROOT };
                // A pin that nothing leaves has nothing to grow into.
                let grows = tree != FREE && rest.iter().any(|&rest| rest > 0);
                if grows {
                    active.push_back(cells.len() as u32);
                }
                cells.push(Cell { rest, tree, parent, active: grows, ..outside });
            }
            cells.push(outside);
        }
        cells.resize(stride * (rows + 2), outside);
        let step = [-1, -(stride as isize), 1, stride as isize];
        Ok(Self { cells, step, active, orphans: VecDeque::new(), clock: 0 })
    }

    fn beside(&self, i: usize, direction: usize) -> usize {
        i.wrapping_add_signed(self.step[direction])
    }

    /// What can still flow away from the root from `i` in `direction`, when `i` is in `tree`.
    fn outward(&self, i: usize, direction: usize, tree: u8) -> u32 {
        if tree == SOURCE {
            self.cells[i].rest[direction]
        } else {
            self.cells[self.beside(i, direction)].rest[direction ^ 2]
        }
    }

    fn run(&mut self, job: &Job<'_>) -> Result<()> {
        let mut until_check = CHECK_EVERY;
        while let Some(next) = self.active.pop_front() {
            let i = next as usize;
            self.cells[i].active = false;
            while self.cells[i].tree != FREE {
                let Some((from, direction)) = self.grow(i) else { break };
                self.clock += 1;
                self.augment(from, direction);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan as usize);
                }
                until_check -= 1;
                if until_check == 0 {
                    until_check = CHECK_EVERY;
                    job.check()?;
                }
            }
            until_check -= 1;
            if until_check == 0 {
                until_check = CHECK_EVERY;
                job.check()?;
            }
        }
        Ok(())
    }

    fn activate(&mut self, i: usize) {
        if !self.cells[i].active {
            self.cells[i].active = true;
            self.active.push_back(i as u32);
        }
    }

    /// Takes in the free neighbours of `i`; the source's end of an edge to the other tree, and its direction, when met.
    fn grow(&mut self, i: usize) -> Option<(usize, usize)> {
        let Cell { tree, stamp, distance, .. } = self.cells[i];
        for direction in 0..4 {
            if self.outward(i, direction, tree) == 0 {
                continue;
            }
            let j = self.beside(i, direction);
            let other = self.cells[j];
            if other.tree == FREE {
                let cell = &mut self.cells[j];
                cell.tree = tree;
                cell.parent = (direction ^ 2) as u8;
                cell.stamp = stamp;
                cell.distance = distance + 1;
                self.activate(j);
            } else if other.tree != tree {
                return Some(if tree == SOURCE { (i, direction) } else { (j, direction ^ 2) });
            } else if other.stamp <= stamp && other.distance > distance + 1 && other.parent < NONE {
                let cell = &mut self.cells[j];
                cell.parent = (direction ^ 2) as u8;
                cell.stamp = stamp;
                cell.distance = distance + 1;
            }
        }
        None
    }

    /// Pushes what fits through the path over the edge from `from`, in the source's tree, in `direction`.
    fn augment(&mut self, from: usize, direction: usize) {
        let to = self.beside(from, direction);
        let mut most = self.cells[from].rest[direction];
        let mut i = from;
        while self.cells[i].parent != ROOT {
            let up = usize::from(self.cells[i].parent);
            i = self.beside(i, up);
            most = most.min(self.cells[i].rest[up ^ 2]);
        }
        let mut i = to;
        while self.cells[i].parent != ROOT {
            let up = usize::from(self.cells[i].parent);
            most = most.min(self.cells[i].rest[up]);
            i = self.beside(i, up);
        }
        self.cells[from].rest[direction] -= most;
        self.cells[to].rest[direction ^ 2] += most;
        let mut i = from;
        while self.cells[i].parent != ROOT {
            let up = usize::from(self.cells[i].parent);
            let parent = self.beside(i, up);
            self.cells[i].rest[up] += most;
            self.cells[parent].rest[up ^ 2] -= most;
            if self.cells[parent].rest[up ^ 2] == 0 {
                self.cells[i].parent = ORPHAN;
                self.orphans.push_front(i as u32);
            }
            i = parent;
        }
        let mut i = to;
        while self.cells[i].parent != ROOT {
            let up = usize::from(self.cells[i].parent);
            let parent = self.beside(i, up);
            self.cells[parent].rest[up ^ 2] += most;
            self.cells[i].rest[up] -= most;
            if self.cells[i].rest[up] == 0 {
                self.cells[i].parent = ORPHAN;
                self.orphans.push_front(i as u32);
            }
            i = parent;
        }
    }

    /// Distance of `i` to its root, `None` when it hangs on an orphan. Marks the way as known.
    fn distance(&mut self, i: usize) -> Option<u32> {
        let (mut at, mut steps) = (i, 0);
        let distance = loop {
            let cell = self.cells[at];
            if cell.stamp == self.clock {
                break steps + cell.distance;
            }
            match cell.parent {
                ROOT => {
                    let root = &mut self.cells[at];
                    root.stamp = self.clock;
                    root.distance = 0;
                    break steps;
                }
                ORPHAN | NONE => return None,
                up => at = self.beside(at, usize::from(up)),
            }
            steps += 1;
        };
        let (mut at, mut rest) = (i, distance);
        while self.cells[at].stamp != self.clock {
            let cell = &mut self.cells[at];
            cell.stamp = self.clock;
            cell.distance = rest;
            let up = usize::from(cell.parent);
            rest -= 1;
            at = self.beside(at, up);
        }
        Some(distance)
    }

    /// Finds an orphan another parent in its tree, or lets it go.
    fn adopt(&mut self, i: usize) {
        let tree = self.cells[i].tree;
        let mut best: Option<(u32, usize)> = None;
        let mut inward = [false; 4];
        for (direction, inward) in inward.iter_mut().enumerate() {
            let j = self.beside(i, direction);
            let other = self.cells[j];
            let rest = if tree == SOURCE { other.rest[direction ^ 2] } else { self.cells[i].rest[direction] };
            if other.tree != tree || rest == 0 {
                continue;
            }
            *inward = true;
            if let Some(distance) = self.distance(j)
                && best.is_none_or(|(least, _)| distance < least)
            {
                best = Some((distance, direction));
            }
        }
        if let Some((distance, direction)) = best {
            let clock = self.clock;
            let cell = &mut self.cells[i];
            cell.parent = direction as u8;
            cell.stamp = clock;
            cell.distance = distance + 1;
            return;
        }
        self.cells[i].tree = FREE;
        self.cells[i].parent = NONE;
        self.cells[i].stamp = 0;
        for (direction, inward) in inward.into_iter().enumerate() {
            let j = self.beside(i, direction);
            if self.cells[j].tree != tree {
                continue;
            }
            if inward {
                self.activate(j);
            }
            if usize::from(self.cells[j].parent) == direction ^ 2 {
                self.cells[j].parent = ORPHAN;
                self.orphans.push_back(j as u32);
            }
        }
    }
}

#[cfg(test)]
mod tests;
