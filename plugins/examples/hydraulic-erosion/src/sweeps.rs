//! One step of erosion: up from the outlets to cut, down from the divides to carry and lay down.

use orograph_plugin::{key, libm, prelude::*, rayon::prelude::*, signed_unit};

use crate::{
    lattice::{Lattice, OUT},
    routing::{Routes, check_at},
};

/// The most that one step fills of a lake's depth, so that its floor keeps a shape for water to follow.
const FULLEST: f64 = 0.9;

/// By which part the slope that ground keeps differs from cell to cell.
const UNEVEN: f64 = 0.25;
/// Stream of random numbers.
const FIRMNESS: u64 = 0x6669_726d;

/// The highest that a cell may stand above its lower neighbours.
///
/// The slope is that of the surface, not of eight directions, whose cones would be pyramids: as in fast marching
/// (Sethian 1996), the lower neighbours along rows and columns give both parts of the gradient.
struct Slide {
    slope: f64,
    side: CellSize,
    row: f64,
    col: f64,
    others: f64,
}

impl Slide {
    fn new(slope: f64, side: CellSize) -> Self {
        Self { slope, side, row: f64::INFINITY, col: f64::INFINITY, others: f64::INFINITY }
    }

    /// Takes note of a lower neighbour.
    fn over(&mut self, base: f64, direction: usize, distance: f64) {
        match direction {
            1 | 6 => self.row = self.row.min(base),
            3 | 4 => self.col = self.col.min(base),
            _ => self.others = self.others.min(base + self.slope * distance),
        }
    }

    fn highest(&self) -> f64 {
        let (x, y) = (self.side.x, self.side.y);
        let mut highest = (self.row + self.slope * y).min(self.col + self.slope * x).min(self.others);
        if self.row.is_finite() && self.col.is_finite() {
            // ((h - col) / x)² + ((h - row) / y)² = slope², where the surface falls towards both.
            let apart = self.row - self.col;
            let (u, v) = (1.0 / (x * x), 1.0 / (y * y));
            let root = (u + v) * self.slope * self.slope - u * v * apart * apart;
            if root > 0.0 {
                let height = self.col + (v * apart + root.sqrt()) / (u + v);
                if height > self.row.max(self.col) {
                    highest = highest.min(height);
                }
            }
        }
        highest
    }
}

/// Terrain under erosion.
pub(crate) struct Erosion {
    /// Heights in metres.
    pub(crate) heights: Vec<f32>,
    /// Thickness of loose sediment in metres.
    pub(crate) sediment: Vec<f32>,
    /// Cubic metres of sediment that left at the edges.
    pub(crate) lost: f64,
    grid: Grid,
    settling: f64,
    /// Greatest fall per metre.
    steepest: f64,
    /// Metres of rain a year.
    rain: f64,
    /// Cubic metres of sediment that came to each cell in the step before.
    load: Vec<f64>,
    /// Per basin: cubic metres of water, then the share of it that sediment takes.
    lakes: Vec<f64>,
    /// Heights after the step.
    next: Vec<f32>,
}

impl Erosion {
    pub(crate) fn new(terrain: &Heightfield, settling: f64, steepest_deg: f64, rain: f64) -> Self {
        let heights = terrain.cells().to_vec();
        Self {
            sediment: heights.iter().map(|height| if height.is_nan() { f32::NAN } else { 0.0 }).collect(),
            lost: 0.0,
            grid: terrain.grid().clone(),
            settling,
            rain,
            lakes: Vec::new(),
            steepest: libm::tan(steepest_deg.to_radians()),
            load: vec![0.0; heights.len()],
            next: heights.clone(),
            heights,
        }
    }

    /// One step; `strength` is the years of it times the rate of cutting at unit slope and unit discharge.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn step(
        &mut self,
        lattice: &Lattice,
        routes: &Routes,
        strength: impl Fn(usize) -> f64,
        job: &Job,
    ) -> Result<()> {
        self.cut(lattice, routes, strength, job)?;
        self.carry(lattice, routes, job)?;
        self.fill_lakes(routes);
        std::mem::swap(&mut self.heights, &mut self.next);
        Ok(())
    }

    /// Upwards: every cell's new height from those that it drains to.
    fn cut(
        &mut self,
        lattice: &Lattice,
        routes: &Routes,
        strength: impl Fn(usize) -> f64,
        job: &Job,
    ) -> Result<()> {
        for (step, &cell) in routes.order.iter().rev().enumerate() {
            check_at(step, job)?;
            let cell = cell as usize;
            let here = f64::from(self.heights[cell]);
            let split = routes.split(lattice, cell);
            let discharge = routes.discharge[cell];
            if split.still || discharge <= 0.0 {
                self.next[cell] = self.heights[cell];
                continue;
            }
            let cutting = strength(cell) * discharge.sqrt();
            let (mut pull, mut target) = (0.0, 0.0);
            let mut slide = Slide::new(self.steepest * self.firmness(cell), lattice.cell);
            for k in 0..split.count {
                let base = f64::from(self.base(lattice, routes, cell, split.to[k]));
                let weight = cutting * split.share[k] / split.distance[k];
                pull += weight;
                target += weight * base;
                slide.over(base, split.direction[k], split.distance[k]);
            }
            // Never more than what comes, so that a trickle under a cliff is not buried in one step.
            let load = self.load[cell];
            let settles = (self.settling * load * self.rain / discharge).min(load / lattice.area);
            let height = (here + settles + target) / (1.0 + pull);
            self.next[cell] = height.min(slide.highest()) as f32;
        }
        Ok(())
    }

    /// How firm the rock is: what is exactly even from cell to cell breaks off in planes as even.
    fn firmness(&self, cell: usize) -> f64 {
        let (row, col) = self.grid.base(cell / self.grid.cols, cell % self.grid.cols);
        1.0 + UNEVEN * signed_unit(key(0, FIRMNESS, row, col))
    }

    /// The height that water from `cell` falls to at `to`: new ground, a lake, or what lies beyond the edge.
    fn base(&self, lattice: &Lattice, routes: &Routes, cell: usize, to: u32) -> f32 {
        if to == OUT {
            return lattice.beyond(cell).map_or(self.heights[cell], |beyond| beyond.height);
        }
        let to = to as usize;
        if routes.water[to] > self.heights[to] { routes.water[to] } else { self.next[to] }
    }

    /// Downwards: hands on what was cut, and lets no cell keep more than came to it.
    fn carry(&mut self, lattice: &Lattice, routes: &Routes, job: &Job) -> Result<()> {
        self.depths(lattice, routes);
        self.load.fill(0.0);
        for (step, &cell) in routes.order.iter().enumerate() {
            check_at(step, job)?;
            let cell = cell as usize;
            let split = routes.split(lattice, cell);
            let mut load = self.load[cell];
            if !split.still {
                let here = self.heights[cell];
                let kept = f64::from(self.next[cell] - here).min(load / lattice.area);
                self.next[cell] = (f64::from(here) + kept) as f32;
                let change = self.next[cell] - here;
                self.sediment[cell] = (self.sediment[cell] + change).max(0.0);
                load = (load - f64::from(change) * lattice.area).max(0.0);
            } else if let Some(basin) = routes.lowest_of(cell) {
                let lake = &mut self.lakes[basin];
                let settles = load.min(*lake * FULLEST);
                load -= settles;
                *lake = if settles > 0.0 { settles / *lake } else { 0.0 };
            }
            for k in 0..split.count {
                let part = load * split.share[k];
                match split.to[k] {
                    OUT => self.lost += part,
                    to => self.load[to as usize] += part,
                }
            }
        }
        Ok(())
    }

    /// How many cubic metres of water stand in each basin.
    fn depths(&mut self, lattice: &Lattice, routes: &Routes) {
        self.lakes.clear();
        self.lakes.resize(routes.basins(), 0.0);
        for (cell, &basin) in routes.basin.iter().enumerate() {
            let depth = routes.water[cell] - self.heights[cell];
            if depth > 0.0 {
                self.lakes[basin as usize] += f64::from(depth) * lattice.area;
            }
        }
    }

    /// Raises the floor of each lake by the same part of its depth everywhere.
    fn fill_lakes(&mut self, routes: &Routes) {
        let Self { heights, sediment, next, lakes, .. } = self;
        next.par_iter_mut().zip(sediment).enumerate().for_each(|(cell, (next, sediment))| {
            let depth = routes.water[cell] - heights[cell];
            if depth > 0.0 {
                *next += (f64::from(depth) * lakes[routes.basin[cell] as usize]) as f32;
                *sediment += *next - heights[cell];
            }
        });
    }
}
