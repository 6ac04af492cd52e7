//! A path typed in the window, where the system has no dialogs: without one nothing could be opened or saved.

use std::path::{Path, PathBuf};

use eframe::egui;

use super::{App, Question, dialogs::For};
use crate::inspector::named;

/// A path that is being typed.
pub(super) struct Typed {
    question: Question,
    purpose: For,
    text: String,
    fresh: bool,
}

impl Typed {
    pub(super) fn new(question: Question, purpose: For, folder: &Path) -> Self {
        let folder = std::path::absolute(folder).or_else(|_| std::env::current_dir()).unwrap_or_default();
        let name = match question {
            Question::Save => "untitled.ron",
            // The folder ends in a separator, for the name to be typed behind it.
            Question::Graph | Question::Input | Question::Output | Question::Folder => "",
        };
        Self { question, purpose, text: folder.join(name).display().to_string(), fresh: true }
    }

    fn path(&self) -> PathBuf {
        let text = self.text.trim();
        let home = text.strip_prefix("~/").zip(std::env::home_dir());
        let path = home.map_or_else(|| PathBuf::from(text), |(inside, home)| home.join(inside));
        // As it will be saved, so that what it replaces is told.
        let bare = self.question == Question::Save && path.extension().is_none() && !path.is_dir();
        if bare { path.with_extension("ron") } else { path }
    }

    /// The word on the button, or why the path will not do.
    fn verdict(&self) -> Result<&'static str, &'static str> {
        let path = self.path();
        match self.question {
            Question::Graph | Question::Input if path.is_file() => Ok("Open"),
            Question::Graph | Question::Input => Err("There is no such file"),
            Question::Folder if path.is_dir() => Ok("Choose"),
            Question::Folder => Err("There is no such folder"),
            Question::Save | Question::Output if path.is_dir() => Err("This is a folder: add a name"),
            Question::Save if !path.parent().is_some_and(Path::is_dir) => Err("There is no such folder"),
            Question::Save if path.is_file() => Ok("Replace"),
            Question::Save => Ok("Save"),
            Question::Output => Ok("Choose"),
        }
    }

    fn title(&self) -> &'static str {
        match self.question {
            Question::Graph => "Which graph?",
            Question::Save => "Save it as",
            Question::Input => "Which file is to be read?",
            Question::Output => "Which file is to be written?",
            Question::Folder => "Which folder?",
        }
    }
}

impl App {
    pub(super) fn typed_ui(&mut self, ctx: &egui::Context) {
        let Some(typed) = &mut self.typed else { return };
        // Asked before the field takes it to end the typing alone.
        let escape = ctx.input(|input| input.key_pressed(egui::Key::Escape));
        let (mut chosen, mut closed) = (false, false);
        let modal = egui::Modal::new("typed path".into()).show(ctx, |ui| {
            ui.set_width(560.0);
            ui.heading(typed.title());
            let edit = egui::TextEdit::singleline(&mut typed.text).desired_width(f32::INFINITY);
            let mut output = edit.show(ui);
            let response = named(output.response.response.clone(), "path");
            if std::mem::take(&mut typed.fresh) {
                response.request_focus();
                let end = egui::text::CCursor::new(typed.text.chars().count());
                output.state.cursor.set_char_range(Some(egui::text::CCursorRange::one(end)));
                output.state.store(ui.ctx(), response.id);
            }
            let verdict = typed.verdict();
            let enter = response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if enter && verdict.is_err() {
                response.request_focus();
            }
            ui.horizontal(|ui| {
                let word = verdict.unwrap_or("Choose");
                let pressed = ui.add_enabled(verdict.is_ok(), egui::Button::new(word)).clicked();
                chosen = verdict.is_ok() && (pressed || enter);
                closed = ui.button("Cancel").clicked();
                if let Err(why) = verdict {
                    ui.label(why);
                }
            });
            ui.weak("This system has no file dialogs; xdg-desktop-portal or zenity brings them.");
        });
        if chosen {
            if let Some(typed) = self.typed.take() {
                let path = typed.path();
                self.answered(typed.question, typed.purpose, path);
            }
        } else if closed || escape || modal.should_close() {
            self.typed = None;
        }
    }
}
