//! Heightfields from nothing: functions of world position and seed.

pub mod constant;
pub mod fbm;
pub mod gradient;
mod ground;
pub mod noise;
mod octaves;
pub mod ridged;
pub mod shape;

pub use ground::{GroundIn, GroundOut};
pub use octaves::Octaves;
use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<constant::Constant>(),
        NodeType::of::<fbm::Fbm>(),
        NodeType::of::<gradient::Gradient>(),
        NodeType::of::<ridged::Ridged>(),
        NodeType::of::<shape::Shape>(),
    ]
}
