//! Normalise: heights stretched to fill a range.
use orograph_core::prelude::*;

/// Stretches heights so that the lowest and the highest reach two levels. Voids stay voids.
///
/// Level ground has no range to stretch: it comes out at `low`.
#[derive(Params, Clone, Debug)]
pub struct Normalise {
    /// Where the lowest height goes.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub low: f64,
    /// Where the highest height goes; below `low`, the terrain is turned upside down.
    #[param(default = 1, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub high: f64,
}

/// Inputs of [`Normalise`].
#[derive(Inputs)]
pub struct NormaliseIn<'a> {
    /// Terrain to change.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Normalise`].
#[derive(Outputs)]
pub struct NormaliseOut {
    /// Terrain from one level to the other.
    pub terrain: Heightfield,
}

impl Node for Normalise {
    const ID: &'static str = "adjust.normalise";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = NormaliseIn<'a>;
    type Outputs = NormaliseOut;

    fn run(&self, inputs: NormaliseIn<'_>, job: &Job) -> Result<NormaliseOut> {
        let (lowest, highest) = finite_range(inputs.terrain)?;
        let scale = if highest > lowest { (self.high - self.low) / (highest - lowest) } else { 0.0 };
        let terrain =
            inputs.terrain.map(job, |height| (self.low + (f64::from(height) - lowest) * scale) as f32)?;
        Ok(NormaliseOut { terrain })
    }
}

/// Lowest and highest height.
///
/// # Errors
/// As [`Heightfield::known_range`], and [`Error::NonFinite`] when a height is infinite.
pub(crate) fn finite_range(terrain: &Heightfield) -> Result<(f64, f64)> {
    let (lowest, highest) = terrain.known_range("terrain")?;
    if lowest.is_finite() && highest.is_finite() {
        return Ok((f64::from(lowest), f64::from(highest)));
    }
    let cell = terrain.cells().iter().position(|height| height.is_infinite()).unwrap_or(0);
    let (row, col) = (cell / terrain.cols(), cell % terrain.cols());
    Err(Error::NonFinite { what: "terrain".into(), row, col })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    fn run(low: f64, high: f64, heights: &[f32]) -> Result<Vec<f32>> {
        let terrain = row(heights);
        let out = Normalise { low, high }.run(NormaliseIn { terrain: &terrain }, &Job::detached())?;
        Ok(out.terrain.into_cells())
    }

    #[test]
    fn heights_fill_the_range() {
        assert_eq!(run(0.0, 1.0, &[10.0, 20.0, 15.0]).unwrap(), [0.0, 1.0, 0.5]);
        assert_eq!(run(5.0, -5.0, &[10.0, 20.0, 15.0]).unwrap(), [5.0, -5.0, 0.0]);
        assert!(run(0.0, 1.0, &[f32::NAN, 1.0, 2.0]).unwrap()[0].is_nan());
        assert_eq!(run(3.0, 9.0, &[7.0, 7.0]).unwrap(), [3.0, 3.0]);
    }

    #[test]
    fn nothing_measured_and_infinite_heights_are_refused() {
        assert!(matches!(run(0.0, 1.0, &[f32::NAN]), Err(Error::AllVoid { .. })));
        let run = run(0.0, 1.0, &[1.0, f32::INFINITY]);
        assert!(matches!(run, Err(Error::NonFinite { col: 1, .. })));
    }
}
