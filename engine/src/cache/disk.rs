//! The disk tier: a content-addressed folder that outlives the process and is shared by any number of them.
//!
//! A value lies under its digest, a record under its key. Every file is written beside its place and renamed
//! into it, and is checked when it is read, so a torn, swapped or foreign file counts as absent. Nothing here
//! is an error to the run: a write that fails turns writing off, with the reason kept for one warning.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
    time::{Duration, SystemTime},
};

use orograph_core::{Digest, Encoded, Value};
use serde::{Serialize, de::DeserializeOwned};

use super::Record;
use crate::whole::write_whole;

/// Raised whenever the layout or the byte form of anything stored changes; older folders are then unused.
const LAYOUT: &str = "v1";
const RECORD_MAGIC: &[u8; 8] = b"OROREC01";
const VALUE_MAGIC: &[u8; 8] = b"OROVAL01";
/// Temporary files older than this were left by a process that died.
const STALE: Duration = Duration::from_secs(3600);

/// A cache folder.
pub struct DiskTier {
    root: PathBuf,
    failure: Mutex<Option<String>>,
}

/// What lies in a cache folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct DiskStat {
    /// Number of values.
    pub values: u64,
    /// Bytes of all values.
    pub value_bytes: u64,
    /// Number of records.
    pub records: u64,
    /// Bytes of everything else.
    pub other_bytes: u64,
}

impl DiskStat {
    /// Bytes of everything.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.value_bytes + self.other_bytes
    }
}

/// The parts of a cache folder.
#[derive(Clone, Copy)]
enum Shelf {
    Values,
    Records,
    Files,
    Runs,
    /// Copies of plugins and what scans of them learnt; see `plugin::store`.
    Plugins,
}

impl Shelf {
    const ALL: [Self; 5] = [Self::Values, Self::Records, Self::Files, Self::Runs, Self::Plugins];

    fn name(self) -> &'static str {
        match self {
            Self::Values => "values",
            Self::Records => "records",
            Self::Files => "files",
            Self::Runs => "runs",
            Self::Plugins => "plugins",
        }
    }
}

/// The folder, below a cache folder, that plugins are kept in.
pub(crate) fn plugin_shelf(root: &Path) -> PathBuf {
    root.join(LAYOUT).join(Shelf::Plugins.name())
}

impl DiskTier {
    /// The cache folder at `root`, made when it is not there.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn open(root: &Path) -> io::Result<Self> {
        let tier = Self { root: root.to_owned(), failure: Mutex::new(None) };
        for shelf in Shelf::ALL {
            fs::create_dir_all(tier.root.join(LAYOUT).join(shelf.name()))?;
        }
        fs::create_dir_all(tier.temporary())?;
        let tag = tier.root.join("CACHEDIR.TAG");
        if !tag.exists() {
            // The signature that backup programs look for: whole, or they would not know it.
            const TEXT: &[u8] =
                b"Signature: 8a477f597d28d172789f06886806bc55\n# Orograph's cache: safe to delete.\n";
            write_whole(&tier.temporary(), &tag, &[TEXT])?;
        }
        Ok(tier)
    }

    /// The folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Why nothing is written any more, told once.
    pub(crate) fn take_failure(&self) -> Option<String> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *failure {
            Some(reason) if !reason.is_empty() => Some(std::mem::take(reason)),
            _ => None,
        }
    }

    fn writable(&self) -> bool {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    pub(crate) fn value(&self, digest: &Digest) -> Option<Value> {
        let bytes = fs::read(self.path(Shelf::Values, digest)).ok()?;
        let value = bytes.strip_prefix(VALUE_MAGIC).filter(|bytes| Digest::of_large(bytes) == *digest);
        let value = value.and_then(|bytes| Value::decode(bytes).ok());
        if value.is_none() {
            self.discard(Shelf::Values, digest);
        }
        value
    }

    pub(crate) fn has_value(&self, digest: &Digest) -> bool {
        self.path(Shelf::Values, digest).exists()
    }

    pub(crate) fn put_value(&self, digest: &Digest, encoded: &Encoded<'_>) -> bool {
        let path = self.path(Shelf::Values, digest);
        self.has_value(digest) || self.write(&path, &[VALUE_MAGIC, &encoded.head, encoded.payload])
    }

    pub(crate) fn record(&self, key: &Digest) -> Option<Record> {
        self.read_small(Shelf::Records, key)
    }

    pub(crate) fn put_record(&self, key: &Digest, record: &Record) {
        self.write_small(Shelf::Records, key, record);
    }

    pub(crate) fn file_digest(&self, identity: &Digest) -> Option<Digest> {
        self.read_small(Shelf::Files, identity)
    }

    pub(crate) fn put_file_digest(&self, identity: &Digest, digest: &Digest) {
        self.write_small(Shelf::Files, identity, digest);
    }

    pub(crate) fn journal<T: DeserializeOwned>(&self, graph: &Digest) -> Option<T> {
        self.read_small(Shelf::Runs, graph)
    }

    pub(crate) fn put_journal(&self, graph: &Digest, journal: &impl Serialize) {
        self.write_small(Shelf::Runs, graph, journal);
    }

    fn path(&self, shelf: Shelf, name: &Digest) -> PathBuf {
        let name = name.to_string();
        self.root.join(LAYOUT).join(shelf.name()).join(&name[..2]).join(name)
    }

    fn temporary(&self) -> PathBuf {
        self.root.join(LAYOUT).join("tmp")
    }

    /// A small item carries its own name and a checksum: magic, name, content, digest of all that.
    fn read_small<T: DeserializeOwned>(&self, shelf: Shelf, name: &Digest) -> Option<T> {
        let bytes = fs::read(self.path(shelf, name)).ok()?;
        let item = bytes.split_last_chunk::<32>().and_then(|(body, checksum)| {
            let content = body.strip_prefix(RECORD_MAGIC)?.strip_prefix(&name.0)?;
            (Digest::of(body).0 == *checksum).then(|| postcard::from_bytes(content).ok())?
        });
        if item.is_none() {
            self.discard(shelf, name);
        }
        item
    }

    fn write_small(&self, shelf: Shelf, name: &Digest, item: &impl Serialize) {
        let Ok(content) = postcard::to_stdvec(item) else { return };
        let body = [RECORD_MAGIC.as_slice(), &name.0, &content].concat();
        self.write(&self.path(shelf, name), &[&body, &Digest::of(&body).0]);
    }

    /// Takes away an item that proved bad, so that it is written anew.
    fn discard(&self, shelf: Shelf, name: &Digest) {
        // Failing that, the next write of the same item replaces it.
        let _ = fs::remove_file(self.path(shelf, name));
    }

    fn write(&self, path: &Path, parts: &[&[u8]]) -> bool {
        if !self.writable() {
            return false;
        }
        match write_whole(&self.temporary(), path, parts) {
            Ok(()) => true,
            Err(error) => {
                let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
                failure.get_or_insert_with(|| format!("{}: {error}", self.root.display()));
                false
            }
        }
    }

    /// Counts what lies in the folder.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn stat(&self) -> io::Result<DiskStat> {
        let mut stat = DiskStat::default();
        for shelf in Shelf::ALL {
            for item in self.items(shelf)? {
                match shelf {
                    Shelf::Values => {
                        stat.values += 1;
                        stat.value_bytes += item.bytes;
                    }
                    _ => stat.other_bytes += item.bytes,
                }
                stat.records += u64::from(matches!(shelf, Shelf::Records));
            }
        }
        Ok(stat)
    }

    /// Removes the items unused for longest until at most `max_bytes` are left, and what dead processes left.
    /// Runs that go on meanwhile recompute what they miss.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn collect(&self, max_bytes: u64) -> io::Result<DiskStat> {
        let mut items = Vec::new();
        for shelf in Shelf::ALL {
            items.extend(self.items(shelf)?);
        }
        let mut left: u64 = items.iter().map(|item| item.bytes).sum();
        items.sort_by(|a, b| (a.used, &a.path).cmp(&(b.used, &b.path)));
        for item in items {
            if left <= max_bytes {
                break;
            }
            if fs::remove_file(&item.path).is_ok() {
                left -= item.bytes;
            }
        }
        for entry in fs::read_dir(self.temporary())?.flatten() {
            let age = entry
                .metadata()
                .and_then(|meta| meta.modified())
                .map(|time| time.elapsed().unwrap_or_default());
            if age.is_ok_and(|age| age > STALE) {
                let _ = fs::remove_file(entry.path());
            }
        }
        self.stat()
    }

    /// Removes everything.
    ///
    /// # Errors
    /// When something cannot be removed.
    pub fn clear(&self) -> io::Result<()> {
        let folder = self.root.join(LAYOUT);
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        Self::open(&self.root).map(|_| ())
    }

    fn items(&self, shelf: Shelf) -> io::Result<Vec<Item>> {
        let mut items = Vec::new();
        for bucket in fs::read_dir(self.root.join(LAYOUT).join(shelf.name()))?.flatten() {
            // A bucket or an item may vanish while another process collects.
            let Ok(entries) = fs::read_dir(bucket.path()) else { continue };
            for entry in entries.flatten() {
                let Ok(meta) = entry.metadata() else { continue };
                let used = meta.accessed().or_else(|_| meta.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
                let used = used.max(meta.modified().unwrap_or(SystemTime::UNIX_EPOCH));
                items.push(Item { path: entry.path(), bytes: meta.len(), used });
            }
        }
        Ok(items)
    }
}

struct Item {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}
