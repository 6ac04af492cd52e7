//! Terrain from a sketch and an exemplar (Zhou, Sun, Turk and Rehg 2007).
//!
//! The pure functions that other families call: [`cut::seam`], [`poisson::masked::solve`],
//! [`poisson::rectangle::solve`], [`poisson::natural::solve`], [`poisson::seam::correction`],
//! [`fill_windows::fill`] and [`ssd::Searcher`].

pub mod canvas;
mod crests;
pub mod cut;
pub mod exemplar;
pub mod fill;
pub mod fill_windows;
pub mod gradient_merge;
pub mod graph_cut;
mod labels;
pub mod r#match;
pub mod matching;
pub mod network;
mod outlets;
pub mod patches;
mod placing;
pub mod poisson;
pub mod poisson_seam;
pub mod replay;
pub mod replay_texture;
pub mod report;
pub mod resample;
pub mod settings;
pub mod ssd;
pub mod stamp;
pub mod synthesise;
#[cfg(test)]
mod tests;
pub mod tps;
pub mod warp;
pub mod water;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<fill::Fill>(),
        NodeType::of::<graph_cut::GraphCut>(),
        NodeType::of::<r#match::Match>(),
        NodeType::of::<patches::Patches>(),
        NodeType::of::<poisson_seam::PoissonSeam>(),
        NodeType::of::<replay::Replay>(),
        NodeType::of::<replay_texture::ReplayTexture>(),
        NodeType::of::<stamp::Stamp>(),
        NodeType::of::<synthesise::Synthesise>(),
        NodeType::of::<warp::Warp>(),
        NodeType::of::<water::Water>(),
    ]
}
