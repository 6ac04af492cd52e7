//! Values in a file of shared memory.

use std::{fs::File, io, os::unix::fs::FileExt, path::PathBuf};

use orograph_core::{Job, Result as NodeResult, Value};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tempfile::TempPath;

use crate::plugin::host::defect;

/// Where a value's byte form lies: its head, then, on a boundary, its cells.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Span {
    pub(super) head: u64,
    pub(super) head_len: u64,
    pub(super) payload: u64,
    pub(super) payload_len: u64,
}

/// Cells begin on a multiple of this.
const BOUNDARY: u64 = 64;
/// What one thread copies at a time.
const CHUNK: usize = 4 << 20;

/// A file that two processes share, and the name that the other one opens it by.
pub(super) struct SharedFile {
    pub(super) file: File,
    pub(super) path: PathBuf,
    /// Where it has a name of its own, that goes with this.
    _name: Option<TempPath>,
}

impl SharedFile {
    /// An empty file: of memory, where the system has such files, and of no size that a mounted folder bounds.
    pub(super) fn new() -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(memory) = rustix::fs::memfd_create("orograph plugin", rustix::fs::MemfdFlags::CLOEXEC) {
            use std::os::fd::AsRawFd;
            let path = format!("/proc/{}/fd/{}", std::process::id(), memory.as_raw_fd()).into();
            return Ok(Self { file: memory.into(), path, _name: None });
        }
        let (file, name) = tempfile::NamedTempFile::new()?.into_parts();
        Ok(Self { file, path: name.to_path_buf(), _name: Some(name) })
    }
}

/// Writes values one after the other.
pub(super) struct Writer<'a> {
    file: &'a File,
    end: u64,
}

impl<'a> Writer<'a> {
    pub(super) fn new(file: &'a File) -> Self {
        Self { file, end: 0 }
    }

    /// Bytes written.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    pub(super) fn put(&mut self, value: &Value) -> io::Result<Span> {
        let encoded = value.encode();
        let (head, head_len) = (self.end, encoded.head.len() as u64);
        let payload = (head + head_len).next_multiple_of(BOUNDARY);
        self.file.write_all_at(&encoded.head, head)?;
        encoded
            .payload
            .par_chunks(CHUNK)
            .enumerate()
            .try_for_each(|(index, bytes)| self.file.write_all_at(bytes, payload + (index * CHUNK) as u64))?;
        let payload_len = encoded.payload.len() as u64;
        self.end = (payload + payload_len).next_multiple_of(BOUNDARY);
        Ok(Span { head, head_len, payload, payload_len })
    }
}

/// Reads a value that a worker wrote, trusting nothing that it says.
pub(super) fn take(file: &File, span: Span, job: &Job) -> NodeResult<Value> {
    let broken = || defect("the plugin's process gave an output that cannot be read");
    let len = file.metadata().map_err(|_| broken())?.len();
    let inside = |start: u64, bytes: u64| start.checked_add(bytes).is_some_and(|end| end <= len);
    // Where there are no cells, the file may end before they would begin.
    let cells_inside = span.payload_len == 0 || inside(span.payload, span.payload_len);
    if !inside(span.head, span.head_len) || !cells_inside {
        return Err(broken());
    }
    job.admit(span.head_len.saturating_add(span.payload_len), || "an output of the plugin".into())?;
    let mut head = vec![0; span.head_len as usize];
    file.read_exact_at(&mut head, span.head).map_err(|_| broken())?;
    let value = Value::decode_filled(&head, span.payload_len as usize, |bytes| {
        let chunks = bytes.par_chunks_mut(CHUNK).enumerate();
        let read =
            chunks.map(|(index, bytes)| file.read_exact_at(bytes, span.payload + (index * CHUNK) as u64));
        read.collect::<io::Result<()>>().is_ok()
    });
    value.map_err(|_| broken())
}
