//! What the commands share: loading a graph with its settings, opening the cache, starting an evaluator.

use std::{
    fs,
    path::{Path, PathBuf},
};

use etcetera::BaseStrategy;
use indexmap::IndexMap;
use orograph_core::Context;
use orograph_engine::{
    Cache, CancelToken, CompileOptions, Compiled, DiskTier, Document, Evaluator, NodeId, Registry, compile,
    document::read_file,
};

use crate::{
    arguments::{EvaluationOptions, GraphSettings, PluginOptions},
    console,
    failure::Failure,
    plugins, size,
};

/// The built-in node types.
pub(crate) fn built_in() -> Result<Registry, Failure> {
    Registry::new(orograph_nodes::all()).map_err(|clash| Failure::Other(clash.to_string()))
}

/// The built-in node types and those of plugins.
pub(crate) fn registry(options: &PluginOptions, cache: Option<&Path>) -> Result<Registry, Failure> {
    let mut registry = built_in()?;
    for found in plugins::register(options, cache, false, &mut registry)? {
        if let Err(reason) = found.outcome {
            console::note(&format!("warning: the plugin {} is refused: {reason}", found.path.display()));
        }
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
    let mut overrides = vars(settings.vars.as_deref())?;
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

/// Refuses a graph in which one of `roots` needs a placeholder, unless its name is excused.
pub(crate) fn refuse_missing(
    compiled: &Compiled,
    roots: impl IntoIterator<Item = NodeId>,
    excused: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let graph = &compiled.graph;
    let mut stack: Vec<_> = roots.into_iter().collect();
    let mut seen = vec![false; graph.nodes().len()];
    while let Some(id) = stack.pop() {
        if std::mem::replace(&mut seen[id.index()], true) {
            continue;
        }
        if let Some(error) = compiled.missing.get(&id).filter(|_| !excused(&graph.node(id).name)) {
            return Err(error.clone().into());
        }
        stack.extend(graph.node(id).inputs.iter().flatten().map(|wire| wire.node));
    }
    Ok(())
}

fn folder_of(file: &Path) -> PathBuf {
    file.parent().map_or_else(PathBuf::new, Path::to_owned)
}

fn vars(file: Option<&Path>) -> Result<Vec<(String, String)>, Failure> {
    let Some(file) = file else { return Ok(Vec::new()) };
    let text = fs::read_to_string(file)
        .map_err(|error| Failure::usage(format!("reading {}: {error}", file.display()), "check the path"))?;
    let values: IndexMap<String, Box<ron::value::RawValue>> = ron::from_str(&text).map_err(|error| {
        // The error begins with its line and column.
        Failure::usage(format!("{}:{error}", file.display()), "write a map such as {\"keep\": 0.05}")
    })?;
    Ok(values.into_iter().map(|(name, value)| (name, value.get_ron().trim().to_owned())).collect())
}

/// The folder that the cache lies in: as said, or the user's; `None` for memory alone.
pub(crate) fn cache_folder(said: Option<&Path>) -> Option<PathBuf> {
    match said {
        Some(folder) if folder == Path::new("none") => None,
        Some(folder) => Some(folder.to_owned()),
        None => etcetera::choose_base_strategy().ok().map(|base| base.cache_dir().join("orograph")),
    }
}

/// An evaluator as the options describe it.
pub(crate) fn evaluator(options: &EvaluationOptions) -> Result<Evaluator, Failure> {
    let memory = options.memory.unwrap_or_else(size::default_memory);
    let disk = cache_folder(options.cache.as_deref()).and_then(|folder| match DiskTier::open(&folder) {
        Ok(disk) => Some(disk),
        Err(error) => {
            console::note(&format!("warning: no cache folder at {}: {error}", folder.display()));
            None
        }
    });
    Evaluator::new(Cache::new(memory, disk), usize::from(options.jobs))
        .map_err(|error| Failure::Other(format!("cannot start threads: {error}")))
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
