//! Terrain from a sketch and an exemplar (Zhou, Sun, Turk and Rehg 2007).

pub mod canvas;
pub mod cut;
pub mod exemplar;
pub mod fill_windows;
pub mod gradient_merge;
pub mod matching;
pub mod network;
pub mod patches;
pub mod poisson;
pub mod resample;
pub mod settings;
pub mod ssd;
pub mod synthesise;
pub mod tps;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<synthesise::Synthesise>()]
}
