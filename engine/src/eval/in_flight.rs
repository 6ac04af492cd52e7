//! Which computations are under way in this process: one a key, however many runs want it.

use std::{
    collections::hash_map::Entry,
    sync::{Mutex, PoisonError, Weak},
};

use orograph_core::Digest;

use super::run::Run;
use crate::cache::DigestMap;

/// Computations under way in this process, with those who wait for them.
#[derive(Default)]
pub(crate) struct InFlight(Mutex<DigestMap<Vec<Waiter>>>);

/// A node of a run.
type Waiter = (Weak<Run>, u32);

impl InFlight {
    /// Whether the caller is to compute `key`; otherwise it is told when someone else has.
    pub(super) fn claim(&self, key: Digest, run: &Weak<Run>, node: u32) -> bool {
        let mut table = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match table.entry(key) {
            Entry::Vacant(entry) => {
                entry.insert(Vec::new());
                true
            }
            Entry::Occupied(mut entry) => {
                entry.get_mut().push((Weak::clone(run), node));
                false
            }
        }
    }

    /// Those who wait for `key`, which is no longer under way.
    pub(super) fn release(&self, key: &Digest) -> Vec<Waiter> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).remove(key).unwrap_or_default()
    }
}
