//! Work that a crash left unsaved, and files that change while they are open.

use std::{
    path::PathBuf,
    sync::mpsc::{self, Receiver},
    time::Duration,
};

use eframe::egui;
use orograph_edit::{Editing, Journal, OpenFile};
use orograph_engine::Document;

use super::App;

/// How often the file is compared with what was read of it, in seconds.
const LOOK: f64 = 2.0;

/// Watches the open file.
#[derive(Default)]
pub(super) struct Watch {
    looked: f64,
    answer: Option<Receiver<bool>>,
    changed: bool,
    /// The user wants to work on without being asked again.
    ignored: bool,
}

impl Watch {
    /// Asks what to do about a file that someone else changed.
    pub(super) fn ask(&mut self) {
        (self.changed, self.ignored) = (true, false);
    }
}

impl App {
    /// Finds what was left unsaved, and begins to keep what is not saved here.
    pub(super) fn look_for_recoveries(&mut self, folder: Option<PathBuf>) {
        let Some(folder) = folder else { return };
        match Journal::left(&folder) {
            Ok(left) => self.left = left,
            Err(error) => self.complain(format!("Unsaved work cannot be looked for: {error}")),
        }
        match Journal::begin(&folder, self.registry.clone()) {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => self.complain(format!("Unsaved work is not kept: {error}")),
        }
    }

    pub(super) fn recovery_ui(&mut self, ctx: &egui::Context) {
        self.watch_file(ctx);
        if self.left.is_empty() {
            return;
        }
        let mut recover = None;
        let mut discard = None;
        egui::Modal::new("recovery".into()).show(ctx, |ui| {
            ui.heading("Unsaved work was found");
            for (index, left) in self.left.iter().enumerate() {
                let path = left.recovery.path.as_ref();
                ui.horizontal(|ui| {
                    let name =
                        path.map_or_else(|| "a graph never saved".into(), |path| path.display().to_string());
                    // Several that were never saved are told apart by nothing else.
                    let age = left.age().map_or_else(String::new, |age| format!(", of {}", ago(age)));
                    ui.label(format!("{name}{age}"));
                    if ui.button("Recover").clicked() {
                        recover = Some(index);
                    }
                    if ui.button("Discard").clicked() {
                        discard = Some(index);
                    }
                });
            }
        });
        if let Some(index) = recover {
            let left = self.left.remove(index);
            let name = left
                .recovery
                .path
                .as_ref()
                .map_or_else(|| "recovered".into(), |path| path.display().to_string());
            match Document::parse(&left.recovery.text, &name) {
                Ok(document) => {
                    let file = left.recovery.path.clone().map(|path| match OpenFile::open(&path) {
                        Ok((file, _)) => file,
                        Err(_) => OpenFile::new(path),
                    });
                    self.replace(file, document.clone());
                    self.editing = Editing::new(document);
                    self.editing.never_saved();
                    self.kept = u64::MAX;
                    // Kept under the new journal before the old one goes.
                    if let Some(journal) = &self.journal {
                        journal.keep(self.file.as_ref().map(OpenFile::path), self.editing.document().clone());
                        if let Err(error) = journal.flush() {
                            self.complain(format!("Unsaved work is not kept: {error}"));
                            return;
                        }
                    }
                    left.forget();
                    self.tell("Recovered; save to keep it");
                }
                Err(errors) => self.complain(super::open::in_words(&errors)),
            }
        }
        if let Some(index) = discard {
            self.left.remove(index).forget();
        }
    }

    /// Compares the file with what was read of it, on a thread of its own, and asks when someone changed it.
    fn watch_file(&mut self, ctx: &egui::Context) {
        let now = ctx.input(|input| input.time);
        if self.writing.is_some() {
            // What is being written here is no change of someone else's.
            (self.watch.answer, self.watch.looked) = (None, now);
        } else if let Some(answer) = &self.watch.answer {
            match answer.try_recv() {
                Ok(changed) => {
                    self.watch.answer = None;
                    self.watch.changed |= changed && !self.watch.ignored;
                }
                Err(mpsc::TryRecvError::Disconnected) => self.watch.answer = None,
                Err(mpsc::TryRecvError::Empty) => {}
            }
        } else if now - self.watch.looked >= LOOK
            && let Some(file) = self.file.clone()
        {
            self.watch.looked = now;
            let (sender, answer) = mpsc::channel();
            let look = move || {
                // The window may be gone by then.
                let _ = sender.send(file.changed_on_disk());
            };
            if std::thread::Builder::new().name("look at the file".into()).spawn(look).is_ok() {
                self.watch.answer = Some(answer);
            }
            ctx.request_repaint_after(Duration::from_secs_f64(LOOK));
        }
        if let Some(error) = self.journal.as_ref().and_then(Journal::take_failure) {
            self.complain(format!("Unsaved work is not kept: {error}"));
        }
        if self.watch.changed {
            self.changed_ui(ctx);
        }
    }

    fn changed_ui(&mut self, ctx: &egui::Context) {
        let mut settled = None;
        egui::Modal::new("changed".into()).show(ctx, |ui| {
            ui.heading("Someone else changed the file");
            let answers = ["Take theirs", "Overwrite with mine", "Work on"];
            ui.horizontal(|ui| {
                for answer in answers {
                    if ui.button(answer).clicked() {
                        settled = Some(answer);
                    }
                }
            });
        });
        let Some(answer) = settled else { return };
        self.watch = Watch { looked: self.watch.looked, ..Watch::default() };
        match answer {
            "Take theirs" => self.reload(),
            "Overwrite with mine" => {
                self.save_over();
            }
            _ => {
                self.watch.ignored = true;
                self.editing.never_saved();
            }
        }
    }
}

/// How long ago something was, in words.
fn ago(age: Duration) -> String {
    let minutes = age.as_secs() / 60;
    let (n, unit) = match minutes {
        0 => return "just now".into(),
        1..60 => (minutes, "minute"),
        60..1440 => (minutes / 60, "hour"),
        _ => (minutes / 1440, "day"),
    };
    format!("{n} {unit}{} ago", if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_age_is_told_in_the_largest_unit_that_it_fills() {
        let told = [30, 60, 7199, 7200, 90_000].map(|seconds| ago(Duration::from_secs(seconds)));
        assert_eq!(told, ["just now", "1 minute ago", "1 hour ago", "2 hours ago", "1 day ago"]);
    }
}
