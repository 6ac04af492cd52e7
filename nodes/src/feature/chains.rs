//! Points and lines of a forest: chains between junctions and ends, near junctions made one, lines smoothed.

use orograph_core::{FeaturePoint, PointKind, Polyline, prelude::*};
use petgraph::unionfind::UnionFind;

use super::{
    forest::{Forest, Frame},
    rings,
    settings::Shaping,
};

/// A maximal run of working cells between two that are no mere passage.
#[derive(Clone, Debug)]
struct Chain {
    cells: Vec<usize>,
    /// In working cells.
    length: f64,
}

/// Points and lines of a forest: cells with one link are ends, those with three or more are branch points, runs
/// between them are lines. See [`Shaping`] for what is merged, smoothed and closed. Line vertices come a working cell
/// apart on the terrain's grid.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn shape(forest: &Forest, frame: &Frame<'_>, shaping: &Shaping, job: &Job) -> Result<Features> {
    let chains = chains(forest, job)?;
    let (kept, hubs) = merge(forest, chains, shaping.joining.merge_radius);
    // Points are numbered by place, whatever the order in which chains were found.
    let mut keys: Vec<usize> =
        kept.iter().flat_map(|chain| [chain.cells[0], chain.cells[chain.cells.len() - 1]]).collect();
    keys.iter_mut().for_each(|cell| *cell = hubs.of(*cell));
    keys.sort_unstable();
    keys.dedup();
    let id = |cell: usize| keys.partition_point(|&key| key < hubs.of(cell)) as u32;
    let mut features = frame.features(Vec::with_capacity(keys.len()), Vec::with_capacity(kept.len()));
    let mut degrees = vec![0_u32; keys.len()];
    for chain in &kept {
        job.check()?;
        let (first, last) = (chain.cells[0], chain.cells[chain.cells.len() - 1]);
        let (from, to) = (id(first), id(last));
        degrees[from as usize] += 1;
        degrees[to as usize] += 1;
        let place = |&cell: &usize| {
            let (row, col) = forest.lattice.place(cell);
            [row as f64, col as f64]
        };
        let mut path: Vec<[f64; 2]> = chain.cells.iter().map(place).collect();
        if hubs.of(first) != first {
            path.insert(0, place(&hubs.of(first)));
        }
        if hubs.of(last) != last {
            path.push(place(&hubs.of(last)));
        }
        smooth(&mut path, shaping.joining.smooth_passes);
        path.iter_mut().for_each(|at| *at = frame.blocks.to_cells(*at, frame.grid));
        let vertices = resample(&path, features.scale.max(1.0));
        features.lines.push(Polyline { from, to, vertices, profiles: Vec::new() });
    }
    for (&cell, &degree) in keys.iter().zip(&degrees) {
        let [row, col] = frame.place(cell);
        let kind = if degree == 1 { PointKind::End } else { PointKind::Branch };
        features.points.push(FeaturePoint { row, col, height: frame.heights[cell], kind });
    }
    features.rings = rings::close(&features, frame.blocks, shaping);
    Ok(features)
}

/// All chains, each once, by the place of the end that comes first.
fn chains(forest: &Forest, job: &Job) -> Result<Vec<Chain>> {
    let mut chains = Vec::new();
    for row in 0..forest.lattice.rows {
        job.check()?;
        for start in row * forest.lattice.cols..(row + 1) * forest.lattice.cols {
            if forest.links[start] == 0 || forest.degree(start) == 2 {
                continue;
            }
            for second in forest.neighbours(start) {
                let cells = follow(forest, start, second);
                let n = cells.len();
                if (cells[0], cells[1]) <= (cells[n - 1], cells[n - 2]) {
                    let steps = cells.windows(2).map(|pair| forest.lattice.distance(pair[0], pair[1]));
                    chains.push(Chain { length: steps.sum(), cells });
                }
            }
        }
    }
    Ok(chains)
}

fn follow(forest: &Forest, start: usize, second: usize) -> Vec<usize> {
    let mut cells = vec![start, second];
    let (mut before, mut cell) = (start, second);
    while forest.degree(cell) == 2 && cell != start {
        let Some(next) = forest.neighbours(cell).find(|&other| other != before) else { break };
        (before, cell) = (cell, next);
        cells.push(cell);
    }
    cells
}

/// For each merged junction the one that stands for all.
struct Hubs {
    /// Sorted by the first.
    stands_for: Vec<(usize, usize)>,
}

impl Hubs {
    fn of(&self, cell: usize) -> usize {
        let found = self.stands_for.binary_search_by_key(&cell, |pair| pair.0);
        found.map_or(cell, |i| self.stands_for[i].1)
    }
}

/// Makes one of junctions that a chain shorter than `radius` joins: the member that most length of line meets in, as
/// moving the others bends only short lines, and of equals the one nearest to their middle.
fn merge(forest: &Forest, chains: Vec<Chain>, radius: f64) -> (Vec<Chain>, Hubs) {
    let mut members: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    let mut kept = Vec::with_capacity(chains.len());
    for chain in chains {
        let (first, last) = (chain.cells[0], chain.cells[chain.cells.len() - 1]);
        let junctions = forest.degree(first) >= 3 && forest.degree(last) >= 3;
        if junctions && chain.length < radius {
            members.extend([first, last]);
            pairs.push((first, last));
        } else {
            kept.push(chain);
        }
    }
    members.sort_unstable();
    members.dedup();
    let mut lengths = vec![0.0; members.len()];
    for chain in &kept {
        for cell in [chain.cells[0], chain.cells[chain.cells.len() - 1]] {
            if let Ok(member) = members.binary_search(&cell) {
                lengths[member] += chain.length;
            }
        }
    }
    let index = |cell: usize| members.partition_point(|&member| member < cell);
    let mut trees = UnionFind::new(members.len());
    for (a, b) in pairs {
        trees.union(index(a), index(b));
    }
    let mut groups: Vec<(usize, usize)> = trees.into_labeling().into_iter().zip(0..).collect();
    groups.sort_unstable();
    let mut stands_for = Vec::with_capacity(groups.len());
    for group in groups.chunk_by(|a, b| a.0 == b.0) {
        let places = || group.iter().map(|&(_, member)| forest.lattice.place(members[member]));
        let n = group.len() as f64;
        let middle_row = places().map(|(row, _)| row as f64).sum::<f64>() / n;
        let middle_col = places().map(|(_, col)| col as f64).sum::<f64>() / n;
        let off = |member: usize| {
            let (row, col) = forest.lattice.place(members[member]);
            let (down, across) = (row as f64 - middle_row, col as f64 - middle_col);
            down * down + across * across
        };
        let better = |a: &usize, b: &usize| {
            lengths[*b].total_cmp(&lengths[*a]).then(off(*a).total_cmp(&off(*b))).then(a.cmp(b))
        };
        let hub = group.iter().map(|&(_, member)| member).min_by(better);
        stands_for.extend(group.iter().filter_map(|&(_, member)| Some((members[member], members[hub?]))));
    }
    stands_for.sort_unstable();
    (kept, Hubs { stands_for })
}

/// Averages each inner vertex with its neighbours, a quarter each, `passes` times; the ends stay.
pub(crate) fn smooth(path: &mut [[f64; 2]], passes: u32) {
    for _ in 0..passes {
        let mut before = path.first().copied().unwrap_or_default();
        for i in 1..path.len().saturating_sub(1) {
            let here = path[i];
            path[i] = [0, 1].map(|k| 0.25 * before[k] + 0.5 * here[k] + 0.25 * path[i + 1][k]);
            before = here;
        }
    }
}

/// The path in equal steps of about `spacing` along it; shorter paths than two steps stay as they are.
pub(crate) fn resample(path: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let steps = path.windows(2).map(|pair| distance(pair[0], pair[1]));
    let length: f64 = steps.clone().sum();
    if length < 2.0 * spacing {
        return path.to_vec();
    }
    let n = (length / spacing).round().max(1.0) as usize;
    let mut out = Vec::with_capacity(n + 1);
    out.push(path[0]);
    let mut done = 0.0;
    for (i, step) in steps.enumerate() {
        while out.len() < n {
            let wanted = out.len() as f64 * length / n as f64;
            if wanted > done + step {
                break;
            }
            let share = if step > 0.0 { (wanted - done) / step } else { 0.0 };
            out.push([0, 1].map(|k| path[i][k] + (path[i + 1][k] - path[i][k]) * share));
        }
        done += step;
    }
    out.push(path[path.len() - 1]);
    out
}

/// Distance between two places.
pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (down, across) = (a[0] - b[0], a[1] - b[1]);
    (down * down + across * across).sqrt()
}

/// Length of all lines in cells.
#[must_use]
pub fn length(features: &Features) -> f64 {
    let steps = features.lines.iter().flat_map(|line| line.vertices.windows(2));
    steps.map(|pair| distance(pair[0], pair[1])).sum()
}
