//! Saving, beside the window: a slow disk freezes nothing, and nothing ends before the file is written.

use std::path::{Path, PathBuf};

use eframe::egui;
use orograph_edit::{
    Interfaces, OpenFile,
    file::{SaveError, Saved, Saving},
};

use super::{
    App, Question,
    dialogs::{For, Then},
};

/// A save that goes on.
pub(super) struct Writing {
    saving: Saving,
    /// The state of the document that is written; it may be edited meanwhile.
    state: u64,
    /// What was asked for meanwhile.
    next: Option<Next>,
}

enum Next {
    Save,
    SaveAs(PathBuf),
    Leave(Then),
}

impl Writing {
    /// Puts off what would end the work on this document.
    pub(super) fn then_leave(&mut self, then: Then) {
        self.next = Some(Next::Leave(then));
    }

    /// Waits until the file is written.
    pub(super) fn wait(self) {
        // The window is gone: nobody is left to tell.
        let _ = self.saving.wait();
    }
}

impl App {
    /// Saves to the file at hand, or asks for one; then does what ends the work on this document.
    pub(super) fn save(&mut self, then: Option<Then>) {
        self.save_file(false, then);
    }

    /// As [`save`](Self::save), over what someone else wrote.
    pub(super) fn save_over(&mut self) {
        self.save_file(true, None);
    }

    fn save_file(&mut self, over: bool, then: Option<Then>) {
        if let Some(writing) = &mut self.writing {
            writing.next = Some(then.map_or(Next::Save, Next::Leave));
            return;
        }
        match self.file.clone() {
            Some(file) => self.write_file(&file, over, then),
            None => self.ask_file(Question::Save, For::SaveAs(then)),
        }
    }

    pub(super) fn save_as(&mut self, path: PathBuf, then: Option<Then>) {
        let path = if path.extension().is_none() { path.with_extension("ron") } else { path };
        if let Some(writing) = &mut self.writing {
            writing.next = Some(Next::SaveAs(path));
            return;
        }
        self.write_file(&OpenFile::new(path), false, then);
    }

    fn write_file(&mut self, file: &OpenFile, over: bool, then: Option<Then>) {
        let state = self.editing.to_be_saved();
        let (document, registry) = (self.editing.document().clone(), self.registry.clone());
        let saving = file.save_beside(document, registry, over, self.wake.clone());
        self.writing = Some(Writing { saving, state, next: then.map(Next::Leave) });
    }

    /// Hears whether the file was written.
    pub(super) fn saving_answers(&mut self) {
        let Some(saved) = self.writing.as_mut().and_then(|writing| writing.saving.poll()) else { return };
        let Some(Writing { state, next, .. }) = self.writing.take() else { return };
        let Saved { file, outcome } = saved;
        match outcome {
            Ok(()) => {
                self.tell(format!("Saved {}", file.path().display()));
                self.take_file(file);
                self.editing.saved(state);
                self.kept = u64::MAX;
                match next {
                    Some(Next::Save) if self.editing.is_dirty() => self.save(None),
                    Some(Next::SaveAs(path)) => self.save_as(path, None),
                    Some(Next::Leave(then)) => self.leave(then),
                    Some(Next::Save) | None => {}
                }
            }
            // What was asked for next would end work that is not saved.
            Err(SaveError::ChangedOnDisk(_)) => self.watch.ask(),
            Err(error) => self.complain(error.to_string()),
        }
    }

    /// Takes a file that was written as the one behind the window.
    fn take_file(&mut self, file: OpenFile) {
        if self.file.as_ref().map(OpenFile::path) != Some(file.path()) {
            let folder = file.path().parent().map(Path::to_owned).unwrap_or_default();
            if folder != self.folder() && self.reads_files() {
                self.complain("Files that nodes read are named relative to the graph: see that they are found from its new folder");
            }
            self.interfaces = Interfaces::new(self.registry.clone(), folder);
            self.asked = None;
        }
        self.remember(file.path());
        self.file = Some(file);
    }

    pub(super) fn saving_ui(&self, ui: &mut egui::Ui) {
        if self.writing.is_some() {
            ui.label("saving…");
        }
    }
}
