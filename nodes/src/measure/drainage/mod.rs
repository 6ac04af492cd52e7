//! Drainage: closed depressions, and how streams gather.
//!
//! Depressions by [priority-flood](mod@flood), flow to the steepest neighbour over the filled ground ([`flow`]). Natural
//! basins obey laws that noise does not: the share of cells that at least a cells drain through falls about as
//! a^-0.43 (Rodríguez-Iturbe, I. et al. (1992), "Power law distributions of discharge mass and energy in river
//! basins", Water Resources Research 28 (4)), and streams lengthen as their area to the power of 0.5 to 0.6
//! (Hack, J. T. (1957), U.S. Geological Survey Professional Paper 294-B).

pub mod flood;
pub mod flow;
pub mod pits;

use orograph_core::{Unit, prelude::*};

use flood::flood;
use flow::Flow;
use pits::Pits;

/// Measures closed depressions and streams, and fills the depressions.
///
/// Water leaves over the border and into voids. Ratios are the terrain's figure over the reference's, NaN
/// without a reference.
#[derive(Params, Clone, Debug)]
pub struct Drainage {
    /// Depressions that are nowhere so deep do not count; the filled terrain has none in any case.
    #[param(default = 0, range = 0.0..=1000.0, slider = 0.0..=10.0, unit = "m")]
    pub min_depth: f64,
    /// Cells that must drain through a cell of a stream, for the density of streams.
    #[param(default = 1000u32, range = 2..=100_000_000, slider = 100..=10_000, unit = "cells")]
    pub stream_cells: u32,
}

/// Inputs of [`Drainage`].
#[derive(Inputs)]
pub struct DrainageIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to hold the figures against, of any size.
    pub reference: Option<&'a Heightfield>,
    /// Valleys of the terrain that ought to lie on streams.
    pub valleys: Option<&'a Features>,
}

/// Outputs of [`Drainage`].
#[derive(Outputs)]
pub struct DrainageOut {
    /// One row of metrics on depressions and streams.
    pub metrics: Table,
    /// The terrain with every closed depression filled to its spill level.
    pub filled: Heightfield,
    /// Cells that drain through each cell, itself included: a raster of counts, not of metres.
    pub accumulation: Heightfield,
}

impl Node for Drainage {
    const ID: &'static str = "measure.drainage";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = DrainageIn<'a>;
    type Outputs = DrainageOut;

    fn cost(&self) -> f64 {
        150.0
    }

    fn run(&self, inputs: DrainageIn<'_>, job: &Job) -> Result<DrainageOut> {
        let DrainageIn { terrain, reference, valleys } = inputs;
        if let Some(valleys) = valleys {
            terrain.grid().match_size("terrain", &valleys.grid, "valleys")?;
        }
        let (own, filled, flow) = self.figures(terrain, job)?;
        let other = reference.map(|field| self.figures(field, job)).transpose()?.map(|(figures, ..)| figures);
        let against = |of: fn(&Figures) -> f64| {
            other.as_ref().map_or((of(&own), f64::NAN), |other| (of(&own), of(other)))
        };
        let ratio = |of| {
            let (own, other): (f64, f64) = against(of);
            if own == other { 1.0 } else { own / other }
        };
        let difference = |of| {
            let (own, other): (f64, f64) = against(of);
            (own - other).abs()
        };
        let on_streams = valleys.map_or(f64::NAN, |valleys| flow.share_on_streams(valleys));
        let metrics = Table::metrics([
            ("pits_per_km2", Unit::One, own.pits_per_km2),
            ("pit_depth_mean", Unit::Metre, own.pit_depth_mean),
            ("pit_depth_max", Unit::Metre, own.pit_depth_max),
            ("raised_share", Unit::Percent, 100.0 * own.raised),
            ("raised_mean", Unit::Metre, own.raised_mean),
            ("exceedance_exponent", Unit::One, own.exceedance),
            ("drainage_density", Unit::PerMetre, own.density),
            ("hack_exponent", Unit::One, own.hack),
            ("valleys_on_streams", Unit::Percent, 100.0 * on_streams),
            ("pit_density_ratio", Unit::One, ratio(|all| all.pits_per_km2)),
            ("pit_depth_ratio", Unit::One, ratio(|all| all.pit_depth_mean)),
            ("raised_mean_ratio", Unit::One, ratio(|all| all.raised_mean)),
            ("drainage_density_ratio", Unit::One, ratio(|all| all.density)),
            ("exceedance_difference", Unit::One, difference(|all| all.exceedance)),
            ("hack_difference", Unit::One, difference(|all| all.hack)),
        ])?;
        let cols = terrain.cols();
        let accumulation = Heightfield::build(terrain.grid().clone(), job, |row, out| {
            let counts = &flow.accumulation[row * cols..(row + 1) * cols];
            for (out, &cells) in out.iter_mut().zip(counts).filter(|(_, cells)| **cells > 0) {
                *out = cells as f32;
            }
            Ok(())
        })?;
        Ok(DrainageOut { metrics, filled, accumulation })
    }
}

impl Drainage {
    /// Figures, the terrain filled, and its flow.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn figures(&self, terrain: &Heightfield, job: &Job) -> Result<(Figures, Heightfield, Flow)> {
        let flood = flood(terrain, job)?;
        let pits = Pits::of(terrain, &flood.filled, self.min_depth, job)?;
        let flow = Flow::of(&flood, job)?;
        let cell = terrain.grid().cell;
        let known = flood.order.len() as f64;
        let square_km = known * cell.x * cell.y / 1e6;
        let figures = Figures {
            pits_per_km2: pits.count as f64 / square_km,
            pit_depth_mean: if pits.count == 0 { 0.0 } else { pits.deepest_sum / pits.count as f64 },
            pit_depth_max: pits.deepest,
            raised: pits.cells as f64 / known,
            raised_mean: pits.depth_sum / known,
            exceedance: flow.exceedance(),
            density: flow.density(self.stream_cells, cell),
            hack: flow.hack(),
        };
        Ok((figures, flood.filled, flow))
    }
}

/// How a terrain drains. Shares and means are over the known ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Closed depressions on each square kilometre.
    pub pits_per_km2: f64,
    /// Mean over the depressions of the depth at their deepest, in metres; 0 without any.
    pub pit_depth_mean: f64,
    /// Depth of the deepest one, in metres; 0 without any.
    pub pit_depth_max: f64,
    /// Share of the ground that lies in depressions, 0 to 1.
    pub raised: f64,
    /// Volume to fill them on each area of ground, in m³/m².
    pub raised_mean: f64,
    /// See [`Flow::exceedance`].
    pub exceedance: f64,
    /// See [`Flow::density`].
    pub density: f64,
    /// See [`Flow::hack`].
    pub hack: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn run(terrain: &Heightfield, reference: Option<&Heightfield>) -> DrainageOut {
        let inputs = DrainageIn { terrain, reference, valleys: None };
        Drainage::default().run(inputs, &Job::detached()).unwrap()
    }

    /// A plane with two pits of 2 × 2 cells, 3 m and 1 m deep.
    fn pitted() -> Heightfield {
        field(100, 100, |row, col| {
            let pit = |r: usize, c: usize| (r..r + 2).contains(&row) && (c..c + 2).contains(&col);
            50.0 - if pit(20, 30) {
                3.0
            } else if pit(60, 70) {
                1.0
            } else {
                0.0
            }
        })
    }

    #[test]
    fn pits_are_counted_and_filled_to_the_brim() {
        let out = run(&pitted(), None);
        let metric = |name: &str| out.metrics.metric(name).unwrap();
        // A hundred hundred-square-metre cells each way make one square kilometre.
        assert_eq!(
            (metric("pits_per_km2"), metric("pit_depth_mean"), metric("pit_depth_max")),
            (2.0, 2.0, 3.0)
        );
        assert!((metric("raised_share") - 0.08).abs() < 1e-12);
        assert!((metric("raised_mean") - 16.0 / 1e4).abs() < 1e-12);
        assert!(out.filled.cells().iter().all(|&height| height == 50.0));
        assert!(metric("pit_density_ratio").is_nan());
        let shallow = Drainage { min_depth: 2.0, ..Drainage::default() };
        assert_eq!(shallow.figures(&pitted(), &Job::detached()).unwrap().0.pits_per_km2, 1.0);
    }

    #[test]
    fn figures_are_held_against_the_reference() {
        let plane = field(100, 100, |row, _| row as f64);
        let metrics = run(&pitted(), Some(&pitted())).metrics;
        for name in ["pit_density_ratio", "pit_depth_ratio", "raised_mean_ratio"] {
            assert_eq!(metrics.metric(name), Some(1.0));
        }
        let out = run(&plane, Some(&pitted()));
        assert_eq!(out.metrics.metric("pit_density_ratio"), Some(0.0));
        assert_eq!(run(&plane, Some(&plane)).metrics.metric("pit_density_ratio"), Some(1.0));
        // Ground without pits is handed on to the bit.
        assert_eq!(out.filled.cells(), plane.cells());
    }

    #[test]
    fn voids_and_no_ground_have_no_figures() {
        let out = run(&field(5, 6, |_, _| f64::NAN), None);
        assert!(out.metrics.metric("pits_per_km2").unwrap().is_nan());
        assert_eq!((out.filled.void_count(), out.accumulation.void_count()), (30, 30));
    }
}
