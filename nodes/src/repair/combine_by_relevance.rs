//! Relevance: patches of several directions as one, each counting by its nearness to known ground.
//!
//! Wecker, Samavati and Gavrilova (2007): weights are the inverse distances, made to sum to one.

use orograph_core::prelude::*;

use super::{harmonic_fill::harmonic_fill, voids::fill_by_cell};

/// Joins patches of the same voids, such as those of `repair.curve_patch`: what lies nearer to known ground counts more.
///
/// A patch counts where both its height and its distance are known. Voids that no patch reaches are filled smoothly from
/// around.
#[derive(Params, Clone, Debug)]
pub struct CombineByRelevance {}

/// Inputs of [`CombineByRelevance`].
#[derive(Inputs)]
pub struct CombineByRelevanceIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
    /// Patched terrains.
    pub patches: Vec<&'a Heightfield>,
    /// Distance of each patch from known ground, in the same order.
    pub distances: Vec<&'a Heightfield>,
}

/// Outputs of [`CombineByRelevance`].
#[derive(Outputs)]
pub struct CombineByRelevanceOut {
    /// Terrain with its voids filled.
    pub terrain: Heightfield,
}

impl Node for CombineByRelevance {
    const ID: &'static str = "repair.combine_by_relevance";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CombineByRelevanceIn<'a>;
    type Outputs = CombineByRelevanceOut;

    fn run(&self, inputs: CombineByRelevanceIn<'_>, job: &Job) -> Result<CombineByRelevanceOut> {
        let CombineByRelevanceIn { terrain, patches, distances } = inputs;
        if patches.len() != distances.len() {
            return Err(Error::invalid(
                format!("{} patches, but {} distances", patches.len(), distances.len()),
                "connect both outputs of each repair.curve_patch, in the same order",
            ));
        }
        for (name, raster) in
            patches.iter().map(|p| ("patches", p)).chain(distances.iter().map(|d| ("distances", d)))
        {
            terrain.grid().match_size("terrain", raster.grid(), name)?;
        }
        let combined = fill_by_cell(terrain, job, |row, col| {
            let at = |i: usize| (f64::from(patches[i].at(row, col)), f64::from(distances[i].at(row, col)));
            relevant((0..patches.len()).map(at)) as f32
        })?;
        Ok(CombineByRelevanceOut { terrain: close(combined, job)? })
    }
}

/// The mean of heights, weighed by inverse distances; NaN where there are none.
pub(super) fn relevant(of: impl Iterator<Item = (f64, f64)>) -> f64 {
    let known = of.filter(|(height, distance)| !height.is_nan() && *distance > 0.0);
    let (sum, weights) = known.fold((0.0, 0.0), |(sum, weights), (height, distance)| {
        (sum + height / distance, weights + 1.0 / distance)
    });
    sum / weights
}

/// Fills smoothly what no curve reached.
pub(super) fn close(terrain: Heightfield, job: &Job<'_>) -> Result<Heightfield> {
    let left = terrain.void_count();
    if left == 0 {
        return Ok(terrain);
    }
    job.warn(format!("{left} voids that no curve reached are filled smoothly"));
    harmonic_fill(&terrain, None, job)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn weights_are_those_of_the_papers_example() {
        let weight = |which: usize| {
            relevant(
                [1.0, 2.0, 4.0, 4.0]
                    .into_iter()
                    .enumerate()
                    .map(|(i, d)| (f64::from(u8::from(i == which)), d)),
            )
        };
        assert_eq!([0, 1, 2, 3].map(weight), [0.5, 0.25, 0.125, 0.125]);
    }

    #[test]
    fn patches_count_where_they_are_known_and_gaps_are_closed() {
        let n = f32::NAN;
        let terrain = row(&[0.0, n, n, n, n, 8.0]);
        let (a, b) = (row(&[0.0, 4.0, 2.0, n, n, 8.0]), row(&[0.0, 8.0, n, n, n, 8.0]));
        let (da, db) = (row(&[0.0, 10.0, 20.0, n, n, 0.0]), row(&[0.0, 30.0, 20.0, n, n, 0.0]));
        let run = |distances| {
            let inputs = CombineByRelevanceIn { terrain: &terrain, patches: vec![&a, &b], distances };
            CombineByRelevance {}.run(inputs, &Job::detached())
        };
        let out = run(vec![&da, &db]).unwrap().terrain;
        let expected = [0.0, 5.0, 2.0, 4.0, 6.0, 8.0];
        assert!(out.cells().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{:?}", out.cells());
        assert!(run(vec![&da]).is_err());
    }
}
