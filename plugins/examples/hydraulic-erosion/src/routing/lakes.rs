//! Basins, and how high the water stands in them.

use std::collections::VecDeque;

use orograph_plugin::{key, prelude::*, rayon::prelude::*};

use super::{Routes, check_at};
use crate::lattice::{FORWARD, Lattice, OUT};

/// A place where water can cross from one basin to another: its height's rank, and its two cells. Among equals chance
/// decides: on level ground an order of cells would draw straight lines.
type Pass = (u64, u32, u32);

/// Where a lake spills: its own cell, and the other basin's.
type Spill = (u32, u32);

/// Stream of random numbers.
const LEVEL: u64 = 0x006c_6576_656c;

/// Order of heights as whole numbers.
fn rank(height: f32) -> u32 {
    let bits = (height + 0.0).to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

impl Routes {
    /// Numbers the basins, 0 standing for what drains out; returns how many there are.
    pub(super) fn gather(&mut self, lattice: &Lattice, job: &Job) -> Result<usize> {
        const UNKNOWN: u32 = u32::MAX;
        self.basin.fill(UNKNOWN);
        let mut basins = 1;
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
                    basins += 1;
                    break (basins - 1) as u32;
                }
                cell = next as usize;
            };
            debug_assert!(lattice.known(start) || label == 0);
            for cell in path.drain(..) {
                self.basin[cell] = label;
            }
        }
        Ok(basins)
    }

    /// How high each basin's lake stands, and over which pair of cells it spills: its own, and the other's.
    pub(super) fn spill(
        &self,
        lattice: &Lattice,
        heights: &[f32],
        basins: usize,
        job: &Job,
    ) -> Result<(Vec<f32>, Vec<Spill>)> {
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
                        let chance = key(0, LEVEL, cell as i64, i64::from(other)) >> 32;
                        passes.push(((u64::from(rank(height)) << 32) | chance, cell as u32, other));
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
        for (step, &(_, a, b)) in passes.iter().enumerate() {
            check_at(step, job)?;
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
