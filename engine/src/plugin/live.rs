//! The jobs that run now, by id.
//!
//! A plugin knows a job by a number alone, so a call that comes late, from a thread that outlived its job, finds
//! nothing and does nothing.

use std::{
    alloc::{Layout, alloc_zeroed, dealloc},
    collections::BTreeMap,
    ffi::c_void,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError, RwLock,
        atomic::{AtomicU64, Ordering},
    },
};

use orograph_core::{Error, Job, PortSpec, Value};

static JOBS: RwLock<BTreeMap<u64, Arc<LiveJob>>> = RwLock::new(BTreeMap::new());
static NEXT: AtomicU64 = AtomicU64::new(1);

/// What the host keeps of a running job.
pub(super) struct LiveJob {
    /// The job, while it runs: none once it is over. Its lifetime is longer than it says; see [`enter`].
    job: RwLock<Option<Job<'static>>>,
    state: Mutex<State>,
}

/// What a plugin has said and taken so far.
#[derive(Default)]
pub(super) struct State {
    /// The output ports' names and types, and the values given.
    pub(super) outputs: Vec<(PortSpec, Option<Value>)>,
    /// The first thing that went wrong.
    pub(super) failure: Option<Error>,
    scratch: Vec<Scratch>,
    scratch_bytes: u64,
    /// Paths handed out, which stay until the job ends.
    pub(super) paths: Vec<String>,
}

/// Memory that a plugin works in.
struct Scratch {
    place: *mut u8,
    layout: Layout,
}

// SAFETY: it is memory of nobody's thread.
unsafe impl Send for Scratch {}

impl Drop for Scratch {
    fn drop(&mut self) {
        // SAFETY: it was allocated with this layout, and is given back once.
        unsafe { dealloc(self.place, self.layout) }
    }
}

/// The id and what is kept of a job while it runs.
pub(super) struct Entered {
    pub(super) id: u64,
    live: Arc<LiveJob>,
}

/// Enters a job into the list until what this gives is dropped.
pub(super) fn enter(job: &Job, outputs: &[PortSpec]) -> Entered {
    // SAFETY: a longer lifetime than it has. `leave` takes the job out before the true one ends, and waits for the calls
    // that are using it.
    let job = unsafe { std::mem::transmute::<Job<'_>, Job<'static>>(*job) };
    let outputs = outputs.iter().map(|port| (port.clone(), None)).collect();
    let live = Arc::new(LiveJob {
        job: RwLock::new(Some(job)),
        state: Mutex::new(State { outputs, ..State::default() }),
    });
    let id = NEXT.fetch_add(1, Ordering::Relaxed);
    JOBS.write().unwrap_or_else(PoisonError::into_inner).insert(id, Arc::clone(&live));
    Entered { id, live }
}

impl Entered {
    /// Ends the job: no call reaches it any more. Gives what the plugin said.
    pub(super) fn leave(self) -> State {
        let live = Arc::clone(&self.live);
        drop(self);
        std::mem::take(&mut *live.state())
    }
}

impl Drop for Entered {
    fn drop(&mut self) {
        JOBS.write().unwrap_or_else(PoisonError::into_inner).remove(&self.id);
        *self.live.job.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl LiveJob {
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes what went wrong, unless something did before.
    pub(super) fn fail(&self, error: Error) {
        self.state().failure.get_or_insert(error);
    }

    /// Zeroed memory, counted against the job's limit.
    pub(super) fn allocate(&self, job: &Job, bytes: usize) -> Option<*mut c_void> {
        let layout = Layout::from_size_align(bytes.max(1), 64).ok()?;
        let mut state = self.state();
        let total = state.scratch_bytes.checked_add(layout.size() as u64)?;
        if total > job.memory_limit() {
            return None;
        }
        // SAFETY: the layout has a size.
        let place = unsafe { alloc_zeroed(layout) };
        if place.is_null() {
            return None;
        }
        state.scratch_bytes = total;
        state.scratch.push(Scratch { place, layout });
        Some(place.cast())
    }

    /// Gives memory back that `allocate` gave.
    pub(super) fn free(&self, memory: *mut c_void) {
        let mut state = self.state();
        if let Some(index) = state.scratch.iter().position(|scratch| scratch.place.cast() == memory) {
            let scratch = state.scratch.swap_remove(index);
            state.scratch_bytes -= scratch.layout.size() as u64;
        }
    }
}

/// Calls `act` with the job of that id, which stays for as long as the call; `None` when it is over.
pub(super) fn with<T>(id: u64, act: impl FnOnce(&LiveJob, &Job) -> T) -> Option<T> {
    let live = Arc::clone(JOBS.read().unwrap_or_else(PoisonError::into_inner).get(&id)?);
    let job = live.job.read().unwrap_or_else(PoisonError::into_inner);
    let job = job.as_ref()?;
    Some(act(&live, job))
}
