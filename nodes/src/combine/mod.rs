//! Two heightfields into one.

pub mod arithmetic;
pub mod blend;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<arithmetic::Arithmetic>(), NodeType::of::<blend::Blend>()]
}
