//! Minimum cuts of a grid of cells whose only terminals are pinned cells.
//!
//! After Boykov and Kolmogorov 2004: two search trees, one from each set of pins, grow towards each other; where they
//! touch, flow is pushed, and cells cut off from their tree look for another parent instead of the trees being grown
//! anew. Departures: neighbours are implicit, four to a cell, and as pins are infinitely strong they are roots that never
//! run dry, so no cell needs terminal capacities.

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

/// Directions to neighbours: west, north, east, south. The opposite of `d` is `d ^ 2`.
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
    flow: u64,
}

/// Cells grown between two looks at whether the job was cancelled.
const CHECK_EVERY: u32 = 1 << 14;

/// The minimum cut of `network`: its labels do not depend on how it was found.
///
/// Slices that are too short for a whole number of rows are cut off there. About 40 bytes a cell.
///
/// # Errors
/// Cancellation, and refusal of the memory.
pub fn min_cut(network: &Network<'_>, job: &Job<'_>) -> Result<MinCut> {
    let cols = network.cols;
    let n = network.pins.len().min(network.right.len()).min(network.down.len());
    let rows = n.checked_div(cols).unwrap_or(0);
    let padded = (rows as u64 + 2) * (cols as u64 + 2);
    let bytes = padded * (size_of::<Cell>() as u64 + 8);
    job.admit(bytes, || format!("a cut of {rows} × {cols} cells"))?;
    if padded > u64::from(u32::MAX) {
        let what = format!("a cut of {rows} × {cols} cells");
        return Err(Error::TooLarge { what, bytes, limit: u64::from(u32::MAX) });
    }
    let mut search = Search::new(network, rows, cols);
    search.run(job)?;
    let stride = cols + 2;
    let side = |i: usize| search.cells[(i / cols + 1) * stride + i % cols + 1].tree == SOURCE;
    Ok(MinCut { source_side: (0..rows * cols).map(side).collect(), flow: search.flow })
}

impl Search {
    /// The cells stand in a frame one cell wide that nothing flows into, so that every cell has four neighbours.
    fn new(network: &Network<'_>, rows: usize, cols: usize) -> Self {
        let stride = cols + 2;
        let outside = Cell { rest: [0; 4], stamp: 0, distance: 0, tree: FREE, parent: NONE, active: false };
        let mut cells = vec![outside; stride * (rows + 2)];
        let mut active = VecDeque::new();
        for row in 0..rows {
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
                let at = (row + 1) * stride + col + 1;
                if grows {
                    active.push_back(at as u32);
                }
                cells[at] = Cell { rest, tree, parent, active: grows, ..outside };
            }
        }
        let step = [-1, -(stride as isize), 1, stride as isize];
        Self { cells, step, active, orphans: VecDeque::new(), clock: 0, flow: 0 }
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
        self.flow += u64::from(most);
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
mod tests {
    use orograph_core::{key, unit};

    use super::*;

    struct Case {
        cols: usize,
        right: Vec<u32>,
        down: Vec<u32>,
        pins: Vec<Pin>,
    }

    impl Case {
        fn random(rows: usize, cols: usize, seed: u64, most: u32, pinned: f64) -> Self {
            let n = rows * cols;
            let draw = |stream: u64, i: usize| unit(key(seed, stream, i as i64, 0));
            let capacity = |stream: u64, i: usize| (draw(stream, i) * f64::from(most)) as u32;
            let pin = |i: usize| match draw(3, i) {
                u if u < pinned / 2.0 => Pin::Source,
                u if u < pinned => Pin::Sink,
                _ => Pin::Free,
            };
            let mut pins: Vec<Pin> = (0..n).map(pin).collect();
            (pins[0], pins[n - 1]) = (Pin::Source, Pin::Sink);
            Self {
                cols,
                right: (0..n).map(|i| capacity(1, i)).collect(),
                down: (0..n).map(|i| capacity(2, i)).collect(),
                pins,
            }
        }

        fn cut(&self) -> MinCut {
            let network = Network { cols: self.cols, right: &self.right, down: &self.down, pins: &self.pins };
            min_cut(&network, &Job::detached()).unwrap()
        }

        fn edges(&self) -> Vec<(usize, usize, u32)> {
            let n = self.pins.len();
            let across = (0..n).filter(|i| (i + 1) % self.cols != 0).map(|i| (i, i + 1, self.right[i]));
            let down = (0..n - self.cols).map(|i| (i, i + self.cols, self.down[i]));
            across.chain(down).collect()
        }

        fn value(&self, side: impl Fn(usize) -> bool) -> u64 {
            self.edges()
                .into_iter()
                .filter(|&(a, b, _)| side(a) != side(b))
                .map(|(_, _, c)| u64::from(c))
                .sum()
        }

        fn honours(&self, side: impl Fn(usize) -> bool) -> bool {
            self.pins.iter().enumerate().all(|(i, pin)| match pin {
                Pin::Free => true,
                Pin::Source => side(i),
                Pin::Sink => !side(i),
            })
        }
    }

    #[test]
    fn small_cuts_are_the_least_and_the_smallest_of_all_partitions() {
        for seed in 0..200 {
            let case = Case::random(3, 4, seed, 5, 0.2);
            let found = case.cut();
            let (mut least, mut common) = (u64::MAX, 0_u32);
            for bits in 0..1_u32 << 12 {
                let side = |i: usize| bits >> i & 1 == 1;
                if !case.honours(side) {
                    continue;
                }
                let value = case.value(side);
                if value < least {
                    (least, common) = (value, bits);
                } else if value == least {
                    common &= bits;
                }
            }
            assert_eq!(found.flow, least, "seed {seed}");
            let bits =
                found.source_side.iter().enumerate().fold(0, |bits, (i, &side)| bits | u32::from(side) << i);
            assert_eq!(bits, common, "seed {seed}");
        }
    }

    /// The same by breadth-first augmenting paths over an edge list: slow and plain.
    fn plain_cut(case: &Case) -> MinCut {
        let n = case.pins.len();
        let mut rest = vec![std::collections::BTreeMap::new(); n + 2];
        for (a, b, capacity) in case.edges() {
            *rest[a].entry(b).or_insert(0_u64) += u64::from(capacity);
            *rest[b].entry(a).or_insert(0) += u64::from(capacity);
        }
        for (i, pin) in case.pins.iter().enumerate() {
            match pin {
                Pin::Source => _ = rest[n].insert(i, u64::from(u32::MAX) * 1000),
                Pin::Sink => _ = rest[i].insert(n + 1, u64::from(u32::MAX) * 1000),
                Pin::Free => {}
            }
        }
        let mut flow = 0;
        loop {
            let mut from = vec![usize::MAX; n + 2];
            from[n] = n;
            let mut queue = VecDeque::from([n]);
            while let Some(i) = queue.pop_front() {
                for (&j, &rest) in &rest[i] {
                    if rest > 0 && from[j] == usize::MAX {
                        from[j] = i;
                        queue.push_back(j);
                    }
                }
            }
            if from[n + 1] == usize::MAX {
                let source_side = (0..n).map(|i| from[i] != usize::MAX).collect();
                return MinCut { source_side, flow };
            }
            let (mut i, mut most) = (n + 1, u64::MAX);
            while i != n {
                most = most.min(rest[from[i]][&i]);
                i = from[i];
            }
            let mut i = n + 1;
            while i != n {
                *rest[from[i]].get_mut(&i).unwrap() -= most;
                *rest[i].entry(from[i]).or_insert(0) += most;
                i = from[i];
            }
            flow += most;
        }
    }

    #[test]
    fn larger_cuts_equal_those_of_plain_augmenting_paths() {
        for seed in 0..60 {
            let (rows, cols) = (2 + seed as usize % 13, 2 + seed as usize * 7 % 17);
            let case = Case::random(rows, cols, seed, [4, 1000, 60_000][seed as usize % 3], 0.08);
            assert_eq!(case.cut(), plain_cut(&case), "seed {seed}");
        }
    }

    #[test]
    fn no_terminal_or_no_cell_is_no_cut() {
        let empty = Case { cols: 0, right: vec![], down: vec![], pins: vec![] };
        assert_eq!(empty.cut().flow, 0);
        let free = Case { cols: 2, right: vec![9; 4], down: vec![9; 4], pins: vec![Pin::Free; 4] };
        assert_eq!(free.cut(), MinCut { source_side: vec![false; 4], flow: 0 });
        let one = Case { pins: vec![Pin::Free, Pin::Source, Pin::Free, Pin::Free], ..free };
        assert_eq!(one.cut(), MinCut { source_side: vec![true; 4], flow: 0 });
    }
}
