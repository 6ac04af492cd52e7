//! Where water goes: lakes, and the order of cells from the divides to the outlets.
//!
//! Depressions are not removed. Every one fills to its spill, and its water goes on from there, after Cordonnier,
//! Bovy & Braun (2019), "A versatile, linear complexity algorithm for flow routing in topographies with
//! depressions": cells are gathered in basins by steepest descent, and the least spanning tree over the passes
//! between basins says which basin spills into which, and how high its lake stands.
//!
//! On the water's surface flow divides among all lower neighbours in proportion to the slope (Quinn et al. 1991).
//! Eight single directions would draw their own star over every smooth slope.

use std::collections::VecDeque;

use orograph_plugin::{prelude::*, rayon::prelude::*};

use crate::lattice::{BEYOND, FORWARD, Lattice, OUT};

/// Cells between two looks at whether the run was cancelled.
const PATIENCE: usize = 1 << 14;

/// Stops when cancelled; cheap enough for every cell.
#[inline(always)]
pub(crate) fn check_at(step: usize, job: &Job) -> Result<()> {
    if step.is_multiple_of(PATIENCE) { job.check() } else { Ok(()) }
}

/// A place where water can cross from one basin to another.
type Pass = (u64, u32);

/// Order of heights as whole numbers.
fn rank(height: f32) -> u32 {
    let bits = (height + 0.0).to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// Where the water of a terrain goes.
pub(crate) struct Routes {
    /// Height of the water's surface, or of the ground where it is dry.
    pub(crate) water: Vec<f32>,
    /// Steepest way down on the ground: a cell, [`OUT`], or the cell itself at a basin's lowest point.
    down: Vec<u32>,
    /// The basin of each cell; 0 drains out without any lake.
    pub(crate) basin: Vec<u32>,
    /// Where each basin's lake spills: a cell or [`OUT`].
    exits: Vec<u32>,
    /// Cells such that every one comes before those that it drains to.
    pub(crate) order: Vec<u32>,
    /// What passes through each cell, its own rain included, in cubic metres a year.
    pub(crate) discharge: Vec<f64>,
}

/// How the water of one cell divides.
pub(crate) struct Split {
    /// Cells, or [`OUT`].
    pub(crate) to: [u32; 9],
    /// Share of each; they add up to one.
    pub(crate) share: [f64; 9],
    /// Metres to each.
    pub(crate) distance: [f64; 9],
    /// Direction of each, or [`BEYOND`].
    pub(crate) direction: [usize; 9],
    /// How many there are.
    pub(crate) count: usize,
    /// The surface is level here: a lake or flat ground.
    pub(crate) still: bool,
}

impl Routes {
    /// Room for the routes of `cells` cells.
    pub(crate) fn new(cells: usize) -> Self {
        Self {
            water: vec![0.0; cells],
            down: vec![OUT; cells],
            basin: vec![0; cells],
            exits: Vec::new(),
            order: Vec::with_capacity(cells),
            discharge: vec![0.0; cells],
        }
    }

    /// Finds the routes over `heights` under `rain`, in cubic metres a year on each cell.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn find(
        &mut self,
        lattice: &Lattice,
        heights: &[f32],
        rain: impl Fn(usize) -> f64 + Sync,
        job: &Job,
    ) -> Result<()> {
        self.descend(lattice, heights, job)?;
        let pits = self.gather(lattice, job)?;
        let (levels, spills) = self.spill(lattice, heights, pits.len(), job)?;
        let basin = &self.basin;
        self.water.par_iter_mut().enumerate().for_each(|(cell, water)| {
            *water = heights[cell].max(levels[basin[cell] as usize]);
        });
        // A lake leaves over its own lip where that falls to the other side; otherwise straight to there.
        self.exits = spills
            .iter()
            .map(|&(lip, other)| if lip != OUT && self.falls(lattice, lip as usize) { lip } else { other })
            .collect();
        self.accumulate(lattice, &pits, rain, job)
    }

    /// Steepest descent on the ground.
    fn descend(&mut self, lattice: &Lattice, heights: &[f32], job: &Job) -> Result<()> {
        self.down.par_chunks_mut(lattice.cols).enumerate().try_for_each(|(row, down)| {
            job.check()?;
            for (col, down) in down.iter_mut().enumerate() {
                let cell = row * lattice.cols + col;
                *down = OUT;
                if lattice.known(cell) {
                    let (mut steepest, mut to) = (0.0, cell as u32);
                    lattice.each(cell, |direction, neighbour| {
                        let slope = (heights[cell] - heights[neighbour]) / lattice.distances[direction];
                        if slope > steepest {
                            (steepest, to) = (slope, neighbour as u32);
                        }
                    });
                    if let Some(beyond) = lattice.beyond(cell)
                        && (heights[cell] - beyond.height) / beyond.distance > steepest
                    {
                        to = OUT;
                    }
                    *down = to;
                }
            }
            Ok(())
        })
    }

    /// Numbers the basins; returns their lowest cells, basin 0 standing for what drains out.
    fn gather(&mut self, lattice: &Lattice, job: &Job) -> Result<Vec<u32>> {
        const UNKNOWN: u32 = u32::MAX;
        self.basin.fill(UNKNOWN);
        let mut pits = vec![OUT];
        let mut path = Vec::new();
        for start in 0..self.down.len() {
            check_at(start, job)?;
            let mut cell = start;
            let label = loop {
                if self.basin[cell] != UNKNOWN {
                    break self.basin[cell];
                }
                path.push(cell);
                let next = self.down[cell];
                if next == OUT {
                    break 0;
                }
                if next as usize == cell {
                    pits.push(cell as u32);
                    break (pits.len() - 1) as u32;
                }
                cell = next as usize;
            };
            debug_assert!(lattice.known(start) || label == 0);
            for cell in path.drain(..) {
                self.basin[cell] = label;
            }
        }
        Ok(pits)
    }

    /// How high each basin's lake stands, and over which pair of cells it spills: its own, and the other's.
    fn spill(
        &self,
        lattice: &Lattice,
        heights: &[f32],
        basins: usize,
        job: &Job,
    ) -> Result<(Vec<f32>, Vec<(u32, u32)>)> {
        let mut levels = vec![f32::NEG_INFINITY; basins];
        let mut spills = vec![(OUT, OUT); basins];
        if basins == 1 {
            return Ok((levels, spills));
        }
        let tree = self.least_tree(self.passes(lattice, heights, job)?, basins, job)?;
        // The passes at each basin, one basin's after the other's.
        let mut starts = vec![0; basins + 1];
        for &(a, b) in &tree {
            starts[self.basin_of(a) as usize + 1] += 1;
            starts[self.basin_of(b) as usize + 1] += 1;
        }
        for basin in 0..basins {
            starts[basin + 1] += starts[basin];
        }
        let mut at = starts.clone();
        let mut passes = vec![(OUT, OUT); tree.len() * 2];
        for &(a, b) in &tree {
            for (here, there) in [(a, b), (b, a)] {
                let slot = &mut at[self.basin_of(here) as usize];
                passes[*slot] = (here, there);
                *slot += 1;
            }
        }
        // From the outside in: each basin spills to where it was reached from.
        let mut reached = vec![false; basins];
        let mut queue = VecDeque::from([0]);
        reached[0] = true;
        while let Some(basin) = queue.pop_front() {
            for &(here, there) in &passes[starts[basin]..starts[basin + 1]] {
                let next = self.basin_of(there) as usize;
                if !reached[next] {
                    reached[next] = true;
                    levels[next] = levels[basin].max(height_of_pass(lattice, heights, there, here));
                    spills[next] = (there, here);
                    queue.push_back(next);
                }
            }
        }
        Ok((levels, spills))
    }

    /// Every place where neighbouring cells belong to different basins, with its height.
    fn passes(&self, lattice: &Lattice, heights: &[f32], job: &Job) -> Result<Vec<Pass>> {
        let rows = (0..lattice.len() / lattice.cols).into_par_iter().map(|row| {
            job.check()?;
            let mut passes = Vec::new();
            for cell in row * lattice.cols..(row + 1) * lattice.cols {
                if !lattice.known(cell) {
                    continue;
                }
                let mut push = |other: u32| {
                    if self.basin[cell] != self.basin_of(other) {
                        let height = height_of_pass(lattice, heights, cell as u32, other);
                        passes.push(((u64::from(rank(height)) << 32) | cell as u64, other));
                    }
                };
                lattice.each(cell, |direction, neighbour| {
                    if direction >= FORWARD {
                        push(neighbour as u32);
                    }
                });
                if lattice.beyond(cell).is_some() {
                    push(OUT);
                }
            }
            Ok(passes)
        });
        Ok(rows.collect::<Result<Vec<_>>>()?.concat())
    }

    /// Kruskal's algorithm: the lowest passes first, unless they would close a ring.
    fn least_tree(&self, mut passes: Vec<Pass>, basins: usize, job: &Job) -> Result<Vec<(u32, u32)>> {
        passes.par_sort_unstable();
        let mut parents: Vec<u32> = (0..basins as u32).collect();
        let mut tree = Vec::with_capacity(basins - 1);
        for (step, &(key, b)) in passes.iter().enumerate() {
            check_at(step, job)?;
            let a = key as u32;
            let (from, to) = (root(&mut parents, self.basin_of(a)), root(&mut parents, self.basin_of(b)));
            if from != to {
                parents[from.max(to) as usize] = from.min(to);
                tree.push((a, b));
                if tree.len() == basins - 1 {
                    break;
                }
            }
        }
        Ok(tree)
    }

    fn basin_of(&self, cell: u32) -> u32 {
        if cell == OUT { 0 } else { self.basin[cell as usize] }
    }

    /// The basin whose lowest cell `cell` is.
    pub(crate) fn lowest_of(&self, cell: usize) -> Option<usize> {
        (self.down[cell] == cell as u32).then(|| self.basin[cell] as usize)
    }

    /// Number of basins, with that of what drains out.
    pub(crate) fn basins(&self) -> usize {
        self.exits.len()
    }

    /// Whether the water's surface falls anywhere from `cell`.
    fn falls(&self, lattice: &Lattice, cell: usize) -> bool {
        let here = self.water[cell];
        let mut falls = lattice.beyond(cell).is_some_and(|beyond| beyond.height < here);
        lattice.each(cell, |_, neighbour| falls |= self.water[neighbour] < here);
        falls
    }

    /// Puts the cells in order and lets the rain run down them.
    fn accumulate(
        &mut self,
        lattice: &Lattice,
        pits: &[u32],
        rain: impl Fn(usize) -> f64 + Sync,
        job: &Job,
    ) -> Result<()> {
        let cells = lattice.len();
        let mut still = vec![false; cells];
        still.par_chunks_mut(lattice.cols).enumerate().try_for_each(|(row, still)| {
            job.check()?;
            for (col, still) in still.iter_mut().enumerate() {
                let cell = row * lattice.cols + col;
                *still = lattice.known(cell) && !self.falls(lattice, cell);
            }
            Ok::<_, Error>(())
        })?;
        // From how many cells each one gets water.
        let mut sources = vec![0_u8; cells];
        sources.par_chunks_mut(lattice.cols).enumerate().try_for_each(|(row, sources)| {
            job.check()?;
            for (col, sources) in sources.iter_mut().enumerate() {
                let cell = row * lattice.cols + col;
                if lattice.known(cell) {
                    lattice.each(cell, |_, neighbour| {
                        let above = self.water[neighbour] > self.water[cell];
                        let level = still[neighbour] && self.down[neighbour] == cell as u32;
                        *sources += u8::from(above || level);
                    });
                }
            }
            Ok::<_, Error>(())
        })?;
        for basin in 1..pits.len() {
            let exit = self.exits[basin];
            if exit != OUT {
                sources[exit as usize] += 1;
            }
        }
        self.discharge.par_iter_mut().enumerate().for_each(|(cell, discharge)| *discharge = rain(cell));
        let mut order = std::mem::take(&mut self.order);
        let mut discharge = std::mem::take(&mut self.discharge);
        order.clear();
        let mut ready = Vec::new();
        for start in 0..cells {
            // A cell that another one made ready has gone already: then its sources are not zero from the start.
            if sources[start] != 0 || !lattice.known(start) {
                continue;
            }
            sources[start] = u8::MAX;
            ready.push(start as u32);
            while let Some(cell) = ready.pop() {
                check_at(order.len(), job)?;
                order.push(cell);
                let split = self.split(lattice, cell as usize);
                for k in 0..split.count {
                    let to = split.to[k] as usize;
                    if split.to[k] != OUT {
                        discharge[to] += discharge[cell as usize] * split.share[k];
                        sources[to] -= 1;
                        if sources[to] == 0 {
                            sources[to] = u8::MAX;
                            ready.push(to as u32);
                        }
                    }
                }
            }
        }
        (self.order, self.discharge) = (order, discharge);
        Ok(())
    }

    /// How the water of `cell` divides.
    #[inline(always)]
    pub(crate) fn split(&self, lattice: &Lattice, cell: usize) -> Split {
        let mut split = Split {
            to: [OUT; 9],
            share: [0.0; 9],
            distance: [1.0; 9],
            direction: [BEYOND; 9],
            count: 0,
            still: false,
        };
        let here = self.water[cell];
        let mut sum = 0.0;
        let mut take = |to: u32, height: f32, distance: f32, direction: usize| {
            if height < here {
                let slope = (f64::from(here) - f64::from(height)) / f64::from(distance);
                split.to[split.count] = to;
                split.share[split.count] = slope;
                split.distance[split.count] = f64::from(distance);
                split.direction[split.count] = direction;
                split.count += 1;
                sum += slope;
            }
        };
        lattice.each(cell, |direction, neighbour| {
            take(neighbour as u32, self.water[neighbour], lattice.distances[direction], direction);
        });
        if let Some(beyond) = lattice.beyond(cell) {
            take(OUT, beyond.height, beyond.distance, BEYOND);
        }
        if split.count == 0 {
            let down = self.down[cell];
            split.to[0] = if down == cell as u32 { self.exits[self.basin[cell] as usize] } else { down };
            split.share[0] = 1.0;
            split.count = 1;
            split.still = true;
        } else {
            let whole = 1.0 / sum;
            split.share[..split.count].iter_mut().for_each(|share| *share *= whole);
        }
        split
    }
}

/// The higher of both sides.
fn height_of_pass(lattice: &Lattice, heights: &[f32], a: u32, b: u32) -> f32 {
    let height = |cell: u32, other: u32| match cell {
        OUT => lattice.beyond(other as usize).map_or(f32::NEG_INFINITY, |beyond| beyond.height),
        cell => heights[cell as usize],
    };
    height(a, b).max(height(b, a))
}

/// The basin that stands for all that `basin` was joined with.
fn root(parents: &mut [u32], mut basin: u32) -> u32 {
    while parents[basin as usize] != basin {
        parents[basin as usize] = parents[parents[basin as usize] as usize];
        basin = parents[basin as usize];
    }
    basin
}
