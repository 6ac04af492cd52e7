//! Which tree comes first, and where each is entered.

use orograph_core::FeatureKind;

use super::radius;
use crate::feature::network::Network;

/// Groups of joined points, each ascending, by their first.
pub(super) fn components(network: &Network<'_>) -> Vec<Vec<usize>> {
    let n = network.features().points.len();
    let mut seen = vec![false; n];
    let mut components = Vec::new();
    for start in 0..n {
        if seen[start] || network.incidences(start).is_empty() {
            continue;
        }
        seen[start] = true;
        let mut group = vec![start];
        let mut next = 0;
        while next < group.len() {
            for &incidence in network.incidences(group[next]) {
                let far = network.far(incidence);
                if !seen[far] {
                    seen[far] = true;
                    group.push(far);
                }
            }
            next += 1;
        }
        group.sort_unstable();
        components.push(group);
    }
    components
}

/// Components, those with the most branch points first, then the longest; each with its root in front.
pub(super) fn sorted(network: &Network<'_>, components: Vec<Vec<usize>>, patch: f64) -> Vec<Vec<usize>> {
    let reach = |&point: &usize| -> f64 {
        network.incidences(point).iter().map(|incidence| network.length(incidence.line)).sum()
    };
    let is_branch = |&&point: &&usize| network.incidences(point).len() >= 3;
    let mut ranked: Vec<(usize, f64, Vec<usize>)> = components
        .into_iter()
        .map(|group| {
            let branches = group.iter().filter(is_branch).count();
            // Each line is counted from both of its ends.
            (branches, group.iter().map(reach).sum::<f64>() / 2.0, group)
        })
        .collect();
    ranked.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| b.1.total_cmp(&a.1)).then_with(|| a.2[0].cmp(&b.2[0])));
    let by_place = |&a: &usize, &b: &usize| {
        let (a, b) = (network.place(a), network.place(b));
        a[0].total_cmp(&b[0]).then_with(|| a[1].total_cmp(&b[1]))
    };
    let rooted = |(branches, _, mut group): (usize, f64, Vec<usize>)| {
        let root = if branches > 0 {
            let degree = |point: &usize| network.arms(*point, radius(patch)).len();
            group.iter().copied().filter(|point| is_branch(&point)).max_by(|a, b| {
                degree(a)
                    .cmp(&degree(b))
                    .then_with(|| reach(a).total_cmp(&reach(b)))
                    .then_with(|| by_place(b, a))
            })
        } else {
            let crest = |point: usize| {
                let height = f64::from(network.features().points[point].height);
                if network.features().kind == FeatureKind::Ridge { height } else { -height }
            };
            group.iter().copied().max_by(|&a, &b| {
                let ends = |point: usize| network.incidences(point).len() == 1;
                ends(a)
                    .cmp(&ends(b))
                    .then_with(|| crest(a).total_cmp(&crest(b)))
                    .then_with(|| by_place(&b, &a))
            })
        };
        if let Some(at) = root.and_then(|root| group.iter().position(|&point| point == root)) {
            group.swap(0, at);
        }
        group
    };
    ranked.into_iter().map(rooted).collect()
}
