//! Curvature: how the ground bends along its slope and across it.
//!
//! Evans, I. S. (1980), "An integrated system of terrain analysis and slope mapping", Zeitschrift für
//! Geomorphologie, Supplementband 36: a quadratic surface by least squares over a square window; profile curvature
//! along the steepest descent, plan curvature of the contour line. Departures: cells need not be square; level
//! ground, which has neither, and windows that a border or a void cuts are left out. Plan curvature has no bounds
//! where the ground is nearly level, so distances are taken between values clipped to the reference's 1 % and 99 %
//! quantiles, over the deviation of the reference's clipped values.

use orograph_core::{Unit, prelude::*};

use super::{distribution::Distribution, sums::per_row};

/// Measures how a terrain bends along and across its slopes, and how far that is from a reference.
///
/// Curvature is positive on convex ground: crests and spurs. Without a reference the distances are NaN; they
/// are 0 for equal distributions and in units of the reference's standard deviation.
#[derive(Params, Clone, Debug)]
pub struct Curvature {
    /// Cells to each side of the middle in the window that the surface is fitted to.
    #[param(default = 1u32, range = 1..=10, slider = 1..=5, unit = "cells")]
    pub reach: u32,
}

/// Inputs of [`Curvature`].
#[derive(Inputs)]
pub struct CurvatureIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Curvature`].
#[derive(Outputs)]
pub struct CurvatureOut {
    /// One row of metrics for profile and plan curvature: quantiles, deviation, Wasserstein distance.
    pub metrics: Table,
}

impl Node for Curvature {
    const ID: &'static str = "measure.curvature";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CurvatureIn<'a>;
    type Outputs = CurvatureOut;

    fn cost(&self) -> f64 {
        let side = 2.0 * f64::from(self.reach) + 1.0;
        10.0 + 2.0 * side * side
    }

    fn run(&self, inputs: CurvatureIn<'_>, job: &Job) -> Result<CurvatureOut> {
        let own = Curvatures::of(inputs.terrain, self.reach as usize, job)?;
        let reference = inputs
            .reference
            .map(|reference| Curvatures::of(reference, self.reach as usize, job))
            .transpose()?;
        let distance = |of: fn(&Curvatures) -> &Bends| {
            reference.as_ref().map_or(f64::NAN, |reference| of(&own).distance(of(reference)))
        };
        let (profile, plan) = (&own.profile, &own.plan);
        let metrics = Table::metrics([
            ("profile_curvature_p01", Unit::PerMetre, profile.low),
            ("profile_curvature_p99", Unit::PerMetre, profile.high),
            ("profile_curvature_deviation", Unit::PerMetre, profile.deviation),
            ("profile_curvature_w1", Unit::One, distance(|all| &all.profile)),
            ("plan_curvature_p01", Unit::PerMetre, plan.low),
            ("plan_curvature_p99", Unit::PerMetre, plan.high),
            ("plan_curvature_deviation", Unit::PerMetre, plan.deviation),
            ("plan_curvature_w1", Unit::One, distance(|all| &all.plan)),
        ])?;
        Ok(CurvatureOut { metrics })
    }
}

/// Profile and plan curvature of a terrain.
#[derive(Clone, Debug)]
pub struct Curvatures {
    /// Along the steepest descent.
    pub profile: Bends,
    /// Of the contour line.
    pub plan: Bends,
}

impl Curvatures {
    /// The curvatures of every cell with a whole window that is not level.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, reach: usize, job: &Job) -> Result<Self> {
        job.admit(terrain.grid().len() as u64 * 16, || "the curvatures of all cells".into())?;
        let fit = Fit::new(reach, terrain.grid().cell);
        let rows = per_row(terrain.rows(), job, |row| Ok(fit.row(terrain, row)))?;
        let count = rows.iter().map(Vec::len).sum();
        let (mut profile, mut plan) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for row in rows {
            job.check()?;
            for [along, across] in row {
                profile.push(along);
                plan.push(across);
            }
        }
        Ok(Self { profile: Bends::of(profile, job)?, plan: Bends::of(plan, job)? })
    }
}

/// Least squares over a window, by sums with polynomials that are orthogonal on it.
struct Fit {
    reach: usize,
    cell: CellSize,
    /// Sum of the squared offsets along a line of the window.
    square: f64,
    /// Sum of the squared values of the second polynomial, offset² less its mean.
    second: f64,
}

impl Fit {
    fn new(reach: usize, cell: CellSize) -> Self {
        let offsets = || (0..=2 * reach).map(|i| i as f64 - reach as f64);
        let square: f64 = offsets().map(|x| x * x).sum();
        let mean = square / (2 * reach + 1) as f64;
        let second = offsets().map(|x| (x * x - mean) * (x * x - mean)).sum();
        Self { reach, cell, square, second }
    }

    /// Profile and plan curvature, in 1/m, of the cells of a row that have them.
    fn row(&self, terrain: &Heightfield, row: usize) -> Vec<[f32; 2]> {
        let (rows, cols) = terrain.grid().size();
        let reach = self.reach;
        if row < reach || row + reach >= rows || cols <= 2 * reach {
            return Vec::new();
        }
        (reach..cols - reach).filter_map(|col| self.at(terrain, row, col)).collect()
    }

    fn at(&self, terrain: &Heightfield, row: usize, col: usize) -> Option<[f32; 2]> {
        let n = (2 * self.reach + 1) as f64;
        let mean = self.square / n;
        let middle = f64::from(terrain.at(row, col));
        // Sums of height times x, y, xy and the second polynomials in x and y; x east, y north.
        let (mut sx, mut sy, mut sxy, mut sxx, mut syy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in 0..=2 * self.reach {
            let y = self.reach as f64 - i as f64;
            let line = &terrain.row(row + i - self.reach)[col - self.reach..=col + self.reach];
            for (j, &height) in line.iter().enumerate() {
                let x = j as f64 - self.reach as f64;
                let z = f64::from(height) - middle;
                sx += x * z;
                sy += y * z;
                sxy += x * y * z;
                sxx += (x * x - mean) * z;
                syy += (y * y - mean) * z;
            }
        }
        let CellSize { x: dx, y: dy } = self.cell;
        let (p, q) = (sx / (n * self.square * dx), sy / (n * self.square * dy));
        let s = sxy / (self.square * self.square * dx * dy);
        let r = 2.0 * sxx / (n * self.second * dx * dx);
        let t = 2.0 * syy / (n * self.second * dy * dy);
        let steep = p * p + q * q;
        // A void or infinity anywhere in the window makes every sum one.
        if !(steep.is_finite() && r.is_finite() && t.is_finite() && s.is_finite() && steep > 0.0) {
            return None;
        }
        let along =
            -(r * p * p + 2.0 * s * p * q + t * q * q) / (steep * (1.0 + steep) * (1.0 + steep).sqrt());
        let across = -(r * q * q - 2.0 * s * p * q + t * p * p) / (steep * steep.sqrt());
        let bends = [along as f32, across as f32];
        bends.iter().all(|bend| bend.is_finite()).then_some(bends)
    }
}

/// One kind of curvature over a terrain.
#[derive(Clone, Debug)]
pub struct Bends {
    values: Vec<f32>,
    /// 1 % quantile in 1/m; NaN without values.
    pub low: f64,
    /// 99 % quantile in 1/m; NaN without values.
    pub high: f64,
    /// Standard deviation, in 1/m, of the values clipped to those quantiles.
    pub deviation: f64,
}

impl Bends {
    fn of(mut values: Vec<f32>, job: &Job) -> Result<Self> {
        if values.is_empty() {
            return Ok(Self { values, low: f64::NAN, high: f64::NAN, deviation: f64::NAN });
        }
        let last = values.len() - 1;
        let mut quantile = |share: f64| {
            job.check()?;
            let at = (share * last as f64).round() as usize;
            Ok(f64::from(*values.select_nth_unstable_by(at, f32::total_cmp).1))
        };
        let (low, high) = (quantile(0.01)?, quantile(0.99)?);
        job.check()?;
        let clipped = || values.iter().map(|&value| f64::from(value).clamp(low, high));
        let n = values.len() as f64;
        let mean = clipped().sum::<f64>() / n;
        let deviation = (clipped().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n).sqrt();
        Ok(Self { values, low, high, deviation })
    }

    /// Wasserstein-1 distance to a reference's curvature, both clipped to the reference's quantiles, over the
    /// reference's deviation; NaN where either has no values or the reference does not vary.
    #[must_use]
    pub fn distance(&self, reference: &Self) -> f64 {
        let classes = 4096;
        let step = (reference.high - reference.low) / classes as f64;
        if !(step > 0.0 && reference.deviation > 0.0) {
            return f64::NAN;
        }
        let spread = |bends: &Self| {
            let mut counts = vec![0u64; classes];
            for &value in &bends.values {
                counts[(((f64::from(value) - reference.low) / step) as usize).min(classes - 1)] += 1;
            }
            Distribution::of_counts(reference.low, step, &counts)
        };
        spread(self).wasserstein(&spread(reference)) / reference.deviation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    /// x east and y north, in metres, from the middle of 21 × 21 oblong cells.
    fn surface(z: impl Fn(f64, f64) -> f64) -> Heightfield {
        let grid = Grid::new(21, 21, CellSize { x: 3.0, y: 2.0 }).unwrap();
        let at = |i: usize| ((i % 21) as f64 * 3.0 - 30.0, 20.0 - (i / 21) as f64 * 2.0);
        let cells = (0..441).map(|i| z(at(i).0, at(i).1) as f32).collect();
        Heightfield::new(grid, cells).unwrap()
    }

    #[test]
    fn a_quadratic_surface_has_the_curvature_of_its_derivatives() {
        let z = |x: f64, y: f64| 0.01 * x * x - 0.02 * y * y + 0.015 * x * y + 0.3 * x - 0.2 * y;
        let terrain = surface(z);
        for reach in [1, 3] {
            let fit = Fit::new(reach, terrain.grid().cell);
            for (row, col) in [(4, 6), (10, 10), (15, 9)] {
                let (x, y) = (col as f64 * 3.0 - 30.0, 20.0 - row as f64 * 2.0);
                let (p, q) = (0.02 * x + 0.015 * y + 0.3, -0.04 * y + 0.015 * x - 0.2);
                let (r, s, t) = (0.02, 0.015, -0.04);
                let g = p * p + q * q;
                let along = -(r * p * p + 2.0 * s * p * q + t * q * q) / (g * libm::pow(1.0 + g, 1.5));
                let across = -(r * q * q - 2.0 * s * p * q + t * p * p) / libm::pow(g, 1.5);
                let [found_along, found_across] = fit.at(&terrain, row, col).unwrap();
                assert!((f64::from(found_along) - along).abs() < 1e-5, "{found_along} for {along}");
                assert!((f64::from(found_across) - across).abs() < 1e-5, "{found_across} for {across}");
            }
        }
    }

    #[test]
    fn a_cone_s_contours_bend_as_their_circles() {
        let terrain = surface(|x, y| -0.5 * (x * x + y * y).sqrt());
        let [along, across] = Fit::new(1, terrain.grid().cell).at(&terrain, 10, 18).unwrap();
        assert!(along.abs() < 1e-3);
        assert!((f64::from(across) - 1.0 / 24.0).abs() < 1e-3, "{across}");
    }

    #[test]
    fn distances_are_nothing_to_oneself_and_grow() {
        let noise = |row: usize, col: usize| orograph_core::gaussian(1, 7, row as i64, col as i64);
        let rough = field(60, 60, |row, col| 10.0 * noise(row, col));
        let rougher = field(60, 60, |row, col| 20.0 * noise(row, col));
        let run = |terrain: &Heightfield, reference: &Heightfield| {
            let inputs = CurvatureIn { terrain, reference: Some(reference) };
            let metrics = Curvature::default().run(inputs, &Job::detached()).unwrap().metrics;
            (metrics.metric("profile_curvature_w1").unwrap(), metrics.metric("plan_curvature_w1").unwrap())
        };
        assert_eq!(run(&rough, &rough), (0.0, 0.0));
        let (profile, _) = run(&rougher, &rough);
        assert!(profile > 0.05, "{profile}");
        let level = field(9, 9, |_, _| 3.0);
        assert!(run(&level, &rough).0.is_nan() && run(&rough, &level).0.is_nan());
    }
}
