//! Moving and resampling grids.

pub mod crop;
pub mod mirror;
pub mod resize;
pub mod rotate;
pub mod sample;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<crop::Crop>(),
        NodeType::of::<mirror::Mirror>(),
        NodeType::of::<resize::Resize>(),
        NodeType::of::<rotate::Rotate>(),
    ]
}
