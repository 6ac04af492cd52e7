//! Hypsometry: how much ground lies at which height.
//!
//! Strahler, A. N. (1952), "Hypsometric (area-altitude) analysis of erosional topography", Geological Society of
//! America Bulletin 63 (11). Heights are taken relative to the terrain's own lowest and highest, so that terrains
//! of different relief compare.

use orograph_core::{Unit, prelude::*};

use super::{distribution::Distribution, sums::Moments};

/// Measures how a terrain's ground is spread over its relief, and how far that is from a reference.
///
/// Heights count from the terrain's lowest (0) to its highest (1). Voids are left out. Without a reference the
/// distance is NaN; it is 0 for equal distributions.
#[derive(Params, Clone, Debug)]
pub struct Hypsometry {}

/// Inputs of [`Hypsometry`].
#[derive(Inputs)]
pub struct HypsometryIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Hypsometry`].
#[derive(Outputs)]
pub struct HypsometryOut {
    /// One row of metrics: relief, hypsometric integral, Wasserstein distance of relative heights.
    pub metrics: Table,
    /// The hypsometric curve: share of the ground that lies above each relative height.
    pub curve: Table,
}

impl Node for Hypsometry {
    const ID: &'static str = "measure.hypsometry";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = HypsometryIn<'a>;
    type Outputs = HypsometryOut;

    fn run(&self, inputs: HypsometryIn<'_>, job: &Job) -> Result<HypsometryOut> {
        let own = Heights::of(inputs.terrain, job)?;
        let reference = inputs.reference.map(|reference| Heights::of(reference, job)).transpose()?;
        let distance = reference.as_ref().map_or(f64::NAN, |other| own.relative.wasserstein(&other.relative));
        let metrics = Table::metrics([
            ("relief", Unit::Metre, own.relief),
            ("hypsometric_integral", Unit::One, own.integral),
            ("hypsometry_w1", Unit::One, distance),
        ])?;
        let column = |name: &str, cells| Column { name: name.into(), unit: Unit::Percent, cells };
        let shares = |heights: Option<&Heights>| {
            Cells::Numbers(heights.map_or_else(|| vec![f64::NAN; LEVELS + 1], Heights::above))
        };
        let levels = (0..=LEVELS).map(|level| 100.0 * level as f64 / LEVELS as f64).collect();
        let curve = Table::new(vec![
            column("relative_height", Cells::Numbers(levels)),
            column("share_above", shares(Some(&own))),
            column("reference_share_above", shares(reference.as_ref())),
        ])?;
        Ok(HypsometryOut { metrics, curve })
    }
}

/// Classes between the lowest and the highest height.
const CLASSES: usize = 1000;
/// Steps of the curve: a whole number of classes each.
const LEVELS: usize = 100;

/// How a terrain's ground is spread over its relief.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Highest less lowest, in metres; NaN for a terrain of voids.
    pub relief: f64,
    /// Mean height relative to the relief; NaN without relief.
    pub integral: f64,
    /// Distribution of relative heights, 0 to 1.
    pub relative: Distribution,
}

impl Heights {
    /// The heights of every cell that is finite.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, job: &Job) -> Result<Self> {
        let finite = |row: usize| terrain.row(row).iter().filter(|height| height.is_finite());
        let ends = super::sums::per_row(terrain.rows(), job, |row| {
            Ok(finite(row).fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &height| {
                (low.min(height), high.max(height))
            }))
        })?;
        let (low, high) = ends
            .into_iter()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |all, own| (all.0.min(own.0), all.1.max(own.1)));
        let (low, relief) = (f64::from(low), f64::from(high) - f64::from(low));
        if relief < 0.0 || relief.is_nan() {
            let relative = Distribution::of_counts(0.0, 1.0 / CLASSES as f64, &[0; CLASSES]);
            return Ok(Self { relief: f64::NAN, integral: f64::NAN, relative });
        }
        let scale = if relief > 0.0 { relief } else { 1.0 };
        let each = |row: usize, hear: &mut dyn FnMut(f64)| {
            finite(row).for_each(|&height| hear((f64::from(height) - low) / scale));
        };
        let relative = Distribution::count(terrain.rows(), (0.0, 1.0 / CLASSES as f64, CLASSES), job, each)?;
        let mean = Moments::of(terrain.rows(), job, each)?.mean;
        Ok(Self { relief, integral: if relief > 0.0 { mean } else { f64::NAN }, relative })
    }

    /// Percent of the ground above each of the curve's levels; NaN for a terrain of voids.
    #[must_use]
    pub fn above(&self) -> Vec<f64> {
        if self.relative.count == 0 {
            return vec![f64::NAN; LEVELS + 1];
        }
        let mut below = 0.0;
        let mut above = vec![100.0];
        for classes in self.relative.shares.chunks(CLASSES / LEVELS) {
            below += classes.iter().sum::<f64>();
            above.push(f64::max(100.0 * (1.0 - below), 0.0));
        }
        above
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};

    fn run(terrain: &Heightfield, reference: Option<&Heightfield>) -> HypsometryOut {
        Hypsometry::default().run(HypsometryIn { terrain, reference }, &Job::detached()).unwrap()
    }

    #[test]
    fn a_plane_has_half_of_its_ground_above_the_middle() {
        let plane = field(4, 2001, |_, col| 100.0 + col as f64);
        let out = run(&plane, Some(&plane));
        assert!((out.metrics.metric("hypsometric_integral").unwrap() - 0.5).abs() < 1e-9);
        assert_eq!(out.metrics.metric("relief"), Some(2000.0));
        assert_eq!(out.metrics.metric("hypsometry_w1"), Some(0.0));
        let Cells::Numbers(above) = &out.curve.column("share_above").unwrap().cells else { panic!() };
        assert!((above[50] - 50.0).abs() < 0.1 && (above[25] - 75.0).abs() < 0.1);
    }

    #[test]
    fn distance_is_that_between_the_integrals_of_ordered_distributions() {
        // z = x² lies wholly below z = x, so the area between the curves is 1/2 - 1/3.
        let (line, bowl) = (field(1, 4001, |_, col| col as f64), field(1, 4001, |_, col| (col * col) as f64));
        let distance = run(&bowl, Some(&line)).metrics.metric("hypsometry_w1").unwrap();
        assert!((distance - 1.0 / 6.0).abs() < 2e-3, "{distance}");
    }

    #[test]
    fn flat_and_void_ground_has_no_integral() {
        assert!(run(&row(&[5.0; 3]), None).metrics.metric("hypsometric_integral").unwrap().is_nan());
        assert!(run(&row(&[f32::NAN; 3]), None).metrics.metric("relief").unwrap().is_nan());
    }
}
