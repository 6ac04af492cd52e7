//! The output folder: files appear whole or not at all, and never outside it.

use std::{
    fs, io,
    io::{Seek, SeekFrom, Write},
    path::{Component, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use orograph_core::{Error, OutputStream, Result};
use tempfile::NamedTempFile;

use crate::cache::{WrittenFile, files::digest_of_file};

/// A folder that files are written into.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    root: PathBuf,
}

impl OutputFolder {
    /// The folder at `root`, made when the first file is.
    #[must_use]
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// Whether all `files`, and there are some, lie there with the content that was once written.
    #[must_use]
    pub fn holds(&self, files: &[WrittenFile]) -> bool {
        let in_place = |file: &WrittenFile| {
            let path = self.root.join(&file.name);
            let same_length =
                fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_file() && meta.len() == file.bytes);
            same_length && digest_of_file(&path).is_ok_and(|digest| digest == file.digest)
        };
        !files.is_empty() && files.iter().all(in_place)
    }

    /// Begins a file.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be made, or when its name leads out of the folder.
    pub fn create(&self, name: &str) -> Result<Box<dyn OutputStream>> {
        self.create_noted(name, &Arc::default())
    }

    /// Begins a file. What was finished is added to `written`.
    pub(crate) fn create_noted(
        &self,
        name: &str,
        written: &Arc<Mutex<Vec<WrittenFile>>>,
    ) -> Result<Box<dyn OutputStream>> {
        let name = PathBuf::from(name);
        let path = self.root.join(&name);
        let fail = |error: io::Error| Error::writing(path.display(), error);
        if !name.components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(Error::writing(path.display(), "the name leads out of the output folder"));
        }
        let parent = path.parent().unwrap_or(&self.root).to_owned();
        fs::create_dir_all(&parent).map_err(|error| {
            Error::writing(path.display(), format!("its folder {} cannot be made: {error}", parent.display()))
        })?;
        let (real_root, real_parent) =
            (fs::canonicalize(&self.root).map_err(fail)?, fs::canonicalize(&parent).map_err(fail)?);
        if !real_parent.starts_with(&real_root) {
            return Err(Error::writing(path.display(), "a link leads out of the output folder"));
        }
        if path.is_dir() {
            return Err(Error::writing(path.display(), "a folder is in the way"));
        }
        let file = tempfile::Builder::new()
            .prefix(".orograph-")
            .suffix(".tmp")
            .tempfile_in(&parent)
            .map_err(fail)?;
        Ok(Box::new(PendingFile { file, name, path, written: Arc::clone(written) }))
    }
}

/// A file under way; dropping it removes what was written.
struct PendingFile {
    file: NamedTempFile,
    name: PathBuf,
    path: PathBuf,
    written: Arc<Mutex<Vec<WrittenFile>>>,
}

impl Write for PendingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for PendingFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl OutputStream for PendingFile {
    fn finish(self: Box<Self>) -> Result<()> {
        let Self { file, name, path, written } = *self;
        let fail = |error: io::Error| Error::writing(path.display(), error);
        let entry = WrittenFile {
            name,
            bytes: file.as_file().metadata().map_err(fail)?.len(),
            digest: digest_of_file(file.path()).map_err(fail)?,
        };
        open_to_readers(&file).map_err(fail)?;
        file.persist(&path).map_err(|error| fail(error.error))?;
        written.lock().unwrap_or_else(PoisonError::into_inner).push(entry);
        Ok(())
    }
}

/// A temporary file is private to its owner; an output is an ordinary file.
#[cfg(unix)]
fn open_to_readers(file: &NamedTempFile) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file().set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn open_to_readers(_: &NamedTempFile) -> io::Result<()> {
    Ok(())
}
