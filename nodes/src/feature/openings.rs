//! Where polygon breaking opened rings.
//!
//! A segment that it deleted joined two cells that are neighbours still, and the way between them through the forest is
//! the polygon. Most polygons are the meshes of a line several working cells wide. The others are rings of ground: a
//! line that closes around something, whose two sides at the opening are no branches of anything.

use std::collections::VecDeque;

use orograph_core::{Job, Result};

use super::forest::Forest;

/// The missing links, as a cell and a direction, that close polygons whose mean width exceeds `width` working cells:
/// most important first, and of several that close the same ring only the first. None for a width of 0.
///
/// # Errors
/// [`Error::Cancelled`](orograph_core::Error::Cancelled).
pub(super) fn openings(
    forest: &Forest,
    crests: &[f32],
    width: f64,
    job: &Job,
) -> Result<Vec<(usize, usize)>> {
    if width <= 0.0 {
        return Ok(Vec::new());
    }
    // No polygon of fewer segments is as wide: a circle is the widest of its length.
    let least = (std::f64::consts::TAU * width) as usize;
    let roots = Roots::new(forest, job)?;
    let mut found: Vec<(f64, usize, usize)> = Vec::new();
    for row in 0..forest.lattice.rows {
        job.check()?;
        for cell in row * forest.lattice.cols..(row + 1) * forest.lattice.cols {
            for direction in (0..4).filter(|direction| is_missing(forest, cell, *direction)) {
                let other = forest.lattice.step(cell, direction);
                if roots.are_apart(cell, other, least) && roots.mean_width(forest, cell, other) > width {
                    found.push((f64::from(crests[cell]) + f64::from(crests[other]), cell, direction));
                }
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| (a.1, a.2).cmp(&(b.1, b.2))));
    let mut closed = forest.clone();
    let mut seen = vec![0_u32; forest.links.len()];
    let mut openings = Vec::new();
    for (turn, (_, cell, direction)) in found.into_iter().enumerate() {
        job.check()?;
        let other = forest.lattice.step(cell, direction);
        if !is_near(&closed, cell, other, least, &mut seen, turn as u32 + 1) {
            closed.join(cell, direction);
            openings.push((cell, direction));
        }
    }
    Ok(openings)
}

/// Whether a cell of the forest has a neighbour in a direction that is in it, too, but not joined to it, and no link
/// crosses the way.
fn is_missing(forest: &Forest, cell: usize, direction: usize) -> bool {
    let lattice = forest.lattice;
    let free = forest.links[cell] != 0 && forest.links[cell] >> direction & 1 == 0;
    let Some(other) = lattice.far(cell, direction, 1).filter(|_| free) else { return false };
    // The two cells beside a diagonal, of which the crossing one would join the first in this direction.
    let crossed = match direction {
        1 => forest.links[cell + 1] >> 3 & 1 == 1,
        3 => forest.links[cell - 1] >> 1 & 1 == 1,
        _ => false,
    };
    forest.links[other] != 0 && !crossed
}

/// Whether fewer than `least` links lead from one cell to another. `seen` holds the number of the last search that came
/// by, which no two may share.
fn is_near(network: &Forest, from: usize, to: usize, least: usize, seen: &mut [u32], search: u32) -> bool {
    seen[from] = search;
    let mut queue = VecDeque::from([(from, 0)]);
    while let Some((cell, far)) = queue.pop_front() {
        if cell == to {
            return true;
        }
        for next in network.neighbours(cell).filter(|_| far + 1 < least) {
            if seen[next] != search {
                seen[next] = search;
                queue.push_back((next, far + 1));
            }
        }
    }
    false
}

/// The way from each cell to the root of its tree.
struct Roots {
    parents: Vec<usize>,
    depths: Vec<u32>,
}

impl Roots {
    fn new(forest: &Forest, job: &Job) -> Result<Self> {
        let n = forest.links.len();
        let (mut parents, mut depths) = (vec![usize::MAX; n], vec![0_u32; n]);
        let mut queue = VecDeque::new();
        for root in 0..n {
            if root % forest.lattice.cols == 0 {
                job.check()?;
            }
            if forest.links[root] == 0 || parents[root] != usize::MAX {
                continue;
            }
            parents[root] = root;
            queue.push_back(root);
            while let Some(cell) = queue.pop_front() {
                for next in forest.neighbours(cell) {
                    if parents[next] == usize::MAX {
                        (parents[next], depths[next]) = (cell, depths[cell] + 1);
                        queue.push_back(next);
                    }
                }
            }
        }
        Ok(Self { parents, depths })
    }

    /// The cells from `a` to `b` in turn, the one of both that lies deeper first; nothing between two trees.
    fn steps(&self, mut a: usize, mut b: usize) -> impl Iterator<Item = (usize, usize, bool)> {
        let mut met = false;
        std::iter::from_fn(move || {
            if met || a == b {
                return None;
            }
            let first = self.depths[a] >= self.depths[b];
            let from = if first { a } else { b };
            let to = self.parents[from];
            if to == from {
                // Both at their roots.
                met = true;
                return None;
            }
            if first {
                a = to
            } else {
                b = to
            }
            Some((from, to, first))
        })
    }

    /// Whether at least `least` links lead from `a` to `b`.
    fn are_apart(&self, a: usize, b: usize, least: usize) -> bool {
        self.steps(a, b).take(least).count() >= least
    }

    /// The area of the polygon that a link from `a` to `b` closes, by half of its length, in working cells.
    fn mean_width(&self, forest: &Forest, a: usize, b: usize) -> f64 {
        let cross = |from: usize, to: usize| {
            let ((r, c), (row, col)) = (forest.lattice.place(from), forest.lattice.place(to));
            (r as i64) * (col as i64) - (row as i64) * (c as i64)
        };
        let (mut area, mut length) = (cross(b, a), forest.lattice.distance(a, b));
        for (from, to, first) in self.steps(a, b) {
            area += if first { cross(from, to) } else { cross(to, from) };
            length += forest.lattice.distance(from, to);
        }
        area.abs() as f64 / length
    }
}
