//! Where plugins lie, where they run, and this program as the process that they are looked at in.

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use etcetera::BaseStrategy;
use orograph_engine::{
    Registry,
    plugin::{Found, Limits, Plugins, Program},
};

use crate::{Error, Settings};

/// The first argument of this program when it is started to look at a plugin or to run one.
const SUBCOMMAND: &str = "plugin-host";

/// Which plugins there are beside those of the settings, and where they run.
#[derive(Clone, Debug, Default)]
pub struct PluginOptions {
    /// Folders that the user named; one that cannot be read is an error.
    pub folders: Vec<PathBuf>,
    /// Whether every plugin runs in a process of its own, and not those alone that the settings name.
    pub isolate: bool,
    /// What such a plugin may take.
    pub limits: Limits,
    /// The cache folder as the user named it; see [`Settings::cache_folder`].
    pub cache: Option<PathBuf>,
    /// Whether to look at every library anew, whatever is remembered of it.
    pub again: bool,
}

/// Registers the plugins of every folder there is. What became of each library is told, and of each folder that cannot
/// be read.
///
/// # Errors
/// [`Error::Refused`] for a folder of the options that cannot be read, [`Error::Failed`] when there is nowhere to keep
/// plugins.
pub fn register(
    options: &PluginOptions,
    settings: &Settings,
    registry: &mut Registry,
) -> Result<Vec<Found>, Error> {
    let (libraries, mut found) = libraries(options, settings)?;
    if libraries.is_empty() {
        return Ok(found);
    }
    let cache = settings.cache_folder(options.cache.as_deref());
    let apart = |name: &str| options.isolate || settings.isolate.iter().any(|isolated| isolated == name);
    let plugins = plugins(cache.as_deref(), options.limits)?.scanning_again(options.again);
    found.extend(plugins.register(&libraries, registry, &apart));
    Ok(found)
}

/// What is worth a warning of a library, or of a folder, that was found.
#[must_use]
pub fn complaint(found: &Found) -> Option<String> {
    let path = found.path.display();
    match &found.outcome {
        Ok(_) => None,
        Err(reason) if found.path.is_file() => Some(format!("the plugin {path} is refused: {reason}")),
        Err(reason) => Some(format!("no plugins of {path}: {reason}")),
    }
}

/// Plugins that this program looks at, remembered below the folder `cache`.
///
/// # Errors
/// [`Error::Failed`] when there is nowhere to keep them.
pub fn plugins(cache: Option<&Path>, limits: Limits) -> Result<Plugins, Error> {
    let plugins = Plugins::new(cache, program()?)
        .map_err(|error| Error::Failed(format!("no folder to keep plugins in: {error}")))?;
    Ok(plugins.with_limits(limits))
}

/// This program, started so that [`serve`] serves.
fn program() -> Result<Program, Error> {
    let executable = std::env::current_exe()
        .map_err(|error| Error::Failed(format!("this program cannot find itself: {error}")))?;
    Ok(Program { executable, arguments: vec![SUBCOMMAND.into()] })
}

/// Serves another process of this program, if that is what it was started for with the arguments that follow its name.
/// A `main` calls this before it looks at its arguments, and ends with the code where there is one.
#[must_use]
pub fn serve(arguments: impl IntoIterator<Item = OsString>) -> Option<ExitCode> {
    let mut arguments = arguments.into_iter();
    (arguments.next()? == SUBCOMMAND).then(|| orograph_engine::plugin::serve(&arguments.collect::<Vec<_>>()))
}

/// The folders of plugins: those of the options, of `OROGRAPH_PLUGINS`, of the settings, and the user's own.
#[must_use]
pub fn folders(options: &PluginOptions, settings: &Settings) -> Vec<PathBuf> {
    let mut folders = options.folders.clone();
    let environment = std::env::var_os("OROGRAPH_PLUGINS").unwrap_or_default();
    folders.extend(std::env::split_paths(&environment).filter(|folder| !folder.as_os_str().is_empty()));
    folders.extend(settings.plugins.iter().cloned());
    folders.extend(own_folder().filter(|folder| folder.is_dir()));
    folders
}

/// The user's own folder of plugins.
#[must_use]
pub fn own_folder() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.data_dir().join("orograph").join("plugins"))
}

/// The libraries in the folders, each once, and the folders that cannot be read.
fn libraries(options: &PluginOptions, settings: &Settings) -> Result<(Vec<PathBuf>, Vec<Found>), Error> {
    let (mut libraries, mut unread) = (Vec::new(), Vec::new());
    for folder in folders(options, settings) {
        match Plugins::in_folder(&folder) {
            Ok(found) => libraries.extend(found),
            Err(error) if options.folders.contains(&folder) => {
                return Err(Error::refused(
                    format!("reading the plugins in {}: {error}", folder.display()),
                    "give the folder that the plugins' libraries lie in",
                ));
            }
            Err(error) => unread.push(Found { path: folder, outcome: Err(error.to_string()) }),
        }
    }
    let mut seen = Vec::new();
    libraries.retain(|path| {
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.clone());
        let new = !seen.contains(&place);
        seen.push(place);
        new
    });
    Ok((libraries, unread))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_the_user_names_must_be_there_and_one_of_the_settings_is_worth_a_word() {
        let gone = PathBuf::from("no/such/folder");
        let mut registry = Registry::default();
        let named = PluginOptions { folders: vec![gone.clone()], ..PluginOptions::default() };
        let refused = register(&named, &Settings::default(), &mut registry).unwrap_err();
        assert!(refused.to_string().contains("no/such/folder"), "{refused}");
        let settings = Settings { plugins: vec![gone.clone()], ..Settings::default() };
        assert!(folders(&PluginOptions::default(), &settings).contains(&gone));
        let found = register(&PluginOptions::default(), &settings, &mut registry).unwrap();
        let told: Vec<_> = found.iter().filter_map(complaint).collect();
        assert!(told.iter().any(|told| told.starts_with("no plugins of no/such/folder: ")), "{told:?}");
    }

    #[test]
    fn only_its_own_subcommand_is_served() {
        let arguments = |words: &[&str]| words.iter().map(OsString::from).collect::<Vec<_>>();
        assert!(serve(arguments(&[])).is_none());
        assert!(serve(arguments(&["run", SUBCOMMAND])).is_none());
        assert!(serve(arguments(&[SUBCOMMAND, "dance"])).is_some(), "served, if only with a refusal");
    }
}
