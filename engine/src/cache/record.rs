//! What is remembered of a computation: the digests of its outputs, not the outputs.

use std::path::PathBuf;

use orograph_core::{Digest, Value};
use serde::{Deserialize, Serialize};

/// The outcome of one computation, stored under its key.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The outputs, in the spec's order.
    pub outputs: Vec<StoredOutput>,
    /// The files that a writer wrote.
    pub files: Vec<WrittenFile>,
    /// What the node told the user.
    pub warnings: Vec<String>,
    /// How long the computation took, in microseconds.
    pub micros: u64,
}

/// One output of a [`Record`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredOutput {
    /// Digest of the value.
    pub digest: Digest,
    /// Bytes of the value's byte form.
    pub bytes: u64,
    /// The byte form itself, where it is small.
    pub inline: Option<Vec<u8>>,
}

/// A file that a writer put into the output folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WrittenFile {
    /// Its name, relative to the output folder.
    pub name: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// Digest of its content.
    pub digest: Digest,
}

/// Values up to this many bytes live inside their record.
const INLINE_LIMIT: u64 = 1024;

impl StoredOutput {
    /// The stored form of a value, and whether the value itself must be stored beside it.
    #[must_use]
    pub fn of(value: &Value) -> Self {
        let encoded = value.encode();
        let inline =
            (encoded.payload.is_empty() && encoded.len() <= INLINE_LIMIT).then(|| encoded.head.clone());
        Self { digest: encoded.digest(), bytes: encoded.len(), inline }
    }

    /// The value, where the record holds it.
    #[must_use]
    pub fn inline_value(&self) -> Option<Value> {
        Value::decode(self.inline.as_deref()?).ok()
    }
}
