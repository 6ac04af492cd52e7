//! To constraints: wanted heights along ridges or valleys.
//!
//! Heights come from the network's own points, straight along each line, or from a picture: Zhou 2007 names a sketch
//! whose grey says how high a line is as future work.

use orograph_core::{Curve, prelude::*};

use crate::{
    mcmd::raster_line::line,
    transform::sample::{Interpolation, sample},
};

/// Turns the lines of a network into wanted heights, for `adjust.elevation_constraints` or `mcmd.mcmd`.
///
/// Without `heights` they run evenly along each line between the heights of its two points. Where lines share a cell,
/// the last one counts.
#[derive(Params, Clone, Debug)]
pub struct ToConstraints {
    /// What each height becomes: from grey levels to metres, or metres moved up or down.
    #[param(default = [[-20_000.0, -20_000.0], [20_000.0, 20_000.0]], range = -20_000.0..=20_000.0, slider = -20_000.0..=20_000.0)]
    pub mapping: Curve,
}

/// Inputs of [`ToConstraints`].
#[derive(Inputs)]
pub struct ToConstraintsIn<'a> {
    /// Ridges or valleys.
    pub features: &'a Features,
    /// Heights or grey levels to read along the lines; laid over the network's grid whatever its own size is.
    pub heights: Option<&'a Heightfield>,
}

/// Outputs of [`ToConstraints`].
#[derive(Outputs)]
pub struct ToConstraintsOut {
    /// Wanted heights along the lines; all other cells are voids.
    pub constraints: Heightfield,
}

impl Node for ToConstraints {
    const ID: &'static str = "feature.to_constraints";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ToConstraintsIn<'a>;
    type Outputs = ToConstraintsOut;

    fn run(&self, inputs: ToConstraintsIn<'_>, job: &Job) -> Result<ToConstraintsOut> {
        let ToConstraintsIn { features, heights } = inputs;
        let size = features.grid.size();
        let mut constraints = Heightfield::filled(features.grid.clone(), f32::NAN, job)?;
        let read = |row: usize, col: usize| {
            heights.map(|heights| {
                let over = |at: usize, n: usize, all: usize| (at as f64 + 0.5) * n as f64 / all as f64 - 0.5;
                let (row, col) = (over(row, heights.rows(), size.0), over(col, heights.cols(), size.1));
                sample(heights, row, col, Interpolation::Bilinear)
            })
        };
        for drawn in &features.lines {
            job.check()?;
            let end = |point: u32| features.points.get(point as usize).map_or(f32::NAN, |point| point.height);
            let (from, to) = (f64::from(end(drawn.from)), f64::from(end(drawn.to)));
            let apart = |pair: &[[f64; 2]]| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let whole: f64 = drawn.vertices.windows(2).map(apart).sum();
            let mut gone = 0.0;
            for pair in drawn.vertices.windows(2) {
                let step = apart(pair);
                let place = |[row, col]: [f64; 2]| (row.round() as i64, col.round() as i64);
                line(place(pair[0]), place(pair[1]), size, |row, col, share| {
                    let along = if whole > 0.0 { (gone + share * step) / whole } else { 0.0 };
                    let height = read(row, col).map_or(from + (to - from) * along, f64::from);
                    if height.is_finite() {
                        constraints.cells_mut()[row * size.1 + col] = self.mapping.at(height) as f32;
                    }
                });
                gone += step;
            }
        }
        Ok(ToConstraintsOut { constraints })
    }
}

#[cfg(test)]
mod tests {
    use orograph_core::{FeaturePoint, PointKind, Polyline};

    use super::*;
    use crate::test_fields::field;

    /// A line from (1, 1) over (1, 5) to (5, 5), from 100 m to 180 m.
    fn bent() -> Features {
        let point = |row, col, height| FeaturePoint { row, col, height, kind: PointKind::End };
        let vertices = vec![[1.0, 1.0], [1.0, 5.0], [5.0, 5.0]];
        Features {
            grid: field(8, 9, |_, _| 0.0).grid().clone(),
            kind: FeatureKind::Ridge,
            points: vec![point(1.0, 1.0, 100.0), point(5.0, 5.0, 180.0)],
            lines: vec![Polyline { from: 0, to: 1, vertices, profiles: Vec::new() }],
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 1.0,
        }
    }

    fn run(node: &ToConstraints, heights: Option<&Heightfield>) -> Heightfield {
        let features = bent();
        node.run(ToConstraintsIn { features: &features, heights }, &Job::detached()).unwrap().constraints
    }

    #[test]
    fn heights_run_evenly_along_a_line() {
        let out = run(&ToConstraints::default(), None);
        for k in 0..=8 {
            let (row, col) = if k < 4 { (1, 1 + k) } else { (k - 3, 5) };
            assert!((out.at(row, col) - (100.0 + 10.0 * k as f32)).abs() < 1e-4);
        }
        assert_eq!(out.void_count(), 8 * 9 - 9);
    }

    #[test]
    fn grey_levels_become_metres() {
        // Half as fine as the network's grid, grey rising to the east; black to white are 1000 m to 3000 m.
        let grey = field(4, 9, |_, col| if col == 3 { f64::NAN } else { col as f64 / 8.0 });
        let node = ToConstraints { mapping: [[0.0, 1000.0], [1.0, 3000.0]].into() };
        let out = run(&node, Some(&grey));
        assert_eq!((out.at(1, 1), out.at(1, 5), out.at(4, 5)), (1250.0, 2250.0, 2250.0));
        // Where the picture has nothing, nothing is wanted.
        assert!(out.at(1, 3).is_nan());
    }
}
