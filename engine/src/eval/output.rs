//! The output folder: files appear whole or not at all, and never outside it.
//!
//! A file grows under a temporary name, on which its writer holds a lock for as long as it lives, and gets its own
//! name when it is whole. What a killed run leaves has no lock; the next run that writes there takes it away.

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
        self.sweep(&parent);
        let file = begin(&parent).map_err(|error| fail(plain(error)))?;
        Ok(Box::new(PendingFile { file, name, path, written: Arc::clone(written) }))
    }
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
    path: PathBuf,
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
        let Self { mut file, name, path, written } = *self;
        let fail = |error: io::Error| Error::writing(path.display(), error);
        let entry = WrittenFile {
            name,
            bytes: file.as_file().metadata().map_err(fail)?.len(),
            // Through the handle that holds the lock, which on some systems keeps all others out.
            digest: file.as_file_mut().rewind().and_then(|()| digest_of(file.as_file_mut())).map_err(fail)?,
        };
        open_to_readers(&file).map_err(fail)?;
        file.persist(&path).map_err(|error| fail(plain(error.error)))?;
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
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn what_dead_runs_left_goes_and_what_living_runs_write_stays() {
        let root = tempfile::tempdir().unwrap();
        let living = OutputFolder::new(root.path());
        let mut under_way = living.create("a.txt").unwrap();
        under_way.write_all(b"whole").unwrap();
        let held = names(root.path());
        for left in [".orograph-dead.tmp", ".orograph-other.txt", "orograph-x.tmp"] {
            fs::write(root.path().join(left), "half").unwrap();
        }
        // Another run begins a file in the same folder.
        OutputFolder::new(root.path()).create("b.txt").unwrap().finish().unwrap();
        let mut expected =
            [held, vec![".orograph-other.txt".into(), "b.txt".into(), "orograph-x.tmp".into()]].concat();
        expected.sort();
        assert_eq!(names(root.path()), expected);
        under_way.finish().unwrap();
        assert_eq!(fs::read(root.path().join("a.txt")).unwrap(), b"whole");
        assert_eq!(names(root.path()), [".orograph-other.txt", "a.txt", "b.txt", "orograph-x.tmp"]);
    }

    #[test]
    fn runs_that_begin_together_do_not_take_each_other_s_files() {
        let root = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for writer in 0..8 {
                let root = root.path();
                scope.spawn(move || {
                    for file in 0..25 {
                        let name = format!("{writer}-{file}");
                        let mut out = OutputFolder::new(root).create(&name).unwrap();
                        out.write_all(name.as_bytes()).unwrap();
                        out.finish().unwrap();
                    }
                });
            }
        });
        assert_eq!(names(root.path()).len(), 200);
    }

    #[test]
    fn errors_name_the_file_as_the_user_finds_it() {
        let folder = OutputFolder::new("out");
        let named = |path: &str| folder.located(Error::writing(path, "no room")).to_string();
        assert_eq!(named("maps/a.png"), "writing out/maps/a.png: no room");
        assert_eq!(named("out/a.png"), "writing out/a.png: no room");
        let other = Error::reading("a.png", "gone");
        assert_eq!(folder.located(other.clone()), other);
    }
}
