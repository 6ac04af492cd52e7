//! Gradient: a tilted plane.

use orograph_core::prelude::*;

use super::ground::{GroundIn, GroundOut, bands, sample_cells};
use crate::Ground;

/// Makes a plane that rises steadily in one direction.
#[derive(Params, Clone, Debug)]
pub struct Gradient {
    /// Compass direction in which the ground rises: 0 is north, 90 is east.
    #[param(default = 0, range = -360.0..=360.0, slider = 0.0..=360.0, unit = "deg")]
    pub direction: f64,
    /// Rise per metre in that direction.
    #[param(default = 0.1, range = 0.0..=100.0, slider = 0.0..=1.0, unit = "m/m")]
    pub slope: f64,
    /// Height at the world's origin, which is the ground's north-west corner when no grid is given.
    #[param(default = 1000, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub base: f64,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

impl Node for Gradient {
    const ID: &'static str = "generate.gradient";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        bands(self, &self.ground, job)
    }

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        let (east, north) = libm::sincos(self.direction.to_radians());
        sample_cells(&self.ground, &inputs, job, |x, y| self.base + self.slope * (east * x + north * y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_rises_by_its_slope_in_its_direction() {
        let rise = |direction| {
            let ground = Ground { width: 300.0, height: 300.0, cells: 3 };
            let node = Gradient { direction, slope: 0.5, base: 0.0, ground };
            let out = node.run(GroundIn { like: None }, &Job::detached()).unwrap().terrain;
            (out.at(1, 2) - out.at(1, 1), out.at(0, 1) - out.at(1, 1))
        };
        assert_eq!(rise(0.0), (0.0, 50.0));
        assert_eq!(rise(90.0), (50.0, 0.0));
        let (east, north) = rise(225.0);
        let expected = -50.0 / 2.0_f32.sqrt();
        assert!((east - expected).abs() < 1e-4 && (north - expected).abs() < 1e-4, "{east} {north}");
    }
}
