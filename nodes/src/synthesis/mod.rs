//! Terrain from a sketch and an exemplar (Zhou, Sun, Turk and Rehg 2007).

pub mod cut;
pub mod poisson;
pub mod resample;
pub mod tps;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![]
}
