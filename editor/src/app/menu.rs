//! The bars at the head and the foot of the window.

use eframe::egui;
use orograph_edit::Fault;

use super::{
    App, Command,
    command::{ENTRIES, Menu},
};
use crate::inspector::named;

impl App {
    pub(super) fn menu(&mut self, ui: &mut egui::Ui) {
        let mut chosen = None;
        egui::MenuBar::new().ui(ui, |ui| {
            for (menu, title) in Menu::ALL {
                ui.menu_button(title, |ui| {
                    for entry in ENTRIES.iter().filter(|entry| entry.menu == menu && !entry.label.is_empty())
                    {
                        let mut button = egui::Button::new(self.label(entry.command, entry.label));
                        if let Some(key) = entry.told() {
                            button = button.shortcut_text(ui.ctx().format_shortcut(&key));
                        }
                        if ui.add_enabled(self.can(entry.command), button).clicked() {
                            chosen = Some(entry.command);
                        }
                        if entry.command == Command::Open {
                            self.recent_menu(ui);
                        }
                    }
                });
            }
            ui.separator();
            if ui.button("Build").on_hover_text("Write every file, as `orograph run` does").clicked() {
                chosen = Some(Command::Build);
            }
            ui.label("preview");
            let text = |cells: Option<u32>| {
                cells.map_or_else(|| "full".to_owned(), |cells| format!("{cells} cells"))
            };
            let combo =
                egui::ComboBox::from_id_salt("resolution").selected_text(text(self.context.resolution));
            let combo = combo.show_ui(ui, |ui| {
                for cells in [Some(128), Some(256), Some(512), Some(1024), Some(2048), None] {
                    ui.selectable_value(&mut self.context.resolution, cells, text(cells));
                }
            });
            named(combo.response, "resolution of the preview");
            ui.label("seed");
            named(ui.add(egui::DragValue::new(&mut self.context.seed)), "seed of the preview");
        });
        if let Some(command) = chosen {
            self.command(ui.ctx(), command);
        }
    }

    fn label(&self, command: Command, label: &'static str) -> String {
        let what = match command {
            Command::Undo => self.editing.undo_label(),
            Command::Redo => self.editing.redo_label(),
            _ => None,
        };
        what.map_or_else(|| label.to_owned(), |what| format!("{label}: {what}"))
    }

    pub(super) fn status(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            self.progress_ui(ui);
            self.saving_ui(ui);
            let n = self.faults.len();
            if n > 0 {
                let words = self.faults.iter().map(Fault::words).collect::<Vec<_>>().join("\n");
                let text = if n == 1 { "1 problem".to_owned() } else { format!("{n} problems") };
                ui.colored_label(crate::theme::FAULT, text).on_hover_text(words);
            }
            let mut gone = false;
            if let Some(note) = self.notes.last() {
                let colour = if note.bad { crate::theme::FAULT } else { ui.visuals().text_color() };
                // Long words take one line; the pointer over them shows them all.
                gone = named(ui.small_button("×"), "put the note away").clicked();
                ui.add(egui::Label::new(egui::RichText::new(&note.text).color(colour)).truncate());
            }
            if gone {
                self.notes.pop();
            }
        });
    }
}
