//! MCMD: a terrain through any set of known cells, by midpoint displacement that they constrain.
//!
//! Belhadj, "Terrain modeling: a constrained fractal model", AFRIGRAPH 2007. Two passes: the bottom-up pass
//! ([`crate::mcmd::mdbu`]) tells every known cell's ascendants in the subdivision what is known below them, the
//! top-down pass ([`crate::mcmd::md`]) displaces midpoints wherever nothing is known. Departures: heights are
//! scaled about a datum instead of about zero; any size is subdivided without padding; unknown corners start at
//! the mean of the known cells; random numbers come from seed and cell, so threads do not change the result.

use orograph_core::Unit;
use orograph_core::prelude::*;

use crate::Chance;
use crate::mcmd::{
    axis::Axis,
    bottom_up::bottom_up,
    params::{Centers, Displacement, Flanks, LargeForms, Level, Limits, Named, Subdivision},
    settings::{Known, Settings},
    top_down::top_down,
};

/// Builds a terrain through known cells: scattered samples, ridges and rivers, drawn lines.
///
/// Known cells keep their heights to the bit; every other cell gets one. Distances count in cells.
#[derive(Params, Clone, Debug)]
pub struct Mcmd {
    /// Settings by name.
    #[param(flatten)]
    pub named: Named,
    /// The subdivision of the plane.
    #[param(flatten)]
    pub subdivision: Subdivision,
    /// The flanks of known cells.
    #[param(flatten)]
    pub flanks: Flanks,
    /// The large forms.
    #[param(flatten)]
    pub large_forms: LargeForms,
    /// The random part of heights.
    #[param(flatten)]
    pub displacement: Displacement,
    /// The level about which heights are scaled.
    #[param(flatten)]
    pub level: Level,
    /// The displacement of centres.
    #[param(flatten)]
    pub centers: Centers,
    /// What holds computed heights back.
    #[param(flatten)]
    pub limits: Limits,
    /// The random numbers.
    #[param(flatten)]
    pub chance: Chance,
}

/// Inputs of [`Mcmd`].
#[derive(Inputs)]
pub struct McmdIn<'a> {
    /// Known heights; a void is an unknown cell.
    pub constraints: &'a Heightfield,
}

/// Outputs of [`Mcmd`].
#[derive(Outputs)]
pub struct McmdOut {
    /// Terrain without voids, through every known cell.
    pub terrain: Heightfield,
    /// What the passes did: cells, constraints, mdbu_rounds, known_after_mdbu, relief and datum.
    pub report: Table,
}

impl Mcmd {
    fn settings(&self, known: &Known, job: &Job<'_>) -> Settings {
        let custom = self.displacement.shape(self.flanks, self.large_forms);
        Settings {
            scheme: self.subdivision.scheme,
            shape: self.named.preset.shape(custom, self.named.flip_l),
            relief: known.relief(self.displacement.relief),
            datum: self.level.of(known),
            center_gain: self.centers.center_gain,
            limits: self.limits.of(known),
            dimensions: 2.0,
            seed: self.chance.key(job),
        }
    }
}

impl Node for Mcmd {
    const ID: &'static str = "mcmd.mcmd";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = McmdIn<'a>;
    type Outputs = McmdOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn check(&self) -> Result<()> {
        self.limits.check()
    }

    fn run(&self, inputs: McmdIn<'_>, job: &Job) -> Result<McmdOut> {
        let known = Known::of(inputs.constraints)?;
        let settings = self.settings(&known, job);
        let (terrain, report) = reconstruct(inputs.constraints, &known, &settings, job)?;
        Ok(McmdOut { terrain, report })
    }
}

/// Both passes over a copy of `constraints`, and the report.
pub(crate) fn reconstruct(
    constraints: &Heightfield,
    known: &Known,
    settings: &Settings,
    job: &Job<'_>,
) -> Result<(Heightfield, Table)> {
    let mut terrain = constraints.map(job, |height| height)?;
    let (cols, rows) = (Axis::new(terrain.cols())?, Axis::new(terrain.rows())?);
    let found = bottom_up(&mut terrain, (&cols, &rows), settings, job)?;
    top_down(&mut terrain, (&cols, &rows), settings, job)?;
    let after = known.cells as f64 + found.found as f64;
    let report = Table::metrics([
        ("cells", Unit::One, terrain.grid().len() as f64),
        ("constraints", Unit::One, known.cells as f64),
        ("mdbu_rounds", Unit::One, found.rounds as f64),
        ("known_after_mdbu", Unit::One, after),
        ("relief", Unit::Metre, settings.relief),
        ("datum", Unit::Metre, settings.datum),
    ])?;
    Ok((terrain, report))
}
