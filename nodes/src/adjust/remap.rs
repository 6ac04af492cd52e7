//! Remap: a linear change of heights, given by two pairs of levels.
use orograph_core::prelude::*;

/// Moves and stretches heights so that two levels become two others. Voids stay voids.
#[derive(Params, Clone, Debug)]
pub struct Remap {
    /// This height becomes `to_low`.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub from_low: f64,
    /// This height becomes `to_high`.
    #[param(default = 1000, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub from_high: f64,
    /// What `from_low` becomes.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub to_low: f64,
    /// What `from_high` becomes; below `to_low`, the terrain is turned upside down.
    #[param(default = 1000, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub to_high: f64,
    /// Hold heights that would leave the new range at its ends.
    #[param(default = false)]
    pub clamp: bool,
}

/// Inputs of [`Remap`].
#[derive(Inputs)]
pub struct RemapIn<'a> {
    /// Terrain to change.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Remap`].
#[derive(Outputs)]
pub struct RemapOut {
    /// Terrain with its new heights.
    pub terrain: Heightfield,
}

impl Node for Remap {
    const ID: &'static str = "adjust.remap";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = RemapIn<'a>;
    type Outputs = RemapOut;

    fn check(&self) -> Result<()> {
        if self.from_low < self.from_high {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`from_low` ({} m) does not lie below `from_high` ({} m)", self.from_low, self.from_high),
            "give two different levels, the lower first; swap `to_low` and `to_high` to invert",
        ))
    }

    fn run(&self, inputs: RemapIn<'_>, job: &Job) -> Result<RemapOut> {
        self.check()?;
        let scale = (self.to_high - self.to_low) / (self.from_high - self.from_low);
        let (low, high) = (self.to_low.min(self.to_high), self.to_low.max(self.to_high));
        let (from, to) = (self.from_low, self.to_low);
        let moved = |height: f32| to + (f64::from(height) - from) * scale;
        let terrain = match self.clamp {
            true => inputs.terrain.map(job, |height| moved(height).clamp(low, high) as f32),
            false => inputs.terrain.map(job, |height| moved(height) as f32),
        }?;
        Ok(RemapOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn levels_become_levels() {
        let node = Remap { from_low: 0.0, from_high: 100.0, to_low: 50.0, to_high: -50.0, clamp: false };
        let terrain = row(&[0.0, 100.0, 50.0, 200.0, f32::NAN]);
        let out = node.run(RemapIn { terrain: &terrain }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells()[..4], [50.0, -50.0, 0.0, -150.0]);
        assert!(out.at(0, 4).is_nan());
        let held = Remap { clamp: true, ..node };
        let out = held.run(RemapIn { terrain: &terrain }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.at(0, 3), -50.0);
        assert!(out.at(0, 4).is_nan());
        assert!(Remap { from_low: 1.0, from_high: 1.0, ..held }.check().is_err());
    }
}
