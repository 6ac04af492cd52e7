//! Morphologically constrained midpoint displacement (Belhadj 2007).

pub(crate) mod axis;
pub(crate) mod bottom_up;
pub mod mcmd;
pub mod md;
pub mod mdbu;
#[cfg(test)]
mod reference;
pub mod settings;
pub(crate) mod top_down;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<mcmd::Mcmd>(), NodeType::of::<mdbu::Mdbu>(), NodeType::of::<md::Md>()]
}
