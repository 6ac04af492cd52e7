//! Single settings and nodes, typed as a compilation would: for inspectors.

use indexmap::IndexMap;
use orograph_core::{Error, NodeType, ParamSpec, ParamValue, RawParams};

use super::typed::{Given, Refused, typed, untyped};
use crate::document::{Body, Literal, Node};

/// The value that a parameter gets from what a graph file writes.
///
/// # Errors
/// Why it is refused, and what would mend it.
pub fn param_value(literal: &Literal, spec: &ParamSpec) -> Result<ParamValue, Refused> {
    typed(&Given::Literal(literal.clone()), spec)
}

/// The node as the current version of its type would write it; a node that is current, as it is.
///
/// # Errors
/// What the type's own upgrade says.
pub fn lifted(node: &Node, node_type: &NodeType) -> orograph_core::Result<Node> {
    let Body::Type { id, version } = &node.body else { return Ok(node.clone()) };
    let current = node_type.spec().version;
    let version = version.unwrap_or(current);
    if version >= current {
        return Ok(node.clone());
    }
    let given = node.params.iter().map(|(param, literal)| (param, Given::Literal(literal.clone())));
    let given: IndexMap<_, _> = given.collect();
    let mut raw = RawParams::default();
    for (param, given) in &given {
        let value = untyped(given).ok_or_else(|| {
            Error::invalid(format!("`{param}` has a value that no parameter takes"), "take that setting away")
        })?;
        raw.set(param, value);
    }
    node_type.upgrade(&mut raw, version)?;
    let lifted = |(param, value): (String, ParamValue)| {
        let literal = match Given::after_upgrade(given.get(&param), value) {
            Given::Literal(literal) => literal,
            Given::Lifted(value) => Literal::from(&value),
            Given::Bare(text) => Literal::Text(text),
        };
        (param, literal)
    };
    let body = Body::Type { id: id.clone(), version: Some(current) };
    Ok(Node { body, params: raw.0.into_iter().map(lifted).collect(), ..node.clone() })
}
