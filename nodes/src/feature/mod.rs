//! Ridges and valleys as networks of lines: found in terrain or in a sketch, ordered for synthesis, compared.
//!
//! The pure functions that other families call: [`ppa::find`] for terrain, [`sketch::prepare`] with
//! [`from_sketch::trace`] for sketches, [`from_curves::trace`] for polylines; [`network::Network`] for what meets where
//! and the arms of a place; [`plan::plan`] for the order of patches; [`profiles::take`] for heights across lines;
//! [`adherence::Measured`] for comparisons.

pub mod adherence;
pub mod branch_reduction;
pub mod chains;
pub mod classify;
mod curves;
pub mod forest;
pub mod from_curves;
pub mod from_sketch;
pub mod lattice;
mod loops;
pub mod medial;
mod nearest;
pub mod network;
mod openings;
pub mod paint;
pub mod plan;
pub mod polygon_breaking;
pub mod ppa;
pub mod profile_recognition;
pub mod profiles;
mod rings;
pub mod settings;
pub mod sketch;
pub mod target_connection;
#[cfg(test)]
mod tests;
pub mod to_constraints;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<adherence::Adherence>(),
        NodeType::of::<branch_reduction::BranchReduction>(),
        NodeType::of::<classify::Classify>(),
        NodeType::of::<from_curves::FromCurves>(),
        NodeType::of::<from_sketch::FromSketch>(),
        NodeType::of::<paint::Paint>(),
        NodeType::of::<plan::Plan>(),
        NodeType::of::<polygon_breaking::PolygonBreaking>(),
        NodeType::of::<ppa::Ppa>(),
        NodeType::of::<profile_recognition::ProfileRecognition>(),
        NodeType::of::<sketch::Sketch>(),
        NodeType::of::<target_connection::TargetConnection>(),
        NodeType::of::<to_constraints::ToConstraints>(),
    ]
}
