//! The threads that a node's parallel work runs on.

use std::sync::{Arc, Mutex, Once, PoisonError};

use orograph_core::{Error, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Runs `work` where rayon's current pool has `threads` threads.
///
/// The plugin has its own copy of rayon. The first count that a host names becomes that of its global pool, which is
/// there without being entered, so that a run costs nothing that it does not use.
pub(crate) fn run<T: Send>(threads: usize, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    static FIRST: Once = Once::new();
    FIRST.call_once(|| {
        // Where the plugin made its global pool by itself, that one counts as the first.
        let _ = named(threads).build_global();
    });
    if rayon::current_num_threads() == threads {
        return work();
    }
    other(threads)?.install(work)
}

/// The pool of another count; one of each is kept.
fn other(threads: usize) -> Result<Arc<ThreadPool>> {
    static POOLS: Mutex<Vec<Arc<ThreadPool>>> = Mutex::new(Vec::new());
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.iter().find(|pool| pool.current_num_threads() == threads) {
        return Ok(pool.clone());
    }
    let pool = named(threads).build().map_err(|error| {
        Error::invalid(format!("no {threads} threads are to be had: {error}"), "run with fewer `--jobs`")
    })?;
    pools.push(Arc::new(pool));
    Ok(pools[pools.len() - 1].clone())
}

fn named(threads: usize) -> ThreadPoolBuilder {
    ThreadPoolBuilder::new().num_threads(threads).thread_name(|index| format!("plugin {index}"))
}
