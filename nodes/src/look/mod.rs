//! Pictures of terrain.

pub mod aspect;
pub mod canvas;
pub mod chart;
pub mod colour;
pub mod colour_relief;
pub mod contact_sheet;
pub mod contours;
pub mod difference_map;
pub mod hillshade;
pub mod histogram;
pub mod legend;
pub mod mark_known;
pub mod mask_overlay;
pub mod plot;
pub mod profile;
pub mod slope;
pub mod ticks;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<aspect::Aspect>(),
        NodeType::of::<colour_relief::ColourRelief>(),
        NodeType::of::<contact_sheet::ContactSheet>(),
        NodeType::of::<contours::Contours>(),
        NodeType::of::<difference_map::DifferenceMap>(),
        NodeType::of::<hillshade::Hillshade>(),
        NodeType::of::<histogram::Histogram>(),
        NodeType::of::<mark_known::MarkKnown>(),
        NodeType::of::<mask_overlay::MaskOverlay>(),
        NodeType::of::<plot::Plot>(),
        NodeType::of::<profile::Profile>(),
        NodeType::of::<slope::Slope>(),
    ]
}
