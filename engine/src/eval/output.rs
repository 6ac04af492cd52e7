//! The output folder: files appear whole or not at all, and never outside it.
//!
//! A file grows under a temporary name, on which its writer holds a lock for as long as it lives, and gets its own
//! name when it is whole. What a killed run leaves has no lock; the next run that writes there takes it away.
//!
//! A link among the folders of a name may lead about inside the output folder, and not out of it. A link that stands at
//! the name itself is replaced, wherever it leads.

use std::{
    collections::BTreeSet,
    fs::{self, File},
    io,
    io::{Seek, SeekFrom, Write},
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use orograph_core::{Error, OutputStream, Result};
use tempfile::NamedTempFile;

use crate::{
    cache::{
        WrittenFile,
        files::{digest_of, digest_of_file},
    },
    whole::plain,
};

/// Begins and ends the name of a file under way.
const TEMPORARY: (&str, &str) = (".orograph-", ".tmp");

/// A folder that files are written into.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    root: PathBuf,
    /// Folders that what dead runs left was taken from.
    swept: Arc<Mutex<BTreeSet<PathBuf>>>,
}

impl OutputFolder {
    /// The folder at `root`, made when the first file is.
    #[must_use]
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), swept: Arc::default() }
    }

    /// Whether all `files`, and there are some, lie there with the content that was once written.
    #[must_use]
    pub fn holds(&self, files: &[WrittenFile]) -> bool {
        let in_place = |file: &WrittenFile| {
            let path = self.root.join(&file.name);
            let same_length =
                fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_file() && meta.len() == file.bytes);
            same_length
                && is_plain(&file.name)
                && path.parent().is_some_and(|parent| self.keeps(parent).unwrap_or(false))
                && digest_of_file(&path).is_ok_and(|digest| digest == file.digest)
        };
        !files.is_empty() && files.iter().all(in_place)
    }

    /// Tells whether files could come to be in it, as far as that shows without writing: who waits for hours of work
    /// wants to hear it before.
    ///
    /// # Errors
    /// Why they could not, in words.
    pub fn look(&self) -> std::result::Result<(), String> {
        let root = std::path::absolute(&self.root).map_err(|error| error.to_string())?;
        let Some(there) = root.ancestors().find(|folder| folder.exists()) else { return Ok(()) };
        if !there.is_dir() {
            return Err(format!("{} is a file, not a folder", there.display()));
        }
        may_write(there).map_err(|error| format!("{}: {error}", there.display()))
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
        let (Some(file_name), true) = (name.file_name(), is_plain(&name)) else {
            return Err(Error::writing(path.display(), "the name leads out of the output folder"));
        };
        let parent = path.parent().unwrap_or(&self.root).to_owned();
        let make = |folder: &Path| {
            fs::create_dir_all(folder).map_err(|error| {
                let reason = format!("its folder {} cannot be made: {error}", parent.display());
                Error::writing(path.display(), reason)
            })
        };
        let leads_out = || Err(Error::writing(path.display(), "a link leads out of the output folder"));
        make(&self.root)?;
        // Looked at before folders are made, which a link would put elsewhere.
        if !self.keeps(&parent).map_err(fail)? {
            return leads_out();
        }
        make(&parent)?;
        // What is looked at now is what is written to, whatever becomes of links meanwhile.
        let folder = fs::canonicalize(&parent).map_err(fail)?;
        if !folder.starts_with(fs::canonicalize(&self.root).map_err(fail)?) {
            return leads_out();
        }
        let place = folder.join(file_name);
        if fs::symlink_metadata(&place).is_ok_and(|meta| meta.is_dir()) {
            return Err(Error::writing(path.display(), "a folder is in the way"));
        }
        self.sweep(&folder);
        let file = begin(&folder).map_err(|error| fail(plain(error)))?;
        Ok(Box::new(PendingFile { file, name, path, place, written: Arc::clone(written) }))
    }

    /// Whether a folder, or what there is of the way to it, lies in this one when links are followed.
    fn keeps(&self, folder: &Path) -> io::Result<bool> {
        let root = fs::canonicalize(&self.root)?;
        for known in folder.ancestors() {
            match fs::canonicalize(known) {
                Ok(real) => return Ok(real.starts_with(&root)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }
}

#[cfg(unix)]
fn may_write(folder: &Path) -> io::Result<()> {
    use rustix::fs::{Access, access};
    Ok(access(folder, Access::WRITE_OK | Access::EXEC_OK)?)
}

#[cfg(not(unix))]
fn may_write(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Whether a name goes down only.
fn is_plain(name: &Path) -> bool {
    name.components().all(|part| matches!(part, Component::Normal(_)))
}

impl OutputFolder {
    /// Takes away what dead runs left beside `files`, once a folder.
    pub(crate) fn sweep_beside(&self, files: &[WrittenFile]) {
        for file in files {
            if let Some(parent) = self.root.join(&file.name).parent() {
                self.sweep(parent);
            }
        }
    }

    fn sweep(&self, folder: &Path) {
        if self.swept.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned()) {
            remove_abandoned(folder);
        }
    }

    /// An error of a node that writes here, naming the file as the user finds it: nodes know only its name inside.
    #[must_use]
    pub fn located(&self, error: Error) -> Error {
        match error {
            Error::Io { action: "writing", path, reason } if !Path::new(&path).starts_with(&self.root) => {
                Error::writing(self.root.join(path).display(), reason)
            }
            other => other,
        }
    }
}

/// Makes a temporary file in `folder` and locks it.
fn begin(folder: &Path) -> io::Result<NamedTempFile> {
    loop {
        let (prefix, suffix) = TEMPORARY;
        let file = tempfile::Builder::new().prefix(prefix).suffix(suffix).tempfile_in(folder)?;
        // Where a file system has no locks nobody takes files for abandoned either.
        let locked = file.as_file().lock().is_ok();
        // Between its making and its lock another run may have taken the file for abandoned.
        if !locked || file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes the temporary files in `folder` that no living run holds a lock on. What cannot be removed stays: it does
/// no harm.
fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let temporary = name.starts_with(TEMPORARY.0) && name.ends_with(TEMPORARY.1);
        if !temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        // Its writer, once it has the lock, looks whether the file is still there.
        if let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A file under way; dropping it removes what was written.
struct PendingFile {
    file: NamedTempFile,
    name: PathBuf,
    /// As the user knows it.
    path: PathBuf,
    /// Where it goes, links followed.
    place: PathBuf,
    written: Arc<Mutex<Vec<WrittenFile>>>,
}

impl Write for PendingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Not through `NamedTempFile`, whose errors tell the temporary name.
        self.file.as_file_mut().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

impl Seek for PendingFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.as_file_mut().seek(to)
    }
}

impl OutputStream for PendingFile {
    fn finish(self: Box<Self>) -> Result<()> {
        let Self { mut file, name, path, place, written } = *self;
        let fail = |error: io::Error| Error::writing(path.display(), error);
        let entry = WrittenFile {
            name,
            bytes: file.as_file().metadata().map_err(fail)?.len(),
            // Through the handle that holds the lock, which on some systems keeps all others out.
            digest: file.as_file_mut().rewind().and_then(|()| digest_of(file.as_file_mut())).map_err(fail)?,
        };
        open_to_readers(&file).map_err(fail)?;
        file.persist(&place).map_err(|error| fail(plain(error.error)))?;
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

#[cfg(test)]
mod tests;
