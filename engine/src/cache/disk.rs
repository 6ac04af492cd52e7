//! The disk tier: a content-addressed folder that outlives the process and is shared by any number of them.
//!
//! A value lies under its digest, a record under its key. Every file is written beside its place and renamed
//! into it, and is checked when it is read, so a torn, swapped or foreign file counts as absent. Nothing here
//! is an error to the run: a write that fails turns writing off, with the reason kept for one warning.

mod upkeep;

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use orograph_core::{Digest, Encoded, Value};
use serde::{Serialize, de::DeserializeOwned};
pub use upkeep::DiskStat;

use super::Record;
use crate::whole::write_whole;

/// Raised whenever the layout or the byte form of anything stored changes; older folders are then unused.
const LAYOUT: &str = "v1";
const RECORD_MAGIC: &[u8; 8] = b"OROREC01";
const VALUE_MAGIC: &[u8; 8] = b"OROVAL01";
/// How often a write is tried while other processes clear the folder under it.
const TRIES: u32 = 16;

/// A cache folder.
pub struct DiskTier {
    root: PathBuf,
    failure: Mutex<Option<String>>,
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
        tier.make_shelves()?;
        let tag = tier.root.join("CACHEDIR.TAG");
        if !tag.exists() {
            // The signature that backup programs look for: whole, or they would not know it.
            const TEXT: &[u8] =
                b"Signature: 8a477f597d28d172789f06886806bc55\n# Orograph's cache: safe to delete.\n";
            tier.put(&tag, &[TEXT])?;
        }
        Ok(tier)
    }

    fn make_shelves(&self) -> io::Result<()> {
        let shelves = Shelf::ALL.map(|shelf| self.root.join(LAYOUT).join(shelf.name()));
        again(|| {
            shelves.iter().try_for_each(fs::create_dir_all)?;
            fs::create_dir_all(self.temporary())
        })
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
        let value = value_in(&bytes, digest);
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

    fn read_small<T: DeserializeOwned>(&self, shelf: Shelf, name: &Digest) -> Option<T> {
        let bytes = fs::read(self.path(shelf, name)).ok()?;
        let item = item_in(&bytes, name);
        if item.is_none() {
            self.discard(shelf, name);
        }
        item
    }

    fn write_small(&self, shelf: Shelf, name: &Digest, item: &impl Serialize) {
        if let Some(bytes) = item_bytes(name, item) {
            self.write(&self.path(shelf, name), &[&bytes]);
        }
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
        match self.put(path, parts) {
            Ok(()) => true,
            Err(error) => {
                let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
                failure.get_or_insert_with(|| format!("{}: {error}", self.root.display()));
                false
            }
        }
    }

    fn put(&self, path: &Path, parts: &[&[u8]]) -> io::Result<()> {
        again(|| {
            let outcome = write_whole(&self.temporary(), path, parts);
            if outcome.as_ref().is_err_and(is_of_clearing) {
                // If that cannot be done, the next try will tell why.
                let _ = self.make_shelves();
            }
            outcome
        })
    }
}

/// Whether the error can come of another process that clears the folder: a part of it went, or went just after it had
/// been found to be there.
fn is_of_clearing(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::AlreadyExists)
}

/// Does it again where another process clears the folder meanwhile.
fn again(mut attempt: impl FnMut() -> io::Result<()>) -> io::Result<()> {
    for _ in 1..TRIES {
        match attempt() {
            Err(error) if is_of_clearing(&error) => {}
            outcome => return outcome,
        }
    }
    attempt()
}

/// The value in a file of values; `None` unless it is whole and that value.
pub(crate) fn value_in(bytes: &[u8], digest: &Digest) -> Option<Value> {
    let value = bytes.strip_prefix(VALUE_MAGIC).filter(|bytes| Digest::of_large(bytes) == *digest);
    Value::decode(value?).ok()
}

/// A small item in its file, which carries the item's own name and a checksum: magic, name, content, digest of all that.
/// `None` unless it is whole and of that name.
pub(crate) fn item_in<T: DeserializeOwned>(bytes: &[u8], name: &Digest) -> Option<T> {
    let (body, checksum) = bytes.split_last_chunk::<32>()?;
    let content = body.strip_prefix(RECORD_MAGIC)?.strip_prefix(&name.0)?;
    (Digest::of(body).0 == *checksum).then(|| postcard::from_bytes(content).ok())?
}

/// The file of a small item.
pub(crate) fn item_bytes(name: &Digest, item: &impl Serialize) -> Option<Vec<u8>> {
    let content = postcard::to_stdvec(item).ok()?;
    let mut bytes = [RECORD_MAGIC.as_slice(), &name.0, &content].concat();
    bytes.extend(Digest::of(&bytes).0);
    Some(bytes)
}
