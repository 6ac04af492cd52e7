//! Poisson seam: two surfaces joined along a seam without a step.

use orograph_core::prelude::*;

use super::poisson::seam::{Composite, SeamGradient, correction};

/// Joins two terrains along a seam and spreads the step there over the ground that both know.
///
/// Cells that only one of them knows keep their heights to the bit.
#[derive(Params, Clone, Debug)]
pub struct PoissonSeam {
    /// The step that is wanted across the seam.
    #[param(default = SeamGradient::Average)]
    pub gradient: SeamGradient,
    /// Cells beyond the overlap that may move too.
    #[param(default = 0u32, range = 0..=256, slider = 0..=40, unit = "cells")]
    pub spread: u32,
}

/// Inputs of [`PoissonSeam`].
#[derive(Inputs)]
pub struct PoissonSeamIn<'a> {
    /// Terrain that is there.
    pub old: &'a Heightfield,
    /// Terrain laid over it, on the same grid.
    pub new: &'a Heightfield,
    /// Where the new terrain is taken, where at least one half, such as `synthesis.graph_cut` tells.
    pub labels: &'a Mask,
}

/// Outputs of [`PoissonSeam`].
#[derive(Outputs)]
pub struct PoissonSeamOut {
    /// The joined terrain.
    pub terrain: Heightfield,
}

impl Node for PoissonSeam {
    const ID: &'static str = "synthesis.poisson_seam";
    const VERSION: u32 = 2; // 2 solves by another multigrid
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PoissonSeamIn<'a>;
    type Outputs = PoissonSeamOut;

    fn cost(&self) -> f64 {
        100.0
    }

    fn run(&self, inputs: PoissonSeamIn<'_>, job: &Job) -> Result<PoissonSeamOut> {
        let PoissonSeamIn { old, new, labels } = inputs;
        old.grid().match_size("old", new.grid(), "new")?;
        old.grid().match_size("old", labels.grid(), "labels")?;
        job.admit(old.cells().len() as u64 * 16, || "the joined terrain".into())?;
        let is_new: Vec<bool> = labels.cells().iter().map(|&label| label >= 0.5).collect();
        let composite = Composite { cols: old.cols(), old: old.cells(), new: new.cells(), is_new: &is_new };
        let added = correction(&composite, self.gradient, self.spread as usize, job)?;
        let height = |(i, added): (usize, f64)| {
            let height = composite.height(i);
            if added == 0.0 { height } else { (f64::from(height) + added) as f32 }
        };
        let cells = added.into_iter().enumerate().map(height).collect();
        Ok(PoissonSeamOut { terrain: Heightfield::new(old.grid().clone(), cells)? })
    }
}
