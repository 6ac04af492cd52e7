//! Private copies of plugins, and what scans of them learnt, by content.
//!
//! A library is loaded from its copy: a file that is built anew while it is in use changes nothing under a running
//! program, and the next run loads the new content beside the old.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use orograph_abi::{OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR};
use orograph_core::Digest;
use tempfile::TempDir;

use super::scan::Scan;
use crate::{
    cache::{DiskTier, FileDigests, plugin_shelf},
    whole::{save_whole, write_whole},
};

/// A library of more bytes than this is a mistake.
const MOST_BYTES: u64 = 1 << 30;

/// A folder of copies and scans. It may go at any time: everything in it is made again.
pub(super) struct Store {
    root: PathBuf,
    /// The cache folder that it lies in, which remembers digests of files.
    cache: Option<DiskTier>,
    digests: FileDigests,
    /// Where there is no cache folder, or no copy can be written there: it lasts as long as this.
    own: Mutex<Option<TempDir>>,
}

impl Store {
    /// A store below the cache folder, or of its own where there is none or none can be made.
    ///
    /// # Errors
    /// When no folder can be made at all.
    pub(super) fn open(cache: Option<&Path>) -> io::Result<Self> {
        let digests = FileDigests::default();
        if let Some(folder) = cache
            && let Ok(cache) = DiskTier::open(folder)
        {
            return Ok(Self {
                root: plugin_shelf(folder),
                cache: Some(cache),
                digests,
                own: Mutex::default(),
            });
        }
        let own = tempfile::tempdir()?;
        Ok(Self { root: own.path().to_owned(), cache: None, digests, own: Mutex::new(Some(own)) })
    }

    /// The digest of the library at `path` and the copy of that content. Unless `again`, both are told apart from others
    /// by path, size and time of change, as every file is that a node reads: whatever became of the library unseen,
    /// what is loaded and what keys name are the same copy.
    pub(super) fn copy(&self, path: &Path, again: bool) -> io::Result<(Digest, PathBuf)> {
        let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
        let place = |digest: &Digest| self.root.join(digest.to_string()).join(name);
        if let Some(digest) = self.known_digest(path).filter(|_| !again) {
            let copy = place(&digest);
            if self.known_digest(&copy) == Some(digest) {
                return Ok((digest, copy));
            }
        }
        if fs::metadata(path)?.len() > MOST_BYTES {
            return Err(io::Error::other(format!("it has more than {MOST_BYTES} bytes")));
        }
        let bytes = fs::read(path)?;
        let digest = Digest::of_large(&bytes);
        let copy = place(&digest);
        if fs::read(&copy).is_ok_and(|there| there == bytes) {
            return Ok((digest, copy));
        }
        // It is not always read whole again, so it must not be lost in part either.
        match save_whole(&copy, &bytes) {
            Ok(()) => Ok((digest, copy)),
            // A cache that cannot be written costs no plugin.
            Err(_) if self.cache.is_some() => {
                let copy = self.own_folder()?.join(digest.to_string()).join(name);
                save_whole(&copy, &bytes)?;
                Ok((digest, copy))
            }
            Err(error) => Err(error),
        }
    }

    fn own_folder(&self) -> io::Result<PathBuf> {
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = match own.take() {
            Some(folder) => folder,
            None => tempfile::tempdir()?,
        };
        Ok(own.insert(folder).path().to_owned())
    }

    fn known_digest(&self, path: &Path) -> Option<Digest> {
        self.digests.digest(path, Some(self.cache.as_ref()?)).ok()
    }

    pub(super) fn scan(&self, digest: &Digest) -> Option<Scan> {
        ron::from_str(&fs::read_to_string(self.scan_path(digest)).ok()?).ok()
    }

    /// What cannot be kept is scanned again.
    pub(super) fn put_scan(&self, digest: &Digest, scan: &Scan) {
        if let Ok(text) = ron::to_string(scan) {
            let path = self.scan_path(digest);
            let _ = write_whole(path.parent().unwrap_or(&self.root), &path, &[text.as_bytes()]);
        }
    }

    fn scan_path(&self, digest: &Digest) -> PathBuf {
        self.root.join(digest.to_string()).join(format!("scan-{OROGRAPH_ABI_MAJOR}.{OROGRAPH_ABI_MINOR}.ron"))
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;

    #[test]
    fn a_copy_is_of_the_content_that_its_digest_names() {
        let folder = tempfile::tempdir().unwrap();
        let library = folder.path().join("lib.so");
        let long_ago = SystemTime::now() - Duration::from_secs(3600);
        let build = |content: &str, time: SystemTime| {
            fs::write(&library, content).unwrap();
            fs::File::options().write(true).open(&library).unwrap().set_modified(time).unwrap();
        };
        let cache = folder.path().join("cache");
        // Each time as another process, which knows what the cache folder remembers.
        let copy = |again: bool| {
            let store = Store::open(Some(&cache)).unwrap();
            let (digest, copy) = store.copy(&library, again).unwrap();
            let content = fs::read_to_string(&copy).unwrap();
            assert_eq!(digest, Digest::of(content.as_bytes()), "{content}");
            (content, copy)
        };
        build("one", long_ago);
        let (content, one) = copy(false);
        assert_eq!(content, "one");
        assert_eq!(copy(false).1, one);
        build("two", long_ago + Duration::from_nanos(1));
        assert_eq!(copy(false).0, "two", "another time of change");
        build("three", long_ago);
        assert_eq!(copy(false).0, "three", "another size");
        // One that hides its change is as it was known, until it is looked at anew.
        build("six", long_ago);
        assert_eq!(copy(false).0, "one");
        assert_eq!(copy(true).0, "six");
        build("now", SystemTime::now());
        assert_eq!(copy(false).0, "now");
        build("two", SystemTime::now());
        assert_eq!(copy(false).0, "two", "what was built this moment is read");
        // A copy that is damaged, or gone, is made again.
        build("one", long_ago);
        fs::write(&one, "on").unwrap();
        assert_eq!(copy(false).0, "one");
        fs::remove_file(&one).unwrap();
        assert_eq!(copy(false), ("one".to_owned(), one));
    }

    #[test]
    fn where_the_cache_takes_no_copy_another_place_does() {
        let folder = tempfile::tempdir().unwrap();
        let library = folder.path().join("lib.so");
        fs::write(&library, "library").unwrap();
        let cache = folder.path().join("cache");
        let store = Store::open(Some(&cache)).unwrap();
        fs::write(store.root.join(Digest::of(b"library").to_string()), "in the way").unwrap();
        let (_, copy) = store.copy(&library, false).unwrap();
        assert!(!copy.starts_with(&cache));
        assert_eq!(fs::read(&copy).unwrap(), b"library");
        assert_eq!(store.copy(&library, false).unwrap().1, copy);
        drop(store);
        assert!(!copy.exists(), "it lasts as long as the store");
    }
}
