//! Orograph's built-in nodes: `src/<family>/<algorithm>.rs`, one algorithm a file.
//!
//! A node depends on `orograph_core` and never on the engine; it takes what it needs from its inputs and its
//! `Job`. Algorithms are plain functions beside their nodes, so that other nodes may share them.

pub mod adjust;
mod chance;
pub mod combine;
pub mod feature;
pub mod filter;
pub mod generate;
mod ground;
pub mod io;
pub mod look;
pub mod mask;
pub mod mcmd;
pub mod measure;
pub mod mesh;
mod patch_size;
pub mod repair;
pub mod surface;
pub mod synthesis;
#[cfg(test)]
mod test_fields;
pub mod transform;

pub use chance::Chance;
pub use ground::Ground;
use orograph_core::NodeType;
pub use patch_size::PatchSize;

/// Every built-in node type, family by family.
#[must_use]
pub fn all() -> Vec<NodeType> {
    [
        adjust::nodes(),
        combine::nodes(),
        feature::nodes(),
        filter::nodes(),
        generate::nodes(),
        io::nodes(),
        look::nodes(),
        mask::nodes(),
        mcmd::nodes(),
        measure::nodes(),
        mesh::nodes(),
        repair::nodes(),
        synthesis::nodes(),
        transform::nodes(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
