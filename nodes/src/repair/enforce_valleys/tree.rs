//! Valleys as trees of cells, each rooted at its outlet.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use orograph_core::prelude::*;

use super::isotonic::ROOT;
use crate::mcmd::raster_line::line;

/// Cells of valleys, and what each flows into.
#[derive(Debug, Default)]
pub(super) struct Trees {
    /// Index of each cell in the terrain.
    pub(super) cells: Vec<usize>,
    /// Which entry each cell flows into; none for outlets.
    pub(super) parents: Vec<u32>,
    /// Metres along the valley to the outlet.
    pub(super) lengths: Vec<f64>,
    /// How many outlets there are.
    pub(super) outlets: usize,
}

impl Trees {
    /// The cells under the lines of `valleys`, without those that `is_ground` denies. The outlet of each connected
    /// part is its lowest cell that `is_outlet`; if there is none, the lowest end of a line; else the lowest cell.
    pub(super) fn new(
        valleys: &Features,
        heights: &[f32],
        is_ground: impl Fn(usize) -> bool,
        is_outlet: impl Fn(usize) -> bool,
        job: &Job,
    ) -> Result<Self> {
        let near = neighbours(valleys, is_ground, job)?;
        let mut seen = BTreeSet::new();
        let mut trees = Self::default();
        for &first in near.keys() {
            if seen.contains(&first) {
                continue;
            }
            job.check()?;
            let mut part = vec![first];
            seen.insert(first);
            let mut at = 0;
            while at < part.len() {
                let cell = part[at];
                part.extend(near[&cell].iter().copied().filter(|&other| seen.insert(other)));
                at += 1;
            }
            let rank = |&cell: &usize| {
                let end = near[&cell].len() < 2;
                (u8::from(!is_outlet(cell)) * (2 - u8::from(end)), cell)
            };
            let lower = |a: &usize, b: &usize| {
                let ((rank_a, a), (rank_b, b)) = (rank(a), rank(b));
                rank_a.cmp(&rank_b).then(heights[a].total_cmp(&heights[b])).then(a.cmp(&b))
            };
            if let Some(&outlet) = part.iter().min_by(|a, b| lower(a, b)) {
                trees.add(outlet, &near, valleys.grid.cell, valleys.grid.cols);
            }
        }
        Ok(trees)
    }

    /// Adds all that flows to `outlet`, by the way of the fewest cells.
    fn add(&mut self, outlet: usize, near: &Neighbours, cell: CellSize, cols: usize) {
        let mut entries = BTreeMap::from([(outlet, self.cells.len())]);
        let mut open = VecDeque::from([outlet]);
        self.cells.push(outlet);
        self.parents.push(ROOT);
        self.lengths.push(0.0);
        self.outlets += 1;
        while let Some(from) = open.pop_front() {
            let entry = entries[&from];
            for &to in &near[&from] {
                if entries.contains_key(&to) {
                    continue;
                }
                let down = (from / cols).abs_diff(to / cols) as f64 * cell.y;
                let right = (from % cols).abs_diff(to % cols) as f64 * cell.x;
                entries.insert(to, self.cells.len());
                self.cells.push(to);
                self.parents.push(entry as u32);
                self.lengths.push(self.lengths[entry] + (down * down + right * right).sqrt());
                open.push_back(to);
            }
        }
    }
}

type Neighbours = BTreeMap<usize, BTreeSet<usize>>;

/// The cells under lines, each with those before and after it.
fn neighbours(valleys: &Features, is_ground: impl Fn(usize) -> bool, job: &Job) -> Result<Neighbours> {
    let size = valleys.grid.size();
    let mut near = Neighbours::new();
    for drawn in &valleys.lines {
        job.check()?;
        if !drawn.vertices.iter().flatten().all(|at| at.is_finite()) {
            return Err(Error::invalid(
                "the valleys are damaged: a line has a vertex that lies nowhere",
                "make them with a node of the `feature` family",
            ));
        }
        let places = drawn.vertices.iter().map(|[row, col]| (row.round() as i64, col.round() as i64));
        let places: Vec<_> = places.collect();
        let mut last = None;
        for (from, to) in places.iter().zip(places.iter().skip(1).chain(places.last())) {
            line(*from, *to, size, |row, col, _| {
                let cell = row * size.1 + col;
                if !is_ground(cell) {
                    last = None;
                    return;
                }
                near.entry(cell).or_default();
                if let Some(before) = last.replace(cell).filter(|&before| before != cell) {
                    near.entry(cell).or_default().insert(before);
                    near.entry(before).or_default().insert(cell);
                }
            });
        }
    }
    Ok(near)
}
