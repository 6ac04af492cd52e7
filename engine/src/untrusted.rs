//! What the engine reads of what others wrote, as functions on bytes: for fuzzing, and the tests that repeat what it
//! found. Nobody else should need them.

use orograph_abi::PluginSpec;
use orograph_core::{Digest, Value};

use crate::cache::{Record, item_bytes, item_in, value_in};

/// Whether a library can be a plugin, by its headers and symbols alone.
///
/// # Errors
/// A line that says why not.
pub fn library(bytes: &[u8]) -> Result<(), String> {
    crate::plugin::examine(bytes)
}

/// What a plugin says of itself.
///
/// # Errors
/// A line that says why nodes cannot be made of it.
pub fn plugin_spec(text: &str) -> Result<PluginSpec, String> {
    crate::plugin::spec_in(text)
}

/// The value in a cache's file of a value.
#[must_use]
pub fn cached_value(file: &[u8], digest: &Digest) -> Option<Value> {
    value_in(file, digest)
}

/// The record in a cache's file of a record.
#[must_use]
pub fn cached_record(file: &[u8], key: &Digest) -> Option<Record> {
    item_in(file, key)
}

/// The cache's file of a record.
#[must_use]
pub fn record_file(key: &Digest, record: &Record) -> Option<Vec<u8>> {
    item_bytes(key, record)
}

/// The content of such a file, without what guards it: its checksum keeps a fuzzer from ever getting so far.
#[must_use]
pub fn record_content(bytes: &[u8]) -> Option<Record> {
    postcard::from_bytes(bytes).ok()
}
