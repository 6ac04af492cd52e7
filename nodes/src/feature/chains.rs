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
        // Smoothed up to its own junctions, so that where it parts from the way to another all lines still meet.
        let mut own: Vec<[f64; 2]> = chain.cells.iter().map(place).collect();
        smooth(&mut own, shaping.joining.smooth_passes);
        let (before, after) = (hubs.way(first).iter().rev(), hubs.way(last).iter());
        let mut path: Vec<[f64; 2]> = before.map(place).chain(own).chain(after.map(place)).collect();
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
    /// Junctions, and the cells that lead from each to the one that stands for it, which comes last. Sorted.
    ways: Vec<(usize, Vec<usize>)>,
}

impl Hubs {
    /// The cells from a junction to the one that stands for it; none from that one, or from any other cell.
    fn way(&self, cell: usize) -> &[usize] {
        let found = self.ways.binary_search_by_key(&cell, |way| way.0);
        found.map_or(&[], |i| &self.ways[i].1)
    }

    fn of(&self, cell: usize) -> usize {
        self.way(cell).last().copied().unwrap_or(cell)
    }
}

/// Makes one of junctions that a chain shorter than `radius` joins: the member nearest to their middle. Lines reach it
/// along the chains that joined them, so that what runs through a junction stays where it is.
fn merge(forest: &Forest, chains: Vec<Chain>, radius: f64) -> (Vec<Chain>, Hubs) {
    let ends = |chain: &Chain| [chain.cells[0], chain.cells[chain.cells.len() - 1]];
    let is_short =
        |chain: &Chain| chain.length < radius && ends(chain).iter().all(|&end| forest.degree(end) >= 3);
    let (short, kept): (Vec<Chain>, Vec<Chain>) = chains.into_iter().partition(is_short);
    let mut members: Vec<usize> = short.iter().flat_map(ends).collect();
    members.sort_unstable();
    members.dedup();
    let index = |cell: usize| members.partition_point(|&member| member < cell);
    let mut trees = UnionFind::new(members.len());
    let mut joined: Vec<Vec<usize>> = vec![Vec::new(); members.len()];
    for (number, chain) in short.iter().enumerate() {
        let [a, b] = ends(chain).map(index);
        trees.union(a, b);
        joined[a].push(number);
        joined[b].push(number);
    }
    let mut groups: Vec<(usize, usize)> = trees.into_labeling().into_iter().zip(0..).collect();
    groups.sort_unstable();
    let mut ways: Vec<(usize, Vec<usize>)> = members.iter().map(|&member| (member, Vec::new())).collect();
    for group in groups.chunk_by(|a, b| a.0 == b.0) {
        let place = |member: usize| {
            let (row, col) = forest.lattice.place(members[member]);
            [row as f64, col as f64]
        };
        let n = group.len() as f64;
        let middle = [0, 1].map(|k| group.iter().map(|&(_, member)| place(member)[k]).sum::<f64>() / n);
        let off = |member: usize| distance(place(member), middle);
        let hub = group
            .iter()
            .map(|&(_, member)| member)
            .min_by(|&a, &b| off(a).total_cmp(&off(b)).then(a.cmp(&b)));
        // Outwards from it, so that each way begins with a chain and goes on as that of the next.
        let mut next: Vec<usize> = hub.into_iter().collect();
        while let Some(member) = next.pop() {
            for &number in &joined[member] {
                let mut cells = short[number].cells.clone();
                if cells[0] == members[member] {
                    cells.reverse();
                }
                let other = index(cells[0]);
                if Some(other) != hub && ways[other].1.is_empty() {
                    cells.remove(0);
                    cells.extend_from_slice(&ways[member].1);
                    ways[other].1 = cells;
                    next.push(other);
                }
            }
        }
    }
    (kept, Hubs { ways })
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
