//! Metrics.

pub mod append;
pub mod compare;
mod rim;
pub mod slope;
mod slope_distance;
pub mod statistics;
mod sums;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<append::Append>(),
        NodeType::of::<compare::Compare>(),
        NodeType::of::<slope::Slope>(),
        NodeType::of::<statistics::Statistics>(),
    ]
}
