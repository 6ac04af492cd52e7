//! Smoothing and ranking over neighbourhoods.

pub mod median;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<median::Median>()]
}
