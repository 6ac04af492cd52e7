//! Which plants grow where: temperature and moisture to colour and cover.
//!
//! Temperature falls with height at an even rate (6.5 °C per km in the international standard atmosphere). Moisture is
//! de Martonne's index of aridity (1926), yearly rain in mm over temperature in °C plus ten: below 10 it is a desert's,
//! to 20 a steppe's, to 35 a woodland's, beyond a forest's. The bands of mean temperature (tundra below -5 °C, boreal to
//! 5 °C, temperate to 20 °C, tropical above) are those of Whittaker's chart of biomes (1975, "Communities and
//! Ecosystems").

/// Red, green and blue, 0 to 255.
pub(crate) type Colour = [f32; 3];

/// A kind of land: its colour seen from above, and the share of ground that plants cover.
#[derive(Clone, Copy)]
struct Biome {
    colour: Colour,
    plants: f32,
}

const fn biome(red: u8, green: u8, blue: u8, plants: f32) -> Biome {
    Biome { colour: [red as f32, green as f32, blue as f32], plants }
}

/// Middles of the bands of mean temperature, in °C.
const TEMPERATURES: [f32; 5] = [-15.0, -8.0, 0.0, 12.0, 26.0];
/// Middles of the classes of moisture, de Martonne's index.
const MOISTURES: [f32; 4] = [5.0, 15.0, 27.0, 45.0];

/// By temperature, then by moisture.
const BIOMES: [[Biome; 4]; 5] = [
    // Ice and snow.
    [
        biome(225, 228, 232, 0.0),
        biome(236, 240, 244, 0.0),
        biome(244, 247, 250, 0.0),
        biome(250, 252, 255, 0.0),
    ],
    // Cold desert, then tundra, drier to wetter.
    [
        biome(150, 143, 132, 0.05),
        biome(146, 141, 118, 0.3),
        biome(132, 131, 100, 0.5),
        biome(118, 122, 92, 0.6),
    ],
    // Cold steppe, then boreal woodland and forest.
    [biome(166, 152, 122, 0.15), biome(142, 138, 92, 0.4), biome(86, 104, 66, 0.75), biome(50, 78, 52, 0.9)],
    // Temperate desert, steppe, woodland, forest.
    [biome(196, 172, 128, 0.05), biome(172, 160, 96, 0.4), biome(112, 128, 62, 0.7), biome(62, 98, 46, 0.95)],
    // Tropical desert, savanna, seasonal forest, rain forest.
    [biome(214, 184, 130, 0.02), biome(178, 158, 82, 0.4), biome(92, 122, 50, 0.8), biome(34, 84, 36, 1.0)],
];

/// Colour and cover at a mean temperature in °C under `rain` mm a year. `softness` 0 gives one biome or the other, 1
/// blends from the middle of one to that of the next.
pub(crate) fn land(temperature: f32, rain: f32, softness: f32) -> (Colour, f32) {
    // Below -5 °C the index loses its meaning: little evaporates, and little rain is enough.
    let moisture = rain / (temperature.max(-5.0) + 10.0);
    let (cold, warm, warmth) = between(&TEMPERATURES, temperature, softness);
    let (dry, wet, wetness) = between(&MOISTURES, moisture, softness);
    let mix = |of: fn(&Biome) -> f32| {
        let across = |row: usize| lerp(of(&BIOMES[row][dry]), of(&BIOMES[row][wet]), wetness);
        lerp(across(cold), across(warm), warmth)
    };
    ([mix(|b| b.colour[0]), mix(|b| b.colour[1]), mix(|b| b.colour[2])], mix(|b| b.plants))
}

/// The two of `middles` that `x` lies between, and how far it is on the way.
fn between(middles: &[f32], x: f32, softness: f32) -> (usize, usize, f32) {
    let above = middles.partition_point(|&middle| middle <= x);
    if above == 0 || above == middles.len() {
        let end = above.saturating_sub(1);
        return (end, end, 0.0);
    }
    let (low, high) = (middles[above - 1], middles[above]);
    let way = (x - low) / (high - low);
    let way = if softness > 0.0 { ((way - 0.5) / softness + 0.5).clamp(0.0, 1.0) } else { way.round() };
    (above - 1, above, way)
}

/// From `a` at 0 to `b` at 1.
pub(crate) fn lerp(a: f32, b: f32, way: f32) -> f32 {
    a + (b - a) * way
}

/// From colour `a` at 0 to `b` at 1.
pub(crate) fn blend(a: Colour, b: Colour, way: f32) -> Colour {
    [lerp(a[0], b[0], way), lerp(a[1], b[1], way), lerp(a[2], b[2], way)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_class_has_its_own_colour() {
        for (row, &temperature) in TEMPERATURES.iter().enumerate() {
            for (col, &moisture) in MOISTURES.iter().enumerate() {
                let rain = moisture * (temperature.max(-5.0) + 10.0);
                for softness in [0.0, 0.5, 1.0] {
                    let (colour, plants) = land(temperature, rain, softness);
                    let expected = BIOMES[row][col];
                    let near = |a: f32, b: f32| (a - b).abs() < 0.01;
                    assert!(
                        colour.iter().zip(expected.colour).all(|(&a, b)| near(a, b)),
                        "{temperature} {moisture}"
                    );
                    assert!(near(plants, expected.plants));
                }
            }
        }
    }

    #[test]
    fn forests_thin_out_with_cold_and_drought() {
        let plants = |temperature, rain| land(temperature, rain, 1.0).1;
        for temperature in [-3.0, 5.0, 15.0, 25.0] {
            assert!((0..30).all(
                |i| plants(temperature, i as f32 * 100.0) <= plants(temperature, (i + 1) as f32 * 100.0)
            ));
        }
        assert!(plants(20.0, 2000.0) > 0.9 && plants(20.0, 100.0) < 0.1 && plants(-20.0, 1000.0) == 0.0);
    }
}
