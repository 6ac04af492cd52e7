//! `orograph run --watch`: the run again, whenever something that it depends on changes.

use std::{
    cell::RefCell,
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    time::Duration,
};

use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};
use orograph_engine::{CancelToken, Compiled};
use orograph_session::{Settings, plugins::folders};

use super::run::once;
use crate::{arguments::RunOptions, console, failure::Failure, session};

/// How long a burst of changes may pause before it counts as over: a linker writes a library in several steps.
const SETTLED: Duration = Duration::from_millis(250);
/// How often the wait looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

pub(crate) fn run(options: &RunOptions) -> Result<(), Failure> {
    let cancel = session::cancel_on_signal();
    let mut evaluator = None;
    let mut watch = Watch::new()?;
    loop {
        let cache = options.evaluation.cache.as_deref();
        let files = RefCell::new(BTreeSet::from([options.settings.graph.clone()]));
        files.borrow_mut().extend(options.settings.vars.clone());
        let registry = session::registry(&options.evaluation.plugins, cache)?;
        let note = |path: &Path| {
            files.borrow_mut().insert(path.to_owned());
        };
        let run = session::load_noting(&options.settings, &registry, &note).and_then(|compiled| {
            files.borrow_mut().extend(inputs(&compiled));
            once(compiled, options, &registry, &mut evaluator, &cancel)
        });
        match run {
            Ok(()) => {}
            Err(Failure::Cancelled) => return Err(Failure::Cancelled),
            // The next change may mend it.
            Err(failure) => failure.tell(),
        }
        let plugins = session::plugin_options(&options.evaluation.plugins, cache);
        watch.follow(files.into_inner(), folders(&plugins, &Settings::load()?));
        if !options.evaluation.quiet {
            console::note("watching; Ctrl-C ends it");
        }
        let Some(changed) = watch.wait(&cancel) else { return Ok(()) };
        if !options.evaluation.quiet {
            console::note(&format!("{} changed", changed.display()));
        }
    }
}

/// The files that the graph's nodes read.
fn inputs(compiled: &Compiled) -> Vec<PathBuf> {
    let nodes = compiled.graph.nodes().iter();
    nodes.flat_map(|node| node.input_files().filter_map(|(_, name)| node.input_path(name).ok())).collect()
}

/// Follows files and folders.
struct Watch {
    watcher: RecommendedWatcher,
    events: Receiver<notify::Result<Event>>,
    watched: BTreeSet<PathBuf>,
    files: BTreeSet<PathBuf>,
    folders: BTreeSet<PathBuf>,
}

impl Watch {
    fn new() -> Result<Self, Failure> {
        let (sender, events) = channel();
        let watcher = notify::recommended_watcher(sender)
            .map_err(|error| Failure::Other(format!("changes of files cannot be watched: {error}")))?;
        let (watched, files, folders) = Default::default();
        Ok(Self { watcher, events, watched, files, folders })
    }

    /// Follows these from now on. A file is followed by its folder, since many programs write a new one in its place.
    fn follow(&mut self, files: BTreeSet<PathBuf>, folders: Vec<PathBuf>) {
        let whole = |path: &PathBuf| fs::canonicalize(path).or_else(|_| std::path::absolute(path)).ok();
        self.files = files.iter().filter_map(whole).collect();
        self.folders = folders.iter().filter_map(whole).collect();
        let parents = self.files.iter().filter_map(|file| file.parent().map(Path::to_owned));
        let wanted: BTreeSet<_> = parents.chain(self.folders.iter().cloned()).collect();
        for folder in wanted.difference(&self.watched) {
            if let Err(error) = self.watcher.watch(folder, RecursiveMode::NonRecursive) {
                console::note(&format!("warning: {} is not watched: {error}", folder.display()));
            }
        }
        for folder in self.watched.difference(&wanted) {
            // It may be gone.
            let _ = self.watcher.unwatch(folder);
        }
        self.watched = wanted;
    }

    /// Waits for a change of something that is followed, and for its end; what changed first, or `None` when the user
    /// ends it.
    fn wait(&self, cancel: &CancelToken) -> Option<PathBuf> {
        let mut changed = None;
        let mut quiet = Duration::ZERO;
        while !cancel.is_cancelled() {
            match self.events.recv_timeout(LOOK) {
                Ok(Ok(event)) => {
                    if let Some(path) = self.concerned(&event) {
                        quiet = Duration::ZERO;
                        changed.get_or_insert_with(|| path.clone());
                    }
                }
                // Something may have been missed.
                Ok(Err(error)) => {
                    quiet = Duration::ZERO;
                    changed
                        .get_or_insert_with(|| error.paths.into_iter().next().unwrap_or_else(|| ".".into()));
                }
                Err(RecvTimeoutError::Timeout) => quiet += LOOK,
                Err(RecvTimeoutError::Disconnected) => return None,
            }
            if changed.is_some() && quiet >= SETTLED {
                return changed;
            }
        }
        None
    }

    /// What is followed of the things that changed.
    fn concerned<'e>(&self, event: &'e Event) -> Option<&'e PathBuf> {
        let concerns = |path: &PathBuf| {
            self.files.contains(path) || path.parent().is_some_and(|folder| self.folders.contains(folder))
        };
        event.paths.iter().filter(|_| !event.kind.is_access()).find(|path| concerns(path))
    }
}
