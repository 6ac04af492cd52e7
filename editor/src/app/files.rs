//! The document in the window: replaced by another one.

use std::path::Path;

use orograph_core::{ParamKind, ValueType};
use orograph_edit::{Editing, Interfaces, Kind, OpenFile};
use orograph_engine::{Document, document::Node};

use super::App;
use crate::{canvas::Canvas, inspector::Inspector};

impl App {
    pub(super) fn replace(&mut self, file: Option<OpenFile>, document: Document) {
        let folder =
            file.as_ref().and_then(|file| file.path().parent()).map(Path::to_owned).unwrap_or_default();
        self.interfaces = Interfaces::new(self.registry.clone(), folder);
        self.editing = Editing::new(document);
        self.file = file;
        (self.writing, self.folding) = (None, None);
        self.kept = self.editing.state();
        self.drawn_state = u64::MAX;
        self.canvas = Canvas::default();
        self.canvas.fit();
        self.inspector = Inspector::default();
        self.badges.clear();
        self.pictures.clear();
        self.asked = None;
        self.variations = None;
        for pane in &mut self.panes {
            (pane.pinned, pane.output) = (None, None);
            pane.clear();
        }
        let shown = self.worth_a_look();
        self.canvas.select(shown);
    }

    /// The node to begin with: the last that writes a picture, else what the graph names, else its last node.
    fn worth_a_look(&mut self) -> Option<String> {
        let document = self.editing.document().clone();
        let writes_picture = |(name, node): &(&String, &Node)| {
            let interface = self.interfaces.of(name, node, &document);
            let takes =
                interface.inputs.first().is_some_and(|port| port.value_type == Some(ValueType::Texture));
            takes && interface.spec().is_some_and(|spec| spec.writes)
        };
        if let Some((name, _)) = document.nodes.iter().rev().find(writes_picture) {
            return Some(name.clone());
        }
        document.outputs.values().next().map(|link| link.node.clone()).or_else(|| {
            let is_input = |name: &str| {
                let mut wires = document.nodes.values().flat_map(|node| node.inputs.values().flatten());
                wires.any(|link| link.node == name)
            };
            document.nodes.keys().rev().find(|name| !is_input(name)).cloned()
        })
    }

    pub(super) fn reads_files(&mut self) -> bool {
        let document = self.editing.document().clone();
        document.nodes.iter().any(|(name, node)| {
            let interface = self.interfaces.of(name, node, &document);
            matches!(interface.kind, Kind::Graph(_))
                || interface.params.iter().any(|param| param.spec.kind == ParamKind::InputPath)
        })
    }
}
