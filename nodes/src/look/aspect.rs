//! Aspect map: the direction that slopes face as a circle of colours, from Horn's gradient (see [`surface`]).

use glam::DVec2;
use orograph_core::prelude::*;

use super::colour::{Tint, blend};
use crate::surface;

/// Colours of the eight directions from north, clockwise: cold to the north, warm to the south, with
/// opposite directions in opposite colours.
const COMPASS: [Tint; 8] = [
    [74, 98, 173, 255],
    [62, 146, 170, 255],
    [86, 173, 112, 255],
    [178, 193, 80, 255],
    [236, 190, 78, 255],
    [226, 126, 70, 255],
    [195, 77, 100, 255],
    [133, 77, 155, 255],
];
const LEVEL: Tint = [226, 226, 226, 255];

/// Colours terrain by the direction that it faces.
///
/// North is blue, east green, south yellow and west red; gentler slopes fade into light grey, so that noise
/// on level ground does not show. `measure.slope` gives the directions themselves.
#[derive(Params, Clone, Debug)]
pub struct Aspect {
    /// Steepness from which colours are full.
    #[param(default = 10, range = 0.01..=90.0, slider = 1.0..=45.0, unit = "deg")]
    pub full: f64,
    /// Colour of voids, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xa8_acb4))]
    pub void_colour: Colour,
}

/// Inputs of [`Aspect`].
#[derive(Inputs)]
pub struct AspectIn<'a> {
    /// Terrain to colour.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Aspect`].
#[derive(Outputs)]
pub struct AspectOut {
    /// The coloured picture.
    pub picture: Texture,
}

impl Node for Aspect {
    const ID: &'static str = "look.aspect";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = AspectIn<'a>;
    type Outputs = AspectOut;

    fn halo(&self, _cell: CellSize) -> usize {
        1
    }

    fn run(&self, inputs: AspectIn<'_>, job: &Job) -> Result<AspectOut> {
        let terrain = inputs.terrain;
        let void = self.void_colour.0;
        let colour = |gradient| {
            let Some(aspect) = surface::aspect_degrees(gradient) else { return LEVEL };
            blend(LEVEL, facing(aspect), surface::slope_degrees(gradient) / self.full)
        };
        let picture = Texture::build(terrain.grid().clone(), job, |row, out| {
            surface::gradients(terrain, row, |start, east, north| {
                for ((pixel, &east), &north) in out[start..].iter_mut().zip(east).zip(north) {
                    *pixel = if east.is_nan() { void } else { colour(DVec2::new(east, north)) };
                }
            });
            Ok(())
        })?;
        Ok(AspectOut { picture })
    }
}

/// The colour of a direction in degrees clockwise from north.
fn facing(degrees: f64) -> Tint {
    let place = degrees / 45.0;
    let before = place.floor();
    let at = |i: usize| COMPASS[i % COMPASS.len()];
    blend(at(before as usize), at(before as usize + 1), place - before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn ground_takes_the_colour_of_the_direction_it_faces() {
        let node = Aspect::default();
        let colour = |terrain: &Heightfield| {
            node.run(AspectIn { terrain }, &Job::detached()).unwrap().picture.at(1, 1)
        };
        // Higher rows lie further south.
        assert_eq!(colour(&field(3, 3, |row, _| row as f64 * 10.0)), COMPASS[0]);
        assert_eq!(colour(&field(3, 3, |_, col| col as f64 * -10.0)), COMPASS[2]);
        assert_eq!(colour(&field(3, 3, |row, col| 10.0 * (col as f64 - row as f64))), COMPASS[5]);
        assert_eq!(colour(&field(3, 3, |_, _| 5.0)), LEVEL);
        assert_eq!(facing(360.0), facing(0.0));
    }
}
