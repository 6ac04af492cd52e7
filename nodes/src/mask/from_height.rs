//! Mask from height: the cells between two levels.

use orograph_core::prelude::*;

use super::ramp::band;

/// Selects the cells whose heights lie between two levels. Voids are not selected.
#[derive(Params, Clone, Debug)]
pub struct FromHeight {
    /// Lowest height to select.
    #[param(default = 500, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub low: f64,
    /// Highest height to select.
    #[param(default = 20_000, range = -20_000.0..=20_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub high: f64,
    /// How far beyond the levels the mask fades out.
    #[param(default = 0, range = 0.0..=20_000.0, slider = 0.0..=500.0, unit = "m")]
    pub soft: f64,
}

/// Inputs of [`FromHeight`].
#[derive(Inputs)]
pub struct FromHeightIn<'a> {
    /// Terrain to select from.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`FromHeight`].
#[derive(Outputs)]
pub struct FromHeightOut {
    /// The selected cells.
    pub mask: Mask,
}

impl Node for FromHeight {
    const ID: &'static str = "mask.from_height";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = FromHeightIn<'a>;
    type Outputs = FromHeightOut;

    fn check(&self) -> Result<()> {
        if self.low <= self.high {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`low` ({} m) lies above `high` ({} m)", self.low, self.high),
            "swap them",
        ))
    }

    fn run(&self, inputs: FromHeightIn<'_>, job: &Job) -> Result<FromHeightOut> {
        let &Self { low, high, soft } = self;
        let mask = inputs.terrain.map(job, |height| band(f64::from(height), low, high, soft) as f32)?;
        Ok(FromHeightOut { mask })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn cells_between_the_levels_are_selected() {
        let node = FromHeight { low: 10.0, high: 20.0, soft: 4.0 };
        let terrain = row(&[0.0, 8.0, 10.0, 15.0, 20.0, 22.0, 30.0, f32::NAN]);
        let out = node.run(FromHeightIn { terrain: &terrain }, &Job::detached()).unwrap().mask;
        assert_eq!(out.cells(), [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0]);
    }
}
