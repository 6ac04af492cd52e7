//! Graphs that were open before, to be opened again.

use std::path::Path;

use eframe::egui;
use orograph_edit::SettingsChange;

use super::{App, dialogs::Then};
use crate::inspector::named;

impl App {
    /// The menu of graphs that were open before.
    pub(super) fn recent_menu(&mut self, ui: &mut egui::Ui) {
        let recent = &self.preferences.keeper.settings().recent;
        let mut chosen = None;
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Recent", |ui| {
                for graph in recent {
                    let name = graph.file_name().unwrap_or(graph.as_os_str()).to_string_lossy();
                    let folder = graph.parent().unwrap_or(Path::new("")).display().to_string();
                    let button = named(ui.button(name.as_ref()), &format!("open {}", graph.display()));
                    if button.on_hover_text(folder).clicked() {
                        chosen = Some(graph.clone());
                    }
                }
            });
        });
        if let Some(graph) = chosen {
            self.leave(Then::Reopen(graph));
        }
    }

    /// Whether a graph is among those that were open before.
    pub(super) fn is_recent(&self, graph: &Path) -> bool {
        self.preferences.keeper.settings().recent.iter().any(|known| known == graph)
    }

    /// Remembers a graph that was opened or saved under a name.
    pub(super) fn remember(&mut self, graph: &Path) {
        // Said absolutely here: the writer may have another folder by then.
        let graph = std::path::absolute(graph).unwrap_or_else(|_| graph.to_owned());
        if self.preferences.keeper.settings().recent.first() != Some(&graph) {
            self.change_settings(SettingsChange::Opened(graph));
        }
    }
}
