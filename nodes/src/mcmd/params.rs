//! Settings that several nodes of this family share, each declared here alone.

use orograph_core::prelude::*;

use crate::mcmd::settings::{Clamp, Datum, Known, Preset, Scheme, Shape};

/// Settings by name.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// Settings by name; every name but `custom` overrides the parameters from l to rs below.
    #[param(default = Preset::Custom)]
    pub preset: Preset,
    /// Uses the named preset's l, or your own, with the other sign. The published figures lost theirs in print.
    #[param(default = false)]
    pub flip_l: bool,
}

impl From<Preset> for Named {
    fn from(preset: Preset) -> Self {
        Self { preset, ..Self::default() }
    }
}

/// The subdivision of the plane.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Subdivision {
    /// How the plane is subdivided.
    #[param(default = Scheme::TriangleEdge)]
    pub scheme: Scheme,
}

/// The flanks of known cells.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Flanks {
    /// How heights fall off away from known cells. Above 0 they sink to the datum, below 0 they rise from it;
    /// less than 1 makes bells, 1 cones, more than 1 sharp ridges; 0 interpolates.
    #[param(default = 0, range = -8.0..=8.0, slider = -2.0..=2.0, unit = "1")]
    pub l: f64,
}

/// The large forms, which the bottom-up pass sets.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct LargeForms {
    /// How heights fall off in the bottom-up pass, which decides the large forms; it counts as `l` of `mcmd.mcmd` does.
    #[param(default = 0, range = -8.0..=64.0, slider = 0.0..=20.0, unit = "1")]
    pub l_bu: f64,
}

/// The random part of computed heights.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Smoothness of the displacement: a profile's Hurst exponent, half of a terrain's. Less is rougher.
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
}

impl Displacement {
    /// With the flanks and the large forms, the numbers that shape a surface.
    pub(crate) fn shape(&self, flanks: Flanks, forms: LargeForms) -> Shape {
        Shape { l: flanks.l, l_bu: forms.l_bu, hurst: self.hurst, rt: self.rt, rs: self.rs }
    }
}

/// The level about which heights are scaled.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Level about which l and l_bu scale heights. The published algorithm has `zero`.
    #[param(default = Datum::Lowest)]
    pub datum: Datum,
    /// That level when `datum` is `level`.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub datum_level: f64,
}

impl Level {
    /// In metres.
    pub(crate) fn of(&self, known: &Known) -> f64 {
        match self.datum {
            Datum::Lowest => known.range.map_or(0.0, |(low, _)| f64::from(low)),
            Datum::Zero => 0.0,
            Datum::Level => self.datum_level,
        }
    }
}

/// The displacement of centres.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Centers {
    /// Factor on the displacement of square centres; the square root of 2 evens out the triangle-edge scheme.
    #[param(default = 1, range = 0.0..=4.0, slider = 0.5..=2.0, unit = "1")]
    pub center_gain: f64,
}

/// What holds computed heights back.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// What holds computed heights back; negative l can overshoot.
    #[param(default = Clamp::Off)]
    pub clamp: Clamp,
    /// Lowest computed height when `clamp` is `levels`.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Highest computed height when `clamp` is `levels`.
    #[param(default = 4000, range = -20_000.0..=20_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
}

impl Limits {
    /// Lowest and highest computed height, in metres, if there are any.
    pub(crate) fn of(&self, known: &Known) -> Option<(f64, f64)> {
        match self.clamp {
            Clamp::Off => None,
            Clamp::Constraints => known.range.map(|(low, high)| (f64::from(low), f64::from(high))),
            Clamp::Levels => Some((self.lowest, self.highest)),
        }
    }

    /// # Errors
    /// [`Error::Invalid`] when levels cross.
    pub(crate) fn check(&self) -> Result<()> {
        let Self { clamp, lowest, highest } = *self;
        if clamp != Clamp::Levels || lowest <= highest {
            return Ok(());
        }
        Err(Error::invalid(format!("`lowest` ({lowest} m) lies above `highest` ({highest} m)"), "swap them"))
    }
}
