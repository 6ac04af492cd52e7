//! Clamp: heights held between two levels.

use orograph_core::prelude::*;

/// Holds every height between a lowest and a highest level. Voids stay voids.
#[derive(Params, Clone, Debug)]
pub struct Clamp {
    /// Heights below this become this.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Heights above this become this.
    #[param(default = 4000, range = -20_000.0..=20_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
}

/// Inputs of [`Clamp`].
#[derive(Inputs)]
pub struct ClampIn<'a> {
    /// Terrain to clamp.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Clamp`].
#[derive(Outputs)]
pub struct ClampOut {
    /// Terrain between the two levels.
    pub terrain: Heightfield,
}

impl Node for Clamp {
    const ID: &'static str = "adjust.clamp";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ClampIn<'a>;
    type Outputs = ClampOut;

    fn check(&self) -> Result<()> {
        if self.lowest <= self.highest {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`lowest` ({} m) lies above `highest` ({} m)", self.lowest, self.highest),
            "swap them",
        ))
    }

    fn run(&self, inputs: ClampIn<'_>, job: &Job) -> Result<ClampOut> {
        let (lowest, highest) = (self.lowest as f32, self.highest as f32);
        // `clamp` hands NaN on, so a void stays one.
        let terrain = inputs.terrain.map(job, |height| height.clamp(lowest, highest))?;
        Ok(ClampOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn heights_stay_between_the_levels_and_voids_stay_voids() {
        let clamp = Clamp { lowest: 0.0, highest: 10.0 };
        let terrain = row(&[-5.0, 5.0, 15.0, f32::NAN]);
        let out = clamp.run(ClampIn { terrain: &terrain }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells()[..3], [0.0, 5.0, 10.0]);
        assert!(out.at(0, 3).is_nan());
    }

    #[test]
    fn crossed_levels_are_refused() {
        assert!(Clamp { lowest: 1.0, highest: 0.0 }.check().is_err());
    }
}
