//! Ways to look at a value: node types that make a picture of it and need nothing else.

use orograph_core::{Arity, NodeSpec, ValueType};
use orograph_engine::Registry;

/// The look that each type is first shown with.
const FIRST: [(ValueType, &str); 4] = [
    (ValueType::Heightfield, "look.hillshade"),
    (ValueType::Mask, "look.mask_overlay"),
    (ValueType::Features, "look.features"),
    (ValueType::Placement, "look.placement"),
];

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
