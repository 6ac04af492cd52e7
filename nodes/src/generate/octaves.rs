//! The settings of fractal noise.

use orograph_core::prelude::*;

use super::noise::{self, Noise};

/// Layers of noise, each finer and lower than the one before.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Octaves {
    /// Size of the largest forms.
    #[param(default = 4000, range = 0.1..=10_000_000.0, slider = 50.0..=20_000.0, unit = "m")]
    pub wavelength: f64,
    /// Layers of ever finer forms.
    #[param(default = 8u32, range = 1..=16, slider = 1..=12, unit = "1")]
    pub octaves: u32,
    /// Height of each layer relative to the one before: higher is rougher.
    #[param(default = 0.5, range = 0.0..=1.0, slider = 0.3..=0.7, unit = "1")]
    pub gain: f64,
    /// How many times finer each layer is than the one before.
    #[param(default = 2, range = 1.01..=4.0, slider = 1.7..=2.5, unit = "1")]
    pub lacunarity: f64,
    /// Which of all such terrains; the run's seed counts as well.
    #[param(default = 0u32, range = 0..=4_294_967_295u32, slider = 0..=999, unit = "seed")]
    pub seed: u32,
}

impl Octaves {
    /// # Errors
    /// As [`noise::check_octaves`].
    pub(crate) fn check(&self) -> Result<()> {
        noise::check_octaves(self.wavelength, self.lacunarity, self.octaves)
    }

    /// The layers under the node's seed and the run's.
    pub(crate) fn noise(&self, job: &Job) -> Noise {
        Noise::new(noise::seed(job.seed(), self.seed), self.wavelength, self.lacunarity, self.octaves)
    }

    /// The layers' heights, which add up to 1.
    pub(crate) fn gains(&self) -> Vec<f32> {
        noise::gains(self.gain, self.octaves)
    }
}
