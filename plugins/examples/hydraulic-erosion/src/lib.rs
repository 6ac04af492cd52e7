//! Hydraulic erosion: rivers carve terrain and lay down what they carry.
//!
//! Method: the stream power law with sediment deposition, solved implicitly in steps of many years. In every step
//! 1. water is routed over the terrain, through lakes and out of it ([`routing`]);
//! 2. from the outlets up, each cell is cut down towards where its water goes, at a rate of
//!    `K (1 - hardness) √Q · slope`, and raised by what settles of the sediment of the ground above it, solved as in
//!    Braun & Willett (2013), "A very efficient O(n), implicit and parallel method to solve the stream power
//!    equation", for flow that divides;
//! 3. from the divides down, what was cut away is handed on with the water, and no cell keeps more of it than came
//!    ([`sweeps`]). What reaches a lake fills its floor.
//!
//! Deposition follows Davy & Lague (2009) and Yuan, Braun, Guerit, Rouby & Cordonnier (2019), "A new efficient method
//! to solve the stream power law model taking into account sediment deposition". Departures: what settles is taken
//! from the sediment of the step before instead of iterating within one; the exponent of the discharge is ½ and that
//! of the slope 1; there is no uplift; slopes steeper than a limit fall at once, and the limit differs a little
//! from cell to cell, without which they would fall in planes.

mod lattice;
mod routing;
mod sweeps;

use orograph_plugin::{libm, prelude::*, rayon::prelude::*};

use crate::{lattice::Lattice, routing::Routes, sweeps::Erosion};

orograph_plugin::export!("Hydraulic erosion", [Hydraulic]);

/// Rain gathers in streams that carve valleys, and what they carry settles in fans, valley floors and lakes. Streams
/// leave at the borders at the height that the ground beyond is likely to have. Voids stay voids, and water that
/// comes to one leaves there.
#[derive(Params, Clone, Debug)]
pub struct Hydraulic {
    /// How long it rains, in years. Valleys grow headwards from the outlets all that time.
    #[param(default = 100_000, range = 0.0..=100_000_000.0, slider = 1_000.0..=1_000_000.0, unit = "1")]
    pub years: f64,
    /// How fast a stream cuts, in millimetres a year: one that drains 1 km² at 10 % slope under 1000 mm of rain.
    #[param(default = 1, range = 0.0..=1000.0, slider = 0.1..=10.0, unit = "1")]
    pub cutting_mm: f64,
    /// Rain, in millimetres a year, where the mask `rain` is 1.
    #[param(default = 1000, range = 0.0..=100_000.0, slider = 100.0..=5000.0, unit = "1")]
    pub rain_mm: f64,
    /// How readily sediment settles. 0 carries everything away; above 1 valleys fill and streams spread in fans.
    #[param(default = 1, range = 0.0..=10.0, slider = 0.0..=3.0, unit = "1")]
    pub settling: f64,
    /// The steepest slope that dry ground keeps, a quarter more or less from cell to cell, as rock is.
    #[param(default = 50, range = 1.0..=89.0, slider = 20.0..=70.0, unit = "deg")]
    pub steepest: f64,
    /// Steps that the years are cut into. More of them let streams move more often; the time taken grows alike.
    #[param(default = 30, range = 1..=10_000, slider = 10.0..=200.0, unit = "1")]
    pub steps: u32,
}

/// Inputs of [`Hydraulic`].
#[derive(Inputs)]
pub struct HydraulicIn<'a> {
    /// Terrain to erode.
    pub terrain: &'a Heightfield,
    /// Where how much rain falls, as a share of `rain_mm`; everywhere all of it when unconnected.
    pub rain: Option<&'a Mask>,
    /// How hard the rock is: 0 is cut at the full rate, 1 never. Soft everywhere when unconnected.
    pub hardness: Option<&'a Mask>,
}

/// Outputs of [`Hydraulic`].
#[derive(Outputs)]
pub struct HydraulicOut {
    /// Eroded terrain.
    pub terrain: Heightfield,
    /// Thickness of the sediment that lies on the rock in the end, in metres; 0 on bare rock, void on voids.
    pub deposit: Heightfield,
    /// How much water runs: 0 where only the cell's own rain does, 1 in the greatest stream, in between by the
    /// logarithm.
    pub flow: Mask,
}

impl Node for Hydraulic {
    const ID: &'static str = "erosion.hydraulic";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = HydraulicIn<'a>;
    type Outputs = HydraulicOut;

    fn cost(&self) -> f64 {
        100.0 * f64::from(self.steps)
    }

    fn run(&self, inputs: HydraulicIn<'_>, job: &Job) -> Result<HydraulicOut> {
        let grid = inputs.terrain.grid();
        for (name, mask) in [("rain", inputs.rain), ("hardness", inputs.hardness)] {
            if let Some(mask) = mask {
                grid.match_size("terrain", mask.grid(), name)?;
            }
        }
        // Heights, sediment, firmness, water, its ways, their order, discharge and loads stand beside each other.
        job.admit((grid.len() as u64).saturating_mul(76), || {
            format!("erosion of {} × {} cells", grid.rows, grid.cols)
        })?;
        let (erosion, routes) = erode(self, &inputs, job)?;
        let flow = flow_of(&routes, grid, job)?;
        Ok(HydraulicOut {
            terrain: Heightfield::new(grid.clone(), erosion.heights)?,
            deposit: Heightfield::new(grid.clone(), erosion.sediment)?,
            flow,
        })
    }
}

/// Runs all steps; the routes are those of the last.
fn erode(settings: &Hydraulic, inputs: &HydraulicIn<'_>, job: &Job) -> Result<(Erosion, Routes)> {
    let terrain = inputs.terrain;
    let lattice = Lattice::new(terrain, job)?;
    let mut routes = Routes::new(lattice.len());
    let mut erosion = Erosion::new(terrain, settings.settling, settings.steepest, settings.rain_mm / 1000.0);
    if lattice.len() == 0 {
        return Ok((erosion, routes));
    }
    let rain_on_cell = settings.rain_mm / 1000.0 * lattice.area;
    let rain = |cell| rain_on_cell * inputs.rain.map_or(1.0, |rain| share(rain.cells()[cell]));
    // Metres a year, at a slope of 1 and a discharge of 1 m³ a year.
    let cutting = settings.cutting_mm / 1000.0 / 0.1 / 1e6_f64.sqrt();
    let years = settings.years / f64::from(settings.steps);
    let strength =
        |cell| cutting * years * inputs.hardness.map_or(1.0, |hard| 1.0 - share(hard.cells()[cell]));
    let done = job.stage(u64::from(settings.steps));
    for _ in 0..settings.steps {
        routes.find(&lattice, &erosion.heights, rain, job)?;
        erosion.step(&lattice, &routes, strength, job)?;
        done.advance(1);
    }
    Ok((erosion, routes))
}

/// A mask's cell held to 0..=1, and 0 where it is no number.
fn share(cell: f32) -> f64 {
    if cell > 0.0 { f64::from(cell.min(1.0)) } else { 0.0 }
}

/// Discharge as a share, by its logarithm.
fn flow_of(routes: &Routes, grid: &Grid, job: &Job) -> Result<Mask> {
    let wet = |discharge: &&f64| **discharge > 0.0;
    let least = routes.discharge.par_iter().filter(wet).copied().reduce(|| f64::INFINITY, f64::min);
    let most = routes.discharge.par_iter().copied().reduce(|| 0.0, f64::max);
    let span = if most > least { libm::log(most / least) } else { 1.0 };
    Mask::build(grid.clone(), job, |row, flow| {
        for (col, flow) in flow.iter_mut().enumerate() {
            let discharge = routes.discharge[row * grid.cols + col];
            *flow =
                if discharge > least { (libm::log(discharge / least) / span).min(1.0) as f32 } else { 0.0 };
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
