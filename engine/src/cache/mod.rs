//! The cache: records of computations and the values they name, in memory over disk.

mod disk;
pub(crate) mod files;
mod memory;
mod record;

use std::{
    collections::HashMap,
    hash::{BuildHasherDefault, Hasher},
    sync::{Arc, Mutex, PoisonError},
};

use orograph_core::{Digest, Value};
use serde::{Serialize, de::DeserializeOwned};

pub use disk::{DiskStat, DiskTier};
pub(crate) use disk::{item_bytes, item_in, plugin_shelf, value_in};
pub(crate) use files::FileDigests;
use memory::MemoryTier;
pub use record::{Record, StoredOutput, WrittenFile};

/// A map by digest. A digest is as good as random, so eight of its bytes serve as its hash.
pub(crate) type DigestMap<T> = HashMap<Digest, T, BuildHasherDefault<DigestHasher>>;

/// Takes the first bytes of a digest for its hash.
#[derive(Default)]
pub(crate) struct DigestHasher(u64);

impl Hasher for DigestHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        if let Some(bytes) = bytes.first_chunk::<8>() {
            self.0 = u64::from_le_bytes(*bytes);
        }
    }
    // The length of the array, which comes first.
    fn write_usize(&mut self, _: usize) {}
}

/// Where something was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tier {
    /// In this process.
    Memory,
    /// In the cache folder.
    Disk,
}

/// Two tiers, one cache. Shared by every run of a process.
pub struct Cache {
    memory: MemoryTier,
    records: Mutex<DigestMap<Arc<Record>>>,
    disk: Option<DiskTier>,
    files: FileDigests,
}

/// Records kept in memory; beyond this many all are dropped, and found on disk or computed again.
const MAX_RECORDS: usize = 1 << 20;

impl Cache {
    /// A cache holding at most `memory_budget` bytes of values in memory, over `disk` where there is one.
    #[must_use]
    pub fn new(memory_budget: u64, disk: Option<DiskTier>) -> Self {
        Self {
            memory: MemoryTier::new(memory_budget),
            records: Mutex::default(),
            disk,
            files: FileDigests::default(),
        }
    }

    /// The folder under the memory, where there is one.
    #[must_use]
    pub fn disk(&self) -> Option<&DiskTier> {
        self.disk.as_ref()
    }

    /// Why the folder is not written any more, told once.
    #[must_use]
    pub fn take_disk_failure(&self) -> Option<String> {
        self.disk.as_ref()?.take_failure()
    }

    /// Bytes that values may take in memory.
    #[must_use]
    pub fn memory_budget(&self) -> u64 {
        self.memory.budget()
    }

    /// Bytes that values take in memory now.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.memory.bytes()
    }

    pub(crate) fn record(&self, key: &Digest) -> Option<(Arc<Record>, Tier)> {
        if let Some(record) = self.records().get(key) {
            return Some((Arc::clone(record), Tier::Memory));
        }
        let record = Arc::new(self.disk.as_ref()?.record(key)?);
        self.remember(*key, &record);
        Some((record, Tier::Disk))
    }

    /// As [`record`](Self::record), for a look ahead: what was found on disk counts as found there next time, too.
    pub(crate) fn peek(&self, key: &Digest) -> Option<Arc<Record>> {
        let held = self.records().get(key).map(Arc::clone);
        held.or_else(|| Some(Arc::new(self.disk.as_ref()?.record(key)?)))
    }

    /// Keeps a record in memory alone.
    pub(crate) fn remember(&self, key: Digest, record: &Arc<Record>) {
        let mut records = self.records();
        if records.len() >= MAX_RECORDS {
            records.clear();
        }
        records.insert(key, Arc::clone(record));
    }

    pub(crate) fn value(&self, output: &StoredOutput) -> Option<Value> {
        self.memory.get(&output.digest).or_else(|| output.inline_value()).or_else(|| {
            let value = self.disk.as_ref()?.value(&output.digest)?;
            self.memory.insert(output.digest, value.clone(), 0, true);
            Some(value)
        })
    }

    /// Whether [`value`](Self::value) would find the value, unless what lies on disk is damaged.
    pub(crate) fn has_value(&self, output: &StoredOutput) -> bool {
        output.inline.is_some()
            || self.memory.contains(&output.digest)
            || self.disk.as_ref().is_some_and(|disk| disk.has_value(&output.digest))
    }

    pub(crate) fn hold(&self, output: &StoredOutput, value: Value, pins: u32) {
        // An inline value costs nothing to have again.
        if output.inline.is_none() {
            self.memory.insert(output.digest, value, pins, false);
        }
    }

    pub(crate) fn unpin(&self, record: &Record) {
        for output in record.outputs.iter().filter(|output| output.inline.is_none()) {
            self.memory.unpin(&output.digest);
        }
    }

    /// Writes values and then the record that names them, so that a record on disk never comes before them.
    pub(crate) fn persist(&self, keys: &[Digest], record: &Record, values: &[Value]) {
        let Some(disk) = &self.disk else { return };
        for (output, value) in record.outputs.iter().zip(values) {
            if output.inline.is_some() {
                continue;
            }
            if !disk.put_value(&output.digest, &value.encode()) {
                return;
            }
            self.memory.mark_on_disk(&output.digest);
        }
        for key in keys {
            disk.put_record(key, record);
        }
    }

    /// Writes another key of a record whose values lie on disk already.
    pub(crate) fn persist_record(&self, key: &Digest, record: &Record) {
        if let Some(disk) = &self.disk
            && record.outputs.iter().all(|output| output.inline.is_some() || disk.has_value(&output.digest))
        {
            disk.put_record(key, record);
        }
    }

    pub(crate) fn file_digest(&self, path: &std::path::Path) -> orograph_core::Result<Digest> {
        self.files.digest(path, self.disk.as_ref())
    }

    pub(crate) fn journal<T: DeserializeOwned>(&self, graph: &Digest) -> Option<T> {
        self.disk.as_ref()?.journal(graph)
    }

    pub(crate) fn put_journal(&self, graph: &Digest, journal: &impl Serialize) {
        if let Some(disk) = &self.disk {
            disk.put_journal(graph, journal);
        }
    }

    fn records(&self) -> std::sync::MutexGuard<'_, DigestMap<Arc<Record>>> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
