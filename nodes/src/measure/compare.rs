//! Compare: how far a terrain is from the truth, and how rough it is beside it.
//!
//! The roughness ratio follows void filling practice: the standard deviation of the Laplacian, divided by
//! that of the reference over the same cells. A patch that is smoother than the ground around it stays
//! below 1, seams push the ratio at the rim above 1. Departure: cells need not be square, so the Laplacian
//! is taken per metre.

use orograph_core::{Unit, prelude::*};

use super::{
    rim::rim,
    slope_distance::slope_distance,
    sums::{Moments, per_row},
};
use crate::surface::laplacian;

/// Measures a terrain against a reference: errors, roughness, slopes and exactness at known cells.
///
/// Errors are taken over the cells that both terrains know, inside the mask where there is one. Cells that
/// only the reference knows are counted as missing. `slope_w1` is the Wasserstein-1 distance of the slopes in bins of
/// 1°: 0 where both are equally steep. `step_ratio_rim` is the mean step of the terrain across the mask's edge, relative to
/// that between cells outside along it: above 1 a rim shows. A metric without any cell is NaN.
#[derive(Params, Clone, Debug)]
pub struct Compare {
    /// Half the breadth of the band along the mask's edge over which roughness at the rim is measured.
    #[param(default = 1u32, range = 1..=8, slider = 1..=4, unit = "cells")]
    pub rim: u32,
}

/// Inputs of [`Compare`].
#[derive(Inputs)]
pub struct CompareIn<'a> {
    /// Terrain to judge.
    pub terrain: &'a Heightfield,
    /// The truth.
    pub reference: &'a Heightfield,
    /// Heights that the terrain must have kept to the bit; voids are free.
    pub known: Option<&'a Heightfield>,
    /// Where to compare: cells of at least one half. Everywhere when nothing is connected.
    pub mask: Option<&'a Mask>,
}

/// Outputs of [`Compare`].
#[derive(Outputs)]
pub struct CompareOut {
    /// One row of metrics.
    pub metrics: Table,
}

impl Node for Compare {
    const ID: &'static str = "measure.compare";
    const VERSION: u32 = 3; // 2 adds slope_w1, 3 step_ratio_rim
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CompareIn<'a>;
    type Outputs = CompareOut;

    fn run(&self, inputs: CompareIn<'_>, job: &Job) -> Result<CompareOut> {
        let grid = inputs.terrain.grid();
        grid.match_size("terrain", inputs.reference.grid(), "reference")?;
        if let Some(known) = inputs.known {
            grid.match_size("terrain", known.grid(), "known")?;
        }
        if let Some(mask) = inputs.mask {
            grid.match_size("terrain", mask.grid(), "mask")?;
        }
        refuse_infinite("terrain", inputs.terrain)?;
        refuse_infinite("reference", inputs.reference)?;

        let errors = Errors::of(&inputs, job)?;
        let CompareIn { terrain, reference, mask, .. } = inputs;
        let rim = mask.map(|mask| rim(mask, self.rim as usize, job)).transpose()?;
        let roughness_at_rim = match &rim {
            Some(rim) => roughness_ratio(terrain, reference, Some(rim), job)?,
            None => f64::NAN,
        };
        let step = mask.map(|mask| step_ratio(terrain, mask, job)).transpose()?.unwrap_or(f64::NAN);
        let apart = slope_distance(terrain, reference, |row, col| inside(mask, row, col), job)?;
        let (known, kept) = exactness(inputs.terrain, inputs.known);
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
        let metrics = [
            ("rmse", Unit::Metre, errors.rmse()),
            ("mae", Unit::Metre, errors.absolute / errors.count as f64),
            ("max_error", Unit::Metre, errors.largest),
            ("bias", Unit::Metre, errors.sum / errors.count as f64),
            ("rmse_of_relief", Unit::Percent, 100.0 * errors.rmse() / (errors.high - errors.low)),
            ("roughness_ratio", Unit::One, roughness_ratio(terrain, reference, mask, job)?),
            ("roughness_ratio_rim", Unit::One, roughness_at_rim),
            ("step_ratio_rim", Unit::One, step),
            ("slope_w1", Unit::Degree, apart),
            ("cells", Unit::Cell, errors.count as f64),
            ("missing", Unit::Cell, errors.missing as f64),
            ("known_cells", Unit::Cell, known as f64),
            ("known_share", Unit::Percent, share(known, if inputs.known.is_some() { grid.len() } else { 0 })),
            ("exact_at_known", Unit::Percent, share(kept, known)),
        ];
        Ok(CompareOut { metrics: Table::metrics(metrics)? })
    }
}

/// Roughness of the terrain relative to the reference, inside the mask.
fn roughness_ratio(
    terrain: &Heightfield,
    reference: &Heightfield,
    mask: Option<&Mask>,
    job: &Job,
) -> Result<f64> {
    let (rows, cols) = terrain.grid().size();
    let deviation = |of_terrain: bool| {
        let each = |row: usize, hear: &mut dyn FnMut(f64)| {
            for col in (0..cols).filter(|&col| inside(mask, row, col)) {
                let pair = (laplacian(terrain, [row, col], 1), laplacian(reference, [row, col], 1));
                if let (Some(own), Some(true_one)) = pair {
                    hear(if of_terrain { own } else { true_one });
                }
            }
        };
        Moments::of(rows, job, each).map(|moments| moments.deviation)
    };
    Ok(deviation(true)? / deviation(false)?)
}

/// Cells outside the mask that count as its surroundings, as steps are compared.
const COLLAR: usize = 4;

/// Mean slope between neighbours across the mask's edge, relative to that between neighbours just outside.
fn step_ratio(terrain: &Heightfield, mask: &Mask, job: &Job) -> Result<f64> {
    let near = rim(mask, COLLAR, job)?;
    let (rows, cols) = terrain.grid().size();
    let CellSize { x, y } = terrain.grid().cell;
    let sums = per_row(rows, job, |row| {
        let mut sums = [[0.0; 2]; 2];
        for col in 0..cols {
            for (other_row, other_col, far) in [(row, col + 1, x), (row + 1, col, y)] {
                if other_row >= rows || other_col >= cols {
                    continue;
                }
                let step = f64::from(terrain.at(row, col)) - f64::from(terrain.at(other_row, other_col));
                let ends = [(row, col), (other_row, other_col)];
                let within = ends.map(|(row, col)| inside(Some(mask), row, col));
                let close = ends.iter().all(|&(row, col)| near.at(row, col) > 0.0);
                if step.is_nan() || !close || within == [true; 2] {
                    continue;
                }
                let [sum, n] = &mut sums[usize::from(within == [false; 2])];
                (*sum, *n) = (*sum + step.abs() / far, *n + 1.0);
            }
        }
        Ok(sums)
    })?;
    let total = sums
        .into_iter()
        .fold([[0.0; 2]; 2], |a: [[f64; 2]; 2], b| [0, 1].map(|i| [0, 1].map(|k| a[i][k] + b[i][k])));
    let [edge, outside] = total.map(|[sum, n]| sum / n);
    Ok(edge / outside)
}

fn refuse_infinite(what: &str, field: &Heightfield) -> Result<()> {
    let Some(i) = field.cells().iter().position(|height| height.is_infinite()) else { return Ok(()) };
    let cols = field.cols();
    Err(Error::NonFinite { what: what.into(), row: i / cols, col: i % cols })
}

fn inside(mask: Option<&Mask>, row: usize, col: usize) -> bool {
    mask.is_none_or(|mask| mask.at(row, col) >= 0.5)
}

/// How many cells are known, and how many of those the terrain has to the bit.
fn exactness(terrain: &Heightfield, known: Option<&Heightfield>) -> (usize, usize) {
    let Some(known) = known else { return (0, 0) };
    let pairs = || known.cells().iter().zip(terrain.cells()).filter(|(known, _)| !known.is_nan());
    (pairs().count(), pairs().filter(|(known, height)| known.to_bits() == height.to_bits()).count())
}

/// Sums of differences, terrain less reference.
struct Errors {
    count: usize,
    missing: usize,
    sum: f64,
    absolute: f64,
    square: f64,
    largest: f64,
    /// Range of the reference over the cells compared.
    low: f64,
    high: f64,
}

impl Errors {
    const NONE: Self = Self {
        count: 0,
        missing: 0,
        sum: 0.0,
        absolute: 0.0,
        square: 0.0,
        largest: f64::NAN,
        low: f64::NAN,
        high: f64::NAN,
    };

    fn of(inputs: &CompareIn<'_>, job: &Job) -> Result<Self> {
        let CompareIn { terrain, reference, mask, .. } = *inputs;
        let rows = per_row(terrain.rows(), job, |row| {
            let mut errors = Self::NONE;
            for (col, (height, truth)) in terrain.row(row).iter().zip(reference.row(row)).enumerate() {
                if !truth.is_nan() && inside(mask, row, col) {
                    errors.add(f64::from(*height), f64::from(*truth));
                }
            }
            Ok(errors)
        })?;
        Ok(rows.into_iter().fold(Self::NONE, Self::join))
    }

    fn add(&mut self, height: f64, truth: f64) {
        if height.is_nan() {
            self.missing += 1;
            return;
        }
        let error = height - truth;
        self.count += 1;
        self.sum += error;
        self.absolute += error.abs();
        self.square += error * error;
        self.largest = self.largest.max(error.abs());
        self.low = self.low.min(truth);
        self.high = self.high.max(truth);
    }

    fn join(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            missing: self.missing + other.missing,
            sum: self.sum + other.sum,
            absolute: self.absolute + other.absolute,
            square: self.square + other.square,
            largest: self.largest.max(other.largest),
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn rmse(&self) -> f64 {
        (self.square / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};

    fn compare(inputs: CompareIn<'_>) -> impl Fn(&str) -> f64 {
        let metrics = Compare::default().run(inputs, &Job::detached()).unwrap().metrics;
        move |name| metrics.metric(name).unwrap()
    }

    #[test]
    fn errors_are_those_of_a_hand_count() {
        let nan = f32::NAN;
        let terrain = row(&[1.0, 2.0, 6.0, nan, 5.0, nan]);
        let reference = row(&[1.0, 3.0, 4.0, 4.0, nan, nan]);
        let metric = compare(CompareIn { terrain: &terrain, reference: &reference, known: None, mask: None });
        assert_eq!((metric("cells"), metric("missing")), (3.0, 1.0));
        assert!((metric("rmse") - (5.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!((metric("mae"), metric("max_error")), (1.0, 2.0));
        assert!((metric("bias") - 1.0 / 3.0).abs() < 1e-12);
        assert!((metric("rmse_of_relief") - metric("rmse") / 3.0 * 100.0).abs() < 1e-9);
        assert!(metric("exact_at_known").is_nan() && metric("roughness_ratio_rim").is_nan());
    }

    #[test]
    fn an_offset_is_all_bias_and_keeps_roughness() {
        let bumps = |row: usize, col: usize| ((row * 7 + col * 3) % 5) as f64;
        let reference = field(8, 9, bumps);
        let terrain = field(8, 9, |row, col| bumps(row, col) + 16.0);
        let metric = compare(CompareIn { terrain: &terrain, reference: &reference, known: None, mask: None });
        assert_eq!([metric("rmse"), metric("mae"), metric("max_error"), metric("bias")], [16.0; 4]);
        assert_eq!(metric("roughness_ratio"), 1.0);
        let twice = field(8, 9, |row, col| 2.0 * bumps(row, col));
        let metric = compare(CompareIn { terrain: &twice, reference: &reference, known: None, mask: None });
        assert!((metric("roughness_ratio") - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_rim_is_the_band_along_the_mask_s_edge() {
        let bumps = |row: usize, col: usize| ((row * 7 + col * 3) % 5) as f64;
        let reference = field(12, 12, bumps);
        let masked = |row: usize, col: usize| (3..9).contains(&row) && (3..9).contains(&col);
        let mask = reference.map(&Job::detached(), |_| 0.0).unwrap();
        let mut mask: Mask = mask;
        (0..144).filter(|i| masked(i / 12, i % 12)).for_each(|i| mask.cells_mut()[i] = 1.0);
        // Doubled deep inside alone: Laplacians at the rim stay the reference's.
        let deep = |row: usize, col: usize| (5..7).contains(&row) && (5..7).contains(&col);
        let terrain = field(12, 12, |r, c| if deep(r, c) { 9.0 * bumps(r, c) } else { bumps(r, c) });
        let inputs = CompareIn { terrain: &terrain, reference: &reference, known: None, mask: Some(&mask) };
        let metric = compare(inputs);
        assert_eq!(metric("cells"), 36.0);
        assert_eq!(metric("roughness_ratio_rim"), 1.0);
        assert!(metric("roughness_ratio") > 1.5);
    }

    #[test]
    fn steps_across_the_edge_are_relative_to_those_outside() {
        let masked = |row: usize, col: usize| (8..15).contains(&row) && (8..15).contains(&col);
        let slope = |row: usize, col: usize| 3.0 * row as f64 + 3.0 * col as f64;
        let mut mask: Mask = field(24, 24, slope).map(&Job::detached(), |_| 0.0).unwrap();
        (0..576).filter(|i| masked(i / 24, i % 24)).for_each(|i| mask.cells_mut()[i] = 1.0);
        // On an even slope every step is 3 m; a patch 12 m too high makes them 9 and 15 m.
        for (raised, expected) in [(0.0, 1.0), (12.0, 4.0)] {
            let terrain = field(24, 24, |r, c| slope(r, c) + if masked(r, c) { raised } else { 0.0 });
            let metric =
                compare(CompareIn { terrain: &terrain, reference: &terrain, known: None, mask: Some(&mask) });
            assert!((metric("step_ratio_rim") - expected).abs() < 1e-6, "{}", metric("step_ratio_rim"));
        }
    }

    #[test]
    fn known_cells_are_compared_bit_by_bit() {
        let known = row(&[1.0, f32::NAN, 3.0, 0.0]);
        let terrain = row(&[1.0, 2.0, 3.000_001, -0.0]);
        let metric =
            compare(CompareIn { terrain: &terrain, reference: &terrain, known: Some(&known), mask: None });
        assert_eq!((metric("known_cells"), metric("known_share")), (3.0, 75.0));
        assert!((metric("exact_at_known") - 100.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_to_compare_is_nan_and_infinity_is_refused() {
        let voids = row(&[f32::NAN; 3]);
        let metric = compare(CompareIn { terrain: &voids, reference: &voids, known: None, mask: None });
        assert!(metric("rmse").is_nan() && metric("max_error").is_nan());
        let infinite = row(&[0.0, f32::INFINITY, 0.0]);
        let inputs = CompareIn { terrain: &infinite, reference: &voids, known: None, mask: None };
        let out = Compare::default().run(inputs, &Job::detached());
        assert!(matches!(out, Err(Error::NonFinite { row: 0, col: 1, .. })));
    }

    #[test]
    fn metrics_have_the_same_bits_on_any_number_of_threads() {
        let noise = |row: usize, col: usize| orograph_core::gaussian(1, 2, row as i64, col as i64);
        let reference = field(70, 50, |row, col| 1000.0 + 30.0 * noise(row, col));
        let terrain = field(70, 50, |row, col| 1000.0 + 30.0 * noise(row, col + 1));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let inputs = CompareIn { terrain: &terrain, reference: &reference, known: None, mask: None };
            let out = pool.install(|| Compare::default().run(inputs, &Job::detached())).unwrap();
            Value::Table(out.metrics.into()).digest()
        };
        assert_eq!(on(1), on(2));
        assert_eq!(on(1), on(8));
    }
}
