//! Histogram: how a terrain's heights are distributed.

use glam::DVec2;
use orograph_core::prelude::*;

use super::chart::{Axis, Chart, Series, Style};
use crate::measure::append::split_list;

/// Plots the share of cells at each height, for one terrain or several.
///
/// Voids are left out; shares are of the known cells of each terrain. The plot has no place in the world.
#[derive(Params, Clone, Debug)]
pub struct Histogram {
    /// Number of classes between the lowest and the highest height of all terrains.
    #[param(default = 100u32, range = 2..=4096, slider = 10..=400, unit = "1")]
    pub classes: u32,
    /// Names of the terrains, in order, separated by `;` or line ends.
    #[param(default = "")]
    pub labels: String,
    /// Heading of the plot; none when empty.
    #[param(default = "")]
    pub title: String,
    /// Width of the plot.
    #[param(default = 720u32, range = 64..=8192, slider = 320..=1920, unit = "px")]
    pub width: u32,
    /// Height of the plot.
    #[param(default = 420u32, range = 64..=8192, slider = 240..=1080, unit = "px")]
    pub height: u32,
}

/// Inputs of [`Histogram`].
#[derive(Inputs)]
pub struct HistogramIn<'a> {
    /// Terrains to compare.
    pub terrains: Vec<&'a Heightfield>,
}

/// Outputs of [`Histogram`].
#[derive(Outputs)]
pub struct HistogramOut {
    /// The plot.
    pub picture: Texture,
}

impl Node for Histogram {
    const ID: &'static str = "look.histogram";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = HistogramIn<'a>;
    type Outputs = HistogramOut;

    fn run(&self, inputs: HistogramIn<'_>, job: &Job) -> Result<HistogramOut> {
        let finite = |terrain: &Heightfield| {
            terrain.range().map(|(low, high)| (low.max(f32::MIN), high.min(f32::MAX)))
        };
        let ranges = inputs.terrains.iter().filter_map(|terrain| finite(terrain));
        let (low, high) = ranges
            .reduce(|all, own| (all.0.min(own.0), all.1.max(own.1)))
            .ok_or_else(|| Error::AllVoid { what: "terrains".into() })?;
        let (low, high) = (f64::from(low), f64::from(high));
        // One height alone still gets a class that it lies in.
        let step = ((high - low) / f64::from(self.classes)).max(f64::from(f32::EPSILON) * low.abs().max(1.0));
        let labels = split_list(&self.labels);
        let style = if inputs.terrains.len() <= 2 { Style::Area } else { Style::Line };
        let mut series = Vec::new();
        for (i, terrain) in inputs.terrains.iter().enumerate() {
            let shares = shares(terrain, low, step, self.classes as usize, job)?;
            let name = labels.get(i).map_or_else(String::new, |label| (*label).to_owned());
            series.push(Series { name, style, points: steps(&shares, low, step) });
        }
        let chart = Chart {
            title: self.title.clone(),
            x: Axis { label: "height (m)".into(), tight: true, ..Axis::default() },
            y: Axis { label: "share of cells (%)".into(), from_zero: true, ..Axis::default() },
            series,
            width: self.width,
            height: self.height,
        };
        Ok(HistogramOut { picture: chart.draw(job)? })
    }
}

/// Percent of the known cells in each class of `step` metres from `low` on.
fn shares(terrain: &Heightfield, low: f64, step: f64, classes: usize, job: &Job) -> Result<Vec<f64>> {
    let mut counts = vec![0u64; classes];
    for row in 0..terrain.rows() {
        job.check()?;
        for &height in terrain.row(row).iter().filter(|height| height.is_finite()) {
            let class = ((f64::from(height) - low) / step) as usize;
            counts[class.min(classes - 1)] += 1;
        }
    }
    let all: u64 = counts.iter().sum();
    Ok(counts.into_iter().map(|count| 100.0 * count as f64 / all.max(1) as f64).collect())
}

/// The outline of a staircase.
fn steps(shares: &[f64], low: f64, step: f64) -> Vec<DVec2> {
    let ends = |(i, &share): (usize, &f64)| {
        let edge = |i: usize| DVec2::new(low + i as f64 * step, share);
        [edge(i), edge(i + 1)]
    };
    shares.iter().enumerate().flat_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn shares_count_known_cells() {
        let terrain = row(&[0.0, 1.0, 1.5, 4.0, f32::NAN]);
        let shares = shares(&terrain, 0.0, 1.0, 4, &Job::detached()).unwrap();
        assert_eq!(shares, [25.0, 50.0, 0.0, 25.0]);
        assert_eq!(steps(&shares, 0.0, 1.0)[1..3], [DVec2::new(1.0, 25.0), DVec2::new(1.0, 50.0)]);
    }

    #[test]
    fn odd_terrains_are_drawn_or_refused() {
        let run = |heights: &[f32]| {
            let terrain = row(heights);
            Histogram::default().run(HistogramIn { terrains: vec![&terrain] }, &Job::detached()).map(|_| ())
        };
        for heights in [&[3.0; 4][..], &[f32::MIN, f32::MAX], &[f32::INFINITY, 0.0], &[8848.0]] {
            assert_eq!(run(heights), Ok(()));
        }
        assert!(matches!(run(&[f32::NAN]), Err(Error::AllVoid { .. })));
    }
}
