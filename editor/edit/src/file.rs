//! The file behind a document: written whole or not at all, and never over what someone else wrote meanwhile.

use std::{
    io,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{self, Receiver, TryRecvError},
    },
};

use orograph_engine::{Document, DocumentErrors, Registry, document::read_file, save_whole};

/// A file, and its content when it was last read or written here.
#[derive(Clone, Debug)]
pub struct OpenFile {
    path: PathBuf,
    seen: Option<blake3::Hash>,
}

/// Why a document was not saved.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// Someone else changed the file.
    #[error("{} was changed by someone else since it was read", .0.display())]
    ChangedOnDisk(PathBuf),
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl OpenFile {
    /// Reads a graph file.
    ///
    /// # Errors
    /// That it cannot be read, or what is wrong with its text.
    pub fn open(path: &Path) -> Result<(Self, Document), DocumentErrors> {
        // Read once, so that what is compared later is what was parsed.
        let document = match read_file(path) {
            Ok(bytes) => {
                let file = Self { path: path.to_owned(), seen: Some(blake3::hash(&bytes)) };
                return Ok((file, Document::from_bytes(&bytes, &path.display().to_string())?));
            }
            Err(_) => Document::load(path)?,
        };
        Ok((Self { path: path.to_owned(), seen: None }, document))
    }

    /// A file that is yet to be written.
    #[must_use]
    pub fn new(path: PathBuf) -> Self {
        Self { path, seen: None }
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the file holds something else than was last read or written here.
    #[must_use]
    pub fn changed_on_disk(&self) -> bool {
        match read_file(&self.path) {
            Ok(bytes) => self.seen.is_some_and(|seen| seen != blake3::hash(&bytes)),
            Err(_) => false,
        }
    }

    /// Takes what the file holds now as seen, so that saving overwrites it.
    pub fn accept(&mut self) {
        self.seen = read_file(&self.path).ok().map(|bytes| blake3::hash(&bytes));
    }

    /// Writes the document.
    ///
    /// # Errors
    /// [`SaveError::ChangedOnDisk`], and what the file system says.
    pub fn save(&mut self, document: &Document, registry: &Registry) -> Result<(), SaveError> {
        if self.changed_on_disk() {
            return Err(SaveError::ChangedOnDisk(self.path.clone()));
        }
        let text = document.to_ron(registry);
        save_whole(&self.path, text.as_bytes())
            .map_err(|source| SaveError::Io { path: self.path.clone(), source })?;
        self.seen = Some(blake3::hash(text.as_bytes()));
        Ok(())
    }

    /// As [`save`](Self::save), on a thread of its own: a slow disk holds nobody up. With `over`, what someone else wrote
    /// is written over. `wake` is called, from that thread, when it is done.
    #[must_use]
    pub fn save_beside(
        &self,
        document: Arc<Document>,
        registry: Arc<Registry>,
        over: bool,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Saving {
        let (sender, answer) = mpsc::channel();
        let mut file = self.clone();
        let write = move || {
            if over {
                file.accept();
            }
            let outcome = file.save(&document, &registry);
            // The window may be gone by then.
            let _ = sender.send(Saved { file, outcome });
            wake();
        };
        // Where no thread can be started, its end of the line is gone at once.
        let _ = std::thread::Builder::new().name("save".into()).spawn(write);
        Saving { file: self.clone(), answer }
    }
}

/// A document that is being written.
pub struct Saving {
    file: OpenFile,
    answer: Receiver<Saved>,
}

/// What came of writing a document.
#[derive(Debug)]
pub struct Saved {
    /// The file, with what it holds now as seen.
    pub file: OpenFile,
    /// Whether it was written, or why not.
    pub outcome: Result<(), SaveError>,
}

impl Saving {
    /// What came of it, once it is over.
    pub fn poll(&mut self) -> Option<Saved> {
        match self.answer.try_recv() {
            Ok(saved) => Some(saved),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(self.lost()),
        }
    }

    /// Waits until it is over.
    #[must_use]
    pub fn wait(self) -> Saved {
        self.answer.recv().unwrap_or_else(|_| self.lost())
    }

    fn lost(&self) -> Saved {
        let source = io::Error::other("no thread could be started that writes it");
        let outcome = Err(SaveError::Io { path: self.file.path.clone(), source });
        Saved { file: self.file.clone(), outcome }
    }
}
