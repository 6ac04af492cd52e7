//! The memory tier: values by digest, under a budget in bytes.

use std::{
    collections::BTreeMap,
    sync::{Mutex, MutexGuard, PoisonError},
};

use orograph_core::{Digest, Value};

use super::DigestMap;

/// Values by digest. The least recently used leave first when the budget is exceeded; a pinned value, one
/// that a run still needs, leaves only when it lies on disk too.
pub(crate) struct MemoryTier {
    budget: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    entries: DigestMap<Entry>,
    by_age: BTreeMap<u64, Digest>,
    clock: u64,
    bytes: u64,
}

struct Entry {
    value: Value,
    bytes: u64,
    age: u64,
    pins: u32,
    on_disk: bool,
}

impl MemoryTier {
    pub(crate) fn new(budget: u64) -> Self {
        Self { budget, state: Mutex::default() }
    }

    pub(crate) fn budget(&self) -> u64 {
        self.budget
    }

    /// Bytes held now.
    pub(crate) fn bytes(&self) -> u64 {
        self.lock().bytes
    }

    pub(crate) fn get(&self, digest: &Digest) -> Option<Value> {
        let mut state = self.lock();
        let state = &mut *state;
        let entry = state.entries.get_mut(digest)?;
        state.by_age.remove(&entry.age);
        state.clock += 1;
        entry.age = state.clock;
        state.by_age.insert(entry.age, *digest);
        Some(entry.value.clone())
    }

    pub(crate) fn contains(&self, digest: &Digest) -> bool {
        self.lock().entries.contains_key(digest)
    }

    /// Adds a value with `pins` pins.
    pub(crate) fn insert(&self, digest: Digest, value: Value, pins: u32, on_disk: bool) {
        let bytes = value.size_in_memory();
        let mut state = self.lock();
        let state = &mut *state;
        if let Some(entry) = state.entries.get_mut(&digest) {
            entry.pins += pins;
            entry.on_disk |= on_disk;
            return;
        }
        state.clock += 1;
        let entry = Entry { value, bytes, age: state.clock, pins, on_disk };
        state.by_age.insert(entry.age, digest);
        state.entries.insert(digest, entry);
        state.bytes += bytes;
        state.shrink(self.budget);
    }

    pub(crate) fn unpin(&self, digest: &Digest) {
        let mut state = self.lock();
        if let Some(entry) = state.entries.get_mut(digest) {
            entry.pins = entry.pins.saturating_sub(1);
        }
        state.shrink(self.budget);
    }

    /// Notes that the value can be had from disk again.
    pub(crate) fn mark_on_disk(&self, digest: &Digest) {
        let mut state = self.lock();
        if let Some(entry) = state.entries.get_mut(digest) {
            entry.on_disk = true;
        }
        state.shrink(self.budget);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // A panic elsewhere leaves the state consistent: no code that can panic runs under the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn shrink(&mut self, budget: u64) {
        if self.bytes <= budget {
            return;
        }
        for spill_pinned in [false, true] {
            let leaving: Vec<Digest> = self
                .by_age
                .values()
                .filter(|digest| {
                    self.entries
                        .get(digest)
                        .is_some_and(|entry| entry.pins == 0 || (spill_pinned && entry.on_disk))
                })
                .copied()
                .collect();
            for digest in leaving {
                if self.bytes <= budget {
                    return;
                }
                if let Some(entry) = self.entries.remove(&digest) {
                    self.by_age.remove(&entry.age);
                    self.bytes -= entry.bytes;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(x: f64) -> (Digest, Value) {
        let value = Value::Number(x);
        (value.digest(), value)
    }

    #[test]
    fn the_least_recently_used_leaves_first_and_pins_hold() {
        let one = Value::Number(0.0).size_in_memory();
        let tier = MemoryTier::new(3 * one);
        let values: Vec<_> = (0..5).map(|i| number(f64::from(i))).collect();
        for (digest, value) in &values[..3] {
            tier.insert(*digest, value.clone(), 0, false);
        }
        assert!(tier.get(&values[0].0).is_some());
        tier.insert(values[3].0, values[3].1.clone(), 1, false);
        assert!(!tier.contains(&values[1].0), "the oldest untouched value leaves");
        assert!(tier.contains(&values[0].0));
        assert!(tier.bytes() <= 3 * one);
        // Everything pinned and not on disk: the budget yields, nothing is lost.
        let tier = MemoryTier::new(one);
        for (digest, value) in &values {
            tier.insert(*digest, value.clone(), 1, false);
        }
        assert_eq!(tier.bytes(), 5 * one);
        tier.mark_on_disk(&values[2].0);
        assert!(!tier.contains(&values[2].0), "a pinned value that lies on disk may leave");
        for (digest, _) in &values {
            tier.unpin(digest);
        }
        assert_eq!(tier.bytes(), one);
    }
}
