//! Digests of external files, remembered by path, size and modification time.

use std::{
    collections::HashMap,
    fs, io,
    path::Path,
    sync::{Mutex, PoisonError},
    time::{Duration, UNIX_EPOCH},
};

use orograph_core::{Digest, Error, Hasher, Result};

use super::DiskTier;

/// Digests by a file's identity, so that a big file is hashed once and not once a run.
#[derive(Default)]
pub(crate) struct FileDigests {
    known: Mutex<HashMap<Digest, Digest>>,
}

impl FileDigests {
    pub(crate) fn digest(&self, path: &Path, disk: Option<&DiskTier>) -> Result<Digest> {
        let fail = |error: io::Error| Error::reading(path.display(), error);
        let (identity, age) = identity(path).map_err(fail)?;
        if age < SETTLED {
            // Written this moment: it may be written again without a visible change of time.
            return digest_of_file(path).map_err(fail);
        }
        if let Some(digest) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&identity) {
            return Ok(*digest);
        }
        let digest = match disk.and_then(|disk| disk.file_digest(&identity)) {
            Some(digest) => digest,
            None => {
                let digest = digest_of_file(path).map_err(fail)?;
                if let Some(disk) = disk {
                    disk.put_file_digest(&identity, &digest);
                }
                digest
            }
        };
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(identity, digest);
        Ok(digest)
    }
}

/// Whether a file is there that may as well be absent. A folder of that name is no such file.
pub(crate) fn is_there(path: &Path) -> Result<bool> {
    match fs::metadata(path) {
        Ok(meta) => Ok(meta.is_file()),
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            Ok(false)
        }
        Err(error) => Err(Error::reading(path.display(), error)),
    }
}

/// Modification times closer to now than this cannot tell one content from the next.
const SETTLED: Duration = Duration::from_secs(2);

/// A digest of path, size and modification time, and how long ago the latter was.
fn identity(path: &Path) -> io::Result<(Digest, Duration)> {
    let meta = fs::metadata(path)?;
    if meta.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder, not a file"));
    }
    if !meta.is_file() {
        // Reading it might never end, or never begin.
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "this is a device or a pipe, not a file"));
    }
    let age = meta.modified()?.elapsed().unwrap_or_default();
    let modified = meta.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = fs::canonicalize(path)?;
    let mut hasher = Hasher::new("orograph file identity");
    hasher.bytes(path.as_os_str().as_encoded_bytes()).number(meta.len());
    hasher.number(modified.as_secs()).number(u64::from(modified.subsec_nanos()));
    Ok((hasher.finish(), age))
}

/// The digest of a file's content, read in pieces.
pub(crate) fn digest_of_file(path: &Path) -> io::Result<Digest> {
    digest_of(fs::File::open(path)?)
}

/// The digest of what is left to read.
pub(crate) fn digest_of(reader: impl io::Read) -> io::Result<Digest> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(reader)?;
    Ok(Digest(*hasher.finalize().as_bytes()))
}
