//! MD alone: the top-down pass of MCMD (equations (1) and (2) of Belhadj 2007).

use orograph_core::prelude::*;

use crate::mcmd::{
    axis::Axis,
    settings::{Clamp, Datum, Known, Preset, Scheme, Settings, Shape, check_levels, seed_of},
    top_down::top_down,
};

/// Displaces the midpoints of everything unknown: the second pass of MCMD.
///
/// Known cells keep their heights to the bit; every other cell gets one. Without the first pass, lone known cells
/// stand out as spikes.
#[derive(Params, Clone, Debug)]
pub struct Md {
    /// Settings by name; every name but `custom` overrides l, hurst, rt and rs below.
    #[param(default = Preset::Custom)]
    pub preset: Preset,
    /// Uses the named preset's l, or your own, with the other sign. The published figures lost theirs in print.
    #[param(default = false)]
    pub flip_l: bool,
    /// How the plane is subdivided.
    #[param(default = Scheme::TriangleEdge)]
    pub scheme: Scheme,
    /// How heights fall off away from known cells. Above 0 they sink to the datum, below 0 they rise from it;
    /// less than 1 makes bells, 1 cones, more than 1 sharp ridges; 0 interpolates.
    #[param(default = 0, range = -8.0..=8.0, slider = -2.0..=2.0, unit = "1")]
    pub l: f64,
    /// Smoothness of the displacement: half of the surface's Hurst exponent. Less is rougher.
    #[param(default = 0.45, range = 0.0..=1.5, slider = 0.25..=0.6, unit = "1")]
    pub hurst: f64,
    /// Shift of the displacement: 1 only raises, -1 only lowers, 0 does both alike.
    #[param(default = 0, range = -2.0..=2.0, slider = -1.0..=1.0, unit = "1")]
    pub rt: f64,
    /// Strength of the displacement; 0 turns it off.
    #[param(default = 0, range = 0.0..=4.0, slider = 0.0..=1.5, unit = "1")]
    pub rs: f64,
    /// Height that the displacement's strength refers to; 0 takes the range of the constraints.
    #[param(default = 0, range = 0.0..=20_000.0, slider = 0.0..=4000.0, unit = "m")]
    pub relief: f64,
    /// Level about which l scales heights. The published algorithm has `zero`.
    #[param(default = Datum::Lowest)]
    pub datum: Datum,
    /// That level when `datum` is `level`.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub datum_level: f64,
    /// Factor on the displacement of square centres; the square root of 2 evens out the triangle-edge scheme.
    #[param(default = 1, range = 0.0..=4.0, slider = 0.5..=2.0, unit = "1")]
    pub center_gain: f64,
    /// What holds computed heights back; negative l can overshoot.
    #[param(default = Clamp::Off)]
    pub clamp: Clamp,
    /// Lowest computed height when `clamp` is `levels`.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Highest computed height when `clamp` is `levels`.
    #[param(default = 4000, range = -20_000.0..=20_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
    /// Seed of the displacement; the run's seed counts too.
    #[param(default = 0u64, range = 0..=4_294_967_295i64, slider = 0..=1000, unit = "seed")]
    pub seed: u64,
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
        let custom = Shape { l: self.l, l_bu: 0.0, hurst: self.hurst, rt: self.rt, rs: self.rs };
        Settings {
            scheme: self.scheme,
            shape: self.preset.shape(custom, self.flip_l),
            relief: known.relief(self.relief),
            datum: known.datum(self.datum, self.datum_level),
            center_gain: self.center_gain,
            limits: known.limits(self.clamp, self.lowest, self.highest),
            dimensions: 2.0,
            seed: seed_of(self.seed, job),
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
        check_levels(self.clamp, self.lowest, self.highest)
    }

    fn run(&self, inputs: MdIn<'_>, job: &Job) -> Result<MdOut> {
        let settings = self.settings(&Known::of(inputs.constraints)?, job);
        let mut terrain = inputs.constraints.map(job, |height| height)?;
        let (cols, rows) = (Axis::new(terrain.cols())?, Axis::new(terrain.rows())?);
        top_down(&mut terrain, (&cols, &rows), &settings, job)?;
        Ok(MdOut { terrain })
    }
}
