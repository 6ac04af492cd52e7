//! Isotonic regression on a tree: the nearest heights that never rise towards the root.
//!
//! Least squares under the order of a rooted tree, by pooling: the lowest of all blocks either hangs on nothing that is
//! higher, and is settled, or is pooled with the block that it hangs on (Thompson, W. A. (1962), "The problem of
//! negative estimates of variance components", Annals of Mathematical Statistics 33; Pardalos, P. M. and Xue, G.
//! (1999), "Algorithms for a class of isotonic regression problems", Algorithmica 23). O(n log n). On a tree that is a
//! line this is the pooling of adjacent violators.

use std::{cmp::Reverse, collections::BinaryHeap};

/// The root of a tree has no parent.
pub(super) const ROOT: u32 = u32::MAX;

/// For each node of a forest, given the parent of each, the value nearest to its own, all together in least squares,
/// such that no value is below its parent's.
pub(super) fn isotonic(parents: &[u32], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    // A block is known by its top node; other nodes point upwards within their block.
    let mut above: Vec<u32> = (0..n as u32).collect();
    let mut blocks: Vec<(f64, u32)> = values.iter().map(|&value| (value, 1)).collect();
    let mut heap: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    let entry = |(sum, count): (f64, u32), top: u32| Reverse((rank(sum / f64::from(count)), top, count));
    (0..n as u32).for_each(|top| heap.push(entry(blocks[top as usize], top)));
    let mut settled = vec![false; n];
    while let Some(Reverse((_, top, count))) = heap.pop() {
        // A block that was pooled since, or grew, has another entry or none.
        if above[top as usize] != top || blocks[top as usize].1 != count {
            continue;
        }
        let parent = parents[top as usize];
        let over = if parent == ROOT { ROOT } else { find(&mut above, parent) };
        if over == ROOT || settled[over as usize] {
            settled[top as usize] = true;
            continue;
        }
        above[top as usize] = over;
        let (sum, count) = blocks[top as usize];
        let block = &mut blocks[over as usize];
        *block = (block.0 + sum, block.1 + count);
        heap.push(entry(*block, over));
    }
    (0..n as u32)
        .map(|node| {
            let (sum, count) = blocks[find(&mut above, node) as usize];
            sum / f64::from(count)
        })
        .collect()
}

/// The top of a node's block.
fn find(above: &mut [u32], mut node: u32) -> u32 {
    while above[node as usize] != node {
        above[node as usize] = above[above[node as usize] as usize];
        node = above[node as usize];
    }
    node
}

/// Bits that ascend as the number does.
fn rank(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

#[cfg(test)]
mod tests {
    use orograph_core::{gaussian, key};

    use super::*;

    /// Isotonic regression by its closed form on a line: at each place the greatest of the means of runs that start
    /// there or before, each the least over its ends.
    fn by_means(values: &[f64]) -> Vec<f64> {
        let n = values.len();
        let mean = |a: usize, b: usize| values[a..=b].iter().sum::<f64>() / (b + 1 - a) as f64;
        let least = |a: usize, i: usize| (i..n).map(|b| mean(a, b)).fold(f64::INFINITY, f64::min);
        (0..n).map(|i| (0..=i).map(|a| least(a, i)).fold(f64::NEG_INFINITY, f64::max)).collect()
    }

    #[test]
    fn on_a_line_it_is_the_closed_form() {
        for seed in 0..40 {
            let n = 1 + seed as usize % 17;
            let values: Vec<f64> = (0..n).map(|i| gaussian(seed, 1, i as i64, 0) + 0.1 * i as f64).collect();
            let parents: Vec<u32> = (0..n as u32).map(|i| if i == 0 { ROOT } else { i - 1 }).collect();
            for (found, truth) in isotonic(&parents, &values).iter().zip(by_means(&values)) {
                assert!((found - truth).abs() < 1e-12, "{found} {truth}");
            }
        }
    }

    #[test]
    fn on_trees_no_better_heights_are_found() {
        for seed in 0..40 {
            let n = 14;
            let draw = |stream: u64, i: u32| key(seed, stream, i64::from(i), 0);
            let parents: Vec<u32> = (0..n)
                .map(
                    |i| if i == 0 || draw(1, i) % 9 == 0 { ROOT } else { (draw(2, i) % u64::from(i)) as u32 },
                )
                .collect();
            let values: Vec<f64> =
                (0..n).map(|i| (3.0 * gaussian(seed, 3, i64::from(i), 0)).round()).collect();
            let found = isotonic(&parents, &values);
            let below = |i: usize| (parents[i] != ROOT).then(|| parents[i] as usize);
            assert!((0..n as usize).all(|i| below(i).is_none_or(|p| found[p] <= found[i] + 1e-12)));
            // Hildreth's method for the dual: forces between parent and child that push them apart and never pull.
            let mut force = vec![0.0; n as usize];
            let mut best = values.clone();
            for _ in 0..4000 {
                for i in 0..n as usize {
                    let Some(p) = below(i) else { continue };
                    let push = f64::max(force[i] + (best[p] - best[i]) / 2.0, 0.0) - force[i];
                    force[i] += push;
                    best[i] += push;
                    best[p] -= push;
                }
            }
            for (found, best) in found.iter().zip(best) {
                assert!((found - best).abs() < 1e-6, "{seed}: {found} {best}");
            }
        }
    }
}
