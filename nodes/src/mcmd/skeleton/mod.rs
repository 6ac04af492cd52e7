//! A skeleton of ridges and rivers from nothing, as constraints for `mcmd.mcmd`.
//!
//! Belhadj (2007) starts terrains from scratch with such a skeleton and says little of it, so this is our own: ridges
//! wander out from summits on fractal headings and sink like a bell; rivers rise beside them and keep to the valleys of
//! a rough terrain that the ridges span, never over a ridge, never uphill, one into another, and out over the border.
//! Lengths are shares of the diagonal, so a preview has the ridges of the build.

mod ridges;
mod rivers;

use orograph_core::prelude::*;

use crate::mcmd::{
    extent::extent,
    mcmd::reconstruct,
    settings::{Known, Scheme, Settings, Shape},
};
use crate::{Chance, Ground};

/// Draws a skeleton of ridges and rivers with their heights, from a seed alone.
///
/// Give it to `mcmd.mcmd`, for instance with the preset `mountains`. Rivers fall all the way to their mouths, and no
/// cell is both ridge and river.
#[derive(Params, Clone, Debug)]
pub struct Skeleton {
    /// Height of the highest possible summit; the lowest ground is at 0 m.
    #[param(default = 2000, range = 0.001..=20_000.0, slider = 100.0..=6000.0, unit = "m")]
    pub relief: f64,
    /// Ridges, each with a summit and two arms.
    #[param(default = 8u32, range = 0..=1000, slider = 0..=32, unit = "1")]
    pub ridges: u32,
    /// Rivers, each rising beside a ridge.
    #[param(default = 24u32, range = 0..=1000, slider = 0..=100, unit = "1")]
    pub rivers: u32,
    /// How far ridges turn on their way; 0 makes them straight.
    #[param(default = 57.3, range = 0.0..=360.0, slider = 0.0..=120.0, unit = "deg")]
    pub wander: f64,
    /// Distance in which a ridge sinks to three fifths of its summit, as a share of the diagonal.
    #[param(default = 0.25, range = 0.01..=2.0, slider = 0.05..=0.6, unit = "1")]
    pub reach: f64,
    /// The ground to cover.
    #[param(flatten, default = Ground { cells: 513, ..Ground::default() })]
    pub ground: Ground,
    /// The random numbers.
    #[param(flatten)]
    pub chance: Chance,
}

/// Outputs of [`Skeleton`].
#[derive(Outputs)]
pub struct SkeletonOut {
    /// Heights of ridges and rivers; all other cells are voids.
    pub constraints: Heightfield,
    /// 1 on ridges.
    pub ridges: Mask,
    /// 1 on rivers.
    pub rivers: Mask,
}

impl Node for Skeleton {
    const ID: &'static str = "mcmd.skeleton";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed, ContextItem::Resolution];
    type Inputs<'a> = ();
    type Outputs = SkeletonOut;

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, (): (), job: &Job) -> Result<SkeletonOut> {
        let grid = extent(&self.ground, job)?;
        let seed = self.chance.key(job);
        let ridges = self.draw_ridges(grid.clone(), seed, job)?;
        let rivers = if ridges.void_count() == grid.len() {
            rivers::Rivers::default()
        } else {
            let surface = spanned(&ridges, self.relief, seed, job)?;
            rivers::trace(&ridges, &surface, self.relief, self.rivers, seed, job)?
        };
        let ridge_mask = ridges.map(job, |height| if height.is_nan() { 0.0 } else { 1.0 })?;
        job.check()?;
        let mut river_mask = Mask::filled(grid, 0.0, job)?;
        let mut constraints = ridges;
        for (&cell, &height) in &rivers.heights {
            constraints.cells_mut()[cell] = height;
            river_mask.cells_mut()[cell] = 1.0;
        }
        Ok(SkeletonOut { constraints, ridges: ridge_mask, rivers: river_mask })
    }
}

/// The terrain that ridges span, for rivers to choose their ways over: its roughness makes them wind.
fn spanned(ridges: &Heightfield, relief: f64, seed: u64, job: &Job<'_>) -> Result<Heightfield> {
    let known = Known::of(ridges)?;
    let settings = Settings {
        scheme: Scheme::DiamondSquare,
        shape: Shape { l: 1.0, l_bu: 6.0, hurst: 0.3, rt: 0.0, rs: 0.6 },
        relief,
        datum: 0.0,
        center_gain: 1.0,
        limits: None,
        dimensions: 2.0,
        seed,
    };
    Ok(reconstruct(ridges, &known, &settings, job)?.0)
}

/// Diagonal of a grid, in cells.
fn diagonal(grid: &Grid) -> f64 {
    libm::hypot(grid.cols as f64, grid.rows as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(cells: u32) -> Ground {
        Ground { cells, ..Skeleton::default().ground }
    }

    fn run(node: &Skeleton) -> SkeletonOut {
        node.run((), &Job::detached()).unwrap()
    }

    #[test]
    fn ridges_and_rivers_are_apart_and_between_0_and_the_relief() {
        for seed in 0..6 {
            let node = Skeleton {
                ground: Ground { height: 7000.0, ..cells(200) },
                chance: Chance { seed },
                ..Skeleton::default()
            };
            let out = run(&node);
            assert_eq!(out.constraints.grid().size(), (140, 200));
            let (low, high) = out.constraints.range().unwrap();
            assert!(low >= 0.0 && high <= 2000.0, "{low} {high}");
            let mut counts = (0, 0);
            for ((&height, &ridge), &river) in
                out.constraints.cells().iter().zip(out.ridges.cells()).zip(out.rivers.cells())
            {
                assert!(ridge + river <= 1.0);
                assert_eq!(height.is_nan(), ridge + river == 0.0);
                counts = (counts.0 + ridge as u32, counts.1 + river as u32);
            }
            assert!(counts.0 > 300 && counts.1 > 100, "{counts:?}");
        }
    }

    #[test]
    fn extremes_pass() {
        for node in [
            Skeleton { ground: cells(1), ..Skeleton::default() },
            Skeleton { ground: cells(2), rivers: 100, ..Skeleton::default() },
            Skeleton { ground: Ground { height: 1.0, ..cells(50) }, ..Skeleton::default() },
            Skeleton { ground: cells(50), ridges: 0, ..Skeleton::default() },
            Skeleton { ground: cells(20), ridges: 300, rivers: 300, ..Skeleton::default() },
        ] {
            let out = run(&node);
            assert_eq!(out.constraints.grid(), out.rivers.grid());
        }
    }

    #[test]
    fn a_seed_gives_one_skeleton_on_any_number_of_threads() {
        let on = |threads: usize, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let node = Skeleton { ground: cells(100), chance: Chance { seed }, ..Skeleton::default() };
            pool.install(|| run(&node))
                .constraints
                .into_cells()
                .iter()
                .map(|h| h.to_bits())
                .collect::<Vec<_>>()
        };
        assert!(on(1, 1) == on(2, 1) && on(1, 1) == on(8, 1) && on(1, 1) != on(1, 2));
    }
}
