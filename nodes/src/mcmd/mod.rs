//! Morphologically constrained midpoint displacement (Belhadj 2007).

pub(crate) mod axis;
pub(crate) mod bottom_up;
pub mod curve;
pub(crate) mod even_level;
pub(crate) mod extent;
#[expect(clippy::module_inception, reason = "the family is named after its algorithm")]
pub mod mcmd;
pub mod md;
pub mod mdbu;
pub mod params;
pub mod random_decimate;
pub(crate) mod raster_line;
#[cfg(test)]
mod reference;
pub(crate) mod selection;
pub mod settings;
pub mod skeleton;
pub mod sketch;
pub mod sobel_decimate;
#[cfg(test)]
mod spectrum;
pub(crate) mod top_down;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<mcmd::Mcmd>(),
        NodeType::of::<mdbu::Mdbu>(),
        NodeType::of::<md::Md>(),
        NodeType::of::<random_decimate::RandomDecimate>(),
        NodeType::of::<sobel_decimate::SobelDecimate>(),
        NodeType::of::<skeleton::Skeleton>(),
        NodeType::of::<sketch::Sketch>(),
        NodeType::of::<curve::Curve>(),
    ]
}
