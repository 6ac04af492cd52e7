//! What Orograph's command line and its editor share, so that both do the same: the user's settings, plugins, node
//! types, evaluators, and the choice of what a run makes of a graph.
//!
//! Nothing here prints or parses a command line. What a front end is to show comes as an [`Error`], or as text beside
//! the result.

mod error;
mod folder_host;
pub mod headless;
pub mod memory;
pub mod pictures;
pub mod plugins;
pub mod settings;
pub mod tables;
pub mod targets;
pub mod vars;

use std::path::Path;

use orograph_engine::{Cache, DiskTier, Evaluator, Registry, plugin::Found};

pub use error::Error;
pub use folder_host::FolderHost;
pub use plugins::PluginOptions;
pub use settings::Settings;
pub use targets::Targets;

/// The built-in node types.
///
/// # Errors
/// [`Error::Failed`] when two of them have one id, which a test rules out.
pub fn built_in() -> Result<Registry, Error> {
    Registry::new(orograph_nodes::all()).map_err(|clash| Error::Failed(clash.to_string()))
}

/// The built-in node types and those of plugins, with what became of each library; [`plugins::complaint`] words what
/// is worth a warning.
///
/// # Errors
/// As [`plugins::register`].
pub fn registry(options: &PluginOptions, settings: &Settings) -> Result<(Registry, Vec<Found>), Error> {
    let mut registry = built_in()?;
    let found = plugins::register(options, settings, &mut registry)?;
    Ok((registry, found))
}

/// An evaluator that holds values of `memory` bytes over the folder `cache`, on `jobs` threads; 0 is one for each core.
/// Where the folder cannot be had it keeps results in memory alone, and the text says why.
///
/// # Errors
/// [`Error::Failed`] when no threads can be started.
pub fn evaluator(
    memory: u64,
    cache: Option<&Path>,
    jobs: usize,
) -> Result<(Evaluator, Option<String>), Error> {
    let opened = cache.map(|folder| {
        DiskTier::open(folder).map_err(|error| format!("no cache folder at {}: {error}", folder.display()))
    });
    let (disk, warning) = match opened {
        Some(Ok(disk)) => (Some(disk), None),
        Some(Err(warning)) => (None, Some(warning)),
        None => (None, None),
    };
    let evaluator = Evaluator::new(Cache::new(memory, disk), jobs)
        .map_err(|error| Error::Failed(format!("cannot start threads: {error}")))?;
    Ok((evaluator, warning))
}

/// Makes a write beyond the system's limit on file sizes an error, as on a full disk, instead of the process's end. To
/// be called first in `main`.
#[cfg(unix)]
pub fn outlive_file_size_limit() {
    // Whoever handles the signal lives; that it came, the failing write tells.
    let came = std::sync::Arc::default();
    // Failing that, the limit ends the process, as it does by default.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, came);
}

/// Nothing: this system has no such limit.
#[cfg(not(unix))]
pub fn outlive_file_size_limit() {}
