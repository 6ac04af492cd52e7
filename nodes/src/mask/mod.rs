//! Masks from terrain and from each other.

pub mod arithmetic;
pub mod distance;
pub mod from_channel;
pub mod from_height;
pub mod from_slope;
pub mod ramp;
pub mod random_voids;
pub mod splat_map;
pub mod to_height;
pub mod voids;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<arithmetic::Arithmetic>(),
        NodeType::of::<distance::Distance>(),
        NodeType::of::<from_channel::FromChannel>(),
        NodeType::of::<from_height::FromHeight>(),
        NodeType::of::<from_slope::FromSlope>(),
        NodeType::of::<random_voids::RandomVoids>(),
        NodeType::of::<splat_map::SplatMap>(),
        NodeType::of::<to_height::ToHeight>(),
        NodeType::of::<voids::Voids>(),
    ]
}
