//! Curve patch: voids bridged along one direction.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    curves::{CurveDetails, Curves, Direction, Filled},
    voids,
};
use crate::filter::chaikin::Boundary;

/// Bridges voids by smooth curves along rows, columns or a diagonal, with or without details of the ground beside.
///
/// Runs of voids that reach the border stay void. Join the patches of all four directions with
/// `repair.combine_by_relevance`.
#[derive(Params, Clone, Debug)]
pub struct CurvePatch {
    /// The direction of the curves.
    #[param(default = Direction::U)]
    pub direction: Direction,
    /// How often curves are halved to take details from the ground on both sides; 0 leaves them smooth.
    #[param(default = 0u32, range = 0..=6, unit = "1")]
    pub levels: u32,
    /// How the ends of curves are treated when they are halved.
    #[param(default = Boundary::Natural)]
    pub boundary: Boundary,
}

/// Inputs of [`CurvePatch`].
#[derive(Inputs)]
pub struct CurvePatchIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`CurvePatch`].
#[derive(Outputs)]
pub struct CurvePatchOut {
    /// Terrain whose voids are bridged.
    pub terrain: Heightfield,
    /// Distance along the curve from each filled cell to the nearer end of its bridge; 0 at known cells, void where nothing
    /// was filled.
    pub distance: Heightfield,
}

impl Node for CurvePatch {
    const ID: &'static str = "repair.curve_patch";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CurvePatchIn<'a>;
    type Outputs = CurvePatchOut;

    fn run(&self, inputs: CurvePatchIn<'_>, job: &Job) -> Result<CurvePatchOut> {
        let details = (self.levels > 0).then_some(CurveDetails {
            levels: self.levels,
            boundary: self.boundary,
            gain: 1.0,
        });
        let filled = bridge(inputs.terrain, self.direction, details, job)?;
        let mut terrain = inputs.terrain.map(job, |height| height)?;
        let mut distance: Heightfield =
            inputs.terrain.map(job, |height| if height.is_nan() { f32::NAN } else { 0.0 })?;
        for Filled { cell, height, distance: from } in filled {
            terrain.cells_mut()[cell] = height as f32;
            distance.cells_mut()[cell] = from as f32;
        }
        Ok(CurvePatchOut { terrain, distance })
    }
}

/// Bridges all voids of a terrain along one direction.
///
/// # Errors
/// Those of the search for voids.
pub fn bridge(
    terrain: &Heightfield,
    direction: Direction,
    details: Option<CurveDetails>,
    job: &Job<'_>,
) -> Result<Vec<Filled>> {
    let curves = Curves::new(terrain, direction);
    let voids = voids::find(terrain.grid().size(), 0, |i| terrain.cells()[i].is_nan(), job)?;
    let done = job.stage(voids.len() as u64);
    let filled: Vec<Vec<Filled>> = voids
        .par_iter()
        .map(|void| {
            job.check()?;
            let filled = curves.bridge(&void.cells, details);
            done.advance(1);
            Ok(filled)
        })
        .collect::<Result<_>>()?;
    Ok(filled.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn known_cells_stay_and_bridges_have_distances() {
        let hole =
            |row: usize, col: usize| (3..6).contains(&row) && (2..9).contains(&col) || row == 0 && col > 7;
        let terrain = field(9, 12, |row, col| if hole(row, col) { f64::NAN } else { (row * col) as f64 });
        let run = |direction| {
            let node = CurvePatch { direction, ..CurvePatch::default() };
            node.run(CurvePatchIn { terrain: &terrain }, &Job::detached()).unwrap()
        };
        let out = run(Direction::U);
        assert_eq!(out.terrain.void_count(), 4);
        assert_eq!(out.distance.row(4)[..10], [0.0, 0.0, 10.0, 20.0, 30.0, 40.0, 30.0, 20.0, 10.0, 0.0]);
        assert!(out.distance.at(0, 9).is_nan());
        let out = run(Direction::V);
        assert_eq!(out.distance.at(4, 5), 20.0);
        for (out, &height) in out.terrain.cells().iter().zip(terrain.cells()) {
            assert!(height.is_nan() || out.to_bits() == height.to_bits());
        }
    }
}
