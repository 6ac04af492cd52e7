//! Statistics: the size of a terrain and the distribution of its heights.

use orograph_core::{Unit, prelude::*};

use super::sums::Moments;

/// Measures a terrain's size, voids and heights.
///
/// Voids and infinite heights count as voids; without any height the height metrics are NaN.
#[derive(Params, Clone, Debug)]
pub struct Statistics {}

/// Inputs of [`Statistics`].
#[derive(Inputs)]
pub struct StatisticsIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Statistics`].
#[derive(Outputs)]
pub struct StatisticsOut {
    /// One row of metrics.
    pub metrics: Table,
}

impl Node for Statistics {
    const ID: &'static str = "measure.statistics";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = StatisticsIn<'a>;
    type Outputs = StatisticsOut;

    fn run(&self, inputs: StatisticsIn<'_>, job: &Job) -> Result<StatisticsOut> {
        let terrain = inputs.terrain;
        let grid = terrain.grid();
        let heights = |row: usize| terrain.row(row).iter().filter(|height| height.is_finite());
        let moments = Moments::of(grid.rows, job, |row, hear| {
            heights(row).for_each(|&height| hear(f64::from(height)));
        })?;
        job.admit(grid.len() as u64 * 4, || "the sorted heights".into())?;
        let mut sorted: Vec<f32> = (0..grid.rows).flat_map(heights).copied().collect();
        let (low, median, high) = middle(&mut sorted);
        let voids = grid.len() - moments.count;
        let metrics = [
            ("rows", Unit::Cell, grid.rows as f64),
            ("cols", Unit::Cell, grid.cols as f64),
            ("cell_x", Unit::Metre, grid.cell.x),
            ("cell_y", Unit::Metre, grid.cell.y),
            ("voids", Unit::Cell, voids as f64),
            ("void_share", Unit::Percent, 100.0 * voids as f64 / grid.len() as f64),
            ("lowest", Unit::Metre, low),
            ("highest", Unit::Metre, high),
            ("relief", Unit::Metre, high - low),
            ("mean", Unit::Metre, moments.mean),
            ("median", Unit::Metre, median),
            ("deviation", Unit::Metre, moments.deviation),
        ];
        Ok(StatisticsOut { metrics: Table::metrics(metrics)? })
    }
}

/// Lowest, middle and highest height; the lower of two middles. NaN without heights.
fn middle(heights: &mut [f32]) -> (f64, f64, f64) {
    if heights.is_empty() {
        return (f64::NAN, f64::NAN, f64::NAN);
    }
    let low = heights.iter().fold(f32::INFINITY, |low, &height| low.min(height));
    let high = heights.iter().fold(f32::NEG_INFINITY, |high, &height| high.max(height));
    let at = (heights.len() - 1) / 2;
    let (_, &mut median, _) = heights.select_nth_unstable_by(at, f32::total_cmp);
    (f64::from(low), f64::from(median), f64::from(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn voids_are_left_out() {
        let terrain = row(&[4.0, f32::NAN, 1.0, 3.0, f32::INFINITY, 8.0]);
        let node = Statistics::default();
        let metrics = node.run(StatisticsIn { terrain: &terrain }, &Job::detached()).unwrap().metrics;
        let metric = |name| metrics.metric(name).unwrap();
        assert_eq!([metric("lowest"), metric("highest"), metric("relief")], [1.0, 8.0, 7.0]);
        assert_eq!([metric("mean"), metric("median"), metric("voids")], [4.0, 3.0, 2.0]);
        assert!((metric("deviation") - 6.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!((metric("rows"), metric("cols"), metric("cell_x")), (1.0, 6.0, 10.0));
    }

    #[test]
    fn without_heights_there_are_no_height_metrics() {
        for heights in [&[][..], &[f32::NAN; 2]] {
            let out = Statistics::default().run(StatisticsIn { terrain: &row(heights) }, &Job::detached());
            let metrics = out.unwrap().metrics;
            assert!(metrics.metric("mean").unwrap().is_nan() && metrics.metric("median").unwrap().is_nan());
        }
    }
}
