//! Which computations are under way in this process: one a key, however many runs want it.

use std::{
    collections::hash_map::Entry,
    sync::{Mutex, MutexGuard, PoisonError, Weak},
};

use orograph_core::Digest;

use super::{CancelToken, run::Run};
use crate::cache::DigestMap;

/// Computations under way or about to be in this process, with the nodes that want them.
///
/// Its lock is the last one taken: a run asks it under the lock of its table, and it asks no run.
#[derive(Default)]
pub(crate) struct InFlight(Mutex<DigestMap<Computation>>);

#[derive(Default)]
struct Computation {
    under_way: bool,
    wanted_by: Vec<Claimant>,
}

/// A node of a run.
struct Claimant {
    run: Weak<Run>,
    node: u32,
    cancel: CancelToken,
    /// It waits for another one to compute; otherwise it is queued to do so itself.
    waits: bool,
}

impl Claimant {
    /// A run that was cancelled, or is over, wants nothing any more.
    fn wants(&self) -> bool {
        !self.cancel.is_cancelled() && self.run.strong_count() > 0
    }
}

impl Computation {
    fn remove(&mut self, run: &Weak<Run>, node: u32) {
        self.wanted_by.retain(|other| other.node != node || !Weak::ptr_eq(&other.run, run));
    }

    fn add(&mut self, run: &Weak<Run>, node: u32, cancel: &CancelToken) {
        self.remove(run, node);
        let (run, cancel, waits) = (Weak::clone(run), cancel.clone(), self.under_way);
        self.wanted_by.push(Claimant { run, node, cancel, waits });
    }
}

impl InFlight {
    /// Notes that a node wants `key`. Whether someone else computes it now: then the node is told when that is over.
    pub(super) fn want(&self, key: Digest, run: &Weak<Run>, node: u32, cancel: &CancelToken) -> bool {
        let mut table = self.lock();
        let computation = table.entry(key).or_default();
        computation.add(run, node, cancel);
        computation.under_way
    }

    /// Whether the node is to compute `key`; otherwise it is told when someone else has.
    pub(super) fn claim(&self, key: Digest, run: &Weak<Run>, node: u32, cancel: &CancelToken) -> bool {
        let mut table = self.lock();
        let computation = table.entry(key).or_default();
        if computation.under_way {
            computation.add(run, node, cancel);
            return false;
        }
        computation.remove(run, node);
        computation.under_way = true;
        true
    }

    /// Notes that a queued node wants `key` no more, or not yet again.
    pub(super) fn forget(&self, key: Digest, run: &Weak<Run>, node: u32) {
        if let Entry::Occupied(mut entry) = self.lock().entry(key) {
            entry.get_mut().remove(run, node);
            if !entry.get().under_way && entry.get().wanted_by.is_empty() {
                entry.remove();
            }
        }
    }

    /// Whether a run that was not cancelled wants `key`, beside the one that computes it.
    pub(super) fn is_wanted(&self, key: &Digest) -> bool {
        self.lock().get(key).is_some_and(|computation| computation.wanted_by.iter().any(Claimant::wants))
    }

    /// The nodes that want `key` now, beside the one that computes it.
    pub(super) fn wanted_by(&self, key: &Digest) -> Vec<(Weak<Run>, u32)> {
        let table = self.lock();
        let all = table.get(key).into_iter().flat_map(|computation| &computation.wanted_by);
        all.filter(|one| one.wants()).map(|one| (Weak::clone(&one.run), one.node)).collect()
    }

    /// Those who wait for `key`, which is no longer under way. Who is queued to compute it stays so.
    pub(super) fn release(&self, key: &Digest) -> Vec<(Weak<Run>, u32)> {
        let mut table = self.lock();
        let Some(computation) = table.remove(key) else { return Vec::new() };
        let (waiting, queued): (Vec<_>, Vec<_>) =
            computation.wanted_by.into_iter().partition(|one| one.waits);
        if !queued.is_empty() {
            table.insert(*key, Computation { under_way: false, wanted_by: queued });
        }
        waiting.into_iter().map(|one| (one.run, one.node)).collect()
    }

    #[cfg(test)]
    pub(super) fn is_empty(&self) -> bool {
        self.lock().is_empty()
    }

    fn lock(&self) -> MutexGuard<'_, DigestMap<Computation>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
