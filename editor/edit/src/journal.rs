//! What is not saved yet, kept where a crash cannot take it.
//!
//! A thread of its own writes the newest document into the folder of recoveries, whole each time, within half a second
//! of the edit. Which journals belong to a program that still runs is told by a lock that the system lets go of when
//! the program ends, however it ends.

use std::{
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::Duration,
};

use orograph_engine::{Document, Registry, save_whole};
use serde::{Deserialize, Serialize};

/// How long an edit waits for others before all are written.
const PAUSE: Duration = Duration::from_millis(300);

/// What was not saved when a program ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recovery {
    /// The file of the document; none for one that was never saved.
    pub path: Option<PathBuf>,
    /// The document as a graph file.
    pub text: String,
}

/// Keeps what is not saved of one document.
pub struct Journal {
    desk: Arc<Desk>,
    writer: Option<JoinHandle<()>>,
    place: PathBuf,
    lock: PathBuf,
    _held: File,
}

/// Where orders for the writer lie; a newer one takes the place of an older one.
struct Desk {
    state: Mutex<State>,
    changed: Condvar,
    /// The node types by which documents are written.
    registry: Mutex<Arc<Registry>>,
}

#[derive(Default)]
struct State {
    order: Option<Order>,
    busy: bool,
    hurried: bool,
    closing: bool,
    failure: Option<io::Error>,
}

enum Order {
    Keep(Option<PathBuf>, Arc<Document>),
    Forget,
}

impl Journal {
    /// A journal in `folder`, which is made when it is not there.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn begin(folder: &Path, registry: Arc<Registry>) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let (held, lock) = own_lock(folder)?;
        let place = lock.with_extension("ron");
        let desk = Arc::new(Desk {
            state: Mutex::default(),
            changed: Condvar::new(),
            registry: Mutex::new(registry),
        });
        let writer = {
            let (desk, place) = (desk.clone(), place.clone());
            std::thread::Builder::new().name("journal".into()).spawn(move || desk.serve(&place))?
        };
        Ok(Self { desk, writer: Some(writer), place, lock, _held: held })
    }

    /// Keeps a document that is not saved.
    pub fn keep(&self, path: Option<&Path>, document: Arc<Document>) {
        self.desk.put(Order::Keep(path.map(Path::to_owned), document));
    }

    /// Writes by other node types from now on, as after plugins came or went.
    pub fn use_registry(&self, registry: Arc<Registry>) {
        *self.desk.registry.lock().unwrap_or_else(PoisonError::into_inner) = registry;
    }

    /// Forgets it: it is saved, or was given up.
    pub fn forget(&self) {
        self.desk.put(Order::Forget);
    }

    /// Waits until everything that was to be kept is on disk.
    ///
    /// # Errors
    /// When something could not be written.
    pub fn flush(&self) -> io::Result<()> {
        let mut state = self.desk.lock();
        state.hurried = true;
        self.desk.changed.notify_all();
        while state.order.is_some() || state.busy {
            state = self.desk.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.hurried = false;
        state.failure.take().map_or(Ok(()), Err)
    }

    /// Why the last write failed, once.
    pub fn take_failure(&self) -> Option<io::Error> {
        self.desk.lock().failure.take()
    }

    /// What other programs left unsaved when they ended. Each is given once: its journal is taken over, and removed
    /// when the recovery is [`Left::forget`]ed.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn left(folder: &Path) -> io::Result<Vec<Left>> {
        let mut left = Vec::new();
        let entries = match fs::read_dir(folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(left),
            Err(error) => return Err(error),
        };
        let mut places: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        places.sort();
        for lock in places.into_iter().filter(|path| path.extension().is_some_and(|kind| kind == "lock")) {
            let Ok(held) = File::open(&lock) else { continue };
            if held.try_lock().is_err() {
                continue;
            }
            let place = lock.with_extension("ron");
            let recovery = fs::read_to_string(&place).ok().and_then(|text| ron::from_str(&text).ok());
            match recovery {
                Some(recovery) => left.push(Left { recovery, place, lock, _held: held }),
                None => {
                    let _ = fs::remove_file(&place);
                    let _ = fs::remove_file(&lock);
                }
            }
        }
        Ok(left)
    }
}

/// A journal that a program left behind.
pub struct Left {
    /// What it holds.
    pub recovery: Recovery,
    place: PathBuf,
    lock: PathBuf,
    _held: File,
}

impl Left {
    /// How long ago it was kept last, where the system can tell.
    #[must_use]
    pub fn age(&self) -> Option<Duration> {
        fs::metadata(&self.place).ok()?.modified().ok()?.elapsed().ok()
    }

    /// Removes the journal; without this it is found again at the next start.
    pub fn forget(self) {
        let _ = fs::remove_file(&self.place);
        let _ = fs::remove_file(&self.lock);
    }
}

fn own_lock(folder: &Path) -> io::Result<(File, PathBuf)> {
    for n in 0..u32::MAX {
        let path = folder.join(format!("{}-{n}.lock", std::process::id()));
        let file = File::options().create(true).truncate(false).write(true).open(&path)?;
        match file.try_lock() {
            // What an earlier program of the same number left is not to be overwritten.
            Ok(()) if path.with_extension("ron").exists() => {}
            Ok(()) => return Ok((file, path)),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => return Err(error),
        }
    }
    Err(io::Error::other("no free name for a journal"))
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, order: Order) {
        self.lock().order = Some(order);
        self.changed.notify_all();
    }

    /// Writes what is ordered until the journal closes.
    fn serve(&self, place: &Path) {
        let mut state = self.lock();
        loop {
            while state.order.is_none() && !state.closing {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            // Counted from the first edit, so that a long drag is written while it goes on.
            let hurried = |state: &mut State| !state.hurried && !state.closing;
            let waited = self.changed.wait_timeout_while(state, PAUSE, hurried);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
            let Some(order) = state.order.take() else { return };
            state.busy = true;
            drop(state);
            let outcome = match order {
                Order::Keep(path, document) => {
                    let registry = self.registry.lock().unwrap_or_else(PoisonError::into_inner).clone();
                    put(place, path, &document, &registry)
                }
                Order::Forget => forget(place),
            };
            state = self.lock();
            state.busy = false;
            state.failure = outcome.err();
            self.changed.notify_all();
        }
    }
}

impl Drop for Journal {
    /// What was ordered is still written; a journal that holds nothing leaves nothing behind.
    fn drop(&mut self) {
        self.desk.lock().closing = true;
        self.desk.changed.notify_all();
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
        if !self.place.exists() {
            let _ = fs::remove_file(&self.lock);
        }
    }
}

fn put(place: &Path, path: Option<PathBuf>, document: &Document, registry: &Registry) -> io::Result<()> {
    let recovery = Recovery { path, text: document.to_ron(registry) };
    let text = ron::to_string(&recovery).map_err(io::Error::other)?;
    save_whole(place, text.as_bytes())
}

fn forget(place: &Path) -> io::Result<()> {
    match fs::remove_file(place) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
