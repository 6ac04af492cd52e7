//! Morphologically constrained midpoint displacement (Belhadj 2007).

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![]
}
