//! The engine's side of a node that runs in a section.

use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use orograph_core::{Host, Job, OutputPath, OutputStream, Result};

use crate::graph::GraphNode;

/// Serves one member through the job of the task.
pub(super) struct MemberHost<'a> {
    job: &'a Job<'a>,
    node: &'a GraphNode,
    warnings: Mutex<Vec<String>>,
}

impl<'a> MemberHost<'a> {
    pub(super) fn new(job: &'a Job<'a>, node: &'a GraphNode) -> Self {
        Self { job, node, warnings: Mutex::default() }
    }

    /// What the node told the user.
    pub(super) fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Host for MemberHost<'_> {
    fn cancelled(&self) -> bool {
        self.job.check().is_err()
    }
    // The task tells how far it is down the rows.
    fn progress(&self, _: f64) {}
    fn warn(&self, message: &str) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_owned());
        self.job.warn(message);
    }
    fn note(&self, message: &str) {
        self.job.note(message);
    }
    fn memory_limit(&self) -> u64 {
        self.job.memory_limit()
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        self.node.input_path(path)
    }
    fn companion(&self, path: &str, name: &str) -> Result<Option<PathBuf>> {
        self.node.companion(path, name)
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        self.job.create(&OutputPath(path.to_owned()))
    }
}

/// Serves a node that is asked, before the run, whether it is a source.
pub(super) struct Asking<'a> {
    pub(super) node: &'a GraphNode,
    pub(super) memory: u64,
}

impl Host for Asking<'_> {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        self.memory
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        self.node.input_path(path)
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(orograph_core::Error::writing(path, "the run has not begun"))
    }
}
