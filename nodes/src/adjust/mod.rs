//! Changing heights cell by cell.

pub mod clamp;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<clamp::Clamp>()]
}
