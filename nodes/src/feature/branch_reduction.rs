//! Branch reduction: short and parallel branches taken off a forest.
//!
//! Chang, Song, Hsu (1998), fourth step, and Chang, Sinha (2007), who add that false ridges beside true ones must go.
//! The papers give no rule; this one works branch by branch, shortest first. A branch goes when it has too few
//! segments or when it never leaves the neighbourhood of the rest: two equally high rows of cells side by side
//! otherwise leave two rails of a ladder, as long as the ridge itself. Ends are trimmed first and grow back last, so
//! that what stays is neither frayed nor shortened. Where polygon breaking opened a ring, rather than a ladder, its two
//! sides are no branches: they are judged as if they still met.

use std::{cmp::Reverse, collections::BinaryHeap};

use orograph_core::prelude::*;

use super::{
    forest::{Forest, Frame, blocks_of},
    openings::openings,
    settings::{Reduction, crest},
};

/// Takes short branches, branches beside others and small groups off a forest: the last of the four steps of
/// `feature.ppa`.
#[derive(Params, Clone, Debug)]
pub struct BranchReduction {
    /// What is taken off.
    #[param(flatten)]
    pub reduction: Reduction,
}

/// Inputs of [`BranchReduction`].
#[derive(Inputs)]
pub struct BranchReductionIn<'a> {
    /// A forest of working cells, from `feature.polygon_breaking`.
    pub forest: &'a Features,
}

/// Outputs of [`BranchReduction`].
#[derive(Outputs)]
pub struct BranchReductionOut {
    /// What is left of it, cell by cell.
    pub forest: Features,
}

impl Node for BranchReduction {
    const ID: &'static str = "feature.branch_reduction";
    const VERSION: u32 = 2; // 2 keeps rings whole
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = BranchReductionIn<'a>;
    type Outputs = BranchReductionOut;

    fn run(&self, inputs: BranchReductionIn<'_>, job: &Job) -> Result<BranchReductionOut> {
        let features = inputs.forest;
        let (forest, heights) = Forest::from_features(features, job)?;
        if has_polygon(&forest) {
            return Err(Error::invalid(
                "the network has closed polygons",
                "put `feature.polygon_breaking` before this node",
            ));
        }
        let crests: Vec<f32> = heights.iter().map(|height| crest(*height, features.kind)).collect();
        let forest = reduce(forest, &crests, &self.reduction, job)?;
        let frame = Frame {
            grid: &features.grid,
            blocks: blocks_of(features)?,
            heights: &heights,
            kind: features.kind,
        };
        Ok(BranchReductionOut { forest: forest.to_features(&frame, job)? })
    }
}

/// A forest has as many links as joined cells less its trees.
fn has_polygon(network: &Forest) -> bool {
    let groups = groups(network);
    network.segments() + groups.len() != network.nodes()
}

/// The joined cells group by group, each as a walk from its lowest number.
fn groups(network: &Forest) -> Vec<Vec<usize>> {
    let mut seen = vec![false; network.links.len()];
    let mut groups = Vec::new();
    for start in 0..network.links.len() {
        if network.links[start] == 0 || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut group = vec![start];
        let mut next = 0;
        while next < group.len() {
            for cell in network.neighbours(group[next]) {
                if !seen[cell] {
                    seen[cell] = true;
                    group.push(cell);
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    groups
}

/// What is left of a forest; `crests` are heights turned so that its lines are crests.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn reduce(forest: Forest, crests: &[f32], by: &Reduction, job: &Job) -> Result<Forest> {
    let alive = forest.links.iter().map(|links| *links != 0).collect();
    let mut forest = forest;
    let width = if by.rings { by.parallel_radius } else { 0.0 };
    let openings = openings(&forest, crests, width, job)?;
    openings.iter().for_each(|&(cell, direction)| forest.join(cell, direction));
    let full = forest.clone();
    let mut pruner = Pruner { forest, alive, crests, by };
    for _ in 0..by.end_trim {
        job.check()?;
        pruner.trim();
    }
    pruner.prune(job)?;
    if by.regrow {
        pruner.regrow(&full, job)?;
    }
    let mut forest = pruner.forest;
    openings.iter().for_each(|&(cell, direction)| forest.part(cell, direction));
    for group in groups(&forest) {
        if group.len() <= by.min_group as usize {
            group.into_iter().for_each(|cell| forest.links[cell] = 0);
        }
    }
    Ok(forest)
}

/// A branch on the heap: the shortest goes first, then the lowest, then the first by place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Branch {
    segments: usize,
    mean: f64,
    leaf: usize,
}

impl Eq for Branch {}

impl Ord for Branch {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.segments
            .cmp(&other.segments)
            .then_with(|| self.mean.total_cmp(&other.mean))
            .then_with(|| self.leaf.cmp(&other.leaf))
    }
}

impl PartialOrd for Branch {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

struct Pruner<'a> {
    forest: Forest,
    /// Cells still there. A cell may have lost all its links and still be there, and then it counts as near by.
    alive: Vec<bool>,
    crests: &'a [f32],
    by: &'a Reduction,
}

impl Pruner<'_> {
    /// Takes off every cell with one link or none, all at once.
    fn trim(&mut self) {
        let ends: Vec<usize> =
            (0..self.alive.len()).filter(|&cell| self.alive[cell] && self.forest.degree(cell) <= 1).collect();
        ends.into_iter().for_each(|cell| self.remove(cell));
    }

    fn remove(&mut self, cell: usize) {
        self.forest.detach(cell);
        self.alive[cell] = false;
    }

    /// Takes off short and parallel branches, judging each anew when its turn comes.
    fn prune(&mut self, job: &Job) -> Result<()> {
        let least = self.by.min_branch.saturating_sub(self.by.end_trim) as usize;
        let leaves = (0..self.alive.len()).filter(|&cell| self.forest.degree(cell) == 1);
        let mut heap: BinaryHeap<Reverse<Branch>> = leaves.map(|leaf| Reverse(self.branch(leaf).0)).collect();
        let mut turn = 0_u64;
        while let Some(Reverse(branch)) = heap.pop() {
            turn += 1;
            if turn.is_multiple_of(256) {
                job.check()?;
            }
            if self.forest.degree(branch.leaf) != 1 {
                continue;
            }
            let (now, path, junction) = self.branch(branch.leaf);
            if now != branch {
                heap.push(Reverse(now));
                continue;
            }
            let Some(junction) = junction else { continue };
            if branch.segments >= least && self.leaves_the_rest(&path) {
                continue;
            }
            path.into_iter().for_each(|cell| self.remove(cell));
            if self.forest.degree(junction) == 2 {
                // Two branches became one: both of its ends are judged again.
                for start in self.forest.neighbours(junction) {
                    let end = self.far_end(junction, start);
                    if self.forest.degree(end) == 1 {
                        heap.push(Reverse(self.branch(end).0));
                    }
                }
            }
        }
        Ok(())
    }

    /// The branch that ends at a leaf: its cells from the leaf inward, and the junction that it hangs on.
    fn branch(&self, leaf: usize) -> (Branch, Vec<usize>, Option<usize>) {
        let mut path = vec![leaf];
        let mut before = leaf;
        let mut junction = None;
        let mut next = self.forest.neighbours(leaf).next();
        while let Some(cell) = next {
            if self.forest.degree(cell) >= 3 {
                junction = Some(cell);
                break;
            }
            next = self.forest.neighbours(cell).find(|&other| other != before);
            before = cell;
            path.push(cell);
        }
        let sum: f64 = path.iter().map(|&cell| f64::from(self.crests[cell])).sum();
        (Branch { segments: path.len(), mean: sum / path.len() as f64, leaf }, path, junction)
    }

    /// Where the chain that leaves `from` through `cell` ends: a leaf or a junction.
    fn far_end(&self, from: usize, cell: usize) -> usize {
        let (mut before, mut cell) = (from, cell);
        // Around a ring without a junction the way leads back.
        while self.forest.degree(cell) == 2 && cell != from {
            let next = self.forest.neighbours(cell).find(|&other| other != before).unwrap_or(cell);
            (before, cell) = (cell, next);
        }
        cell
    }

    /// Whether some cell of the branch lies further from everything else than the parallel radius.
    fn leaves_the_rest(&mut self, path: &[usize]) -> bool {
        let radius = self.by.parallel_radius;
        let reach = radius.ceil() as i64;
        path.iter().for_each(|&cell| self.alive[cell] = false);
        let (rows, cols) = (self.forest.lattice.rows as i64, self.forest.lattice.cols as i64);
        let alone = |&cell: &usize| {
            let (row, col) = self.forest.lattice.place(cell);
            let (row, col) = (row as i64, col as i64);
            !((row - reach).max(0)..=(row + reach).min(rows - 1)).any(|r| {
                ((col - reach).max(0)..=(col + reach).min(cols - 1)).any(|c| {
                    let square = (r - row) * (r - row) + (c - col) * (c - col);
                    square as f64 <= radius * radius && self.alive[(r * cols + c) as usize]
                })
            })
        };
        let leaves = path.iter().any(alone);
        path.iter().for_each(|&cell| self.alive[cell] = true);
        leaves
    }

    /// Lets each end walk back into what was taken, towards where most was taken.
    fn regrow(&mut self, full: &Forest, job: &Job) -> Result<()> {
        let tips: Vec<usize> = (0..self.alive.len()).filter(|&cell| self.forest.degree(cell) == 1).collect();
        for (n, tip) in tips.into_iter().enumerate() {
            if n.is_multiple_of(256) {
                job.check()?;
            }
            let mut end = tip;
            for _ in 0..self.by.end_trim {
                let gone =
                    full.directions(end).map(|direction| (direction, full.lattice.step(end, direction)));
                let deepest = gone.filter(|(_, cell)| !self.alive[*cell]).max_by(|(_, a), (_, b)| {
                    let depth = |cell| self.depth(full, cell, end, self.by.end_trim as usize);
                    depth(*a)
                        .cmp(&depth(*b))
                        .then_with(|| self.crests[*a].total_cmp(&self.crests[*b]))
                        .then_with(|| a.cmp(b))
                });
                let Some((direction, cell)) = deepest else { break };
                self.forest.join(end, direction);
                self.alive[cell] = true;
                end = cell;
            }
        }
        Ok(())
    }

    /// How many removed cells follow one another from `cell` away from `before`, up to `most`.
    fn depth(&self, full: &Forest, cell: usize, before: usize, most: usize) -> usize {
        if most <= 1 {
            return 1;
        }
        let onward = full.neighbours(cell).filter(|&next| next != before && !self.alive[next]);
        1 + onward.map(|next| self.depth(full, next, cell, most - 1)).max().unwrap_or(0)
    }
}
