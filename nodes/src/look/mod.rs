//! Pictures of terrain.

pub mod canvas;
pub mod colour;
pub mod hillshade;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<hillshade::Hillshade>()]
}
