//! Opening graph files, beside the window once there is one.

use std::{
    path::{Path, PathBuf},
    sync::mpsc::{self, Receiver, TryRecvError},
};

use eframe::egui;
use orograph_edit::{Kind, OpenFile, SettingsChange};
use orograph_engine::{Document, DocumentErrors};

use super::App;

/// A file that is being read.
pub(super) struct Opening {
    path: PathBuf,
    answer: Receiver<Result<(OpenFile, Document), Unopened>>,
}

/// Why a file was not opened.
enum Unopened {
    Gone,
    Wrong(DocumentErrors),
    NoThread,
}

impl App {
    /// Opens a graph file in place of what is open, at once.
    pub fn open(&mut self, path: &Path) {
        let opened = read(path);
        self.opened(path, opened);
    }

    /// Opens a graph file in place of what is open, as soon as it is read.
    pub(super) fn open_beside(&mut self, path: PathBuf) {
        let (sender, answer) = mpsc::channel();
        let (file, wake) = (path.clone(), self.wake.clone());
        let work = move || {
            // The user may have given it up by then.
            let _ = sender.send(read(&file));
            wake();
        };
        self.opening = Some(Opening { path, answer });
        // Where no thread can be started, its end of the line is gone at once.
        let _ = std::thread::Builder::new().name("open".into()).spawn(work);
    }

    /// Takes a file that was read, and holds the window for one that is yet to come: edits would go with what it
    /// replaces.
    pub(super) fn opening_ui(&mut self, ctx: &egui::Context) {
        let Some(opening) = &self.opening else { return };
        let opened = match opening.answer.try_recv() {
            Ok(opened) => opened,
            Err(TryRecvError::Disconnected) => Err(Unopened::NoThread),
            Err(TryRecvError::Empty) => {
                let mut given_up = false;
                egui::Modal::new("opening".into()).show(ctx, |ui| {
                    ui.heading(format!("Reading {}", opening.path.display()));
                    given_up = ui.button("Do not open it").clicked();
                });
                if given_up {
                    self.opening = None;
                }
                return;
            }
        };
        let Some(Opening { path, .. }) = self.opening.take() else { return };
        self.opened(&path, opened);
    }

    fn opened(&mut self, path: &Path, opened: Result<(OpenFile, Document), Unopened>) {
        match opened {
            Ok((file, document)) => {
                if document.has_inner_comments() {
                    self.complain("Comments inside the graph are lost when it is saved from here");
                }
                self.replace(Some(file), document);
                self.remember(path);
                self.tell_placeholders();
            }
            Err(Unopened::Wrong(errors)) => self.complain(in_words(&errors)),
            Err(Unopened::NoThread) => {
                self.complain(format!("{} is not opened: no thread could be started", path.display()));
            }
            Err(Unopened::Gone) if self.is_recent(path) => {
                let name = path.display();
                self.complain(format!("{name} is no longer there, and no longer among the recent files"));
                self.change_settings(SettingsChange::Gone(path.to_owned()));
            }
            Err(Unopened::Gone) => self.complain(format!("{} is not there: check the path", path.display())),
        }
    }

    /// Says which nodes are not known here, and why.
    fn tell_placeholders(&mut self) {
        /// How many are told of by name.
        const NAMED: usize = 3;
        let document = self.editing.document().clone();
        let mut reasons = Vec::new();
        for (name, node) in &document.nodes {
            if let Kind::Unknown(reason) = &self.interfaces.of(name, node, &document).kind {
                reasons.push(format!("`{name}`: {reason}"));
            }
        }
        let (nodes, more) = (reasons.len(), reasons.len().saturating_sub(NAMED));
        if nodes == 0 {
            return;
        }
        reasons.truncate(NAMED);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        let are = if nodes == 1 {
            "One node is a placeholder".into()
        } else {
            format!("{nodes} nodes are placeholders")
        };
        self.complain(format!(
            "{are}, kept as they are: {}{more}. A newer Orograph may know them, or a plugin: see the settings",
            reasons.join("; ")
        ));
    }
}

fn read(path: &Path) -> Result<(OpenFile, Document), Unopened> {
    OpenFile::open(path).map_err(|errors| match path.try_exists() {
        Ok(false) => Unopened::Gone,
        _ => Unopened::Wrong(errors),
    })
}

/// What is wrong with a file, line by line, each with its mend.
pub(super) fn in_words(errors: &DocumentErrors) -> String {
    let words = errors.errors().iter().map(|error| match error.help_text() {
        Some(help) => format!("{error}: {help}"),
        None => error.to_string(),
    });
    words.collect::<Vec<_>>().join("\n")
}
