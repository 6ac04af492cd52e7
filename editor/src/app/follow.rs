//! After a frame: what changed is kept, and computed.

use std::sync::Arc;

use eframe::egui;
use orograph_core::ValueType;
use orograph_edit::{Beside, Delta, OpenFile, Scene, Wish};
use orograph_engine::{
    Document,
    document::{GRAPH, Link},
};

use super::{App, nodes, variations::Variations};

impl App {
    /// After a frame: what changed is kept, and computed.
    pub(super) fn catch_up(&mut self, ctx: &egui::Context) {
        self.follow_selection();
        let document = self.editing.document().clone();
        if self.kept != self.editing.state() {
            self.kept = self.editing.state();
            if let Some(journal) = &self.journal {
                match self.editing.is_dirty() {
                    true => journal.keep(self.file.as_ref().map(OpenFile::path), document.clone()),
                    false => journal.forget(),
                }
            }
        }
        let wishes = self.wishes(&document);
        let same = self.asked.as_mut().is_some_and(|(before, asked, context)| {
            if !Arc::ptr_eq(before, &document) && !Delta::between(before, &document).changes_results() {
                // Not to be compared again in the next frame.
                *before = document.clone();
            }
            Arc::ptr_eq(before, &document) && *asked == wishes && *context == self.context
        });
        if !same {
            self.asked = Some((document.clone(), wishes.clone(), self.context));
            self.progress.begin();
            self.runner.show(Scene { document, folder: self.folder(), context: self.context }, wishes);
        }
        self.call_window(ctx);
    }

    /// Sends what the window is called, when that changed.
    fn call_window(&mut self, ctx: &egui::Context) {
        let path = self.file.as_ref().map(|file| file.path().display().to_string());
        let mark = if self.editing.is_dirty() { "*" } else { "" };
        let called = format!("{mark}{} — Orograph", path.as_deref().unwrap_or("new graph"));
        if self.called != called {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(called.clone()));
            self.called = called;
        }
        if self.quit {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }

    /// Panes that are not pinned show what the last selected node gives.
    fn follow_selection(&mut self) {
        let Some(name) = self.canvas.selection.last().cloned() else { return };
        let output = self.output_to_show(&name);
        let document = self.editing.document().clone();
        for index in 0..self.panes.len() {
            let pane = &self.panes[index];
            // Another output of the same node was chosen in the pane.
            let chosen = pane.output.clone().filter(|output| output.node == name);
            let stays = chosen.is_some_and(|output| self.gives(&document, &output));
            let pane = &mut self.panes[index];
            if pane.pinned.is_none() && !stays && pane.output != output {
                pane.output.clone_from(&output);
                pane.clear();
            }
        }
    }

    /// Whether a node has an output of that name.
    fn gives(&mut self, document: &Document, output: &Link) -> bool {
        let Some(node) = document.nodes.get(&output.node) else { return false };
        self.interfaces.of(&output.node, node, document).output(&output.port).is_some()
    }

    /// What to look at of a node: its first output, or of one that gives nothing, what it is given.
    fn output_to_show(&mut self, name: &str) -> Option<Link> {
        let document = self.editing.document().clone();
        let node = document.nodes.get(name)?;
        let interface = self.interfaces.of(name, node, &document);
        match interface.outputs.first() {
            Some(output) => Some(Link::new(name, &output.name)),
            None => node.inputs.values().flatten().next().filter(|link| link.node != GRAPH).cloned(),
        }
    }

    pub(super) fn type_of(&mut self, output: &Link) -> Option<ValueType> {
        self.interfaces.type_of(output, self.editing.document())
    }

    /// What the panes want, then the grid of variations, then a picture for every node.
    fn wishes(&mut self, document: &Document) -> Vec<Wish> {
        let mut wishes = Vec::new();
        for index in 0..self.panes.len() {
            let value_type = self.panes[index].output.clone().and_then(|output| self.type_of(&output));
            let beside = self.beside(index, value_type);
            wishes.extend(self.panes[index].wish(&self.registry, value_type, beside));
        }
        wishes.extend(self.variations.iter().flat_map(Variations::wishes));
        if self.thumbnails {
            for (name, node) in &document.nodes {
                let interface = self.interfaces.of(name, node, document);
                let Some(output) = interface.outputs.first() else { continue };
                let Some(value_type) = output.value_type else { continue };
                let look = self.interfaces.first_look(value_type);
                if look.is_some() || value_type == ValueType::Texture {
                    let output = Link::new(name, &output.name);
                    wishes.push(Wish {
                        name: nodes::picture_name(name),
                        output,
                        look,
                        beside: Beside::Nothing,
                        overrides: Vec::new(),
                    });
                }
            }
        }
        wishes
    }
}
