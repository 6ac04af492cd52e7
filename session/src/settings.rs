//! The user's settings: one file for the command line and the editor.
//!
//! What is said on a command line or in the environment goes before them.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use etcetera::BaseStrategy;
use orograph_engine::save_whole;
use ron::{extensions::Extensions, ser::PrettyConfig};
use serde::{Deserialize, Serialize};

use crate::{Error, memory};

/// How a cache folder is called off.
pub const NONE: &str = "none";

/// How many graphs [`Settings::recent`] holds.
pub const MOST_RECENT: usize = 12;

/// The user's settings, `settings.ron` in the folder of their configuration. What is left out has its default.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The editor's colours.
    pub theme: Theme,
    /// The cache folder, or `none` to keep results in memory alone.
    pub cache: Option<PathBuf>,
    /// Bytes that results may take in memory; in the file a number or text such as `"2GiB"`.
    #[serde(with = "memory::setting")]
    pub memory: Option<u64>,
    /// Folders of plugins beside the user's own.
    pub plugins: Vec<PathBuf>,
    /// Names of plugins that run in processes of their own.
    pub isolate: Vec<String>,
    /// Graphs that the editor had open, the latest first.
    pub recent: Vec<PathBuf>,
}

/// The editor's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// As the system has them.
    #[default]
    System,
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
}

/// Options of the file's language: what may be left out is written without `Some`.
fn language() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

impl Settings {
    /// Where the settings lie; `None` on a system that tells no folder for them.
    #[must_use]
    pub fn file() -> Option<PathBuf> {
        Some(etcetera::choose_base_strategy().ok()?.config_dir().join("orograph").join("settings.ron"))
    }

    /// The user's settings; where there is no file the defaults.
    ///
    /// # Errors
    /// [`Error::Refused`] when the file cannot be read, or says what no setting is.
    pub fn load() -> Result<Self, Error> {
        Self::file().map_or_else(|| Ok(Self::default()), |file| Self::load_from(&file))
    }

    /// As [`load`](Self::load), from a file.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn load_from(file: &Path) -> Result<Self, Error> {
        let text = match fs::read_to_string(file) {
            Ok(text) => text,
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                return Ok(Self::default());
            }
            Err(error) => {
                let message = format!("reading {}: {error}", file.display());
                return Err(Error::refused(message, "make the settings readable, or move them away"));
            }
        };
        Self::parse(&text, file)
    }

    /// As [`load_from`](Self::load_from), from the text of the file.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(text: &str, file: &Path) -> Result<Self, Error> {
        let mut settings: Self = language().from_str(text).map_err(|error| {
            // The error begins with its line and column.
            let message = format!("{}:{error}", file.display());
            Error::refused(
                message,
                "write settings such as (memory: \"4GiB\", isolate: [\"Name of a plugin\"])",
            )
        })?;
        settings.start_paths_from(file.parent().unwrap_or(Path::new("")));
        Ok(settings)
    }

    /// Relative paths count from the file, wherever a program is started.
    fn start_paths_from(&mut self, folder: &Path) {
        let cache = self.cache.iter_mut().filter(|cache| **cache != Path::new(NONE));
        for path in cache.chain(&mut self.plugins).chain(&mut self.recent) {
            *path = folder.join(&path);
        }
    }

    /// Writes the whole file anew, at once. Comments in it are lost.
    ///
    /// # Errors
    /// [`Error::Failed`] when it cannot be written; the file is then as it was.
    pub fn save(&self) -> Result<(), Error> {
        let file = Self::file()
            .ok_or_else(|| Error::Failed("this system tells no folder for a user's settings".into()))?;
        self.save_to(&file)
    }

    /// As [`save`](Self::save), to a file.
    ///
    /// # Errors
    /// As [`save`](Self::save).
    pub fn save_to(&self, file: &Path) -> Result<(), Error> {
        let failed =
            |error: &dyn std::fmt::Display| Error::Failed(format!("writing {}: {error}", file.display()));
        let text =
            language().to_string_pretty(self, PrettyConfig::default()).map_err(|error| failed(&error))?;
        save_whole(file, (text + "\n").as_bytes()).map_err(|error| failed(&error))
    }

    /// Changes one thing of the user's settings as they are now in the file, which another program may have written
    /// since they were loaded.
    ///
    /// # Errors
    /// As [`load`](Self::load) and [`save`](Self::save).
    pub fn change(change: impl FnOnce(&mut Self)) -> Result<Self, Error> {
        let mut settings = Self::load()?;
        change(&mut settings);
        settings.save()?;
        Ok(settings)
    }

    /// As [`change`](Self::change), in a file.
    ///
    /// # Errors
    /// As [`change`](Self::change).
    pub fn change_in(file: &Path, change: impl FnOnce(&mut Self)) -> Result<Self, Error> {
        let mut settings = Self::load_from(file)?;
        change(&mut settings);
        settings.save_to(file)?;
        Ok(settings)
    }

    /// Puts a graph first among the [`recent`](Self::recent) ones, of which the oldest goes where there are too many.
    pub fn opened(&mut self, graph: &Path) {
        let graph = std::path::absolute(graph).unwrap_or_else(|_| graph.to_owned());
        self.recent.retain(|known| *known != graph);
        self.recent.insert(0, graph);
        self.recent.truncate(MOST_RECENT);
    }

    /// Takes a graph that is gone off the [`recent`](Self::recent) ones.
    pub fn forget(&mut self, graph: &Path) {
        self.recent.retain(|known| known != graph);
    }

    /// The folder that the cache lies in: as `said`, as `OROGRAPH_CACHE` says, as the settings say, or the user's; `None`
    /// for memory alone.
    #[must_use]
    pub fn cache_folder(&self, said: Option<&Path>) -> Option<PathBuf> {
        let environment = std::env::var_os("OROGRAPH_CACHE").map(PathBuf::from);
        let named = [said, environment.as_deref(), self.cache.as_deref()];
        match named.into_iter().flatten().find(|folder| !folder.as_os_str().is_empty()) {
            Some(folder) if folder == Path::new(NONE) => None,
            Some(folder) => Some(folder.to_owned()),
            None => Self::usual_cache_folder(),
        }
    }

    /// The folder that the cache lies in when nobody says; `None` on a system that tells no folder for caches.
    #[must_use]
    pub fn usual_cache_folder() -> Option<PathBuf> {
        Some(etcetera::choose_base_strategy().ok()?.cache_dir().join("orograph"))
    }

    /// Bytes that results may take in memory: as `said`, as the settings say, or as fits the machine.
    #[must_use]
    pub fn memory_budget(&self, said: Option<u64>) -> u64 {
        said.or(self.memory).unwrap_or_else(memory::default_memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        fs::write(&file, text).unwrap();
        Settings::load_from(&file).unwrap_err().to_string()
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/er/settings.ron");
        assert_eq!(Settings::load_from(&file).unwrap(), Settings::default(), "no file is no error");
        let settings = Settings {
            theme: Theme::Dark,
            cache: Some("/tmp/cache".into()),
            memory: Some(3 << 30),
            plugins: vec!["/opt/plugins".into()],
            isolate: vec!["Coast \"lines\"".into()],
            recent: vec!["/home/a/b.ron".into()],
        };
        for settings in [settings, Settings::default()] {
            settings.save_to(&file).unwrap();
            assert_eq!(
                Settings::load_from(&file).unwrap(),
                settings,
                "{}",
                fs::read_to_string(&file).unwrap()
            );
        }
        assert!(!fs::read_to_string(&file).unwrap().contains("enable"), "no extensions to be switched on");
    }

    #[test]
    fn a_file_says_what_it_likes_and_paths_count_from_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        let load = |text: &str| {
            fs::write(&file, text).unwrap();
            Settings::load_from(&file).unwrap()
        };
        let settings = load("// mine\n(memory: \"2GiB\", cache: \"c\", plugins: [\"p\", \"/q\"])");
        assert_eq!(settings.memory, Some(2 << 30));
        assert_eq!(settings.cache, Some(folder.path().join("c")));
        assert_eq!(settings.plugins, [folder.path().join("p"), "/q".into()]);
        assert_eq!(load("(memory: 1000, cache: Some(\"none\"))").memory, Some(1000));
        assert_eq!(load("(cache: \"none\")").cache, Some("none".into()));
        assert_eq!(
            load("(theme: Light, memory: None)"),
            Settings { theme: Theme::Light, ..Settings::default() }
        );
    }

    #[test]
    fn what_is_no_setting_is_refused_with_its_place() {
        for (text, said) in [
            ("(insulate: [])", ":1:"),
            ("(insulate: [])", "insulate"),
            ("(\n  memory: \"much\")", ":2:"),
            ("(memory: \"much\")", "`much` is no size"),
            ("(memory: -1)", "not negative"),
            ("(theme: Blue)", "Blue"),
            ("", ":1:"),
        ] {
            let refusal = refusal(text);
            assert!(refusal.contains(said), "{text}: {refusal}");
        }
    }

    #[test]
    fn a_change_keeps_what_others_wrote_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        Settings { memory: Some(7), ..Settings::default() }.save_to(&file).unwrap();
        let changed = Settings::change_in(&file, |settings| settings.theme = Theme::Dark).unwrap();
        assert_eq!((changed.memory, changed.theme), (Some(7), Theme::Dark));
        assert_eq!(Settings::load_from(&file).unwrap(), changed);
        fs::write(&file, "(theme: Blue)").unwrap();
        Settings::change_in(&file, |settings| settings.theme = Theme::Dark).unwrap_err();
        assert_eq!(fs::read_to_string(&file).unwrap(), "(theme: Blue)", "what cannot be read is left alone");
    }

    #[test]
    fn recent_graphs_stand_once_the_latest_first_and_no_more_than_a_few() {
        let mut settings = Settings::default();
        for n in 0..MOST_RECENT + 3 {
            settings.opened(Path::new(&format!("graph-{n}.ron")));
        }
        assert_eq!(settings.recent.len(), MOST_RECENT);
        assert!(settings.recent.iter().all(|graph| graph.is_absolute()));
        let old = settings.recent[5].clone();
        settings.opened(&old);
        assert_eq!((&settings.recent[0], settings.recent.len()), (&old, MOST_RECENT));
        assert_eq!(settings.recent.iter().filter(|graph| **graph == old).count(), 1);
        settings.forget(&old);
        assert!(!settings.recent.contains(&old));
    }

    #[test]
    fn what_is_said_goes_before_the_settings() {
        let settings = Settings { cache: Some("/settled".into()), memory: Some(7), ..Settings::default() };
        assert_eq!(settings.cache_folder(Some(Path::new("/said"))), Some("/said".into()));
        assert_eq!(settings.cache_folder(Some(Path::new("none"))), None);
        assert_eq!((settings.memory_budget(Some(5)), settings.memory_budget(None)), (5, 7));
        assert_eq!(Settings::default().memory_budget(None), memory::default_memory());
    }
}
