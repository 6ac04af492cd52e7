//! Smoothing and ranking over neighbourhoods, and multiresolution.

pub mod chaikin;
pub mod chaikin_compose;
pub mod chaikin_decompose;
pub mod gaussian_blur;
pub mod median;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<chaikin_compose::ChaikinCompose>(),
        NodeType::of::<chaikin_decompose::ChaikinDecompose>(),
        NodeType::of::<gaussian_blur::GaussianBlur>(),
        NodeType::of::<median::Median>(),
    ]
}
