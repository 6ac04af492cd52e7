//! Nodes run by hand, without a graph and a run.

use std::path::{Path, PathBuf};

use orograph_core::{Error, Host, OutputStream, Result};
use orograph_engine::eval::OutputFolder;

use crate::memory::default_memory;

/// Lets readers read any file, and writers write into one folder.
pub struct FolderHost(OutputFolder);

impl FolderHost {
    /// A host whose writers write into `folder`, which is made when the first file is.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self(OutputFolder::new(folder))
    }

    /// An error of a node that wrote here, naming the file as the user finds it.
    #[must_use]
    pub fn located(&self, error: Error) -> Error {
        self.0.located(error)
    }
}

impl Host for FolderHost {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        default_memory()
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Ok(path.into())
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        self.0.create(path)
    }
}
