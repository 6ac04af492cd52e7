//! Valleys as trees of cells, each rooted at its outlet: a priority-flood along the lines.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet, BinaryHeap},
};

use orograph_core::prelude::*;

use super::isotonic::ROOT;
use crate::{mcmd::raster_line::line, measure::drainage::flood::rank};

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
    /// The cells under the lines of `valleys`, without those that `is_ground` denies. Where a connected part comes to
    /// cells that `is_outlet`, or a line ends beside the border, each of these is one; else its lowest end of a line is, else its lowest cell.
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
            let leaves = |cell: &usize| is_outlet(*cell) || near[cell].len() < 2 && at_border(valleys, *cell);
            let mut outlets: Vec<usize> = part.iter().copied().filter(leaves).collect();
            if outlets.is_empty() {
                let order = |&cell: &usize| (near[&cell].len() > 1, rank(heights[cell], cell));
                outlets.extend(part.iter().copied().min_by_key(order));
            }
            trees.add(&outlets, &near, heights, &valleys.grid);
        }
        Ok(trees)
    }

    /// Adds all that flows to some outlets, by the ways that climb least: where two of them meet is a divide.
    fn add(&mut self, outlets: &[usize], near: &Neighbours, heights: &[f32], grid: &Grid) {
        let mut entries = BTreeMap::new();
        let mut open = BinaryHeap::new();
        self.outlets += outlets.len();
        for &outlet in outlets {
            open.push(Reverse((rank(heights[outlet], outlet), outlet)));
            self.enter(outlet, ROOT, 0.0, &mut entries);
        }
        while let Some(Reverse((level, from))) = open.pop() {
            let entry: u32 = entries[&from];
            for &to in &near[&from] {
                if entries.contains_key(&to) {
                    continue;
                }
                let down = (from / grid.cols).abs_diff(to / grid.cols) as f64 * grid.cell.y;
                let right = (from % grid.cols).abs_diff(to % grid.cols) as f64 * grid.cell.x;
                let length = self.lengths[entry as usize] + (down * down + right * right).sqrt();
                self.enter(to, entry, length, &mut entries);
                open.push(Reverse((level.max(rank(heights[to], to)), to)));
            }
        }
    }

    fn enter(&mut self, cell: usize, parent: u32, length: f64, entries: &mut BTreeMap<usize, u32>) {
        entries.insert(cell, self.cells.len() as u32);
        self.cells.push(cell);
        self.parents.push(parent);
        self.lengths.push(length);
    }
}

/// Whether a cell lies no further from the border than lines found on coarser cells may end.
fn at_border(valleys: &Features, cell: usize) -> bool {
    let (rows, cols) = valleys.grid.size();
    let (row, col) = (cell / cols, cell % cols);
    let margin = ((2.0 * valleys.scale).ceil() as usize).saturating_add(2);
    row.min(rows - 1 - row).min(col).min(cols - 1 - col) <= margin
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
