//! Where water goes: lakes, and the order of cells from the divides to the outlets.
//!
//! Depressions are not removed. Every one fills to its spill, and its water goes on from there, after Cordonnier,
//! Bovy & Braun (2019), "A versatile, linear complexity algorithm for flow routing in topographies with
//! depressions": cells are gathered in basins by steepest descent, and the least spanning tree over the passes
//! between basins says which basin spills into which, and how high its lake stands.
//!
//! On the water's surface flow divides among all lower neighbours in proportion to the slope (Quinn et al. 1991).
//! Eight single directions would draw their own star over every smooth slope.

mod lakes;

use orograph_plugin::{prelude::*, rayon::prelude::*};

use crate::lattice::{BEYOND, Lattice, OUT};

/// Cells between two looks at whether the run was cancelled.
const PATIENCE: usize = 1 << 14;

/// Stops when cancelled; cheap enough for every cell.
#[inline(always)]
pub(crate) fn check_at(step: usize, job: &Job) -> Result<()> {
    if step.is_multiple_of(PATIENCE) { job.check() } else { Ok(()) }
}

/// Where the water of a terrain goes.
pub(crate) struct Routes {
    /// Height of the water's surface, or of the ground where it is dry.
    pub(crate) water: Vec<f32>,
    /// Steepest way down on the ground: a cell, [`OUT`], or the cell itself at a basin's lowest point.
    down: Vec<u32>,
    /// How the water of each cell divides among its neighbours by direction and, last, [`BEYOND`]; nothing where its
    /// surface is level. Whole numbers, in proportion to the largest.
    parts: Vec<[u16; 9]>,
    /// The basin of each cell; 0 drains out without any lake.
    pub(crate) basin: Vec<u32>,
    /// Where each basin's lake spills: a cell or [`OUT`].
    exits: Vec<u32>,
    /// Cells such that every one comes before those that it drains to.
    pub(crate) order: Vec<u32>,
    /// What passes through each cell, its own rain included, in cubic metres a year.
    pub(crate) discharge: Vec<f64>,
}

impl Routes {
    /// Room for the routes of `cells` cells.
    pub(crate) fn new(cells: usize) -> Self {
        Self {
            water: vec![0.0; cells],
            down: vec![OUT; cells],
            parts: vec![[0; 9]; cells],
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
        let basins = self.gather(lattice, job)?;
        let (levels, spills) = self.spill(lattice, heights, basins, job)?;
        let basin = &self.basin;
        self.water.par_iter_mut().enumerate().for_each(|(cell, water)| {
            *water = heights[cell].max(levels[basin[cell] as usize]);
        });
        // A lake leaves over its own lip where that falls to the other side; otherwise straight to there.
        self.exits = spills
            .iter()
            .map(|&(lip, other)| if lip != OUT && self.falls(lattice, lip as usize) { lip } else { other })
            .collect();
        self.divide(lattice, job)?;
        self.accumulate(lattice, rain, job)
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

    /// Divides the water of each cell among those below it.
    fn divide(&mut self, lattice: &Lattice, job: &Job) -> Result<()> {
        let water = &self.water;
        self.parts.par_chunks_mut(lattice.cols).enumerate().try_for_each(|(row, parts)| {
            job.check()?;
            for (col, parts) in parts.iter_mut().enumerate() {
                let cell = row * lattice.cols + col;
                *parts = [0; 9];
                if !lattice.known(cell) {
                    continue;
                }
                let here = f64::from(water[cell]);
                let mut slopes = [0.0; 9];
                lattice.each(cell, |direction, neighbour| {
                    let fall = here - f64::from(water[neighbour]);
                    slopes[direction] = fall * lattice.nearness[direction];
                });
                if let Some(beyond) = lattice.beyond(cell) {
                    slopes[BEYOND] = (here - f64::from(beyond.height)) / f64::from(beyond.distance);
                }
                let steepest = slopes.iter().copied().fold(0.0, f64::max);
                if steepest > 0.0 {
                    let scale = f64::from(u16::MAX) / steepest;
                    for (part, slope) in parts.iter_mut().zip(slopes) {
                        if slope > 0.0 {
                            *part = ((slope * scale) as u16).max(1);
                        }
                    }
                }
            }
            Ok(())
        })
    }

    /// From how many cells each one gets water.
    fn sources(&self, lattice: &Lattice, job: &Job) -> Result<Vec<u8>> {
        let mut sources = vec![0_u8; lattice.len()];
        sources.par_chunks_mut(lattice.cols).enumerate().try_for_each(|(row, sources)| {
            job.check()?;
            for (col, sources) in sources.iter_mut().enumerate() {
                let cell = row * lattice.cols + col;
                if lattice.known(cell) {
                    lattice.each(cell, |_, neighbour| {
                        let above = self.water[neighbour] > self.water[cell];
                        let level = self.down[neighbour] == cell as u32 && self.still(neighbour);
                        *sources += u8::from(above || level);
                    });
                }
            }
            Ok::<_, Error>(())
        })?;
        for &exit in &self.exits[1..] {
            if exit != OUT {
                sources[exit as usize] += 1;
            }
        }
        Ok(sources)
    }

    /// Puts the cells in order and lets the rain run down them.
    fn accumulate(&mut self, lattice: &Lattice, rain: impl Fn(usize) -> f64 + Sync, job: &Job) -> Result<()> {
        const GONE: u8 = u8::MAX;
        let mut sources = self.sources(lattice, job)?;
        self.discharge.par_iter_mut().enumerate().for_each(|(cell, discharge)| *discharge = rain(cell));
        let mut order = std::mem::take(&mut self.order);
        let mut discharge = std::mem::take(&mut self.discharge);
        order.clear();
        let mut ready = Vec::new();
        for start in 0..lattice.len() {
            if sources[start] != 0 || !lattice.known(start) {
                continue;
            }
            sources[start] = GONE;
            ready.push(start as u32);
            while let Some(cell) = ready.pop() {
                check_at(order.len(), job)?;
                order.push(cell);
                let water = discharge[cell as usize];
                self.each_way(lattice, cell as usize, |_, to, share| {
                    if to != OUT {
                        let to = to as usize;
                        discharge[to] += water * share;
                        sources[to] -= 1;
                        if sources[to] == 0 {
                            sources[to] = GONE;
                            ready.push(to as u32);
                        }
                    }
                });
            }
        }
        (self.order, self.discharge) = (order, discharge);
        Ok(())
    }

    /// Whether the surface is level at `cell`: in a lake, or on flat ground.
    #[inline(always)]
    pub(crate) fn still(&self, cell: usize) -> bool {
        self.parts[cell] == [0; 9]
    }

    /// Calls `visit(direction, to, share)` for each way that the water of `cell` takes; the shares add up to one. From
    /// still water there is one, which has no direction of its own.
    #[inline(always)]
    pub(crate) fn each_way(&self, lattice: &Lattice, cell: usize, mut visit: impl FnMut(usize, u32, f64)) {
        let parts = &self.parts[cell];
        let sum: u32 = parts.iter().map(|&part| u32::from(part)).sum();
        if sum == 0 {
            let down = self.down[cell];
            let lowest = down == cell as u32;
            visit(BEYOND, if lowest { self.exits[self.basin[cell] as usize] } else { down }, 1.0);
            return;
        }
        let whole = 1.0 / f64::from(sum);
        for (direction, &part) in parts.iter().enumerate() {
            if part > 0 {
                let to = if direction == BEYOND { OUT } else { lattice.towards(cell, direction) as u32 };
                visit(direction, to, f64::from(part) * whole);
            }
        }
    }
}
