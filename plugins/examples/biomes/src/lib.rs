//! Colours of plants, rock, snow and water by climate.
//!
//! Method: every cell has a mean temperature from its height and a moisture from rain, and these say which plants grow
//! ([`climate`]). Steep ground is bare rock. Water lies where a mask of flow is high, and below the sea's level.

mod climate;

use climate::{Colour, blend, land};
use orograph_plugin::{key, libm, prelude::*, signed_unit};

orograph_plugin::export!("Biomes", [Biomes]);

/// Paints the land by climate: forest, steppe, desert, tundra, rock, snow and water. The colours are those of the
/// ground alone, without light and shade. Voids become transparent.
#[derive(Params, Clone, Debug)]
pub struct Biomes {
    /// Mean temperature at height 0, in °C.
    #[param(default = 16, range = -50.0..=50.0, slider = -10.0..=30.0, unit = "1")]
    pub sea_temperature_c: f64,
    /// By how many °C it is colder 1000 m higher up.
    #[param(default = 6.5, range = 0.0..=20.0, slider = 3.0..=10.0, unit = "1")]
    pub lapse_c: f64,
    /// Rain in millimetres a year where the mask `wetness` is 1.
    #[param(default = 1000, range = 0.0..=20_000.0, slider = 100.0..=3000.0, unit = "1")]
    pub rain_mm: f64,
    /// Steeper ground is bare rock.
    #[param(default = 38, range = 0.0..=90.0, slider = 20.0..=60.0, unit = "deg")]
    pub rock: f64,
    /// Water lies where the mask `flow` is at least this.
    #[param(default = 0.7, range = 0.0..=1.0, unit = "1")]
    pub river: f64,
    /// Ground below this lies under the sea.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=3000.0, unit = "m")]
    pub sea_level: f64,
    /// How gently one biome goes over into the next: 0 gives sharp borders, 1 no borders at all.
    #[param(default = 0.6, range = 0.0..=1.0, unit = "1")]
    pub softness: f64,
    /// By how many °C the climate differs from cell to cell, which frays borders out.
    #[param(default = 0.8, range = 0.0..=20.0, slider = 0.0..=4.0, unit = "1")]
    pub ragged_c: f64,
    /// Other frays.
    #[param(default = 1, range = 0..=4_294_967_295u32, unit = "seed")]
    pub seed: u64,
}

/// Inputs of [`Biomes`].
#[derive(Inputs)]
pub struct BiomesIn<'a> {
    /// Terrain to paint.
    pub terrain: &'a Heightfield,
    /// Where how much rain falls, as a share of `rain_mm`; everywhere all of it when unconnected.
    pub wetness: Option<&'a Mask>,
    /// How much water runs where; there is none but the sea when unconnected.
    pub flow: Option<&'a Mask>,
}

/// Outputs of [`Biomes`].
#[derive(Outputs)]
pub struct BiomesOut {
    /// Colours of the ground.
    pub texture: Texture,
    /// Share of the ground that plants cover.
    pub plants: Mask,
}

/// Degrees of slope over which rock sets in.
const ROCK_SOFTNESS: f64 = 6.0;
const ROCK: Colour = [122.0, 114.0, 106.0];
const RIVER: Colour = [64.0, 98.0, 122.0];
const SHORE: Colour = [78.0, 122.0, 138.0];
const DEEP: Colour = [18.0, 42.0, 74.0];
/// Depth at which the sea has its darkest colour.
const DEEP_AT: f32 = 200.0;
/// Stream of random numbers.
const FRAY: u64 = 0x0062_696f_6d65;

impl Node for Biomes {
    const ID: &'static str = "look.biomes";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = BiomesIn<'a>;
    type Outputs = BiomesOut;

    /// Slopes are taken from the neighbours.
    fn halo(&self, _: CellSize) -> usize {
        1
    }

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, inputs: BiomesIn<'_>, job: &Job) -> Result<BiomesOut> {
        let grid = inputs.terrain.grid();
        for (name, mask) in [("wetness", inputs.wetness), ("flow", inputs.flow)] {
            if let Some(mask) = mask {
                grid.match_size("terrain", mask.grid(), name)?;
            }
        }
        let texture = Texture::build(grid.clone(), job, |row, colours| {
            for (col, colour) in colours.iter_mut().enumerate() {
                if let Some((ground, _)) = self.cell(&inputs, row, col) {
                    let [red, green, blue] = ground.map(|channel| channel.round() as u8);
                    *colour = [red, green, blue, 255];
                }
            }
            Ok(())
        })?;
        let plants = Mask::build(grid.clone(), job, |row, plants| {
            for (col, plants) in plants.iter_mut().enumerate() {
                *plants = self.cell(&inputs, row, col).map_or(0.0, |(_, cover)| cover.clamp(0.0, 1.0));
            }
            Ok(())
        })?;
        Ok(BiomesOut { texture, plants })
    }
}

impl Biomes {
    /// Colour and cover of a cell; `None` at a void.
    fn cell(&self, inputs: &BiomesIn<'_>, row: usize, col: usize) -> Option<(Colour, f32)> {
        let height = inputs.terrain.at(row, col);
        if height.is_nan() {
            return None;
        }
        let under = self.sea_level as f32 - height;
        if under > 0.0 {
            return Some((blend(SHORE, DEEP, (under / DEEP_AT).min(1.0)), 0.0));
        }
        let (base_row, base_col) = inputs.terrain.grid().base(row, col);
        let fray = self.ragged_c * signed_unit(key(self.seed, FRAY, base_row, base_col));
        let temperature = self.sea_temperature_c - self.lapse_c * f64::from(height) / 1000.0 + fray;
        let wetness = inputs.wetness.map_or(1.0, |wetness| share(wetness.at(row, col)));
        let (colour, plants) = land(temperature as f32, self.rain_mm as f32 * wetness, self.softness as f32);
        let steep = slope_deg(inputs.terrain, row, col);
        let rock = ((steep - self.rock) / ROCK_SOFTNESS + 0.5).clamp(0.0, 1.0) as f32;
        let (colour, plants) = (blend(colour, ROCK, rock), plants * (1.0 - rock));
        let flow = inputs.flow.map_or(0.0, |flow| share(flow.at(row, col)));
        if inputs.flow.is_some() && f64::from(flow) >= self.river {
            return Some((RIVER, 0.0));
        }
        Some((colour, plants))
    }
}

/// A mask's cell held to 0..=1, and 0 where it is no number.
fn share(cell: f32) -> f32 {
    if cell > 0.0 { cell.min(1.0) } else { 0.0 }
}

/// Steepness in degrees, from the neighbours on both sides, or on one side beside the border or a void.
fn slope_deg(terrain: &Heightfield, row: usize, col: usize) -> f64 {
    let (rows, cols) = terrain.grid().size();
    let cell = terrain.grid().cell;
    let here = terrain.at(row, col);
    let gradient = |before: Option<f32>, after: Option<f32>, metres: f64| {
        let known = |height: Option<f32>| height.filter(|height| !height.is_nan());
        let (before, after) = (known(before), known(after));
        let steps = f64::from(u8::from(before.is_some()) + u8::from(after.is_some())).max(1.0);
        (f64::from(after.unwrap_or(here)) - f64::from(before.unwrap_or(here))) / (steps * metres)
    };
    let west = (col > 0).then(|| terrain.at(row, col - 1));
    let east = (col + 1 < cols).then(|| terrain.at(row, col + 1));
    let north = (row > 0).then(|| terrain.at(row - 1, col));
    let south = (row + 1 < rows).then(|| terrain.at(row + 1, col));
    let (x, y) = (gradient(west, east, cell.x), gradient(north, south, cell.y));
    libm::atan((x * x + y * y).sqrt()).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBLONG: CellSize = CellSize { x: 10.0, y: 25.0 };

    fn field(rows: usize, cols: usize, height: impl Fn(usize, usize) -> f32) -> Heightfield {
        let cells = (0..rows * cols).map(|i| height(i / cols, i % cols)).collect();
        Heightfield::new(Grid::new(rows, cols, OBLONG).unwrap(), cells).unwrap()
    }

    fn paint(settings: &Biomes, terrain: &Heightfield, flow: Option<&Mask>) -> BiomesOut {
        settings.run(BiomesIn { terrain, wetness: None, flow }, &Job::detached()).unwrap()
    }

    #[test]
    fn slopes_are_those_of_planes_on_cells_that_are_not_square() {
        for (east, south) in [(0.5, 0.0), (0.0, -0.7), (0.3, 0.4)] {
            let plane = field(5, 6, |row, col| (east * 10.0 * col as f64 + south * 25.0 * row as f64) as f32);
            let expected = libm::atan(libm::hypot(east, south)).to_degrees();
            for (row, col) in [(0, 0), (2, 3), (4, 5), (0, 3)] {
                assert!((slope_deg(&plane, row, col) - expected).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn high_ground_is_white_low_ground_green_and_the_sea_blue() {
        let settings = Biomes { ragged_c: 0.0, ..Biomes::default() };
        // One plain each: between them would be cliffs.
        let [sea, forest, snow] = [-50.0, 100.0, 6000.0].map(|height| {
            let out = paint(&settings, &field(1, 1, |_, _| height), None);
            (out.texture.at(0, 0), out.plants.at(0, 0))
        });
        assert!(sea.1 == 0.0 && forest.1 > 0.6 && snow.1 == 0.0);
        let [sea, forest, snow] = [sea.0, forest.0, snow.0];
        assert!(sea[2] > sea[0] && sea[2] > sea[1], "{sea:?}");
        assert!(forest[1] > forest[0] && forest[1] > forest[2], "{forest:?}");
        assert!(snow[..3].iter().all(|&channel| channel > 220), "{snow:?}");
    }

    #[test]
    fn cliffs_are_rock_rivers_water_and_voids_transparent() {
        let settings = Biomes::default();
        let terrain = field(3, 9, |_, col| if col == 8 { f32::NAN } else { 100.0 + 40.0 * col as f32 });
        let out = paint(&settings, &terrain, None);
        assert_eq!(out.texture.at(1, 4), [122, 114, 106, 255]);
        assert_eq!(out.texture.at(1, 8), [0; 4]);
        let mut flow = Mask::filled(terrain.grid().clone(), 0.1, &Job::detached()).unwrap();
        flow.cells_mut()[13] = 0.9;
        let out = paint(&settings, &terrain, Some(&flow));
        assert_eq!(out.texture.at(1, 4), [64, 98, 122, 255]);
        assert_eq!(out.texture.at(1, 3), [122, 114, 106, 255]);
    }

    #[test]
    fn tiles_with_their_halo_have_the_bits_of_the_whole() {
        let job = Job::detached();
        let terrain = field(20, 30, |row, col| (row * row) as f32 * 3.0 + 900.0 * ((col % 7) as f32) / 7.0);
        let whole = paint(&Biomes::default(), &terrain, None);
        let part = paint(&Biomes::default(), &terrain.crop(4, 9, 10, 12, &job).unwrap(), None);
        let inner = part.texture.crop(1, 1, 8, 10, &job).unwrap();
        assert_eq!(inner.cells(), whole.texture.crop(5, 10, 8, 10, &job).unwrap().cells());
    }

    #[test]
    fn odd_terrain_is_taken() {
        for (rows, cols) in [(0, 0), (0, 4), (1, 1), (1, 5), (5, 1)] {
            for height in [0.0, f32::NAN, 1e30, f32::INFINITY, f32::NEG_INFINITY] {
                paint(&Biomes::default(), &field(rows, cols, |_, _| height), None);
            }
        }
    }

    #[test]
    fn masks_of_another_size_are_refused() {
        let (terrain, other) = (field(3, 3, |_, _| 1.0), field(2, 3, |_, _| 0.0));
        let wetness = Mask::filled(other.grid().clone(), 0.5, &Job::detached()).unwrap();
        let inputs = BiomesIn { terrain: &terrain, wetness: Some(&wetness), flow: None };
        assert!(Biomes::default().run(inputs, &Job::detached()).is_err());
    }
}
