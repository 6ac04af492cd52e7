//! Colours: one for each type of wire, one for each family of nodes.

use eframe::egui::{Color32, ecolor::Hsva};
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

/// The colour of a node's title bar: of its family, so that a plugin's families have colours, too.
#[must_use]
pub fn family(family: &str, dark: bool) -> Color32 {
    let mut hash: u32 = 2_166_136_261;
    for byte in family.bytes() {
        hash = (hash ^ u32::from(byte)).wrapping_mul(16_777_619);
    }
    let hue = f32::from(u16::try_from(hash >> 16).unwrap_or(0)) / 65_536.0;
    let (saturation, value) = if dark { (0.45, 0.42) } else { (0.28, 0.88) };
    Hsva::new(hue, saturation, value, 1.0).into()
}

/// What went wrong.
pub const FAULT: Color32 = Color32::from_rgb(0xd9, 0x4f, 0x4f);
/// What deserves a look.
pub const WARNING: Color32 = Color32::from_rgb(0xd9, 0xa0, 0x3f);
