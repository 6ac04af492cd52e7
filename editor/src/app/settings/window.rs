//! The window of settings.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;
use orograph_edit::SettingsChange;
use orograph_engine::{
    Evaluator,
    plugin::{Found, Registered},
};
use orograph_session::{
    Settings, memory, plugins as session_plugins,
    settings::{NONE, Theme},
};

use super::{disk::Disk, memory_hint, plugins::Plugins};
use crate::{inspector::named, theme};

/// What is shown.
pub(super) struct View<'a> {
    pub(super) settings: &'a Settings,
    pub(super) file: Option<&'a PathBuf>,
    pub(super) plugins: &'a Plugins,
    pub(super) disk: &'a Disk,
    pub(super) evaluator: &'a Arc<Evaluator>,
}

/// What the user asks for.
pub(super) enum Ask {
    Change(SettingsChange),
    CacheFolder,
    PluginFolder,
    Reload,
    Count,
    Clear,
}

/// What the window remembers between frames.
#[derive(Default)]
pub(super) struct Window {
    cache: Field,
    memory: Field,
}

/// A line of text that stands for a setting.
#[derive(Default)]
struct Field {
    /// The setting as the text said it when it was last the same.
    of: Option<String>,
    text: String,
    refused: Option<String>,
}

impl Field {
    /// Draws it; the text once the user is done with another one.
    fn show(&mut self, ui: &mut egui::Ui, name: &str, hint: &str, setting: String) -> Option<String> {
        if self.of.as_ref() != Some(&setting) {
            self.text.clone_from(&setting);
            self.of = Some(setting);
            self.refused = None;
        }
        let edit = egui::TextEdit::singleline(&mut self.text).hint_text(hint).desired_width(300.0);
        let response = named(ui.add(edit), name);
        let other = self.of.as_ref() != Some(&self.text);
        (response.lost_focus() && other).then(|| self.text.trim().to_owned())
    }
}

const NEXT_START: &str = "Takes effect when the editor is started again.";

impl Window {
    /// Draws the window; false once it was closed.
    pub(super) fn show(&mut self, ctx: &egui::Context, view: &View<'_>) -> (bool, Vec<Ask>) {
        let (mut open, mut asks) = (true, Vec::new());
        // Below the menu, and above what is looked at.
        let place = ctx.content_rect().center_top() + egui::vec2(-280.0, 40.0);
        let window = egui::Window::new("Settings").id("settings".into()).open(&mut open);
        window.default_pos(place).default_size([560.0, 640.0]).vscroll(true).show(ctx, |ui| {
            ui.heading("Colours");
            ui.horizontal(|ui| {
                for (theme, label) in
                    [(Theme::System, "as the system"), (Theme::Light, "light"), (Theme::Dark, "dark")]
                {
                    if ui.radio(view.settings.theme == theme, label).clicked() {
                        asks.push(Ask::Change(SettingsChange::Theme(theme)));
                    }
                }
            });
            ui.add_space(10.0);
            ui.heading("Results");
            self.cache(ui, view, &mut asks);
            ui.add_space(6.0);
            self.memory(ui, view, &mut asks);
            ui.add_space(10.0);
            ui.heading("Plugins");
            plugins(ui, view, &mut asks);
            ui.add_space(10.0);
            ui.separator();
            match view.file {
                Some(file) => ui.weak(format!("Kept in {}", file.display())),
                None => ui.weak("Kept until the editor ends: this system tells no folder for settings"),
            };
        });
        (open, asks)
    }

    fn cache(&mut self, ui: &mut egui::Ui, view: &View<'_>, asks: &mut Vec<Ask>) {
        let usual = Settings::usual_cache_folder().map_or_else(|| NONE.into(), |usual| text(&usual));
        ui.label("Cache folder, in which results outlive the program");
        ui.horizontal(|ui| {
            let setting = view.settings.cache.as_deref().map(text).unwrap_or_default();
            if let Some(said) = self.cache.show(ui, "cache folder", &usual, setting) {
                let folder = match said.as_str() {
                    "" => None,
                    NONE => Some(NONE.into()),
                    said => Some(std::path::absolute(said).unwrap_or_else(|_| said.into())),
                };
                asks.push(Ask::Change(SettingsChange::Cache(folder)));
            }
            if named(ui.button("Choose…"), "choose the cache folder").clicked() {
                asks.push(Ask::CacheFolder);
            }
            if named(ui.button("Usual place"), "usual cache folder").on_hover_text(&usual).clicked() {
                asks.push(Ask::Change(SettingsChange::Cache(None)));
            }
            if named(ui.button("None"), "no cache folder").on_hover_text("Results in memory alone").clicked()
            {
                asks.push(Ask::Change(SettingsChange::Cache(Some(NONE.into()))));
            }
        });
        let used = view.evaluator.cache().disk().map(|disk| text(disk.root()));
        ui.weak(match &used {
            Some(folder) => format!("{NEXT_START} In use now: {folder}"),
            None => format!("{NEXT_START} In use now: memory alone"),
        });
        if used.is_none() {
            return;
        }
        ui.horizontal(|ui| {
            ui.label(match view.disk.bytes() {
                Some(bytes) => format!("It takes {} on the disk.", memory::text(bytes)),
                None => "It takes … on the disk.".into(),
            });
            let idle = !view.disk.is_busy();
            if ui.add_enabled(idle, egui::Button::new("Count again")).clicked() {
                asks.push(Ask::Count);
            }
            let clear = ui.add_enabled(idle, egui::Button::new("Clear the cache"));
            if clear.on_hover_text("What is needed again is computed again").clicked() {
                asks.push(Ask::Clear);
            }
            if !idle {
                ui.spinner();
            }
        });
    }

    fn memory(&mut self, ui: &mut egui::Ui, view: &View<'_>, asks: &mut Vec<Ask>) {
        ui.label("Memory that results may take");
        let setting = view.settings.memory.map(memory::exact_text).unwrap_or_default();
        if let Some(said) = self.memory.show(ui, "memory budget", &memory_hint(), setting) {
            let bytes = if said.is_empty() { Ok(None) } else { memory::parse(&said).map(Some) };
            match bytes {
                Ok(bytes) => {
                    // The same amount may be written in other words.
                    self.memory.of = None;
                    asks.push(Ask::Change(SettingsChange::Memory(bytes)));
                }
                Err(why) => self.memory.refused = Some(why),
            }
        }
        if let Some(why) = &self.memory.refused {
            ui.colored_label(theme::FAULT, why);
        }
        let used = memory::text(view.evaluator.cache().memory_budget());
        ui.weak(format!("{NEXT_START} In use now: {used}"));
    }
}

fn plugins(ui: &mut egui::Ui, view: &View<'_>, asks: &mut Vec<Ask>) {
    for folder in &view.settings.plugins {
        ui.horizontal(|ui| {
            ui.label(text(folder));
            if named(ui.small_button("Remove"), &format!("remove the folder {}", folder.display())).clicked()
            {
                asks.push(Ask::Change(SettingsChange::RemovePlugins(folder.clone())));
            }
        });
    }
    if let Some(own) = session_plugins::own_folder() {
        ui.weak(format!("Always looked at: {}", own.display()));
    }
    ui.horizontal(|ui| {
        if ui.button("Add folder…").on_hover_text("A folder that plugins' libraries lie in").clicked() {
            asks.push(Ask::PluginFolder);
        }
        let reload = ui.add_enabled(!view.plugins.is_busy(), egui::Button::new("Reload"));
        if named(reload, "reload plugins").on_hover_text("Looks at the folders again").clicked() {
            asks.push(Ask::Reload);
        }
        if view.plugins.is_busy() {
            ui.spinner();
        }
    });
    if view.plugins.found().is_empty() {
        ui.weak("No plugins were found.");
    }
    for Found { path, outcome } in view.plugins.found() {
        ui.separator();
        match outcome {
            Ok(plugin) => sound(ui, view.settings, path, plugin, asks),
            Err(reason) => {
                ui.label(text(path));
                ui.colored_label(theme::FAULT, format!("Refused: {reason}"));
            }
        }
    }
}

fn sound(ui: &mut egui::Ui, settings: &Settings, path: &Path, plugin: &Registered, asks: &mut Vec<Ask>) {
    ui.horizontal(|ui| {
        ui.strong(format!("{} {}", plugin.name, plugin.version));
        let said = settings.isolate.contains(&plugin.name);
        let mut apart = said || plugin.apart;
        // What the command line says for all plugins, the settings cannot take back.
        let switch = egui::Checkbox::new(&mut apart, "in a process of its own");
        let switch = ui.add_enabled(said || !plugin.apart, switch);
        let hint = "Slower, but it cannot take the editor down with it";
        if named(switch, &format!("{} in a process of its own", plugin.name)).on_hover_text(hint).changed() {
            asks.push(Ask::Change(SettingsChange::Isolate(plugin.name.clone(), apart)));
        }
    });
    ui.weak(text(path));
    ui.label(plugin.nodes.join(", "));
}

fn text(path: &Path) -> String {
    path.display().to_string()
}
