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

use orograph_abi::Cells;
use orograph_core::{Error, Job, PortSpec, Result, Value};

static JOBS: RwLock<BTreeMap<u64, Arc<LiveJob>>> = RwLock::new(BTreeMap::new());
static NEXT: AtomicU64 = AtomicU64::new(1);

/// What the host keeps of a running job.
pub(super) struct LiveJob {
    /// The job, while it runs: none once it is over. Its lifetime is shorter than it says; see [`enter`].
    job: RwLock<Option<Running<'static>>>,
    state: Mutex<State>,
}

/// A job and where its outputs go.
#[derive(Clone, Copy)]
pub(super) struct Running<'a> {
    pub(super) job: Job<'a>,
    /// The output ports.
    pub(super) ports: &'a [PortSpec],
    pub(super) keeper: &'a dyn Keep,
}

/// Keeps the outputs of a job.
pub(super) trait Keep: Sync {
    /// What is to become of a raster's cells, which the plugin only lends until [`keep`](Self::keep) returns.
    fn cells(&self) -> Cells;
    /// Keeps the value of a port, which is of the right type and comes once.
    ///
    /// # Errors
    /// When there is no room for it.
    fn keep(&self, port: usize, value: Value) -> Result<()>;
}

/// What a plugin has said and taken so far.
#[derive(Default)]
pub(super) struct State {
    /// For each output port whether its value was given.
    pub(super) given: Vec<bool>,
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
pub(super) fn enter(running: Running<'_>) -> Entered {
    let given = vec![false; running.ports.len()];
    // SAFETY: a longer lifetime than it has. dropping what this gives takes the job out before the true one ends, and waits for the calls
    // that are using it.
    let running = unsafe { std::mem::transmute::<Running<'_>, Running<'static>>(running) };
    let live = Arc::new(LiveJob {
        job: RwLock::new(Some(running)),
        state: Mutex::new(State { given, ..State::default() }),
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
pub(super) fn with<T>(id: u64, act: impl FnOnce(&LiveJob, &Running<'_>) -> T) -> Option<T> {
    let live = Arc::clone(JOBS.read().unwrap_or_else(PoisonError::into_inner).get(&id)?);
    let job = live.job.read().unwrap_or_else(PoisonError::into_inner);
    let job = job.as_ref()?;
    Some(act(&live, job))
}
