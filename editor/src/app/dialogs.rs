//! Questions about files, asked beside the window so that nothing waits, and what to do when work would be lost.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{self, Receiver, TryRecvError},
    },
};

use eframe::egui;
use orograph_core::ParamValue;
use orograph_edit::{OpenFile, operations};
use orograph_engine::{Document, document::Link};

use super::App;

/// What a dialog asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// A graph file to read.
    Graph,
    /// A graph file to write.
    Save,
    /// A file that a node reads.
    Input,
    /// A file that a node writes.
    Output,
}

/// Asks the user for a file, beginning in a folder; `None` when the user chose none. Called on a thread of its own.
pub type Dialogs = Arc<dyn Fn(Question, &Path) -> Option<PathBuf> + Send + Sync>;

/// What the chosen file is for.
#[derive(Clone, Debug)]
pub(super) enum For {
    Open,
    SaveAs,
    Subgraph,
    Collapse(Vec<String>),
    Param(Link),
}

/// A dialog that is open.
pub(super) struct Waiting {
    purpose: For,
    answer: Receiver<Option<PathBuf>>,
}

/// What is to be done once unsaved work is saved or given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then {
    New,
    Open,
    Quit,
}

impl App {
    pub(super) fn ask_file(&mut self, question: Question, purpose: For) {
        let (sender, answer) = mpsc::channel();
        let (dialogs, folder) = (self.dialogs.clone(), self.folder());
        let spawned = std::thread::Builder::new().name("dialog".into()).spawn(move || {
            // The window may be gone by then.
            let _ = sender.send(dialogs(question, &folder));
        });
        match spawned {
            Ok(_) => self.dialog = Some(Waiting { purpose, answer }),
            Err(error) => self.complain(format!("cannot start a thread: {error}")),
        }
    }

    pub(super) fn dialog_answers(&mut self, ctx: &egui::Context) {
        let Some(waiting) = &self.dialog else { return };
        let answer = match waiting.answer.try_recv() {
            Err(TryRecvError::Empty) => {
                ctx.request_repaint_after(std::time::Duration::from_millis(50));
                return;
            }
            Err(TryRecvError::Disconnected) => None,
            Ok(answer) => answer,
        };
        let Some(Waiting { purpose, .. }) = self.dialog.take() else { return };
        let Some(path) = answer else { return };
        match purpose {
            For::Open => self.open(&path),
            For::SaveAs => self.save_as(path),
            For::Subgraph => self.add_graph(&path),
            For::Collapse(names) => self.collapse(&names, &path),
            For::Param(link) => {
                let text = self.relative(&path);
                self.set(&link, &ParamValue::Text(text));
                self.editing.end_gesture();
            }
        }
    }

    /// The path as the graph names it: relative to its folder where it lies inside.
    fn relative(&self, path: &Path) -> String {
        let folder = std::path::absolute(self.folder()).unwrap_or_default();
        path.strip_prefix(&folder).unwrap_or(path).to_string_lossy().replace('\\', "/")
    }

    fn add_graph(&mut self, path: &Path) {
        let name = self.relative(path);
        let at = self.canvas.middle();
        let added = self.edit("add graph", |document, _| Ok(operations::add_graph(document, &name, at)));
        self.canvas.select(added);
    }

    /// Does something that ends the work on this document, once the user settled what becomes of unsaved edits.
    pub(super) fn leave(&mut self, then: Then) {
        if self.editing.is_dirty() {
            self.closing = Some(then);
        } else {
            self.go(then);
        }
    }

    fn go(&mut self, then: Then) {
        if let Some(journal) = &self.journal {
            journal.forget();
        }
        match then {
            Then::New => self.replace(None, Document::new()),
            Then::Open => self.ask_file(Question::Graph, For::Open),
            Then::Quit => self.quit = true,
        }
    }

    /// Holds the window open while there is unsaved work.
    pub(super) fn may_close(&mut self, ctx: &egui::Context) {
        if ctx.input(|input| input.viewport().close_requested()) && !self.quit && self.editing.is_dirty() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.closing = Some(Then::Quit);
        }
    }

    pub(super) fn closing_ui(&mut self, ctx: &egui::Context) {
        let Some(then) = self.closing else { return };
        let mut settled = None;
        egui::Modal::new("unsaved".into()).show(ctx, |ui| {
            ui.heading("There are unsaved changes");
            ui.horizontal(|ui| {
                for answer in ["Save", "Discard", "Keep editing"] {
                    if ui.button(answer).clicked() {
                        settled = Some(answer);
                    }
                }
            });
        });
        match settled {
            Some("Save") => {
                self.closing = None;
                self.save();
                if !self.editing.is_dirty() {
                    self.go(then);
                }
            }
            Some("Discard") => {
                self.closing = None;
                self.go(then);
            }
            Some(_) => self.closing = None,
            None => {}
        }
    }

    /// A wire that was refused: why, and what could stand between its ends.
    pub(super) fn refusal_ui(&mut self, ctx: &egui::Context) {
        let Some((refused, (from, to))) = self.refused.clone() else { return };
        let mut chosen = None;
        let mut closed = false;
        let modal = egui::Modal::new("refused".into()).show(ctx, |ui| {
            ui.set_max_width(440.0);
            ui.strong(&refused.message);
            ui.label(&refused.help);
            egui::ScrollArea::vertical().max_height(220.0).show(ui, |ui| {
                for id in &refused.converters {
                    if ui.button(format!("Insert {id}")).clicked() {
                        chosen = Some(id.clone());
                    }
                }
            });
            closed = ui.button("Leave it").clicked();
        });
        if let Some(id) = chosen {
            self.refused = None;
            self.edit("connect", |document, interfaces| {
                operations::connect_through(document, interfaces, &id, &from, &to)
            });
        } else if closed || modal.should_close() {
            self.refused = None;
        }
    }

    /// Takes what is on the disk in place of what is open.
    pub(super) fn reload(&mut self) {
        if let Some(path) = self.file.as_ref().map(|file| OpenFile::path(file).to_owned()) {
            self.open(&path);
        }
    }
}
