//! Words on the canvas: titles of frames, and comments.

use eframe::egui;
use orograph_engine::document::Comment;

use super::App;
use crate::inspector::named;

/// Whose words are being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whose {
    /// The frame's of this number.
    Frame(usize),
    /// The comment's of this number.
    Comment(usize),
    /// A comment's that is not there yet.
    NewComment,
}

/// Words that are being written.
pub(super) struct Words {
    whose: Whose,
    text: String,
    /// Where a new comment goes.
    at: (f64, f64),
}

impl App {
    /// Asks for the words of something that is there.
    pub(super) fn write(&mut self, whose: Whose) {
        let layout = &self.editing.document().layout;
        let text = match whose {
            Whose::Frame(index) => layout.frames.get(index).map(|frame| frame.title.clone()),
            Whose::Comment(index) => layout.comments.get(index).map(|comment| comment.text.clone()),
            Whose::NewComment => Some(String::new()),
        };
        self.words = text.map(|text| Words { whose, text, at: self.canvas.middle() });
    }

    pub(super) fn words_ui(&mut self, ctx: &egui::Context) {
        let Some(words) = &mut self.words else { return };
        let (mut done, mut remove) = (false, false);
        let is_frame = matches!(words.whose, Whose::Frame(_));
        let modal = egui::Modal::new("words".into()).show(ctx, |ui| {
            let response = match is_frame {
                true => named(ui.text_edit_singleline(&mut words.text), "title of the frame"),
                false => named(ui.text_edit_multiline(&mut words.text), "words of the comment"),
            };
            response.request_focus();
            ui.horizontal(|ui| {
                let enter = ui.input(|input| {
                    input.key_pressed(egui::Key::Enter) && (is_frame || input.modifiers.command)
                });
                done = ui.button("Done").clicked() || enter;
                remove = match words.whose {
                    Whose::Frame(_) => ui.button("Remove frame").clicked(),
                    Whose::Comment(_) => ui.button("Remove comment").clicked(),
                    Whose::NewComment => ui.button("Cancel").clicked(),
                };
            });
            if !is_frame {
                ui.weak("Ctrl+Enter is Done");
            }
        });
        if !done && !remove {
            if modal.should_close() {
                self.words = None;
            }
            return;
        }
        let Some(Words { whose, text, at }) = self.words.take() else { return };
        let (label, empty) = (if is_frame { "frame" } else { "comment" }, text.trim().is_empty());
        self.edit(label, |document, _| {
            let layout = &mut document.layout;
            match whose {
                Whose::Frame(index) if remove && index < layout.frames.len() => {
                    layout.frames.remove(index);
                }
                Whose::Frame(index) => {
                    if let Some(frame) = layout.frames.get_mut(index) {
                        frame.title = text;
                    }
                }
                Whose::Comment(index) if (remove || empty) && index < layout.comments.len() => {
                    layout.comments.remove(index);
                }
                Whose::Comment(index) => {
                    if let Some(comment) = layout.comments.get_mut(index) {
                        comment.text = text;
                    }
                }
                Whose::NewComment if remove || empty => {}
                Whose::NewComment => layout.comments.push(Comment { text, at, ..Comment::default() }),
            }
            Ok(())
        });
    }
}
