//! The engine's side of a running node.

use std::{
    path::PathBuf,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use orograph_core::{Digest, Error, Host, OutputStream, Result};

use super::{output::OutputFolder, run::Run};
use crate::{cache::WrittenFile, graph::NodeId};

/// Serves one run of one node.
pub(crate) struct TaskHost<'a> {
    run: &'a Run,
    node: NodeId,
    action: Digest,
    folder: OutputFolder,
    /// It was told to stop. That stands, whoever else comes to want it: some of its work may be left out already.
    stopped: AtomicBool,
    warnings: Mutex<Vec<String>>,
    written: Arc<Mutex<Vec<WrittenFile>>>,
}

impl<'a> TaskHost<'a> {
    pub(crate) fn new(run: &'a Run, node: NodeId, action: Digest) -> Self {
        let folder = run.folder.clone();
        let (stopped, warnings, written) = Default::default();
        Self { run, node, action, folder, stopped, warnings, written }
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
        if !self.run.cancel.is_cancelled() {
            return false;
        }
        if !self.stopped.load(Ordering::Acquire) && self.run.goes_on_for_others(self.node.0, &self.action) {
            return false;
        }
        self.stopped.store(true, Ordering::Release);
        true
    }
    fn progress(&self, done: f64) {
        self.run.progress(self.node, done);
        for (run, node) in self.run.shared.in_flight.wanted_by(&self.action) {
            if let Some(run) = run.upgrade() {
                run.progress(NodeId(node), done);
            }
        }
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
        self.run.node(self.node.0).input_path(path)
    }
    fn companion(&self, path: &str, name: &str) -> Result<Option<PathBuf>> {
        self.run.node(self.node.0).companion(path, name)
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        if self.run.node(self.node.0).spec().is_some_and(|spec| spec.writes) {
            return self.folder.create_noted(path, &self.written);
        }
        Err(Error::writing(path, "the node does not declare that it writes files"))
    }
}
