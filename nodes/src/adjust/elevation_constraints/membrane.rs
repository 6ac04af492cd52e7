//! A change that is as even as heights wanted at some cells allow: Laplace's equation between them.

use orograph_core::prelude::*;

use super::Site;
use crate::{
    mask::distance::distances,
    synthesis::poisson::masked::{Cell, Domain, solve, solve_held},
};

/// The ground that a change may reach.
pub(super) struct Ground {
    cols: usize,
    cells: Vec<Cell>,
    weights: [f64; 2],
}

impl Ground {
    /// All of the terrain but its voids; cells further than `reach` metres from every site stay, unless it is 0.
    pub(super) fn new(terrain: &Heightfield, sites: &[Site], reach: f64, job: &Job<'_>) -> Result<Self> {
        let grid = terrain.grid();
        job.admit(grid.len() as u64 * 9, || format!("the kinds of {} cells", grid.len()))?;
        let kind = |height: &f32| if height.is_finite() { Cell::Free } else { Cell::Outside };
        let mut cells: Vec<Cell> = terrain.cells().iter().map(kind).collect();
        if reach > 0.0 {
            let mut at = Mask::filled(grid.clone(), 0.0, job)?;
            sites.iter().for_each(|site| at.cells_mut()[site.cell] = 1.0);
            let away = distances(&at, |share| share > 0.5, job)?;
            for (cell, &away) in cells.iter_mut().zip(away.cells()) {
                if *cell == Cell::Free && f64::from(away) > reach {
                    *cell = Cell::Fixed;
                }
            }
        }
        let least = grid.cell.x.min(grid.cell.y);
        let weight = |side: f64| (least / side) * (least / side);
        Ok(Self { cols: grid.cols, cells, weights: [weight(grid.cell.x), weight(grid.cell.y)] })
    }

    /// The change that meets every site and has no extremum elsewhere.
    pub(super) fn exact(&self, sites: &[Site], job: &Job<'_>) -> Result<Vec<f64>> {
        let n = self.cells.len();
        let mut cells = self.cells.clone();
        let mut given = vec![0.0; n];
        for site in sites {
            cells[site.cell] = Cell::Fixed;
            given[site.cell] = site.change;
        }
        let mut right = vec![0.0; n];
        for site in sites {
            for (other, weight) in self.near(site.cell) {
                right[other] += weight * site.change;
            }
        }
        let domain = Domain { cols: self.cols, cells: &cells, weights: self.weights };
        let mut change = solve(&domain, &right, job)?;
        change.iter_mut().zip(given).for_each(|(change, given)| *change += given);
        Ok(change)
    }

    /// The change `u` of least `sum of (u_q - u_p)² + weight · sum over sites of (u - wanted)² + tie · sum of u²`.
    pub(super) fn weighted(&self, sites: &[Site], weight: f64, tie: f64, job: &Job<'_>) -> Result<Vec<f64>> {
        let n = self.cells.len();
        // Solved for the way back from the exact change, so that a great weight leaves little to solve for.
        let mut change = self.exact(sites, job)?;
        let mut holds = vec![tie; n];
        sites.iter().for_each(|site| holds[site.cell] += weight);
        let mut right = vec![0.0; n];
        for (i, right) in right.iter_mut().enumerate().filter(|(i, _)| self.cells[*i] == Cell::Free) {
            let flow: f64 = self.near(i).map(|(other, weight)| weight * (change[other] - change[i])).sum();
            *right = flow - tie * change[i];
        }
        let domain = Domain { cols: self.cols, cells: &self.cells, weights: self.weights };
        let back = solve_held(&domain, &holds, &right, job)?;
        change.iter_mut().zip(back).for_each(|(change, back)| *change += back);
        Ok(change)
    }

    /// The neighbours of a cell that are part of the ground, and the weights of the steps to them.
    fn near(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let col = i % self.cols;
        let [across, down] = self.weights;
        let near = [
            (col > 0).then(|| (i - 1, across)),
            (i >= self.cols).then(|| (i - self.cols, down)),
            (col + 1 < self.cols).then_some((i + 1, across)),
            (i + self.cols < self.cells.len()).then_some((i + self.cols, down)),
        ];
        near.into_iter().flatten().filter(|&(other, _)| self.cells[other] != Cell::Outside)
    }
}
