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
struct Slide<'a> {
    ground: &'a Ground,
    slope: f64,
    row: f64,
    col: f64,
    others: f64,
}

/// What all slides have in common.
struct Ground {
    /// Greatest fall per metre.
    steepest: f64,
    side: CellSize,
    /// Inverse squares of the sides, and the inverse of their sum.
    u: f64,
    v: f64,
    both: f64,
}

impl Ground {
    fn new(steepest_deg: f64, side: CellSize) -> Self {
        let (u, v) = (1.0 / (side.x * side.x), 1.0 / (side.y * side.y));
        Self { steepest: libm::tan(steepest_deg.to_radians()), side, u, v, both: 1.0 / (u + v) }
    }

    /// On ground of this firmness; the mean is 1.
    fn slide(&self, firmness: f32) -> Slide<'_> {
        let slope = self.steepest * f64::from(firmness);
        Slide { ground: self, slope, row: f64::INFINITY, col: f64::INFINITY, others: f64::INFINITY }
    }
}

impl Slide<'_> {
    /// Takes note of a lower neighbour.
    fn over(&mut self, base: f64, direction: usize, distance: f64) {
        match direction {
            1 | 6 => self.row = self.row.min(base),
            3 | 4 => self.col = self.col.min(base),
            _ => self.others = self.others.min(base + self.slope * distance),
        }
    }

    fn highest(&self) -> f64 {
        let Ground { side, u, v, both, .. } = *self.ground;
        let highest = (self.row + self.slope * side.y).min(self.col + self.slope * side.x).min(self.others);
        // ((h - col) / x)² + ((h - row) / y)² = slope², where the surface falls towards both.
        let apart = self.row - self.col;
        let root = (u + v) * self.slope * self.slope - u * v * apart * apart;
        if root > 0.0 {
            let height = self.col + (v * apart + root.sqrt()) * both;
            if height > self.row.max(self.col) {
                return highest.min(height);
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
    settling: f64,
    ground: Ground,
    /// How firm the rock is: what is exactly even from cell to cell breaks off in planes as even.
    firmness: Vec<f32>,
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
            settling,
            rain,
            lakes: Vec::new(),
            ground: Ground::new(steepest_deg, terrain.grid().cell),
            firmness: firmness(terrain.grid()),
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
            let discharge = routes.discharge[cell];
            if routes.still(cell) || discharge <= 0.0 {
                // What falls into a lake falls to its surface; the downward sweep puts its floor back.
                self.next[cell] = routes.water[cell];
                continue;
            }
            let cutting = strength(cell) * discharge.sqrt();
            let (mut pull, mut target) = (0.0, 0.0);
            let mut slide = self.ground.slide(self.firmness[cell]);
            routes.each_way(lattice, cell, |direction, to, share| {
                let (base, distance, nearness) = self.base(lattice, cell, direction, to);
                let weight = cutting * share * nearness;
                pull += weight;
                target += weight * base;
                slide.over(base, direction, distance);
            });
            // Never more than what comes, so that a trickle under a cliff is not buried in one step.
            let load = self.load[cell];
            let settles = (self.settling * load * self.rain / discharge).min(load / lattice.area);
            let height = (here + settles + target) / (1.0 + pull);
            self.next[cell] = height.min(slide.highest()) as f32;
        }
        Ok(())
    }

    /// The height that water from `cell` falls to at `to`, how far away that is, and the inverse of it: new
    /// ground, a lake, or what lies beyond the edge.
    #[inline(always)]
    fn base(&self, lattice: &Lattice, cell: usize, direction: usize, to: u32) -> (f64, f64, f64) {
        if to == OUT {
            let beyond = lattice.beyond(cell);
            return beyond.map_or((f64::INFINITY, 1.0, 1.0), |beyond| {
                let distance = f64::from(beyond.distance);
                (beyond.height.into(), distance, 1.0 / distance)
            });
        }
        let ground = f64::from(self.next[to as usize]);
        (ground, lattice.distances[direction].into(), lattice.nearness[direction])
    }

    /// Downwards: hands on what was cut, and lets no cell keep more than came to it.
    fn carry(&mut self, lattice: &Lattice, routes: &Routes, job: &Job) -> Result<()> {
        self.depths(lattice, routes);
        self.load.fill(0.0);
        for (step, &cell) in routes.order.iter().enumerate() {
            check_at(step, job)?;
            let cell = cell as usize;
            let mut load = self.load[cell];
            if !routes.still(cell) {
                let here = self.heights[cell];
                let kept = f64::from(self.next[cell] - here).min(load / lattice.area);
                self.next[cell] = (f64::from(here) + kept) as f32;
                let change = self.next[cell] - here;
                self.sediment[cell] = (self.sediment[cell] + change).max(0.0);
                load = (load - f64::from(change) * lattice.area).max(0.0);
            } else {
                self.next[cell] = self.heights[cell];
                if let Some(basin) = routes.lowest_of(cell) {
                    let lake = &mut self.lakes[basin];
                    let settles = load.min(*lake * FULLEST);
                    load -= settles;
                    *lake = if settles > 0.0 { settles / *lake } else { 0.0 };
                }
            }
            let Self { load: loads, lost, .. } = self;
            routes.each_way(lattice, cell, |_, to, share| match to {
                OUT => *lost += load * share,
                to => loads[to as usize] += load * share,
            });
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

fn firmness(grid: &Grid) -> Vec<f32> {
    let cell = |cell| {
        let (row, col) = grid.base(cell / grid.cols, cell % grid.cols);
        (1.0 + UNEVEN * signed_unit(key(0, FIRMNESS, row, col))) as f32
    };
    (0..grid.len()).into_par_iter().map(cell).collect()
}
