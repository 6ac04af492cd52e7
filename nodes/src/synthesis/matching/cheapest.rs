//! The best of many by a cost that is dear to tell and that a cheap one bounds from below.

use std::cmp::Ordering;

use rayon::prelude::*;

/// Judged at once: enough to keep every thread at work.
const AT_ONCE: usize = 64;

/// What competes, what it costs, and its place among the others, which decides between equals.
struct Entry<T> {
    item: T,
    cost: f64,
    rank: usize,
}

impl<T> Entry<T> {
    fn order(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.rank.cmp(&other.rank))
    }
}

/// The `n` cheapest of `items` that `fits` accepts, cheapest first, of equals the earlier.
///
/// `bound` must not be more than `cost`: what it tells apart is never judged. `fits` is asked only of those that would be
/// among the best.
pub(super) fn cheapest<T: Send>(
    items: Vec<T>,
    n: usize,
    bound: impl Fn(&T) -> f64,
    cost: impl Fn(&T) -> f64 + Sync,
    fits: impl Fn(&T) -> bool,
) -> Vec<T> {
    let mut entries: Vec<Entry<T>> =
        items.into_iter().enumerate().map(|(rank, item)| Entry { cost: bound(&item), item, rank }).collect();
    entries.sort_by(Entry::order);
    let mut entries = entries.into_iter();
    let mut best: Vec<Entry<T>> = Vec::with_capacity(n.saturating_add(1).min(entries.len() + 1));
    loop {
        let mut next: Vec<Entry<T>> = entries.by_ref().take(AT_ONCE).collect();
        let Some(least) = next.first().map(|entry| entry.cost) else { break };
        if best.len() == n && best.last().is_none_or(|worst| worst.cost < least) {
            break;
        }
        next.par_iter_mut().for_each(|entry| entry.cost = cost(&entry.item));
        for entry in next {
            let at = best.partition_point(|other| other.order(&entry).is_lt());
            if at < n && fits(&entry.item) {
                best.insert(at, entry);
                best.truncate(n);
            }
        }
    }
    best.into_iter().map(|entry| entry.item).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use orograph_core::{key, unit};

    use super::*;

    #[test]
    fn the_same_as_judging_all_and_sorting_them() {
        for seed in 0..40 {
            let draw = |i: usize, what: i64| unit(key(seed, 1, i as i64, what));
            // Few different values, so that there are equals.
            let bound = |i: &usize| (draw(*i, 0) * 8.0).floor();
            let cost = |i: &usize| bound(i) + (draw(*i, 1) * 4.0).floor();
            let fits = |i: &usize| draw(*i, 2) < 0.7;
            for n in [0, 1, 12, 400] {
                let mut all: Vec<usize> = (0..300).filter(fits).collect();
                all.sort_by(|a, b| cost(a).total_cmp(&cost(b)).then(a.cmp(b)));
                all.truncate(n);
                assert_eq!(cheapest((0..300).collect(), n, bound, cost, fits), all);
            }
        }
    }

    #[test]
    fn what_the_bound_rules_out_is_not_judged() {
        let judged = AtomicUsize::new(0);
        let cost = |i: &usize| {
            judged.fetch_add(1, Relaxed);
            *i as f64
        };
        assert_eq!(cheapest((0..1000).collect(), 2, |i| *i as f64, cost, |_| true), [0, 1]);
        assert_eq!(judged.into_inner(), AT_ONCE);
        assert!(cheapest(Vec::<usize>::new(), 2, |_| 0.0, |_| 0.0, |_| true).is_empty());
    }
}
