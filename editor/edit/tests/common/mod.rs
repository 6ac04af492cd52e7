//! What the tests share. A helper that fails is a test that fails.
#![allow(clippy::unwrap_used, dead_code)]

use std::{path::PathBuf, sync::Arc};

use orograph_edit::{Interfaces, operations};
use orograph_engine::{Document, Registry, document::Link};

pub(crate) fn registry() -> Arc<Registry> {
    Arc::new(orograph_session::built_in().unwrap())
}

pub(crate) fn interfaces(registry: &Arc<Registry>) -> Interfaces {
    Interfaces::new(registry.clone(), PathBuf::new())
}

pub(crate) fn link(text: &str) -> Link {
    Link::parse(text).unwrap()
}

/// Noise, blurred, shaded.
pub(crate) fn chain(registry: &Registry) -> Document {
    let text = r#"(format: 1, nodes: {
        "hills": (node: "generate.fbm", version: 1, params: (cells: 64)),
        "soft": (node: "filter.gaussian_blur", version: 1, inputs: {"terrain": "hills.terrain"}),
        "shade": (node: "look.hillshade", version: 1, inputs: {"terrain": "soft.terrain"}),
    }, outputs: {"picture": "shade.picture"}, layout: (nodes: {"hills": (0, 0), "soft": (250, 0), "shade": (500, 0)}))"#;
    let document = Document::parse(text, "chain").unwrap();
    for node in document.nodes.values() {
        let orograph_engine::document::Body::Type { id, .. } = &node.body else {
            unreachable!("types alone")
        };
        assert!(registry.get(id).is_some(), "{id} is a node type");
    }
    document
}

pub(crate) fn add(document: &mut Document, registry: &Registry, id: &str) -> String {
    operations::add(document, registry.get(id).unwrap(), (10.0, 20.0))
}
