//! Parts of a domain that nothing holds in place.

use std::ops::Range;

use super::masked::Cell;

/// Connected parts of free cells that touch no fixed cell and are held nowhere: each as its cells in order, the parts by
/// their first. The arrays are framed.
pub(super) fn floating_parts(stride: usize, cells: &[Cell], holds: &[f64]) -> Vec<Vec<usize>> {
    let mut runs: Vec<Run> = Vec::new();
    let mut above = 0..0;
    for (row, line) in cells.chunks(stride).enumerate() {
        let first = runs.len();
        // Of the row before, what ends before this run touches none after it either.
        let mut next_above = above.start;
        for run in free_runs(line) {
            let range = row * stride + run.start..row * stride + run.end;
            let this = runs.len();
            runs.push(Run::new(range.clone(), this, stride, cells, holds));
            while next_above < above.end && runs[next_above].cells.end + stride <= range.start {
                next_above += 1;
            }
            let mut other = next_above;
            while other < above.end && runs[other].cells.start + stride < range.end {
                join(&mut runs, this, other);
                other += 1;
            }
        }
        above = first..runs.len();
    }
    let mut parts: Vec<Vec<usize>> = Vec::new();
    let mut places = vec![None; runs.len()];
    for i in 0..runs.len() {
        let part = root(&mut runs, i);
        if !runs[part].anchored {
            let place = *places[part].get_or_insert_with(|| {
                parts.push(Vec::new());
                parts.len() - 1
            });
            parts[place].extend(runs[i].cells.clone());
        }
    }
    parts
}

/// Free cells side by side.
fn free_runs(line: &[Cell]) -> impl Iterator<Item = Range<usize>> {
    let mut col = 0;
    std::iter::from_fn(move || {
        let start = col + line[col..].iter().position(|&cell| cell == Cell::Free)?;
        col = line[start..].iter().position(|&cell| cell != Cell::Free).map_or(line.len(), |n| start + n);
        Some(start..col)
    })
}

/// Free cells side by side in a row, and what is known of the part that they belong to.
struct Run {
    cells: Range<usize>,
    /// A run of the same part that lies before it, or itself.
    part: usize,
    anchored: bool,
}

impl Run {
    fn new(run: Range<usize>, i: usize, stride: usize, cells: &[Cell], holds: &[f64]) -> Self {
        // Cells within the frame have all neighbours.
        let (start, end) = (run.start, run.end);
        let near = [start - stride..end - stride, start - 1..end + 1, start + stride..end + stride];
        let held = holds.get(run.clone()).is_some_and(|holds| holds.iter().any(|&hold| hold > 0.0));
        let anchored = held || near.into_iter().any(|near| cells[near].contains(&Cell::Fixed));
        Self { cells: run, part: i, anchored }
    }
}

/// The first run of the part of run `i`, which speaks for it.
fn root(runs: &mut [Run], mut i: usize) -> usize {
    while runs[i].part != i {
        runs[i].part = runs[runs[i].part].part;
        i = runs[i].part;
    }
    i
}

fn join(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (root(runs, a), root(runs, b));
    let (first, other) = (a.min(b), a.max(b));
    runs[first].anchored |= runs[other].anchored;
    runs[other].part = first;
}
