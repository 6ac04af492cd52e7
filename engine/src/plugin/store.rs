//! Private copies of plugins, and what scans of them learnt, by content.
//!
//! A library is loaded from its copy: a file that is built anew while it is in use changes nothing under a running
//! program, and the next run loads the new content beside the old.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use orograph_abi::{OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR};
use orograph_core::Digest;
use tempfile::{NamedTempFile, TempDir};

use super::scan::Scan;
use crate::cache::plugin_shelf;

/// A folder of copies and scans. It may go at any time: everything in it is made again.
pub(super) struct Store {
    root: PathBuf,
    /// Where there is no cache folder, it lasts as long as this.
    _own: Option<TempDir>,
}

impl Store {
    /// A store below the cache folder, or of its own where there is none or none can be made.
    ///
    /// # Errors
    /// When no folder can be made at all.
    pub(super) fn open(cache: Option<&Path>) -> io::Result<Self> {
        if let Some(cache) = cache {
            let root = plugin_shelf(cache);
            if fs::create_dir_all(&root).is_ok() {
                return Ok(Self { root, _own: None });
            }
        }
        let own = tempfile::tempdir()?;
        Ok(Self { root: own.path().to_owned(), _own: Some(own) })
    }

    /// The copy of a library with this content.
    pub(super) fn copy(&self, digest: &Digest, path: &Path, bytes: &[u8]) -> io::Result<PathBuf> {
        let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
        let folder = self.root.join(digest.to_string());
        let copy = folder.join(name);
        if fs::read(&copy).is_ok_and(|there| there == bytes) {
            return Ok(copy);
        }
        fs::create_dir_all(&folder)?;
        write_whole(&folder, &copy, bytes)?;
        Ok(copy)
    }

    pub(super) fn scan(&self, digest: &Digest) -> Option<Scan> {
        ron::from_str(&fs::read_to_string(self.scan_path(digest)).ok()?).ok()
    }

    /// What cannot be kept is scanned again.
    pub(super) fn put_scan(&self, digest: &Digest, scan: &Scan) {
        if let Ok(text) = ron::to_string(scan) {
            let path = self.scan_path(digest);
            let _ = path.parent().map(|folder| write_whole(folder, &path, text.as_bytes()));
        }
    }

    fn scan_path(&self, digest: &Digest) -> PathBuf {
        self.root.join(digest.to_string()).join(format!("scan-{OROGRAPH_ABI_MAJOR}.{OROGRAPH_ABI_MINOR}.ron"))
    }
}

/// The whole file in its place at once.
fn write_whole(folder: &Path, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}
