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
use orograph_edit::{OpenFile, SettingsChange, operations};
use orograph_engine::{Document, document::Link};

use super::{App, typed::Typed};

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
    /// A folder.
    Folder,
}

/// The system has no dialogs to ask with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoDialogs;

/// Asks the user for a file or folder, beginning in a folder; `None` when the user chose none. Called on a thread of its own.
pub type Dialogs = Arc<dyn Fn(Question, &Path) -> Result<Option<PathBuf>, NoDialogs> + Send + Sync>;

/// What the chosen file is for.
#[derive(Clone, Debug)]
pub(super) enum For {
    Open,
    /// And what to do once it is saved.
    SaveAs(Option<Then>),
    Subgraph,
    Collapse(Vec<String>),
    Param(Link),
    /// A picture under the painting of this input's node.
    Under(Link),
    CacheFolder,
    PluginFolder,
}

/// A dialog that is open.
pub(super) struct Waiting {
    purpose: For,
    question: Question,
    folder: PathBuf,
    answer: Receiver<Result<Option<PathBuf>, NoDialogs>>,
}

/// What is to be done once unsaved work is saved or given up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Then {
    New,
    Open,
    Reopen(PathBuf),
    Quit,
}

impl App {
    pub(super) fn ask_file(&mut self, question: Question, purpose: For) {
        let (sender, answer) = mpsc::channel();
        let folder = match question {
            Question::Output => self.out.clone(),
            _ => self.folder(),
        };
        let (dialogs, beginning) = (self.dialogs.clone(), folder.clone());
        let spawned = std::thread::Builder::new().name("dialog".into()).spawn(move || {
            // The window may be gone by then.
            let _ = sender.send(dialogs(question, &beginning));
        });
        match spawned {
            Ok(_) => self.dialog = Some(Waiting { purpose, question, folder, answer }),
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
            Err(TryRecvError::Disconnected) => Ok(None),
            Ok(answer) => answer,
        };
        let Some(Waiting { purpose, question, folder, .. }) = self.dialog.take() else { return };
        match answer {
            Ok(Some(path)) => self.answered(question, purpose, path),
            Ok(None) => {}
            Err(NoDialogs) => self.typed = Some(Typed::new(question, purpose, &folder)),
        }
    }

    /// Does what the path was asked for.
    pub(super) fn answered(&mut self, question: Question, purpose: For, path: PathBuf) {
        match purpose {
            For::Open => self.open_beside(path),
            For::SaveAs(then) => self.save_as(path, then),
            For::CacheFolder => self.settings_folder(|folder| SettingsChange::Cache(Some(folder)), path),
            For::PluginFolder => self.settings_folder(SettingsChange::AddPlugins, path),
            For::Subgraph => self.add_graph(&path),
            For::Collapse(names) => self.collapse(&names, &path),
            For::Under(input) => {
                let file = self.relative(&path);
                self.put_under(&input, file);
            }
            For::Param(link) => {
                let text = match question {
                    Question::Output => self.in_output_folder(&path),
                    _ => Some(self.relative(&path)),
                };
                if let Some(text) = text {
                    self.set(&link, &ParamValue::Text(text));
                    self.editing.end_gesture();
                }
            }
        }
    }

    /// The path as the graph names it: relative to its folder where it lies inside.
    fn relative(&self, path: &Path) -> String {
        let folder = std::path::absolute(self.folder()).unwrap_or_default();
        path.strip_prefix(&folder).unwrap_or(path).to_string_lossy().replace('\\', "/")
    }

    /// The path as writers name it: relative to the folder that builds write into, which they do not leave.
    fn in_output_folder(&mut self, path: &Path) -> Option<String> {
        let out = std::path::absolute(&self.out).unwrap_or_default();
        match path.strip_prefix(&out) {
            Ok(inside) => Some(inside.to_string_lossy().replace('\\', "/")),
            Err(_) => {
                let out = out.display();
                self.complain(format!("Builds write into {out} alone: choose a file in there, or start the editor with another --out"));
                None
            }
        }
    }

    fn add_graph(&mut self, path: &Path) {
        let name = self.relative(path);
        let at = self.canvas.middle();
        let added = self.edit("add graph", |document, _| Ok(operations::add_graph(document, &name, at)));
        self.canvas.select(added);
    }

    /// Does something that ends the work on this document, once the user settled what becomes of unsaved edits.
    pub(super) fn leave(&mut self, then: Then) {
        if let Some(writing) = &mut self.writing {
            writing.then_leave(then);
        } else if self.editing.is_dirty() {
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
            Then::Reopen(graph) => self.open_beside(graph),
            Then::Quit => self.quit = true,
        }
    }

    /// Holds the window open while there is unsaved work, or work that is being saved.
    pub(super) fn may_close(&mut self, ctx: &egui::Context) {
        let unsaved = self.editing.is_dirty() || self.writing.is_some();
        if ctx.input(|input| input.viewport().close_requested()) && !self.quit && unsaved {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.leave(Then::Quit);
        }
    }

    pub(super) fn closing_ui(&mut self, ctx: &egui::Context) {
        let Some(then) = self.closing.clone() else { return };
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
                self.save(Some(then));
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
            self.open_beside(path);
        }
    }
}
