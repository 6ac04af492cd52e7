//! Changing heights: cell by cell, and to meet wanted ones.

pub mod clamp;
pub mod curve;
pub mod elevation_constraints;
pub mod normalise;
pub mod punch;
pub mod remap;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<clamp::Clamp>(),
        NodeType::of::<curve::Curve>(),
        NodeType::of::<elevation_constraints::ElevationConstraints>(),
        NodeType::of::<normalise::Normalise>(),
        NodeType::of::<punch::Punch>(),
        NodeType::of::<remap::Remap>(),
    ]
}
