//! Seams: whether the joins of a synthesis show.
//!
//! Steps across the joins against steps inside the patches, and bends along the joins against bends elsewhere, both
//! as logarithms. The test has two sides: a visible step scores above 0, a join that was ironed flat below, and
//! a one-sided measure would reward that. Without a placement, every straight line between two rows or columns is
//! held against the lines beside it, which finds the edges of tiles.

use orograph_core::{Placement, Unit, prelude::*};
use rayon::prelude::*;

use super::sums::per_row;

/// Measures how far joins of patches stand out, as logarithms: 0 is invisible, up to 0.25 either way is good.
///
/// With a placement, joins are where neighbouring cells come from different patches. Straight lines along the
/// grid are tested in any case. Voids are left out; what cannot be measured is NaN.
#[derive(Params, Clone, Debug)]
pub struct Seams {
    /// Lines to each side that a straight line is held against.
    #[param(default = 8u32, range = 1..=256, slider = 2..=32, unit = "cells")]
    pub flank: u32,
}

/// Inputs of [`Seams`].
#[derive(Inputs)]
pub struct SeamsIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Which patch each cell of the terrain came from.
    pub placement: Option<&'a Placement>,
    /// Terrain without seams, of any size: how far its own straight lines stand out.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Seams`].
#[derive(Outputs)]
pub struct SeamsOut {
    /// One row of metrics.
    pub metrics: Table,
}

impl Node for Seams {
    const ID: &'static str = "measure.seams";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = SeamsIn<'a>;
    type Outputs = SeamsOut;

    fn cost(&self) -> f64 {
        12.0
    }

    fn run(&self, inputs: SeamsIn<'_>, job: &Job) -> Result<SeamsOut> {
        let joins =
            inputs.placement.map(|placement| Joins::of(inputs.terrain, placement, job)).transpose()?;
        let joins = joins.unwrap_or(Joins::NONE);
        let lines = Lines::of(inputs.terrain, self.flank as usize, job)?;
        let reference =
            inputs.reference.map(|field| Lines::of(field, self.flank as usize, job)).transpose()?;
        let of_reference =
            |of: fn(&Lines) -> Line| reference.as_ref().map_or(f64::NAN, |lines| of(lines).log_ratio);
        let metrics = Table::metrics([
            ("seam_edges", Unit::One, joins.edges as f64),
            ("seam_step", Unit::One, joins.step),
            ("seam_bend", Unit::One, joins.bend),
            ("row_line_step", Unit::One, lines.between_rows.log_ratio),
            ("row_line", Unit::Cell, lines.between_rows.at),
            ("row_line_step_reference", Unit::One, of_reference(|lines| lines.between_rows)),
            ("column_line_step", Unit::One, lines.between_columns.log_ratio),
            ("column_line", Unit::Cell, lines.between_columns.at),
            ("column_line_step_reference", Unit::One, of_reference(|lines| lines.between_columns)),
        ])?;
        Ok(SeamsOut { metrics })
    }
}

/// Label of each cell's patch, checked against the grid that they are to lie on.
///
/// # Errors
/// [`Error::DimensionMismatch`] for a placement of another size, [`Error::Invalid`] for one whose labels do not
/// fit its own grid or patches.
pub(super) fn checked_labels<'a>(grid: &Grid, placement: &'a Placement) -> Result<&'a [u32]> {
    grid.match_size("terrain", &placement.grid, "placement")?;
    let known = |label: &u32| *label as usize <= placement.patches.len();
    if placement.labels.len() == grid.len() && placement.labels.iter().all(known) {
        return Ok(&placement.labels);
    }
    Err(Error::invalid(
        "the placement's labels do not fit its grid or its patches",
        "connect the placement that the synthesis of this terrain gave",
    ))
}

/// How the joins of patches stand out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joins {
    /// Pairs of neighbouring cells from different patches.
    pub edges: u64,
    /// Natural logarithm of the mean step across joins over the mean step inside patches.
    pub step: f64,
    /// Natural logarithm of the root mean square Laplacian at joins over that inside patches.
    pub bend: f64,
}

/// Counts and sums at joins and inside patches.
#[derive(Clone, Copy, Default)]
struct Sums {
    steps: [(u64, f64); 2],
    bends: [(u64, f64); 2],
}

impl Joins {
    const NONE: Self = Self { edges: 0, step: f64::NAN, bend: f64::NAN };

    /// Compares joins with the rest of the patches. Ground that belongs to no patch counts only where it borders
    /// on one.
    ///
    /// # Errors
    /// As [`Seams`]: a placement that does not fit; [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, placement: &Placement, job: &Job) -> Result<Self> {
        let labels = checked_labels(terrain.grid(), placement)?;
        let (rows, cols) = terrain.grid().size();
        let cell = terrain.grid().cell;
        let height = |i: usize| f64::from(terrain.cells()[i]);
        let parts = per_row(rows, job, |row| {
            let mut sums = Sums::default();
            for col in 0..cols {
                let i = row * cols + col;
                let mut edge = |other: usize, size: f64| {
                    let step = (height(i) - height(other)).abs() / size;
                    let join = labels[i] != labels[other];
                    if step.is_finite() && (join || labels[i] != 0) {
                        let sum = &mut sums.steps[usize::from(join)];
                        *sum = (sum.0 + 1, sum.1 + step);
                    }
                };
                if col + 1 < cols {
                    edge(i + 1, cell.x);
                }
                if row + 1 < rows {
                    edge(i + cols, cell.y);
                }
                if row == 0 || col == 0 || row + 1 == rows || col + 1 == cols {
                    continue;
                }
                let along = (height(i - 1) - 2.0 * height(i) + height(i + 1)) / (cell.x * cell.x);
                let across = (height(i - cols) - 2.0 * height(i) + height(i + cols)) / (cell.y * cell.y);
                let join = [i - 1, i + 1, i - cols, i + cols].iter().any(|&other| labels[other] != labels[i]);
                let square = (along + across) * (along + across);
                if square.is_finite() && (join || labels[i] != 0) {
                    let sum = &mut sums.bends[usize::from(join)];
                    *sum = (sum.0 + 1, sum.1 + square);
                }
            }
            Ok(sums)
        })?;
        let mut all = Sums::default();
        for part in parts {
            for side in 0..2 {
                let add = |a: (u64, f64), b: (u64, f64)| (a.0 + b.0, a.1 + b.1);
                all.steps[side] = add(all.steps[side], part.steps[side]);
                all.bends[side] = add(all.bends[side], part.bends[side]);
            }
        }
        let log_ratio = |[(n, inside), (m, join)]: [(u64, f64); 2]| {
            let (inside, join) = (inside / n as f64, join / m as f64);
            if inside > 0.0 { libm::log(join / inside) } else { f64::NAN }
        };
        // The mean square's logarithm is twice the root's.
        Ok(Self { edges: all.steps[1].0, step: log_ratio(all.steps), bend: log_ratio(all.bends) / 2.0 })
    }
}

/// The straight line that stands out most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Natural logarithm of the mean step across it over that across the lines beside it.
    pub log_ratio: f64,
    /// The row or column before it.
    pub at: f64,
}

/// Straight lines along the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Between two rows.
    pub between_rows: Line,
    /// Between two columns.
    pub between_columns: Line,
}

impl Lines {
    /// Holds each line against `flank` lines to each side.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, flank: usize, job: &Job) -> Result<Self> {
        job.check()?;
        let (rows, cols) = terrain.grid().size();
        let add = |sum: &mut (u64, f64), a: f32, b: f32| {
            let step = (f64::from(a) - f64::from(b)).abs();
            if step.is_finite() {
                *sum = (sum.0 + 1, sum.1 + step);
            }
        };
        let between_rows = per_row(rows.saturating_sub(1), job, |row| {
            let mut sum = (0, 0.0);
            terrain.row(row).iter().zip(terrain.row(row + 1)).for_each(|(&a, &b)| add(&mut sum, a, b));
            Ok(sum)
        })?;
        // Some columns at a time, each from top to bottom: memory is read along the rows.
        let mut between_columns = vec![(0, 0.0); cols.saturating_sub(1)];
        let breadth = 64;
        between_columns.par_chunks_mut(breadth).enumerate().try_for_each(|(block, sums)| {
            for row in 0..rows {
                if row.is_multiple_of(256) {
                    job.check()?;
                }
                let line = &terrain.row(row)[block * breadth..];
                sums.iter_mut().zip(line.windows(2)).for_each(|(sum, pair)| add(sum, pair[0], pair[1]));
            }
            Ok(())
        })?;
        Ok(Self {
            between_rows: most_outstanding(&between_rows, flank),
            between_columns: most_outstanding(&between_columns, flank),
        })
    }
}

fn most_outstanding(lines: &[(u64, f64)], flank: usize) -> Line {
    let mut most = Line { log_ratio: f64::NAN, at: f64::NAN };
    for (i, &(count, sum)) in lines.iter().enumerate() {
        let beside = i.saturating_sub(flank)..(i + flank + 1).min(lines.len());
        let others = lines[beside.clone()].iter().zip(beside).filter(|(_, at)| *at != i);
        let (n, around) = others.fold((0, 0.0), |all, (own, _)| (all.0 + own.0, all.1 + own.1));
        let log_ratio = libm::log((sum / count as f64) / (around / n as f64));
        if log_ratio.is_finite() && (most.log_ratio.is_nan() || log_ratio > most.log_ratio) {
            most = Line { log_ratio, at: i as f64 };
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;
    use orograph_core::Patch;

    /// Two patches that meet in the middle of the columns.
    fn halves(grid: &Grid) -> Placement {
        let patch = Patch {
            exemplar: 0,
            source_center: [0.0; 2],
            target_center: [0.0; 2],
            size: 32,
            mirrored: false,
            controls: Vec::new(),
            offset: 0.0,
        };
        let labels = (0..grid.len()).map(|i| if i % grid.cols < grid.cols / 2 { 1 } else { 2 }).collect();
        let (sources, seams) = (vec![[0.0; 2]; grid.len()], Vec::new());
        Placement {
            grid: grid.clone(),
            scales: Vec::new(),
            patches: vec![patch.clone(), patch],
            labels,
            sources,
            seams,
        }
    }

    fn hills(row: usize, col: usize) -> f64 {
        10.0 * orograph_core::gaussian(1, 2, row as i64, col as i64)
    }

    #[test]
    fn invisible_joins_score_nothing_steps_above_and_ironed_ones_below() {
        let score = |z: &dyn Fn(usize, usize) -> f64| {
            let terrain = field(64, 64, z);
            Joins::of(&terrain, &halves(terrain.grid()), &Job::detached()).unwrap()
        };
        let plain = score(&hills);
        assert_eq!(plain.edges, 64);
        assert!(plain.step.abs() < 0.2 && plain.bend.abs() < 0.2, "{plain:?}");
        let stepped = score(&|row, col| hills(row, col) + if col < 32 { 0.0 } else { 60.0 });
        assert!(stepped.step > 1.0 && stepped.bend > 0.3, "{stepped:?}");
        let ironed = score(&|row, col| hills(row, if col == 32 { 31 } else { col }));
        assert!(ironed.step < -5.0, "{ironed:?}");
    }

    #[test]
    fn a_ramp_has_the_ratio_that_was_built_in() {
        // One metre a column, three across the join; rows are level.
        let terrain = field(8, 20, |_, col| col as f64 + if col < 10 { 0.0 } else { 2.0 });
        let found = Joins::of(&terrain, &halves(terrain.grid()), &Job::detached()).unwrap();
        // Inside: 8 × 18 steps of one metre and 7 × 20 of none.
        let inside = 144.0 / 284.0;
        assert!((found.step - libm::log(3.0 / inside)).abs() < 1e-9);
        let lines = Lines::of(&terrain, 4, &Job::detached()).unwrap();
        assert_eq!(lines.between_columns.at, 9.0);
        assert!((lines.between_columns.log_ratio - libm::log(3.0)).abs() < 1e-9);
        assert!(lines.between_rows.log_ratio.is_nan());
    }

    #[test]
    fn a_placement_that_does_not_fit_is_refused() {
        let terrain = field(8, 8, hills);
        let run = |placement: &Placement| {
            let inputs = SeamsIn { terrain: &terrain, placement: Some(placement), reference: Some(&terrain) };
            Seams::default().run(inputs, &Job::detached()).map(|_| ())
        };
        let good = halves(terrain.grid());
        assert_eq!(run(&good), Ok(()));
        assert!(run(&Placement { labels: vec![1; 3], ..good.clone() }).is_err());
        assert!(run(&Placement { labels: vec![9; 64], ..good.clone() }).is_err());
        assert!(run(&halves(field(4, 4, hills).grid())).is_err());
    }
}
