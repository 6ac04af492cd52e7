//! Ways to look at a value: node types that make a picture of it and need nothing else.

use orograph_core::{Arity, NodeSpec, ParamValue, Unit, Value, ValueType};
use orograph_engine::Registry;

/// The look that each type is first shown with.
const FIRST: [(ValueType, &str); 4] = [
    (ValueType::Heightfield, "look.hillshade"),
    (ValueType::Mask, "look.mask_overlay"),
    (ValueType::Features, "look.features"),
    (ValueType::Placement, "look.placement"),
];

/// The look at two terrains that tells where the one lies above the other.
pub const DIFFERENCE: &str = "look.difference_map";

/// The setting of a look that reaches as far to either side of zero.
pub(crate) const LARGEST: &str = "largest";

/// Looks that colour by number, and which numbers take the ends of their colours.
const SCALES: [(&str, Ends); 3] = [
    ("look.colour_relief", Ends::OfValue),
    ("look.slope", Ends::UpTo("steepest")),
    ("look.mask_overlay", Ends::Shares),
];

enum Ends {
    /// The least and the greatest height.
    OfValue,
    /// Zero and the number that a setting says.
    UpTo(&'static str),
    /// None and all.
    Shares,
}

/// What the colours of a picture mean: numbers from one end of them to the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// From which colour to which.
    pub colours: Colours,
    /// The number of the first colour.
    pub low: f64,
    /// The number of the last colour.
    pub high: f64,
    /// The unit of both.
    pub unit: Unit,
}

/// Colours in a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Colours {
    /// Those of the palette of this name, as settings write it.
    Palette(String),
    /// From white paper to a colour.
    Tint {
        /// The colour, as settings write it.
        colour: String,
        /// How much of the paper it hides at last.
        opacity: f64,
    },
    /// Blue below, white at the middle, red above.
    Diverging,
}

/// The node types that can show a value of a type, the first one first. A [`ValueType::Texture`] needs none.
#[must_use]
pub fn of(registry: &Registry, value_type: ValueType) -> Vec<&NodeSpec> {
    let first = FIRST.iter().find(|(of, _)| *of == value_type).map(|(_, id)| *id);
    let mut looks: Vec<_> = registry
        .iter()
        .map(|node_type| node_type.spec())
        .filter(|spec| {
            let needs = |port: &orograph_core::PortSpec| port.arity == Arity::One;
            let alone = spec.inputs.first().is_some_and(|port| port.value_type == value_type && needs(port))
                && !spec.inputs.iter().skip(1).any(needs);
            alone && !spec.writes && spec.family() == "look" && picture_port(spec).is_some()
        })
        .collect();
    looks.sort_by_key(|spec| (Some(&*spec.id) != first, spec.id.clone()));
    looks
}

/// The id of the node type that shows a value of a type first.
#[must_use]
pub fn first(registry: &Registry, value_type: ValueType) -> Option<String> {
    of(registry, value_type).first().map(|spec| spec.id.to_string())
}

/// The first output that is a picture.
#[must_use]
pub fn picture_port(spec: &NodeSpec) -> Option<u32> {
    let port = spec.outputs.iter().position(|port| port.value_type == ValueType::Texture)?;
    u32::try_from(port).ok()
}

/// The input by which a look draws over a picture, when it has one.
#[must_use]
pub fn ground_port(spec: &NodeSpec) -> Option<&str> {
    let over = |port: &&orograph_core::PortSpec| {
        port.value_type == ValueType::Texture && port.arity == Arity::Optional
    };
    spec.inputs.iter().find(over).map(|port| &*port.name)
}

/// Whether the difference between two values of the type can be looked at.
#[must_use]
pub fn can_be_compared(value_type: ValueType) -> bool {
    matches!(value_type, ValueType::Heightfield | ValueType::Mask)
}

/// What the colours mean that a look at its defaults gives a value; none for a look that does not colour by number.
#[must_use]
pub fn scale(spec: &NodeSpec, value: &Value) -> Option<Scale> {
    let (_, ends) = SCALES.iter().find(|(id, _)| *id == spec.id)?;
    let param = |name: &str| spec.params.iter().find(|param| param.name == name);
    let text = |name: &str| match &param(name)?.default {
        ParamValue::Text(text) => Some(text.clone()),
        _ => None,
    };
    match (ends, value) {
        (Ends::OfValue, Value::Heightfield(terrain)) => {
            let (low, high) = terrain.range()?;
            let (low, high) = (f64::from(low), f64::from(high));
            Some(Scale { colours: Colours::Palette(text("palette")?), low, high, unit: Unit::Metre })
        }
        (Ends::UpTo(name), _) => {
            let most = param(name)?;
            let ParamValue::Number(high) = most.default else { return None };
            Some(Scale { colours: Colours::Palette(text("palette")?), low: 0.0, high, unit: most.unit })
        }
        (Ends::Shares, _) => {
            let ParamValue::Number(opacity) = param("opacity")?.default else { return None };
            let colours = Colours::Tint { colour: text("colour")?, opacity };
            Some(Scale { colours, low: 0.0, high: 1.0, unit: Unit::One })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::{CellSize, Grid, Heightfield};

    use super::*;

    #[test]
    fn every_look_that_is_named_here_is_there_and_has_what_is_asked_of_it() {
        let registry = orograph_session::built_in().unwrap();
        let grid = Grid::new(1, 2, CellSize::square(1.0)).unwrap();
        let value = Value::Heightfield(Heightfield::new(grid, vec![3.0, 7.0]).unwrap().into());
        for (id, _) in SCALES {
            let spec = registry.get(id).unwrap().spec();
            let scale = scale(spec, &value).unwrap();
            assert!(scale.low < scale.high, "{id}: {scale:?}");
        }
        let spec = registry.get(DIFFERENCE).unwrap().spec();
        assert!(spec.params.iter().any(|param| param.name == LARGEST && param.unit == Unit::Metre));
        for (value_type, id) in FIRST {
            assert_eq!(of(&registry, value_type)[0].id, id);
        }
    }

    #[test]
    fn relief_is_coloured_from_the_lowest_to_the_highest() {
        let registry = orograph_session::built_in().unwrap();
        let grid = Grid::new(1, 3, CellSize::square(1.0)).unwrap();
        let value = Value::Heightfield(Heightfield::new(grid, vec![3.0, f32::NAN, 7.5]).unwrap().into());
        let scale = scale(registry.get("look.colour_relief").unwrap().spec(), &value).unwrap();
        assert_eq!((scale.low, scale.high, scale.unit), (3.0, 7.5, Unit::Metre));
    }
}
