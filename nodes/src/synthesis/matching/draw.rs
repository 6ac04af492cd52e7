//! Chance among the best: the seed of a run makes variants.

/// Candidates that cost more than this many times what the best costs are never drawn.
const WORST: f64 = 1.2;

/// Which of the candidates with these costs is taken, given `chance` in 0..1: of the `among` cheapest one with weights
/// `exp(-(c - least) / least)`, the earlier of equals first. `None` when there are none.
///
/// One that costs far more than the best is left out, and where the best costs nothing it is taken.
pub(super) fn draw(costs: &[f64], among: usize, chance: f64) -> Option<usize> {
    let mut ranks: Vec<usize> = (0..costs.len()).collect();
    ranks.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]).then(a.cmp(&b)));
    let best = *ranks.first()?;
    let least = costs[best];
    ranks.truncate(among);
    ranks.retain(|&rank| costs[rank] <= WORST * least);
    if !(least > 0.0 && least.is_finite()) || ranks.is_empty() {
        return Some(best);
    }
    let weights: Vec<f64> = ranks.iter().map(|&rank| libm::exp(-(costs[rank] - least) / least)).collect();
    let mut left = chance * weights.iter().sum::<f64>();
    for (&rank, weight) in ranks.iter().zip(&weights) {
        left -= weight;
        if left < 0.0 {
            return Some(rank);
        }
    }
    ranks.last().copied()
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, unit};

    use super::*;

    #[test]
    fn how_often_each_is_drawn_follows_from_its_cost() {
        let costs = [3.3, 3.7, f64::NAN, 3.0, 6.0, 3.5];
        let n = 40_000;
        let mut counts = [0.0; 6];
        for i in 0..n {
            counts[draw(&costs, 4, unit(key(7, 1, i, 0))).unwrap()] += 1.0 / n as f64;
        }
        // The four cheapest are 3, 3.3, 3.5 and 3.7, the last of which costs more than a fifth more than the best.
        let weights = [(3, 1.0), (0, libm::exp(-0.3 / 3.0)), (5, libm::exp(-0.5 / 3.0))];
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        for (which, weight) in weights {
            let share: f64 = counts[which];
            assert!((share - weight / sum).abs() < 0.01, "{which}: {share}");
        }
        assert_eq!((counts[1], counts[2], counts[4]), (0.0, 0.0, 0.0));
    }

    #[test]
    fn the_best_is_taken_where_nothing_is_left_to_chance() {
        for chance in [0.0, 0.5, 0.999_999] {
            assert_eq!(draw(&[3.0, 2.0, 2.0, 2.1], 1, chance), Some(1));
            assert_eq!(draw(&[3.0, 2.0], 0, chance), Some(1));
            assert_eq!(draw(&[0.1, 0.0, 0.2], 3, chance), Some(1));
            assert_eq!(draw(&[f64::NAN, f64::NAN], 2, chance), Some(0));
            assert_eq!(draw(&[f64::INFINITY, f64::INFINITY], 2, chance), Some(0));
            assert_eq!(draw(&[], 3, chance), None);
        }
    }
}
