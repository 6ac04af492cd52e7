//! The contract that every node keeps, whoever supplies it: checks over a node type, each giving what to mend.
//!
//! The built-in nodes are swept by a test, a plugin's by `orograph plugin check`.

mod bands;
mod determinism;
mod host;
mod inputs;
mod robustness;
mod spec;

use orograph_core::{NodeType, ParamKind, ParamValue};

/// A value of each type, over one small terrain with voids and a georeference.
pub use inputs::{inputs_of, samples};

pub use bands::band_by_band;
pub use determinism::{any_number_of_threads, tile_by_tile, undeclared_context};
pub use robustness::{cancelled_run, limits_of_settings, odd_terrain, ordinary_terrain, writers};
pub use spec::{docs, keys, names_and_limits, ranges_are_enforced, survives_a_file};

/// A check of one node type: what is wrong with it, nothing when it is sound.
pub type Check = fn(&NodeType) -> Vec<String>;

/// Every check that holds for every node, with what it is about.
pub const CHECKS: [(&str, Check); 12] = [
    ("names, limits and defaults", names_and_limits),
    ("docs", docs),
    ("spec and settings as text", survives_a_file),
    ("keys", keys),
    ("hard ranges", ranges_are_enforced),
    ("ordinary terrain", ordinary_terrain),
    ("tiny and void terrain", odd_terrain),
    ("cancelling", cancelled_run),
    ("writing", writers),
    ("band by band", band_by_band),
    ("the same bits on 1, 2 and 8 threads", any_number_of_threads),
    ("context that is not declared", undeclared_context),
];

/// The node's default parameters.
fn defaults(node: &NodeType) -> Vec<ParamValue> {
    node.spec().params.iter().map(|param| param.default.clone()).collect()
}

/// Whether the node can run without files of its own.
fn needs_no_file(node: &NodeType) -> bool {
    !node.spec().params.iter().any(|param| matches!(param.kind, ParamKind::InputPath))
}

fn complain(complaints: &mut Vec<String>, holds: bool, complaint: &str) {
    if !holds {
        complaints.push(complaint.to_owned());
    }
}
