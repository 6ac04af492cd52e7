//! Colour relief: heights as colours, shaded.

use orograph_core::prelude::*;

use super::{
    colour::{self, Palette},
    hillshade::{Light, Sun},
    legend::{Legend, with_legend},
};

/// Colours terrain by height, with shaded relief.
#[derive(Params, Clone, Debug)]
pub struct ColourRelief {
    /// Colours from low to high.
    #[param(default = Palette::Atlas)]
    pub palette: Palette,
    /// Colours of your own from low to high, instead of the palette's.
    #[param(default = Gradient::default())]
    pub colours: Gradient,
    /// Stretches the palette from the lowest to the highest height; `lowest` and `highest` are then unused.
    #[param(default = true)]
    pub automatic: bool,
    /// Height of the palette's first colour.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub lowest: f64,
    /// Height of the palette's last colour.
    #[param(default = 4000, range = -20_000.0..=20_000.0, slider = 0.0..=9000.0, unit = "m")]
    pub highest: f64,
    /// Strength of the shading: 0 gives flat colours.
    #[param(default = 0.7, range = 0.0..=1.0, unit = "1")]
    pub shading: f64,
    /// Factor on heights before shading.
    #[param(default = 1.5, range = 0.01..=1000.0, slider = 0.5..=10.0, unit = "1")]
    pub exaggeration: f64,
    /// Direction of the light that shades.
    #[param(default = Light::Multidirectional)]
    pub light: Light,
    /// Colour of voids, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xa8_acb4))]
    pub void_colour: Colour,
    /// Adds a colour bar with heights on the right; the picture then has more columns than the terrain.
    #[param(default = false)]
    pub legend: bool,
}

/// Inputs of [`ColourRelief`].
#[derive(Inputs)]
pub struct ColourReliefIn<'a> {
    /// Terrain to colour.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`ColourRelief`].
#[derive(Outputs)]
pub struct ColourReliefOut {
    /// The coloured picture.
    pub picture: Texture,
}

impl Node for ColourRelief {
    const ID: &'static str = "look.colour_relief";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ColourReliefIn<'a>;
    type Outputs = ColourReliefOut;

    fn check(&self) -> Result<()> {
        if self.automatic || self.lowest < self.highest {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`lowest` ({} m) does not lie below `highest` ({} m)", self.lowest, self.highest),
            "raise `highest`, or set `automatic`",
        ))
    }

    fn run(&self, inputs: ColourReliefIn<'_>, job: &Job) -> Result<ColourReliefOut> {
        let terrain = inputs.terrain;
        let void = self.void_colour.0;
        let (low, high) = match terrain.range().filter(|_| self.automatic) {
            Some((low, high)) => (f64::from(low), f64::from(high)),
            None => (self.lowest, self.highest),
        };
        let colours = self.palette.unless(&self.colours);
        // Level terrain takes the first colour.
        let per_metre = if high > low { 1.0 / (high - low) } else { 0.0 };
        let sun = Sun::new(315.0, 45.0, self.light);
        let picture = Texture::build(terrain.grid().clone(), job, |row, out| {
            for (pixel, &height) in out.iter_mut().zip(terrain.row(row)) {
                let height = f64::from(height);
                *pixel =
                    if height.is_nan() { void } else { colour::tint(&colours, (height - low) * per_metre) };
            }
            if self.shading > 0.0 {
                sun.brightnesses(terrain, row, self.exaggeration, |start, bright| {
                    for (pixel, &bright) in out[start..].iter_mut().zip(bright).filter(|(_, b)| !b.is_nan()) {
                        *pixel = colour::shade(*pixel, sun.relative(bright, self.shading));
                    }
                });
            }
            Ok(())
        })?;
        let legend = Legend { colours, low, high, unit: "m" };
        let picture = if self.legend { with_legend(&picture, &legend, job)? } else { picture };
        Ok(ColourReliefOut { picture })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn heights_take_the_palette_s_colours() {
        let terrain = row(&[0.0, 50.0, 100.0, f32::NAN, 200.0]);
        let run = |node: &ColourRelief| {
            node.run(ColourReliefIn { terrain: &terrain }, &Job::detached()).unwrap().picture.into_cells()
        };
        let flat = ColourRelief { palette: Palette::Grey, shading: 0.0, ..ColourRelief::default() };
        let void = [0xa8, 0xac, 0xb4, 255];
        let grey = |level: u8| [level, level, level, 255];
        assert_eq!(run(&flat), [grey(0), grey(64), grey(128), void, grey(255)]);
        let own = "0 #000000, 0.5 #ff0000, 1 #0000ff80".parse().unwrap();
        let own = ColourRelief { colours: own, ..flat.clone() };
        let red = |level: u8| [level, 0, 0, 255];
        assert_eq!(run(&own), [red(0), red(128), red(255), void, [0, 0, 255, 128]]);
        let fixed = ColourRelief { automatic: false, lowest: 50.0, highest: 100.0, ..flat };
        assert_eq!(run(&fixed), [grey(0), grey(0), grey(255), void, grey(255)]);
    }

    #[test]
    fn level_and_void_terrain_is_drawn_too() {
        for heights in [&[][..], &[7.0], &[f32::NAN; 3], &[f32::INFINITY, 0.0]] {
            let node = ColourRelief { legend: true, ..ColourRelief::default() };
            assert!(node.run(ColourReliefIn { terrain: &row(heights) }, &Job::detached()).is_ok());
        }
        assert!(
            ColourRelief { automatic: false, lowest: 1.0, highest: 1.0, ..ColourRelief::default() }
                .check()
                .is_err()
        );
    }
}
