//! Values in a file of shared memory.

use std::{
    fs::File,
    io,
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
};

use orograph_core::{Job, Result as NodeResult, Value};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

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

/// Where files of shared memory are made: in memory where the system has such a folder.
pub(super) fn folder() -> PathBuf {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() }
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
    if !inside(span.head, span.head_len) || !inside(span.payload, span.payload_len) {
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
