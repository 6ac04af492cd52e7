//! Filling voids.

pub mod harmonic_fill;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<harmonic_fill::HarmonicFill>()]
}
