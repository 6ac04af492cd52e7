//! Slope and aspect as data, from Horn's gradient (see [`surface`]).

use glam::DVec2;
use orograph_core::prelude::*;

use crate::surface;

/// Measures how steep the ground is and which way it faces, in degrees.
///
/// The outputs are rasters of degrees, not of metres: plot them, make masks of them or take their
/// statistics, and read degrees where those say metres.
#[derive(Params, Clone, Debug)]
pub struct Slope {}

/// Inputs of [`Slope`].
#[derive(Inputs)]
pub struct SlopeIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Slope`].
#[derive(Outputs)]
pub struct SlopeOut {
    /// Steepness in degrees, 0 for level ground, below 90; voids stay voids.
    pub slope: Heightfield,
    /// Compass direction that the ground faces, in degrees clockwise from north, 0 to below 360; voids and
    /// level ground are voids.
    pub aspect: Heightfield,
}

impl Node for Slope {
    const ID: &'static str = "measure.slope";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = SlopeIn<'a>;
    type Outputs = SlopeOut;

    fn halo(&self, _cell: CellSize) -> usize {
        1
    }

    fn run(&self, inputs: SlopeIn<'_>, job: &Job) -> Result<SlopeOut> {
        let terrain = inputs.terrain;
        let each = |of: fn(DVec2) -> Option<f64>| {
            Heightfield::build(terrain.grid().clone(), job, |row, out| {
                surface::gradients(terrain, row, |start, east, north| {
                    for ((out, &east), &north) in out[start..].iter_mut().zip(east).zip(north) {
                        let degrees = if east.is_nan() { None } else { of(DVec2::new(east, north)) };
                        *out = degrees.map_or(f32::NAN, |degrees| degrees as f32);
                    }
                });
                Ok(())
            })
        };
        let slope = each(|gradient| Some(surface::slope_degrees(gradient)))?;
        // Rounding to single precision may reach the full turn.
        let aspect = each(|gradient| {
            surface::aspect_degrees(gradient).map(|a| if a as f32 >= 360.0 { 0.0 } else { a })
        })?;
        Ok(SlopeOut { slope, aspect })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_on_oblong_cells_has_its_tilt_and_direction_everywhere() {
        let grid = Grid::new(4, 5, CellSize { x: 30.0, y: 20.0 }).unwrap();
        // 30° steep, rising towards the south-west: it faces north-east.
        let tilt = glam::DVec2::new(-1.0, -1.0).normalize() / 3f64.sqrt();
        let cells = (0..20).map(|i| tilt.dot(grid.position(i / 5, i % 5)) as f32).collect();
        let terrain = Heightfield::new(grid, cells).unwrap();
        let out = Slope::default().run(SlopeIn { terrain: &terrain }, &Job::detached()).unwrap();
        assert!(out.slope.cells().iter().all(|slope| (slope - 30.0).abs() < 1e-4));
        assert!(out.aspect.cells().iter().all(|aspect| (aspect - 45.0).abs() < 1e-4));
    }

    #[test]
    fn level_ground_faces_nowhere() {
        let terrain = crate::test_fields::row(&[2.0, 2.0, f32::NAN]);
        let out = Slope::default().run(SlopeIn { terrain: &terrain }, &Job::detached()).unwrap();
        assert_eq!(out.slope.cells()[..2], [0.0, 0.0]);
        assert!(out.slope.cells()[2].is_nan() && out.aspect.cells().iter().all(|aspect| aspect.is_nan()));
    }
}
