//! Slope map: steepness as colours, from Horn's gradient (see [`surface`]).

use glam::DVec2;
use orograph_core::prelude::*;

use super::colour::{Palette, tint};
use crate::surface;

/// Colours terrain by its steepness in degrees.
///
/// `measure.slope` gives the degrees themselves.
#[derive(Params, Clone, Debug)]
pub struct Slope {
    /// Colours from level to steepest.
    #[param(default = Palette::Heat)]
    pub palette: Palette,
    /// Colours of your own from level to steep, instead of the palette's.
    #[param(default = Gradient::default())]
    pub colours: Gradient,
    /// Steepness that takes the palette's last colour.
    #[param(default = 60, range = 0.01..=90.0, slider = 10.0..=90.0, unit = "deg")]
    pub steepest: f64,
    /// Colour of voids, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xa8_acb4))]
    pub void_colour: Colour,
}

/// Inputs of [`Slope`].
#[derive(Inputs)]
pub struct SlopeIn<'a> {
    /// Terrain to colour.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Slope`].
#[derive(Outputs)]
pub struct SlopeOut {
    /// The coloured picture.
    pub picture: Texture,
}

impl Node for Slope {
    const ID: &'static str = "look.slope";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = SlopeIn<'a>;
    type Outputs = SlopeOut;

    fn halo(&self, _cell: CellSize) -> usize {
        1
    }

    fn run(&self, inputs: SlopeIn<'_>, job: &Job) -> Result<SlopeOut> {
        let terrain = inputs.terrain;
        let (void, colours) = (self.void_colour.0, self.palette.unless(&self.colours));
        let picture = Texture::build(terrain.grid().clone(), job, |row, out| {
            surface::gradients(terrain, row, |start, east, north| {
                for ((pixel, &east), &north) in out[start..].iter_mut().zip(east).zip(north) {
                    let steep = surface::slope_degrees(DVec2::new(east, north));
                    *pixel = if steep.is_nan() { void } else { tint(&colours, steep / self.steepest) };
                }
            });
            Ok(())
        })?;
        Ok(SlopeOut { picture })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_of_half_the_steepest_takes_the_middle_colour() {
        // 10 m cells that rise by 10 m · tan 30°.
        let rise = 10.0 / 3f64.sqrt();
        let mut terrain = crate::test_fields::field(3, 4, |_, col| col as f64 * rise);
        terrain.cells_mut()[0] = f32::NAN;
        let node = Slope { palette: Palette::Grey, ..Slope::default() };
        let out = node.run(SlopeIn { terrain: &terrain }, &Job::detached()).unwrap().picture;
        assert_eq!(out.cells()[0], [0xa8, 0xac, 0xb4, 255]);
        assert!(out.cells()[1..].iter().all(|pixel| (127..=128).contains(&pixel[0])));
    }
}
