//! MD alone: the top-down pass of MCMD (equations (1) and (2) of Belhadj 2007).

use orograph_core::prelude::*;

use crate::Chance;
use crate::mcmd::{
    axis::Axis,
    params::{Centers, Displacement, Flanks, LargeForms, Level, Limits, Named, Subdivision},
    settings::{Known, Settings},
    top_down::top_down,
};

/// Displaces the midpoints of everything unknown: the second pass of MCMD.
///
/// Known cells keep their heights to the bit; every other cell gets one. Without the first pass, lone known cells
/// stand out as spikes.
#[derive(Params, Clone, Debug)]
pub struct Md {
    /// Settings by name.
    #[param(flatten)]
    pub named: Named,
    /// The subdivision of the plane.
    #[param(flatten)]
    pub subdivision: Subdivision,
    /// The flanks of known cells.
    #[param(flatten)]
    pub flanks: Flanks,
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

/// Inputs of [`Md`].
#[derive(Inputs)]
pub struct MdIn<'a> {
    /// Known heights; a void is an unknown cell.
    pub constraints: &'a Heightfield,
}

/// Outputs of [`Md`].
#[derive(Outputs)]
pub struct MdOut {
    /// Terrain without voids, through every known cell.
    pub terrain: Heightfield,
}

impl Md {
    fn settings(&self, known: &Known, job: &Job<'_>) -> Settings {
        let custom = self.displacement.shape(self.flanks, LargeForms::default());
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

impl Node for Md {
    const ID: &'static str = "mcmd.md";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = MdIn<'a>;
    type Outputs = MdOut;

    fn cost(&self) -> f64 {
        6.0
    }

    fn check(&self) -> Result<()> {
        self.limits.check()
    }

    fn run(&self, inputs: MdIn<'_>, job: &Job) -> Result<MdOut> {
        let settings = self.settings(&Known::of(inputs.constraints)?, job);
        let mut terrain = inputs.constraints.map(job, |height| height)?;
        let (cols, rows) = (Axis::new(terrain.cols())?, Axis::new(terrain.rows())?);
        top_down(&mut terrain, (&cols, &rows), &settings, job)?;
        Ok(MdOut { terrain })
    }
}
