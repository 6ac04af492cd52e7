//! The contract that every built-in node keeps, swept over the registry.

#[cfg(test)]
#[path = "contract/determinism.rs"]
mod determinism;
#[cfg(test)]
#[path = "contract/host.rs"]
mod host;
#[cfg(test)]
#[path = "contract/inputs.rs"]
mod inputs;
#[cfg(test)]
#[path = "contract/robustness.rs"]
mod robustness;
#[cfg(test)]
#[path = "contract/spec.rs"]
mod spec;

use orograph_core::{NodeType, ParamKind, ParamValue};

/// Runs `check` over every node and fails with the list of complaints, each headed by its node's id.
fn sweep(check: impl Fn(&NodeType) -> Vec<String>) {
    let complaints: Vec<String> = orograph_nodes::all()
        .iter()
        .flat_map(|node| {
            check(node)
                .into_iter()
                .map(|complaint| format!("{}: {complaint}", node.spec().id))
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// The node's default parameters.
fn defaults(node: &NodeType) -> Vec<ParamValue> {
    node.spec().params.iter().map(|param| param.default.clone()).collect()
}

/// Whether the node can run without files of its own.
fn needs_no_file(node: &NodeType) -> bool {
    !node.spec().params.iter().any(|param| matches!(param.kind, ParamKind::InputPath))
}
