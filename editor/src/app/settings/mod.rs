//! Settings of the program: held, shown in a window, and put to use while it runs.

mod disk;
mod plugins;
mod window;

use std::sync::Arc;

use eframe::egui;
use orograph_edit::{Keeper, SettingsChange};
use orograph_engine::{Evaluator, plugin::Found};
use orograph_session::{Settings, settings::Theme};

pub use plugins::PluginLoader;

use super::{App, Question, dialogs::For};
use disk::Disk;
use plugins::Plugins;
use window::{Ask, View, Window};

/// What the settings need to be shown and put to use.
pub(super) struct Preferences {
    pub(super) keeper: Keeper,
    window: Option<Window>,
    plugins: Plugins,
    disk: Disk,
    evaluator: Arc<Evaluator>,
    /// The colours that the window has now.
    theme: Option<Theme>,
}

impl Preferences {
    pub(super) fn new(
        keeper: Keeper,
        evaluator: Arc<Evaluator>,
        loader: PluginLoader,
        found: Vec<Found>,
    ) -> Self {
        let (plugins, disk) = (Plugins::new(loader, found), Disk::default());
        Self { keeper, window: None, plugins, disk, evaluator, theme: None }
    }

    /// The plugin that supplies a node type; nothing for one of Orograph's own.
    pub(super) fn supplier(&self, id: &str) -> String {
        let plugins = self.plugins.found().iter().filter_map(|found| found.outcome.as_ref().ok());
        let supplier = plugins.into_iter().find(|plugin| plugin.nodes.iter().any(|node| node == id));
        supplier.map_or_else(String::new, |plugin| plugin.name.clone())
    }

    /// Whether something goes on beside the window.
    pub(super) fn is_busy(&self) -> bool {
        self.keeper.is_busy() || self.plugins.is_busy() || self.disk.is_busy()
    }
}

impl App {
    /// Opens the window, with what the file and the disk hold now.
    pub(super) fn open_settings(&mut self) {
        self.preferences.window.get_or_insert_default();
        let looked = self.preferences.keeper.look();
        self.settings_told(looked);
        self.preferences.disk.count(&self.preferences.evaluator);
    }

    /// Changes something in the settings.
    pub(super) fn change_settings(&mut self, change: SettingsChange) {
        let changed = self.preferences.keeper.change(change);
        self.settings_told(changed);
    }

    fn settings_told(&mut self, outcome: Result<(), orograph_session::Error>) {
        if let Err(error) = outcome {
            self.complain(error.in_words());
        }
    }

    /// Puts settings to use and shows them.
    pub(super) fn settings_ui(&mut self, ctx: &egui::Context) {
        for error in self.preferences.keeper.failures() {
            self.complain(format!("Settings are not kept: {}", error.in_words()));
        }
        let theme = self.preferences.keeper.settings().theme;
        if self.preferences.theme.replace(theme) != Some(theme) {
            ctx.set_theme(colours(theme));
        }
        self.plugins_answer();
        self.disk_answers();
        let Preferences { keeper, window, plugins, disk, evaluator, .. } = &mut self.preferences;
        let Some(shown) = window else { return };
        let view = View { settings: keeper.settings(), file: keeper.file(), plugins, disk, evaluator };
        let (open, asks) = shown.show(ctx, &view);
        if !open {
            *window = None;
        }
        for ask in asks {
            self.settings_ask(ask);
        }
    }

    fn settings_ask(&mut self, ask: Ask) {
        match ask {
            Ask::Change(change) => {
                let about_plugins = matches!(
                    change,
                    SettingsChange::AddPlugins(_)
                        | SettingsChange::RemovePlugins(_)
                        | SettingsChange::Isolate(..)
                );
                self.change_settings(change);
                if about_plugins {
                    self.reload_plugins();
                }
            }
            Ask::CacheFolder => self.ask_file(Question::Folder, For::CacheFolder),
            Ask::PluginFolder => self.ask_file(Question::Folder, For::PluginFolder),
            Ask::Reload => self.reload_plugins(),
            Ask::Count => self.preferences.disk.count(&self.preferences.evaluator),
            Ask::Clear => self.preferences.disk.clear(&self.preferences.evaluator),
        }
    }

    /// Takes the folder that a dialog gave.
    pub(super) fn settings_folder(
        &mut self,
        ask: fn(std::path::PathBuf) -> SettingsChange,
        folder: std::path::PathBuf,
    ) {
        self.settings_ask(Ask::Change(ask(folder)));
    }

    fn disk_answers(&mut self) {
        match self.preferences.disk.answer() {
            Some(Ok(Some(freed))) => {
                self.tell(format!(
                    "The cache is empty: {} are free again",
                    orograph_session::memory::text(freed)
                ));
                // Copies of plugins lay there, too.
                if self.preferences.plugins.are_there() {
                    self.reload_plugins();
                }
            }
            Some(Err(error)) => self.complain(format!("The cache on disk: {error}")),
            Some(Ok(None)) | None => {}
        }
    }
}

fn colours(theme: Theme) -> egui::ThemePreference {
    match theme {
        Theme::System => egui::ThemePreference::System,
        Theme::Light => egui::ThemePreference::Light,
        Theme::Dark => egui::ThemePreference::Dark,
    }
}

/// What is shown of memory when nobody says how much.
fn memory_hint() -> String {
    let fits = orograph_session::memory::text(Settings::default().memory_budget(None));
    format!("{fits}, as fits this machine")
}
