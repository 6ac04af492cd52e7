//! What the commands share: loading a graph with its settings, and what the options say to `orograph-session`.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use indexmap::IndexMap;
use orograph_core::Context;
use orograph_engine::{
    CancelToken, CompileOptions, Compiled, Document, Evaluator, Registry, compile, document::read_file,
    plugin::Limits,
};
use orograph_session::{Settings, plugins, vars};

use crate::{
    arguments::{EvaluationOptions, GraphSettings, PluginOptions},
    console,
    failure::Failure,
};

/// What the options say of plugins, to be remembered below the cache folder that `cache` names.
pub(crate) fn plugin_options(
    options: &PluginOptions,
    cache: Option<&Path>,
) -> orograph_session::PluginOptions {
    orograph_session::PluginOptions {
        folders: options.plugins.clone(),
        isolate: options.isolate,
        limits: Limits {
            silence: Duration::from_secs(options.isolate_silence),
            time: options.isolate_timeout.map(Duration::from_secs),
            memory: options.isolate_memory,
        },
        cache: cache.map(Path::to_owned),
        again: false,
    }
}

/// The built-in node types and those of plugins.
pub(crate) fn registry(options: &PluginOptions, cache: Option<&Path>) -> Result<Registry, Failure> {
    let (registry, found) = orograph_session::registry(&plugin_options(options, cache), &Settings::load()?)?;
    for complaint in found.iter().filter_map(plugins::complaint) {
        console::note(&format!("warning: {complaint}"));
    }
    Ok(registry)
}

/// A graph file with its settings applied.
pub(crate) fn load(settings: &GraphSettings, registry: &Registry) -> Result<Compiled, Failure> {
    load_noting(settings, registry, &|_| {})
}

/// As [`load`]; `note` hears of every graph file that is read beside the first.
pub(crate) fn load_noting(
    settings: &GraphSettings,
    registry: &Registry,
    note: &dyn Fn(&Path),
) -> Result<Compiled, Failure> {
    let document = Document::load(&settings.graph)?;
    compile_noting(&document, settings, &[], registry, note)
}

/// A document with the settings of the command line applied, and `more` after them.
pub(crate) fn compile_with(
    document: &Document,
    settings: &GraphSettings,
    more: &[(String, String)],
    registry: &Registry,
) -> Result<Compiled, Failure> {
    compile_noting(document, settings, more, registry, &|_| {})
}

fn compile_noting(
    document: &Document,
    settings: &GraphSettings,
    more: &[(String, String)],
    registry: &Registry,
    note: &dyn Fn(&Path),
) -> Result<Compiled, Failure> {
    let mut overrides = settings.vars.as_deref().map_or_else(|| Ok(Vec::new()), vars::load)?;
    for text in &settings.set {
        let Some((name, value)) = text.split_once('=') else {
            return Err(Failure::usage(format!("`--set {text}` has no `=`"), "write --set node.param=value"));
        };
        overrides.push((name.trim().to_owned(), value.to_owned()));
    }
    overrides.extend_from_slice(more);
    // The last word on a parameter holds.
    let overrides: IndexMap<String, String> = overrides.into_iter().collect();
    let options = CompileOptions {
        base_dir: folder_of(&settings.graph),
        overrides: overrides.into_iter().collect(),
        loader: &|path| {
            note(path);
            read_file(path)
        },
    };
    Ok(compile(document, registry, &options)?)
}

fn folder_of(file: &Path) -> PathBuf {
    file.parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// An evaluator as the options and the settings describe it.
pub(crate) fn evaluator(options: &EvaluationOptions) -> Result<Evaluator, Failure> {
    let settings = Settings::load()?;
    let (evaluator, warning) = orograph_session::evaluator(
        settings.memory_budget(options.memory),
        settings.cache_folder(options.cache.as_deref()).as_deref(),
        usize::from(options.jobs),
    )?;
    if let Some(warning) = warning {
        console::note(&format!("warning: {warning}"));
    }
    Ok(evaluator)
}

/// The run's context.
pub(crate) fn context(options: &EvaluationOptions) -> Context {
    Context { seed: options.seed, resolution: options.resolution }
}

/// A token that Ctrl-C and a termination signal use; a second one ends the program at once.
pub(crate) fn cancel_on_signal() -> CancelToken {
    let token = CancelToken::new();
    let asked = token.clone();
    let result = ctrlc::set_handler(move || {
        if asked.is_cancelled() {
            std::process::exit(3);
        }
        asked.cancel();
    });
    if let Err(error) = result {
        console::note(&format!("warning: Ctrl-C will not stop the run cleanly: {error}"));
    }
    token
}
