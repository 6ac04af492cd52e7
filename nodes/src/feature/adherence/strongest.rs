//! The strongest of many lines, and what they join.

use orograph_core::{FeatureKind, Heightfield};

use crate::{
    feature::{chains::distance, network::Network, profiles::normal},
    transform::sample::{Interpolation, sample},
};

/// The lines with the greatest product of length and height over their sides, until `length` is reached.
pub(super) fn strongest(network: &Network<'_>, terrain: &Heightfield, length: f64) -> Vec<usize> {
    let features = network.features();
    let off = 3.0 * features.scale;
    let turn = if features.kind == FeatureKind::Ridge { 1.0 } else { -1.0 };
    let strength = |line: usize| {
        let path = &features.lines[line].vertices;
        let (mut n, mut sum) = (0.0, 0.0);
        for (i, &at) in path.iter().enumerate() {
            let across = normal(path, i);
            let height = |sign: f64| {
                let [row, col] = [0, 1].map(|k| at[k] + sign * off * across[k]);
                f64::from(sample(terrain, row, col, Interpolation::Bilinear))
            };
            let drop = turn * (height(0.0) - (height(1.0) + height(-1.0)) / 2.0);
            if drop.is_finite() {
                (n, sum) = (n + 1.0, sum + drop);
            }
        }
        if n > 0.0 { network.length(line) * sum / n } else { 0.0 }
    };
    let mut ranked: Vec<(f64, usize)> =
        (0..features.lines.len()).map(|line| (strength(line), line)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut so_far = 0.0;
    let enough = |&(_, line): &(f64, usize)| {
        let wanted = so_far < length;
        so_far += network.length(line);
        wanted
    };
    let mut lines: Vec<usize> = ranked.into_iter().take_while(enough).map(|ranked| ranked.1).collect();
    lines.sort_unstable();
    lines
}

/// Branch points and components of some lines, points nearer than `radius` taken as one.
pub(super) fn topology(network: &Network<'_>, lines: &[usize], radius: f64) -> [usize; 2] {
    let features = network.features();
    let mut degrees = vec![0_usize; features.points.len()];
    let mut trees: Vec<usize> = (0..features.points.len()).collect();
    let root = |trees: &[usize], mut point: usize| {
        while trees[point] != point {
            point = trees[point];
        }
        point
    };
    for &line in lines {
        let ends = [features.lines[line].from as usize, features.lines[line].to as usize];
        ends.iter().for_each(|&end| degrees[end] += 1);
        let (a, b) = (root(&trees, ends[0]), root(&trees, ends[1]));
        trees[a.max(b)] = a.min(b);
    }
    let used: Vec<usize> = (0..degrees.len()).filter(|&point| degrees[point] > 0).collect();
    let mut groups: Vec<usize> = (0..degrees.len()).collect();
    for (i, &a) in used.iter().enumerate() {
        for &b in &used[i + 1..] {
            if distance(network.place(a), network.place(b)) > radius {
                continue;
            }
            for forest in [&mut trees, &mut groups] {
                let (a, b) = (root(forest, a), root(forest, b));
                forest[a.max(b)] = a.min(b);
            }
        }
    }
    let count = |forest: &[usize], points: &mut dyn Iterator<Item = usize>| {
        let mut roots: Vec<usize> = points.map(|point| root(forest, point)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots.len()
    };
    let branches = count(&groups, &mut used.iter().copied().filter(|&point| degrees[point] >= 3));
    [branches, count(&trees, &mut used.iter().copied())]
}
