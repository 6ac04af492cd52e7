//! The engine's side of a running node.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use orograph_core::{Error, Host, OutputStream, Result};

use super::{output::OutputFolder, run::Run};
use crate::{
    cache::{WrittenFile, files::is_there},
    graph::NodeId,
};

/// Serves one run of one node.
pub(crate) struct TaskHost<'a> {
    run: &'a Run,
    node: NodeId,
    folder: OutputFolder,
    warnings: Mutex<Vec<String>>,
    written: Arc<Mutex<Vec<WrittenFile>>>,
}

impl<'a> TaskHost<'a> {
    pub(crate) fn new(run: &'a Run, node: NodeId) -> Self {
        Self { run, node, folder: run.folder.clone(), warnings: Mutex::default(), written: Arc::default() }
    }

    /// The node's error as the user meets it.
    pub(crate) fn located(&self, error: Error) -> Error {
        self.folder.located(error)
    }

    /// What the node said and wrote.
    pub(crate) fn into_traces(self) -> (Vec<String>, Vec<WrittenFile>) {
        let take = |list: &Mutex<Vec<WrittenFile>>| {
            std::mem::take(&mut *list.lock().unwrap_or_else(PoisonError::into_inner))
        };
        let mut warnings = self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner);
        // Parallel work may warn in any order; a record must not depend on it.
        warnings.sort_unstable();
        warnings.dedup();
        (warnings, take(&self.written))
    }
}

impl Host for TaskHost<'_> {
    fn cancelled(&self) -> bool {
        self.run.cancel.is_cancelled()
    }
    fn progress(&self, done: f64) {
        self.run.progress(self.node, done);
    }
    fn warn(&self, message: &str) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_owned());
    }
    fn note(&self, message: &str) {
        self.run.note(self.node, message);
    }
    fn memory_limit(&self) -> u64 {
        self.run.shared.cache.memory_budget()
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        self.run.request.graph.node(self.node).input_path(path)
    }
    fn companion(&self, path: &str, name: &str) -> Result<Option<PathBuf>> {
        let node = self.run.request.graph.node(self.node);
        let named = node.companions(&node.input_path(path)?)?.into_iter().find(|(other, _)| other == name);
        let Some((_, path)) = named else {
            let message = format!("the node does not declare that it reads `{name}` beside `{path}`");
            return Err(Error::invalid(message, "report it to the node's author"));
        };
        Ok(is_there(&path)?.then_some(path))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        if self.run.request.graph.node(self.node).spec().is_some_and(|spec| spec.writes) {
            return self.folder.create_noted(path, &self.written);
        }
        Err(Error::writing(path, "the node does not declare that it writes files"))
    }
}
