//! Mask from slope: the cells whose slope lies between two angles.

use glam::DVec2;
use orograph_core::prelude::*;

use super::ramp::band;
use crate::surface;

/// Selects the cells whose slope lies between two angles. Voids are not selected.
///
/// Slopes are Horn's, over the eight neighbours, in true metres on both axes.
#[derive(Params, Clone, Debug)]
pub struct FromSlope {
    /// Gentlest slope to select.
    #[param(default = 30, range = 0.0..=90.0, unit = "deg")]
    pub low: f64,
    /// Steepest slope to select.
    #[param(default = 90, range = 0.0..=90.0, unit = "deg")]
    pub high: f64,
    /// How far beyond these angles the mask fades out.
    #[param(default = 5, range = 0.0..=90.0, slider = 0.0..=30.0, unit = "deg")]
    pub soft: f64,
}

/// Inputs of [`FromSlope`].
#[derive(Inputs)]
pub struct FromSlopeIn<'a> {
    /// Terrain to select from.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`FromSlope`].
#[derive(Outputs)]
pub struct FromSlopeOut {
    /// The selected cells.
    pub mask: Mask,
}

impl Node for FromSlope {
    const ID: &'static str = "mask.from_slope";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = FromSlopeIn<'a>;
    type Outputs = FromSlopeOut;

    fn check(&self) -> Result<()> {
        if self.low <= self.high {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`low` ({} degrees) lies above `high` ({} degrees)", self.low, self.high),
            "swap them",
        ))
    }

    fn run(&self, inputs: FromSlopeIn<'_>, job: &Job) -> Result<FromSlopeOut> {
        let terrain = inputs.terrain;
        let mask = Mask::build(terrain.grid().clone(), job, |row, out| {
            surface::gradients(terrain, row, |start, east, north| {
                for ((share, &east), &north) in out[start..].iter_mut().zip(east).zip(north) {
                    let slope = surface::slope_degrees(DVec2::new(east, north));
                    // No angle lies in the band at a void.
                    *share = band(slope, self.low, self.high, self.soft) as f32;
                }
            });
            Ok(())
        })?;
        Ok(FromSlopeOut { mask })
    }

    fn halo(&self, _: CellSize) -> usize {
        1
    }

    fn cost(&self) -> f64 {
        10.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn a_plane_is_selected_by_its_angle() {
        let plane = field(5, 5, |row, col| 3.0 * row as f64 + 4.0 * col as f64);
        // 0.5 m per m on cells of 10 m.
        let slope = libm::atan(0.5).to_degrees();
        let at = |low: f64, high: f64| {
            let node = FromSlope { low, high, soft: 0.0 };
            node.run(FromSlopeIn { terrain: &plane }, &Job::detached()).unwrap().mask.at(2, 2)
        };
        assert_eq!(at(slope - 0.01, slope + 0.01), 1.0);
        assert_eq!(at(slope + 0.01, 90.0), 0.0);
        assert_eq!(at(0.0, slope - 0.01), 0.0);
    }

    #[test]
    fn voids_are_not_selected() {
        let terrain = field(3, 3, |row, col| if (row, col) == (1, 1) { f64::NAN } else { 5.0 });
        let node = FromSlope { low: 0.0, high: 90.0, soft: 0.0 };
        let mask = node.run(FromSlopeIn { terrain: &terrain }, &Job::detached()).unwrap().mask;
        assert_eq!(mask.cells(), [1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    }
}
