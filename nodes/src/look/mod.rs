//! Pictures of terrain.

pub mod canvas;
pub mod chart;
pub mod colour;
pub mod colour_relief;
pub mod difference_map;
pub mod hillshade;
pub mod legend;
pub mod ticks;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<colour_relief::ColourRelief>(),
        NodeType::of::<difference_map::DifferenceMap>(),
        NodeType::of::<hillshade::Hillshade>(),
    ]
}
