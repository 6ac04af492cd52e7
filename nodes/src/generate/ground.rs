//! Where a generator is sampled.
//!
//! A generator is a function of world position alone. Its grid therefore only says where that function is
//! sampled: the same ground in fewer cells looks the same, and a crop of the grid gives a crop of the
//! terrain, to the bit.

use glam::DVec2;
use orograph_core::{Wire, prelude::*};

use crate::Ground;

/// Inputs of a generator.
#[derive(Inputs)]
pub struct GroundIn<'a> {
    /// Terrain whose grid to use: its cells, place and georeference; its heights do not count.
    /// Unconnected, the settings say how much ground to cover.
    pub like: Option<&'a Heightfield>,
}

/// Outputs of a generator.
#[derive(Outputs)]
pub struct GroundOut {
    /// The terrain made, without voids.
    pub terrain: Heightfield,
}

/// The grid of `like`, or one over `ground` whose north-west corner is the world's origin and whose cells are as
/// nearly square as whole cells allow.
fn grid_of(ground: &Ground, like: Option<&Heightfield>, job: &Job) -> Result<Grid> {
    if let Some(like) = like {
        return Ok(like.grid().clone());
    }
    let (n, extent) = ground.longer_side(job);
    let side = extent / f64::from(n);
    let count = |extent: f64| ((extent / side).round() as usize).max(1);
    let (rows, cols) = (count(ground.height), count(ground.width));
    let cell = CellSize { x: ground.width / cols as f64, y: ground.height / rows as f64 };
    let mut grid = Grid::new(rows, cols, cell)?;
    grid.origin = DVec2::new(cell.x, -cell.y) / 2.0;
    Ok(grid)
}

/// A generator as bands of the ground that its settings name.
pub(crate) fn bands<N>(node: &N, ground: &Ground, job: &Job) -> Result<Option<Box<dyn BandSource>>>
where
    N: Clone + for<'a> Node<Inputs<'a> = GroundIn<'a>, Outputs = GroundOut>,
{
    Ok(Some(Box::new(Generated { node: node.clone(), grid: grid_of(ground, None, job)? })))
}

/// A generator on a grid.
struct Generated<N> {
    node: N,
    grid: Grid,
}

impl<N: for<'a> Node<Inputs<'a> = GroundIn<'a>, Outputs = GroundOut>> BandSource for Generated<N> {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn band(&self, first: usize, rows: usize, job: &Job) -> Result<Value> {
        let like = Heightfield::filled(self.grid.crop(first, 0, rows, self.grid.cols)?, 0.0, job)?;
        Ok(self.node.run(GroundIn { like: Some(&like) }, job)?.terrain.into_value())
    }
}

/// The terrain of the given heights: `fill` gets the world x of the columns, the world y of the row, and the row
/// to write.
pub(crate) fn sample_rows(
    ground: &Ground,
    inputs: &GroundIn<'_>,
    job: &Job,
    fill: impl Fn(&[f64], f64, &mut [f32]) + Sync,
) -> Result<GroundOut> {
    let grid = grid_of(ground, inputs.like, job)?;
    let (place, n_cols) = (grid.clone(), if grid.is_empty() { 0 } else { grid.cols });
    job.admit((n_cols as u64).saturating_mul(8), || "the columns' positions".into())?;
    let x: Vec<f64> = (0..n_cols).map(|col| place.position(0, col).x).collect();
    let terrain = Heightfield::build(grid, job, |row, out| {
        fill(&x, place.position(row, 0).y, out);
        Ok(())
    })?;
    Ok(GroundOut { terrain })
}

/// The terrain whose height at world position (x, y) is `height(x, y)`, in metres.
pub(crate) fn sample_cells(
    ground: &Ground,
    inputs: &GroundIn<'_>,
    job: &Job,
    height: impl Fn(f64, f64) -> f64 + Sync,
) -> Result<GroundOut> {
    sample_rows(ground, inputs, job, |x, y, out| {
        for (out, &x) in out.iter_mut().zip(x) {
            *out = height(x, y) as f32;
        }
    })
}

#[cfg(test)]
mod tests {
    use orograph_core::{Context, DetachedHost};

    use super::*;

    #[test]
    fn the_run_s_resolution_counts_along_the_longer_side() {
        let ground = Ground { width: 1000.0, height: 2000.0, cells: 10 };
        let none = GroundIn { like: None };
        let at = |resolution| Job::new(&DetachedHost, Context { seed: 0, resolution });
        let grid = |job: &Job| sample_cells(&ground, &none, job, |x, _| x).unwrap().terrain.grid().clone();
        assert_eq!(grid(&at(None)).size(), (10, 5));
        let fine = grid(&at(Some(100)));
        assert_eq!((fine.size(), fine.cell), ((100, 50), CellSize::square(20.0)));
        assert_eq!(fine.position(0, 0), DVec2::new(10.0, -10.0));
    }

    #[test]
    fn odd_ground_is_covered_exactly() {
        let ground = Ground { width: 10.0, height: 3.3, cells: 4 };
        let grid = grid_of(&ground, None, &Job::detached()).unwrap();
        assert_eq!(grid.size(), (1, 4));
        assert_eq!(grid.cell, CellSize { x: 2.5, y: 3.3 });
    }
}
