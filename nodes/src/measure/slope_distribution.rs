//! Distribution of slopes, from Horn's gradient (see [`surface`]), in classes of one degree.

use glam::DVec2;
use orograph_core::{Unit, prelude::*};

use super::{distribution::Distribution, sums::per_row};
use crate::surface;

/// Measures how steep a terrain is, and how far that is from a reference.
///
/// Voids are left out. Without a reference the distances are NaN; they are 0 for equal distributions.
#[derive(Params, Clone, Debug)]
pub struct SlopeDistribution {}

/// Inputs of [`SlopeDistribution`].
#[derive(Inputs)]
pub struct SlopeDistributionIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`SlopeDistribution`].
#[derive(Outputs)]
pub struct SlopeDistributionOut {
    /// One row of metrics: mean, median and 95 % quantile, Wasserstein and Jensen–Shannon distances.
    pub metrics: Table,
    /// Share of the cells in each degree of slope.
    pub histogram: Table,
}

impl Node for SlopeDistribution {
    const ID: &'static str = "measure.slope_distribution";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = SlopeDistributionIn<'a>;
    type Outputs = SlopeDistributionOut;

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, inputs: SlopeDistributionIn<'_>, job: &Job) -> Result<SlopeDistributionOut> {
        let own = Slopes::of(inputs.terrain, job)?;
        let reference = inputs.reference.map(|reference| Slopes::of(reference, job)).transpose()?;
        let distance = |of: fn(&Distribution, &Distribution) -> f64| {
            reference.as_ref().map_or(f64::NAN, |reference| of(&own.degrees, &reference.degrees))
        };
        let metrics = Table::metrics([
            ("slope_mean", Unit::Degree, own.mean),
            ("slope_median", Unit::Degree, own.degrees.quantile(0.5)),
            ("slope_p95", Unit::Degree, own.degrees.quantile(0.95)),
            ("slope_w1", Unit::Degree, distance(Distribution::wasserstein)),
            ("slope_js", Unit::One, distance(Distribution::jensen_shannon)),
        ])?;
        let percent = |slopes: Option<&Slopes>| {
            let share = |class: usize| slopes.map_or(f64::NAN, |slopes| 100.0 * slopes.degrees.shares[class]);
            Cells::Numbers((0..CLASSES).map(share).collect())
        };
        let middles = Cells::Numbers((0..CLASSES).map(|class| own.degrees.middle(class)).collect());
        let histogram = Table::new(vec![
            Column { name: "slope".into(), unit: Unit::Degree, cells: middles },
            Column { name: "share".into(), unit: Unit::Percent, cells: percent(Some(&own)) },
            Column {
                name: "reference_share".into(),
                unit: Unit::Percent,
                cells: percent(reference.as_ref()),
            },
        ])?;
        Ok(SlopeDistributionOut { metrics, histogram })
    }
}

/// One class a degree.
const CLASSES: usize = 90;

/// How steep a terrain is.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Mean slope in degrees; NaN for a terrain of voids.
    pub mean: f64,
    /// Classes of one degree from 0° to 90°.
    pub degrees: Distribution,
}

impl Slopes {
    /// The slopes of every cell that is no void.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, job: &Job) -> Result<Self> {
        let rows = per_row(terrain.rows(), job, |row| {
            let (mut sum, mut counts) = (0.0, [0u32; CLASSES]);
            surface::gradients(terrain, row, |_, east, north| {
                for (&east, &north) in east.iter().zip(north).filter(|(east, _)| !east.is_nan()) {
                    let degrees = surface::slope_degrees(DVec2::new(east, north));
                    sum += degrees;
                    counts[(degrees as usize).min(CLASSES - 1)] += 1;
                }
            });
            Ok((sum, counts))
        })?;
        let (mut sum, mut counts) = (0.0, [0u64; CLASSES]);
        for (of_row, counts_of_row) in rows {
            sum += of_row;
            counts.iter_mut().zip(counts_of_row).for_each(|(all, own)| *all += u64::from(own));
        }
        let degrees = Distribution::of_counts(0.0, 1.0, &counts);
        let mean = if degrees.count == 0 { f64::NAN } else { sum / degrees.count as f64 };
        Ok(Self { mean, degrees })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};

    fn plane(degrees: f64) -> Heightfield {
        field(12, 15, |_, col| col as f64 * 10.0 * libm::tan(degrees.to_radians()))
    }

    fn run(terrain: &Heightfield, reference: Option<&Heightfield>) -> SlopeDistributionOut {
        SlopeDistribution::default()
            .run(SlopeDistributionIn { terrain, reference }, &Job::detached())
            .unwrap()
    }

    #[test]
    fn two_planes_lie_their_angle_apart() {
        let (gentle, steep) = (plane(10.5), plane(33.5));
        let metrics = run(&gentle, Some(&steep)).metrics;
        assert!((metrics.metric("slope_mean").unwrap() - 10.5).abs() < 1e-4);
        assert!((metrics.metric("slope_w1").unwrap() - 23.0).abs() < 1e-9);
        assert!((metrics.metric("slope_js").unwrap() - 1.0).abs() < 1e-9);
        let same = run(&steep, Some(&steep)).metrics;
        assert_eq!((same.metric("slope_w1"), same.metric("slope_js")), (Some(0.0), Some(0.0)));
    }

    #[test]
    fn shares_sum_to_the_whole_and_voids_have_none() {
        let hills = field(20, 30, |row, col| 40.0 * libm::sin(row as f64) * libm::cos(col as f64 / 3.0));
        let table = run(&hills, None).histogram;
        let Cells::Numbers(shares) = &table.column("share").unwrap().cells else { panic!() };
        assert!((shares.iter().sum::<f64>() - 100.0).abs() < 1e-9);
        let voids = run(&row(&[f32::NAN; 4]), Some(&hills)).metrics;
        assert!(voids.metric("slope_mean").unwrap().is_nan() && voids.metric("slope_w1").unwrap().is_nan());
    }
}
