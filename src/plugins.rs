//! Where plugins lie, and what the user has settled about them.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use etcetera::BaseStrategy;
use orograph_engine::{
    Registry,
    plugin::{Found, Limits, Plugins, Program},
};
use serde::Deserialize;

use crate::{arguments::PluginOptions, console, failure::Failure, session};

/// The user's settings, `settings.ron` in the folder of their configuration.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Names of plugins that run in processes of their own.
    #[serde(default)]
    isolate: Vec<String>,
}

/// Registers the plugins of every folder there is.
pub(crate) fn register(
    options: &PluginOptions,
    cache: Option<&Path>,
    again: bool,
    registry: &mut Registry,
) -> Result<Vec<Found>, Failure> {
    let libraries = libraries(options)?;
    if libraries.is_empty() {
        return Ok(Vec::new());
    }
    let settings = settings()?;
    let apart = |name: &str| options.isolate || settings.isolate.iter().any(|isolated| isolated == name);
    let silence = Duration::from_secs(options.isolate_silence);
    let time = options.isolate_timeout.map(Duration::from_secs);
    let limits = Limits { silence, time, memory: options.isolate_memory };
    let plugins = plugins(cache, limits)?.scanning_again(again);
    Ok(plugins.register(&libraries, registry, &apart))
}

/// The plugins of this program, with a place to remember them.
pub(crate) fn plugins(cache: Option<&Path>, limits: Limits) -> Result<Plugins, Failure> {
    let said = cache.map(Path::to_owned).or_else(|| std::env::var_os("OROGRAPH_CACHE").map(PathBuf::from));
    let cache = session::cache_folder(said.as_deref());
    let plugins = Plugins::new(cache.as_deref(), program()?)
        .map_err(|error| Failure::Other(format!("no folder to keep plugins in: {error}")))?;
    Ok(plugins.with_limits(limits))
}

fn program() -> Result<Program, Failure> {
    let executable = std::env::current_exe()
        .map_err(|error| Failure::Other(format!("this program cannot find itself: {error}")))?;
    Ok(Program { executable, arguments: vec!["plugin-host".into()] })
}

/// The folders of plugins: those of the command line, of `OROGRAPH_PLUGINS`, and the user's own.
pub(crate) fn folders(options: &PluginOptions) -> Vec<PathBuf> {
    let mut folders = options.plugins.clone();
    folders.extend(folders_of_environment());
    folders.extend(own_folder().filter(|folder| folder.is_dir()));
    folders
}

fn folders_of_environment() -> Vec<PathBuf> {
    let folders = std::env::var_os("OROGRAPH_PLUGINS").unwrap_or_default();
    std::env::split_paths(&folders).filter(|folder| !folder.as_os_str().is_empty()).collect()
}

/// The libraries in the folders.
fn libraries(options: &PluginOptions) -> Result<Vec<PathBuf>, Failure> {
    let mut libraries = Vec::new();
    for folder in folders(options) {
        match Plugins::in_folder(&folder) {
            Ok(found) => libraries.extend(found),
            Err(error) if options.plugins.contains(&folder) => {
                return Err(Failure::usage(
                    format!("reading the plugins in {}: {error}", folder.display()),
                    "give the folder that the plugins' libraries lie in",
                ));
            }
            Err(error) => console::note(&format!("warning: no plugins of {}: {error}", folder.display())),
        }
    }
    let mut seen = Vec::new();
    libraries.retain(|path| {
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.clone());
        let new = !seen.contains(&place);
        seen.push(place);
        new
    });
    Ok(libraries)
}

/// The user's own folder of plugins.
pub(crate) fn own_folder() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.data_dir().join("orograph").join("plugins"))
}

fn settings() -> Result<Settings, Failure> {
    let Ok(base) = etcetera::choose_base_strategy() else { return Ok(Settings::default()) };
    let file = base.config_dir().join("orograph").join("settings.ron");
    let Ok(text) = fs::read_to_string(&file) else { return Ok(Settings::default()) };
    ron::from_str(&text).map_err(|error| {
        // The error begins with its line and column.
        let message = format!("{}:{error}", file.display());
        Failure::usage(message, "write settings such as (isolate: [\"Name of a plugin\"])")
    })
}
