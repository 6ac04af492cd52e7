//! A host that keeps written files in memory.

use std::{
    collections::BTreeMap,
    io::{Cursor, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use orograph_core::{Error, Host, OutputStream, Result};

/// Finished files by name.
type Files = Arc<Mutex<BTreeMap<String, Vec<u8>>>>;

/// A host without disk.
#[derive(Default)]
pub(crate) struct MemoryHost {
    /// Whether every question is answered with "cancelled".
    pub(crate) cancelled: AtomicBool,
    /// What was written and finished.
    pub(crate) files: Files,
}

impl MemoryHost {
    /// What was written and finished, by name.
    pub(crate) fn written(&self) -> BTreeMap<String, Vec<u8>> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Host for MemoryHost {
    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
    fn progress(&self, done: f64) {
        assert!((0.0..=1.0).contains(&done), "it reports progress of {done}");
    }
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        1 << 30
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Err(Error::reading(path, "there are no files here"))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Ok(Box::new(MemoryFile { name: path.into(), bytes: Cursor::default(), files: self.files.clone() }))
    }
}

struct MemoryFile {
    name: String,
    bytes: Cursor<Vec<u8>>,
    files: Files,
}

impl Write for MemoryFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes.write(bytes)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for MemoryFile {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.bytes.seek(to)
    }
}

impl OutputStream for MemoryFile {
    fn finish(self: Box<Self>) -> Result<()> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).insert(self.name, self.bytes.into_inner());
        Ok(())
    }
}
