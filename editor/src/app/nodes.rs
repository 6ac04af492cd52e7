//! What the canvas draws of the document, made anew only when something in it changed.

use orograph_core::ValueType;
use orograph_edit::{Fault, Kind, Port};
use orograph_engine::document::{Body, GRAPH, Link};

use super::App;
use crate::canvas::{NodeView, PortView};

const PICTURE: &str = "node ";

/// The name of the wish for a node's small picture.
pub(super) fn picture_name(node: &str) -> String {
    format!("{PICTURE}{node}")
}

/// The node whose small picture a wish of that name is for.
pub(super) fn node_of(wish: &str) -> Option<&str> {
    wish.strip_prefix(PICTURE)
}

impl App {
    pub(super) fn redraw(&mut self) {
        if !self.stale && self.drawn_state == self.editing.state() {
            return;
        }
        (self.stale, self.drawn_state) = (false, self.editing.state());
        let document = self.editing.document().clone();
        self.drawn.clear();
        self.wires.clear();
        for (name, node) in &document.nodes {
            let interface = self.interfaces.of(name, node, &document);
            let ports = |ports: &[Port]| {
                let view = |port: &Port| PortView {
                    name: port.name.clone(),
                    value_type: port.value_type,
                    doc: port.doc.clone(),
                };
                ports.iter().map(view).collect::<Vec<_>>()
            };
            let (kind, family) = match &node.body {
                Body::Type { id, .. } => (id.clone(), id.split('.').next().unwrap_or(id).to_owned()),
                Body::Graph { path } => (path.clone(), "graph".to_owned()),
            };
            let mut inputs = ports(&interface.inputs);
            // A wire to a port that the node no longer has is drawn, too, so that it can be taken away.
            for port in node.inputs.keys().filter(|port| interface.input(port).is_none()) {
                inputs.push(PortView { name: port.clone(), value_type: None, doc: "no such input".into() });
            }
            let fault = self.faults.iter().find(|fault| fault.node.as_deref() == Some(name));
            self.drawn.push(NodeView {
                name: name.clone(),
                kind,
                family,
                summary: interface.summary(),
                inputs,
                outputs: ports(&interface.outputs),
                position: document.layout.nodes.get(name).copied(),
                bypass: node.bypass,
                unknown: matches!(interface.kind, Kind::Unknown(_)),
                comment: node.comment.clone(),
                badge: self.badges.get(name).cloned(),
                fault: fault.map(Fault::words),
                thumbnail: self.pictures.get(name).filter(|_| self.thumbnails).map(|picture| picture.id()),
            });
            for (port, links) in &node.inputs {
                let to = Link::new(name, port);
                self.wires.extend(
                    links.iter().filter(|from| from.node != GRAPH).map(|from| (from.clone(), to.clone())),
                );
            }
        }
    }

    pub(super) fn port_type(&self, link: &Link, is_output: bool) -> Option<ValueType> {
        let node = self.drawn.iter().find(|node| node.name == link.node)?;
        let ports = if is_output { &node.outputs } else { &node.inputs };
        ports.iter().find(|port| port.name == link.port)?.value_type
    }
}
