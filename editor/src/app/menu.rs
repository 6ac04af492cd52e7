//! The bars at the head and the foot of the window.

use eframe::egui;

use super::{
    App, Command,
    command::{ENTRIES, Menu},
};

impl App {
    pub(super) fn menu(&mut self, ui: &mut egui::Ui) {
        let mut chosen = None;
        egui::MenuBar::new().ui(ui, |ui| {
            for (menu, title) in Menu::ALL {
                ui.menu_button(title, |ui| {
                    for entry in ENTRIES.iter().filter(|entry| entry.menu == menu && !entry.label.is_empty())
                    {
                        let mut button = egui::Button::new(self.label(entry.command, entry.label));
                        if let Some(key) = entry.shortcut() {
                            button = button.shortcut_text(ui.ctx().format_shortcut(&key));
                        }
                        if ui.add_enabled(self.can(entry.command), button).clicked() {
                            chosen = Some(entry.command);
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
            egui::ComboBox::from_id_salt("resolution").selected_text(text(self.context.resolution)).show_ui(
                ui,
                |ui| {
                    for cells in [Some(128), Some(256), Some(512), Some(1024), Some(2048), None] {
                        ui.selectable_value(&mut self.context.resolution, cells, text(cells));
                    }
                },
            );
            ui.label("seed");
            ui.add(egui::DragValue::new(&mut self.context.seed));
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
            if let Some(done) = self.building {
                ui.add(egui::ProgressBar::new(done as f32).desired_width(140.0).text("building"));
            }
            if let Some(done) = self.progress {
                ui.add(egui::ProgressBar::new(done as f32).desired_width(140.0).text("preview"));
            }
            if (self.building.is_some() || self.progress.is_some()) && ui.small_button("stop").clicked() {
                self.runner.stop();
            }
            let n = self.faults.len();
            if n > 0 {
                let words =
                    self.faults.iter().map(|fault| fault.message.as_str()).collect::<Vec<_>>().join("\n");
                let text = if n == 1 { "1 problem".to_owned() } else { format!("{n} problems") };
                ui.colored_label(crate::theme::FAULT, text).on_hover_text(words);
            }
            let mut gone = false;
            if let Some(note) = self.notes.last() {
                let colour = if note.bad { crate::theme::FAULT } else { ui.visuals().text_color() };
                ui.colored_label(colour, &note.text);
                gone = ui.small_button("×").clicked();
            }
            if gone {
                self.notes.pop();
            }
        });
    }
}
