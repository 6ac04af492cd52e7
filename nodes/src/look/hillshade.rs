//! Hillshade: ground lit from a low sun.
//!
//! Lambert's cosine law on Horn's gradient (see [`surface`]). Several directions: Mark, R. K. (1992),
//! "Multidirectional, oblique-weighted, shaded-relief image of the Island of Hawaii", USGS Open-File Report
//! 92-422: four suns 45° apart, each weighted by how obliquely it meets the slope. The gradient vector gives
//! those weights without an angle.

use glam::DVec2;
use orograph_core::prelude::*;
use pulp::{Arch, NullaryFnOnce};

use super::colour::{self, Tint};
use crate::surface;

/// From how many directions the ground is lit.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// One sun: strong relief, dark far slopes.
    Single,
    /// Four suns 45° apart: detail on every slope.
    Multidirectional,
}

/// Shades the ground as a sun lights it, in grey or over a picture.
///
/// Level ground is as bright as the sine of the sun's altitude. Voids take the void colour, or keep the
/// picture beneath.
#[derive(Params, Clone, Debug)]
pub struct Hillshade {
    /// Compass direction from which the light comes, clockwise from north. Several suns stand 90° and 45°
    /// before it, in it, and 45° past it.
    #[param(default = 315, range = 0.0..=360.0, unit = "deg")]
    pub azimuth: f64,
    /// Height of the sun over the horizon.
    #[param(default = 45, range = 1.0..=90.0, unit = "deg")]
    pub altitude: f64,
    /// Factor on heights before shading; more than 1 strengthens flat land.
    #[param(default = 1, range = 0.01..=1000.0, slider = 0.5..=10.0, unit = "1")]
    pub exaggeration: f64,
    /// One sun or several.
    #[param(default = Light::Single)]
    pub light: Light,
    /// How far shading darkens the picture that it is laid over: 0 not at all, 1 wholly. Without
    /// such a picture it has no effect.
    #[param(default = 1, range = 0.0..=1.0, unit = "1")]
    pub strength: f64,
    /// Colour of voids without a picture beneath, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xe6_c8dc))]
    pub void_colour: Colour,
}

/// Inputs of [`Hillshade`].
#[derive(Inputs)]
pub struct HillshadeIn<'a> {
    /// Terrain to shade.
    pub terrain: &'a Heightfield,
    /// Picture to darken by the shading, on the terrain's grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`Hillshade`].
#[derive(Outputs)]
pub struct HillshadeOut {
    /// The shaded picture.
    pub picture: Texture,
}

impl Node for Hillshade {
    const ID: &'static str = "look.hillshade";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = HillshadeIn<'a>;
    type Outputs = HillshadeOut;

    fn halo(&self, _cell: CellSize) -> usize {
        1
    }

    fn run(&self, inputs: HillshadeIn<'_>, job: &Job) -> Result<HillshadeOut> {
        let HillshadeIn { terrain, onto } = inputs;
        if let Some(onto) = onto {
            terrain.grid().match_size("terrain", onto.grid(), "onto")?;
        }
        let void = self.void_colour.0;
        let sun = Sun::new(self.azimuth, self.altitude, self.light);
        let picture = Texture::build(terrain.grid().clone(), job, |row, out| {
            if let Some(onto) = onto {
                out.copy_from_slice(onto.row(row));
            }
            sun.brightnesses(terrain, row, self.exaggeration, |start, bright| {
                let pixels = out[start..].iter_mut().zip(bright);
                if onto.is_none() {
                    pixels.for_each(|(pixel, &bright)| {
                        *pixel = if bright.is_nan() { void } else { grey(bright) }
                    });
                } else {
                    let known = pixels.filter(|(_, bright)| !bright.is_nan());
                    known.for_each(|(pixel, &bright)| {
                        *pixel = colour::shade(*pixel, sun.relative(bright, self.strength));
                    });
                }
            });
            Ok(())
        })?;
        Ok(HillshadeOut { picture })
    }
}

fn grey(share: f64) -> Tint {
    let level = colour::byte(share * 255.0);
    [level, level, level, 255]
}

/// A stretch of a row to be lit.
struct Lit<'a> {
    sun: &'a Sun,
    exaggeration: f64,
    east: &'a [f64],
    north: &'a [f64],
    bright: &'a mut [f64],
}

impl NullaryFnOnce for Lit<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for ((bright, &east), &north) in self.bright.iter_mut().zip(self.east).zip(self.north) {
            *bright = self.sun.brightness(DVec2::new(east, north) * self.exaggeration);
        }
    }
}

/// Light from one direction or several.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    /// Unit vectors over the ground towards each sun.
    towards: [DVec2; 4],
    count: usize,
    /// Sine and cosine of the altitude.
    up: f64,
    along: f64,
}

impl Sun {
    /// A sun in the compass direction `azimuth`, `altitude` over the horizon, both in degrees.
    #[must_use]
    pub fn new(azimuth: f64, altitude: f64, light: Light) -> Self {
        let towards = [0.0, -90.0, -45.0, 45.0].map(|turn: f64| {
            let (sine, cosine) = libm::sincos((azimuth + turn).to_radians());
            DVec2::new(sine, cosine)
        });
        let (up, along) = libm::sincos(altitude.to_radians());
        let count = if light == Light::Single { 1 } else { towards.len() };
        Self { towards, count, up, along }
    }

    /// Brightness, 0 to 1, of the cells of a row, heights taken times `exaggeration`, a stretch at a time: `take`
    /// gets the first column of the stretch and the brightness of its cells, NaN where the cell is a void.
    pub fn brightnesses(
        &self,
        terrain: &Heightfield,
        row: usize,
        exaggeration: f64,
        mut take: impl FnMut(usize, &[f64]),
    ) {
        let arch = Arch::new();
        let mut bright = Vec::with_capacity(terrain.cols().min(surface::STRETCH));
        surface::gradients(terrain, row, |start, east, north| {
            bright.resize(east.len(), 0.0);
            arch.dispatch(Lit { sun: self, exaggeration, east, north, bright: &mut bright });
            take(start, &bright);
        });
    }

    /// Brightness, 0 to 1, of ground with that gradient.
    #[inline(always)]
    fn brightness(&self, gradient: DVec2) -> f64 {
        let square = gradient.length_squared();
        let steep = (1.0 + square).sqrt();
        // The normal is (-gradient, 1): lit by the cosine of its angle to the sun, never less than nothing.
        let lit = |towards: DVec2| ((self.up - self.along * towards.dot(gradient)) / steep).clamp(0.0, 1.0);
        if self.count == 1 {
            return lit(self.towards[0]);
        }
        if square == 0.0 {
            return self.up;
        }
        // The squared sine between slope and sun; over four suns 45° apart these add up to 2.
        let weighted = |towards: DVec2| {
            let across = towards.perp_dot(gradient);
            across * across / square * lit(towards)
        };
        (self.towards.into_iter().map(weighted).sum::<f64>() / 2.0).clamp(0.0, 1.0)
    }

    /// The share of its brightness that a picture keeps: level ground keeps all, `strength` scales the rest.
    #[must_use]
    pub fn relative(&self, brightness: f64, strength: f64) -> f64 {
        // Slopes towards the sun would be brighter than the picture; a soft shoulder keeps their relief.
        let ratio = brightness / self.up.max(1e-6);
        let toned = if ratio <= 1.0 { ratio } else { 2.0 - 1.0 / ratio };
        (1.0 + (toned - 1.0) * strength).clamp(0.0, 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terrain(tilt: DVec2) -> Heightfield {
        let grid = Grid::new(5, 6, CellSize { x: 30.0, y: 20.0 }).unwrap();
        let cells = (0..30).map(|i| tilt.dot(grid.position(i / 6, i % 6)) as f32).collect();
        Heightfield::new(grid, cells).unwrap()
    }

    fn shade(node: &Hillshade, terrain: &Heightfield, onto: Option<&Texture>) -> Texture {
        node.run(HillshadeIn { terrain, onto }, &Job::detached()).unwrap().picture
    }

    #[test]
    fn a_plane_is_lit_by_the_cosine_of_the_angle_between_normal_and_sun() {
        // Facing west (rising eastwards) at 45°, sun in the west at 45°: straight on.
        let west = Hillshade { azimuth: 270.0, ..Hillshade::default() };
        let plane = terrain(DVec2::new(1.0, 0.0));
        assert!(shade(&west, &plane, None).cells().iter().all(|&pixel| pixel == [255; 4]));
        let east = Hillshade { azimuth: 90.0, ..Hillshade::default() };
        assert!(shade(&east, &plane, None).cells().iter().all(|&pixel| pixel == [0, 0, 0, 255]));
        // Level ground: sin 45° of 255.
        let level = shade(&west, &terrain(DVec2::ZERO), None);
        assert!(level.cells().iter().all(|&pixel| pixel == [180, 180, 180, 255]));
        // From the south-east at 30°, by the textbook formula with angles.
        let sun = Sun::new(135.0, 30.0, Light::Single);
        let gradient = DVec2::new(0.2, 0.5);
        let slope = surface::slope_degrees(gradient).to_radians();
        let aspect = surface::aspect_degrees(gradient).unwrap().to_radians();
        let (zenith, azimuth) = (60f64.to_radians(), 135f64.to_radians());
        let textbook = libm::cos(zenith) * libm::cos(slope)
            + libm::sin(zenith) * libm::sin(slope) * libm::cos(azimuth - aspect);
        assert!((sun.brightness(gradient) - textbook).abs() < 1e-12);
    }

    #[test]
    fn several_suns_are_weighted_by_the_squared_sine_of_the_aspect() {
        let sun = Sun::new(315.0, 30.0, Light::Multidirectional);
        let gradient = DVec2::new(-0.3, 0.1);
        let aspect = surface::aspect_degrees(gradient).unwrap();
        let mut expected = 0.0;
        for azimuth in [225.0, 270.0, 315.0, 360.0] {
            let sine = libm::sin((aspect - azimuth).to_radians());
            expected += sine * sine * Sun::new(azimuth, 30.0, Light::Single).brightness(gradient) / 2.0;
        }
        assert!((sun.brightness(gradient) - expected).abs() < 1e-12);
        assert!((sun.brightness(DVec2::ZERO) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn voids_take_their_colour_or_keep_the_picture() {
        let mut plane = terrain(DVec2::ZERO);
        plane.cells_mut()[7] = f32::NAN;
        let node = Hillshade { void_colour: Colour([1, 2, 3, 4]), ..Hillshade::default() };
        assert_eq!(shade(&node, &plane, None).cells()[7], [1, 2, 3, 4]);
        let onto = Texture::filled(plane.grid().clone(), [9, 90, 200, 255], &Job::detached()).unwrap();
        // Level ground keeps the picture's own colours.
        assert_eq!(shade(&node, &plane, Some(&onto)).cells(), onto.cells());
    }

    #[test]
    fn tiles_with_a_halo_equal_the_whole() {
        let job = Job::detached();
        let terrain = crate::test_fields::field(9, 11, |row, col| ((row * 7 + col * 13) % 10) as f64);
        let whole = shade(&Hillshade::default(), &terrain, None);
        let tile = shade(&Hillshade::default(), &terrain.crop(2, 3, 5, 6, &job).unwrap(), None);
        let inner = |picture: &Texture, row, col| picture.crop(row, col, 3, 4, &job).unwrap().into_cells();
        assert_eq!(inner(&tile, 1, 1), inner(&whole, 3, 4));
    }
}
