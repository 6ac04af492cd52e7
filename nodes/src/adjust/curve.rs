//! Curve: heights passed through a curve on their normalised range.

use orograph_core::prelude::*;

use super::normalise::finite_range;

/// Reshapes heights by a curve, as a tone curve does a picture. Voids stay voids.
///
/// The curve runs from 0 to 1 in both directions: x is the height as a share of the range between the lowest
/// and the highest, y the share that it becomes. Beyond its end points the curve is level.
#[derive(Params, Clone, Debug)]
pub struct Curve {
    /// Share of the range before (x) and after (y), straight between its points.
    #[param(default = [[0.0, 0.0], [0.25, 0.1], [0.75, 0.6], [1.0, 1.0]])]
    pub curve: orograph_core::Curve,
    /// Take the terrain's own lowest and highest height as the range.
    #[param(default = true)]
    pub own_range: bool,
    /// Height of share 0, unless the terrain's own range counts.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub low: f64,
    /// Height of share 1, unless the terrain's own range counts.
    #[param(default = 1000, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub high: f64,
}

/// Inputs of [`Curve`].
#[derive(Inputs)]
pub struct CurveIn<'a> {
    /// Terrain to change.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Curve`].
#[derive(Outputs)]
pub struct CurveOut {
    /// Terrain with its new heights, in the same range.
    pub terrain: Heightfield,
}

impl Node for Curve {
    const ID: &'static str = "adjust.curve";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CurveIn<'a>;
    type Outputs = CurveOut;

    fn check(&self) -> Result<()> {
        if self.own_range || self.low < self.high {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`low` ({} m) does not lie below `high` ({} m)", self.low, self.high),
            "give two different levels, the lower first, or turn `own_range` on",
        ))
    }

    fn run(&self, inputs: CurveIn<'_>, job: &Job) -> Result<CurveOut> {
        self.check()?;
        let (low, high) = if self.own_range { finite_range(inputs.terrain)? } else { (self.low, self.high) };
        let range = high - low;
        let terrain = inputs.terrain.map(job, |height| {
            // Level ground has no shares, and a void has none either.
            if height.is_nan() || range <= 0.0 {
                return height;
            }
            (low + range * self.curve.at((f64::from(height) - low) / range)) as f32
        })?;
        Ok(CurveOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn shares_of_the_range_follow_the_curve() {
        let node = Curve {
            curve: orograph_core::Curve::from([[0.0, 0.0], [0.5, 0.2], [1.0, 1.0]]),
            ..Curve::default()
        };
        let terrain = row(&[100.0, 150.0, 200.0, 175.0, f32::NAN]);
        let out = node.run(CurveIn { terrain: &terrain }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells()[..4], [100.0, 120.0, 200.0, 160.0]);
        assert!(out.at(0, 4).is_nan());
        let fixed = Curve { own_range: false, low: 0.0, high: 400.0, ..node };
        let out = fixed.run(CurveIn { terrain: &terrain }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.at(0, 0), 40.0);
        assert!(Curve { high: 0.0, ..fixed }.check().is_err());
    }

    #[test]
    fn level_ground_stays() {
        let terrain = row(&[7.0, 7.0]);
        let out = Curve::default().run(CurveIn { terrain: &terrain }, &Job::detached()).unwrap();
        assert_eq!(out.terrain.cells(), [7.0, 7.0]);
    }
}
