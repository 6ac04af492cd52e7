//! Colours: one for each type of wire, one for each family of nodes.

use eframe::egui::{Color32, ecolor::HsvaGamma};
use orograph_core::ValueType;

/// The colour of wires of a type; grey for one that is not known.
#[must_use]
pub fn wire(value_type: Option<ValueType>) -> Color32 {
    match value_type {
        Some(ValueType::Heightfield) => Color32::from_rgb(0x6f, 0xb3, 0x6a),
        Some(ValueType::Mask) => Color32::from_rgb(0xc9, 0xc9, 0xc9),
        Some(ValueType::Texture) => Color32::from_rgb(0xe0, 0xa6, 0x4a),
        Some(ValueType::Features) => Color32::from_rgb(0x4f, 0xa3, 0xe0),
        Some(ValueType::Points) => Color32::from_rgb(0x8f, 0x7f, 0xe6),
        Some(ValueType::Placement) => Color32::from_rgb(0xd0, 0x6f, 0xb0),
        Some(ValueType::Table) => Color32::from_rgb(0x5f, 0xc0, 0xb8),
        Some(ValueType::Mesh) => Color32::from_rgb(0xd9, 0x77, 0x57),
        Some(ValueType::Number | ValueType::Integer | ValueType::Boolean | ValueType::Text) => {
            Color32::from_rgb(0xd8, 0xcf, 0x6a)
        }
        _ => Color32::GRAY,
    }
}

/// Hues in degrees and saturations of the families that come with the program, as far from each other as so many
/// can be: neighbours on the wheel are families that one seldom mistakes.
const FAMILIES: [(&str, f32, f32); 15] = [
    ("mask", 40.0, 0.06),
    ("io", 28.0, 0.62),
    ("combine", 52.0, 0.6),
    ("adjust", 84.0, 0.5),
    ("mesh", 106.0, 0.5),
    ("generate", 128.0, 0.52),
    ("measure", 160.0, 0.5),
    ("filter", 184.0, 0.55),
    ("feature", 206.0, 0.62),
    ("transform", 228.0, 0.5),
    ("mcmd", 252.0, 0.5),
    ("look", 282.0, 0.5),
    ("graph", 305.0, 0.2),
    ("synthesis", 326.0, 0.5),
    ("repair", 356.0, 0.55),
];

/// The colour of a node's title bar: of its family. Those of plugins have colours by their names.
#[must_use]
pub fn family(family: &str, dark: bool) -> Color32 {
    let known = FAMILIES.iter().find(|(name, ..)| *name == family);
    let (hue, saturation) =
        known.map_or_else(|| (hashed(family), 0.4), |(_, hue, saturation)| (*hue, *saturation));
    let (saturation, value) = if dark { (saturation, 0.46) } else { (0.55 * saturation, 0.9) };
    HsvaGamma { h: hue / 360.0, s: saturation, v: value, a: 1.0 }.into()
}

fn hashed(family: &str) -> f32 {
    let mut hash: u32 = 2_166_136_261;
    for byte in family.bytes() {
        hash = (hash ^ u32::from(byte)).wrapping_mul(16_777_619);
    }
    f32::from(u16::try_from(hash >> 16).unwrap_or(0)) / 65_536.0 * 360.0
}

/// What went wrong.
pub const FAULT: Color32 = Color32::from_rgb(0xd9, 0x4f, 0x4f);
/// What deserves a look.
pub const WARNING: Color32 = Color32::from_rgb(0xd9, 0xa0, 0x3f);

#[cfg(test)]
mod tests {
    use eframe::egui::Rgba;

    use super::*;

    #[test]
    fn families_have_colours_apart_on_which_words_are_read() {
        let registry = orograph_session::built_in().unwrap_or_default();
        let mut families: Vec<&str> = registry.iter().map(|node_type| node_type.spec().family()).collect();
        families.dedup();
        assert!(families.len() > 10, "{families:?}");
        for name in &families {
            assert!(FAMILIES.iter().any(|(known, ..)| known == name), "{name} has no colour of its own");
        }
        for (index, (one, hue, saturation)) in FAMILIES.iter().enumerate() {
            for (other, other_hue, other_saturation) in &FAMILIES[index + 1..] {
                let between = (hue - other_hue).abs();
                let apart = between.min(360.0 - between);
                assert!(
                    apart >= 20.0 || (saturation - other_saturation).abs() > 0.25,
                    "{one} and {other} look alike"
                );
            }
            for (dark, words) in [(true, Color32::WHITE), (false, Color32::BLACK)] {
                assert!(contrast(family(one, dark), words) >= 4.5, "{one}: words are hard to read");
            }
        }
    }

    /// As the guidelines for accessible pages (WCAG 2) measure it.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let light = |colour: Color32| {
            let [r, g, b, _] = Rgba::from(colour).to_array();
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let (a, b) = (light(a), light(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }
}
