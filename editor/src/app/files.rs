//! The document in the window: replaced by another one.

use std::path::Path;

use orograph_core::ParamKind;
use orograph_edit::{Editing, Interfaces, Kind, OpenFile};
use orograph_engine::Document;

use super::App;
use crate::{canvas::Canvas, inspector::Inspector};

impl App {
    pub(super) fn replace(&mut self, file: Option<OpenFile>, document: Document) {
        let folder =
            file.as_ref().and_then(|file| file.path().parent()).map(Path::to_owned).unwrap_or_default();
        self.interfaces = Interfaces::new(self.registry.clone(), folder);
        self.editing = Editing::new(document);
        self.file = file;
        self.writing = None;
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
        // Something to look at: what the graph writes, or its last node.
        let document = self.editing.document().clone();
        let last = document.outputs.values().next().map(|link| link.node.clone()).or_else(|| {
            let is_input = |name: &str| {
                document
                    .nodes
                    .values()
                    .any(|node| node.inputs.values().flatten().any(|link| link.node == name))
            };
            document.nodes.keys().rev().find(|name| !is_input(name)).cloned()
        });
        self.canvas.select(last);
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
