//! The file behind the window: opened, saved, replaced.

use std::path::{Path, PathBuf};

use orograph_core::ParamKind;
use orograph_edit::{Editing, Interfaces, Kind, OpenFile, file::SaveError};
use orograph_engine::Document;

use super::{App, Question, dialogs::For};
use crate::{canvas::Canvas, inspector::Inspector};

impl App {
    /// Opens a graph file in place of what is open.
    pub fn open(&mut self, path: &Path) {
        match OpenFile::open(path) {
            Ok((file, document)) => {
                if document.has_inner_comments() {
                    self.complain("Comments inside the graph are lost when it is saved from here");
                }
                self.replace(Some(file), document);
            }
            Err(errors) => self.complain(errors.to_string()),
        }
    }

    pub(super) fn replace(&mut self, file: Option<OpenFile>, document: Document) {
        let folder =
            file.as_ref().and_then(|file| file.path().parent()).map(Path::to_owned).unwrap_or_default();
        self.interfaces = Interfaces::new(self.registry.clone(), folder);
        self.editing = Editing::new(document);
        self.file = file;
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

    /// Saves to the file at hand, or asks for one.
    pub(super) fn save(&mut self) {
        let Some(file) = &mut self.file else {
            self.ask_file(Question::Save, For::SaveAs);
            return;
        };
        match file.save(self.editing.document(), &self.registry) {
            Ok(()) => {
                let text = format!("Saved {}", file.path().display());
                self.editing.saved();
                self.kept = u64::MAX;
                self.tell(text);
            }
            Err(SaveError::ChangedOnDisk(_)) => self.watch.ask(),
            Err(error) => self.complain(error.to_string()),
        }
    }

    pub(super) fn save_as(&mut self, path: PathBuf) {
        let path = if path.extension().is_none() { path.with_extension("ron") } else { path };
        let mut file = OpenFile::new(path);
        match file.save(self.editing.document(), &self.registry) {
            Ok(()) => {
                let folder = file.path().parent().map(Path::to_owned).unwrap_or_default();
                self.tell(format!("Saved {}", file.path().display()));
                if folder != self.folder() && self.reads_files() {
                    self.complain("Files that nodes read are named relative to the graph: see that they are found from its new folder");
                }
                self.interfaces = Interfaces::new(self.registry.clone(), folder);
                self.file = Some(file);
                self.editing.saved();
                self.kept = u64::MAX;
                self.asked = None;
            }
            Err(error) => self.complain(error.to_string()),
        }
    }

    fn reads_files(&mut self) -> bool {
        let document = self.editing.document().clone();
        document.nodes.iter().any(|(name, node)| {
            let interface = self.interfaces.of(name, node, &document);
            matches!(interface.kind, Kind::Graph(_))
                || interface.params.iter().any(|param| param.spec.kind == ParamKind::InputPath)
        })
    }
}
