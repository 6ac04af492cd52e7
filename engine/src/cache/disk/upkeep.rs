//! Counting what lies in a cache folder, and taking away from it while other processes go on.

use std::{
    fs::{self, DirEntry},
    io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use serde::Serialize;

use super::{DiskTier, LAYOUT, Shelf};

/// Temporary files older than this were left by a process that died.
const STALE: Duration = Duration::from_secs(3600);
/// Begins the name of what is being cleared away.
const CLEARED: &str = "cleared-";

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

impl DiskTier {
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
        for entry in entries(&self.temporary())? {
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

    /// Removes everything. Runs that go on meanwhile write what they find out into a new folder.
    ///
    /// # Errors
    /// When something cannot be removed.
    pub fn clear(&self) -> io::Result<()> {
        // Under another name nobody writes into it any more while it goes.
        let aside = tempfile::Builder::new().prefix(CLEARED).tempdir_in(&self.root)?.keep();
        let folder = self.root.join(LAYOUT);
        match fs::rename(&folder, aside.join(LAYOUT)) {
            Ok(()) => {}
            // Another process was first.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // Some systems do not rename what is in use.
            Err(_) => remove(&folder)?,
        }
        // With what processes left that died over it.
        for entry in entries(&self.root)? {
            if entry.file_name().to_string_lossy().starts_with(CLEARED) {
                remove(&entry.path())?;
            }
        }
        Self::open(&self.root).map(|_| ())
    }

    fn items(&self, shelf: Shelf) -> io::Result<Vec<Item>> {
        let mut items = Vec::new();
        for bucket in entries(&self.root.join(LAYOUT).join(shelf.name()))? {
            // A bucket or an item may vanish while another process collects.
            for entry in entries(&bucket.path()).unwrap_or_default() {
                let Ok(meta) = entry.metadata() else { continue };
                let used = meta.accessed().or_else(|_| meta.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
                let used = used.max(meta.modified().unwrap_or(SystemTime::UNIX_EPOCH));
                items.push(Item { path: entry.path(), bytes: meta.len(), used });
            }
        }
        Ok(items)
    }
}

/// What lies in a folder; nothing in one that is gone because another process clears.
fn entries(folder: &Path) -> io::Result<Vec<DirEntry>> {
    match fs::read_dir(folder) {
        Ok(entries) => Ok(entries.flatten().collect()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}

/// Removes a folder with all in it, which others may be removing, or still be writing into, at the same time.
fn remove(folder: &Path) -> io::Result<()> {
    use io::ErrorKind::{DirectoryNotEmpty, NotFound};
    const TRIES: u32 = 100;
    for _ in 0..TRIES {
        match fs::remove_dir_all(folder) {
            Ok(()) => return Ok(()),
            Err(error) if matches!(error.kind(), NotFound | DirectoryNotEmpty) => {
                if !folder.exists() {
                    return Ok(());
                }
            }
            Err(error) => return Err(error),
        }
    }
    fs::remove_dir_all(folder)
}

struct Item {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

#[cfg(test)]
mod tests {
    use orograph_core::{Digest, Value};

    use super::*;
    use crate::cache::{Record, StoredOutput};

    #[test]
    fn what_others_write_while_it_is_cleared_succeeds() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        // What a process left that died while it cleared.
        fs::create_dir_all(root.join("cleared-dead/v1/values")).unwrap();
        std::thread::scope(|scope| {
            for writer in 0..3_u8 {
                scope.spawn(move || {
                    for n in 0..300_u32 {
                        let tier = DiskTier::open(root).unwrap();
                        let value = Value::Text(format!("{writer} {n}").into());
                        let encoded = value.encode();
                        assert!(tier.put_value(&encoded.digest(), &encoded));
                        let record = Record { outputs: vec![StoredOutput::of(&value)], ..Record::default() };
                        tier.put_record(&Digest::of(&[writer]), &record);
                        assert_eq!(tier.take_failure(), None);
                    }
                });
            }
            for _ in 0..2 {
                scope.spawn(move || {
                    for n in 0..100 {
                        let tier = DiskTier::open(root).unwrap();
                        tier.clear().unwrap();
                        tier.collect(n * 20).unwrap();
                        tier.stat().unwrap();
                    }
                });
            }
        });
        let tier = DiskTier::open(root).unwrap();
        tier.clear().unwrap();
        assert_eq!(tier.stat().unwrap(), DiskStat::default());
        let mut left: Vec<_> = entries(root).unwrap().iter().map(DirEntry::file_name).collect();
        left.sort();
        assert_eq!(left, ["CACHEDIR.TAG", "v1"]);
    }
}
