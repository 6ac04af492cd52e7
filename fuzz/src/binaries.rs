//! Readers of what programs write for programs.

use orograph_core::{Digest, Value};
use orograph_engine::untrusted;

/// A library that may be a plugin. Nothing of it is run.
pub(super) fn library(bytes: &[u8]) {
    if let Err(reason) = untrusted::library(bytes) {
        assert!(!reason.is_empty());
    }
}

/// An entry of the cache: a byte that says of what kind, then what a file holds, or what its checksum guards.
pub(super) fn cache(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    match kind % 3 {
        0 => value(bytes),
        1 => record(bytes),
        _ => files(bytes),
    }
}

fn value(bytes: &[u8]) {
    let Ok(value) = Value::decode(bytes) else { return };
    let _ = value.size_in_memory();
    let encoded = value.encode();
    let again = Value::decode(&[&encoded.head, encoded.payload].concat()).expect("what was written is read");
    assert_eq!(again.digest(), value.digest());
}

fn record(bytes: &[u8]) {
    let Some(record) = untrusted::record_content(bytes) else { return };
    for output in &record.outputs {
        let _ = output.inline_value();
    }
    let key = Digest::of(bytes);
    let file = untrusted::record_file(&key, &record).expect("a record is written");
    assert_eq!(untrusted::cached_record(&file, &key), Some(record));
    assert_eq!(untrusted::cached_record(&file, &Digest::of(&file)), None, "the record of another key");
}

fn files(bytes: &[u8]) {
    let key = Digest([0; 32]);
    let _ = untrusted::cached_record(bytes, &key);
    assert!(untrusted::cached_value(bytes, &key).is_none(), "no digest is that of anything");
}
