//! What nodes are measured on: they write into memory that is thrown away at once.

use std::{
    io::{self, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::atomic::{AtomicBool, Ordering},
};

use orograph_core::{Error, Host, OutputStream, Result};

/// A host whose files are nowhere.
#[derive(Default)]
pub(crate) struct Nowhere {
    /// Whether the node is to stop.
    pub(crate) cancelled: AtomicBool,
}

impl Host for Nowhere {
    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        8 << 30
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Err(Error::reading(path, "there are no files here"))
    }
    fn create(&self, _: &str) -> Result<Box<dyn OutputStream>> {
        Ok(Box::new(Nothing(io::Cursor::default())))
    }
}

struct Nothing(io::Cursor<Vec<u8>>);

impl Write for Nothing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Nothing {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

impl OutputStream for Nothing {
    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
