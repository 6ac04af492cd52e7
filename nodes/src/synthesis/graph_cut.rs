//! Graph cut: where to change from one surface to another with the least mismatch.

use orograph_core::Unit;
use orograph_core::prelude::*;

use super::cut::{Keep, Overlay, SeamWeight, seam};

/// Finds the seam between two overlapping terrains along which they differ least.
///
/// A cell that only one of them knows is its own; where both are known, cells beside ground that only one knows are held
/// on its side. Without any such cell, and without masks, all is the new terrain's.
#[derive(Params, Clone, Debug)]
pub struct GraphCut {
    /// How the mismatch along the seam is weighed.
    #[param(default = SeamWeight::Plain)]
    pub weight: SeamWeight,
}

/// Inputs of [`GraphCut`].
#[derive(Inputs)]
pub struct GraphCutIn<'a> {
    /// Terrain that is there.
    pub old: &'a Heightfield,
    /// Terrain to lay over it, on the same grid.
    pub new: &'a Heightfield,
    /// Cells that must stay, where at least one half.
    pub keep_old: Option<&'a Mask>,
    /// Cells that must change, where at least one half.
    pub keep_new: Option<&'a Mask>,
}

/// Outputs of [`GraphCut`].
#[derive(Outputs)]
pub struct GraphCutOut {
    /// 1 where the new terrain is taken.
    pub labels: Mask,
    /// Cost of the seam, its number of cell edges and its mean mismatch.
    pub report: Table,
}

impl Node for GraphCut {
    const ID: &'static str = "synthesis.graph_cut";
    const VERSION: u32 = 2; // 2 tells the mismatch in height, whatever edges weigh
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = GraphCutIn<'a>;
    type Outputs = GraphCutOut;

    fn cost(&self) -> f64 {
        200.0
    }

    fn run(&self, inputs: GraphCutIn<'_>, job: &Job) -> Result<GraphCutOut> {
        let grid = inputs.old.grid();
        grid.match_size("old", inputs.new.grid(), "new")?;
        for (mask, name) in [(inputs.keep_old, "keep_old"), (inputs.keep_new, "keep_new")] {
            if let Some(mask) = mask {
                grid.match_size("old", mask.grid(), name)?;
            }
        }
        job.admit(grid.len() as u64 * 68, || format!("a cut of {} cells", grid.len()))?;
        let is_set = |mask: Option<&Mask>, i: usize| mask.is_some_and(|mask| mask.cells()[i] >= 0.5);
        let keep: Vec<Keep> = (0..grid.len())
            .map(|i| {
                if is_set(inputs.keep_old, i) {
                    Keep::Old
                } else if is_set(inputs.keep_new, i) {
                    Keep::New
                } else {
                    Keep::Either
                }
            })
            .collect();
        let overlay =
            Overlay { cols: grid.cols, old: inputs.old.cells(), new: inputs.new.cells(), keep: &keep };
        let seam = seam(&overlay, self.weight, job)?;
        let cells = seam.new.iter().map(|&new| f32::from(u8::from(new))).collect();
        let report = Table::metrics([
            ("cost", Unit::Metre, seam.cost),
            ("edges", Unit::One, seam.n_cut as f64),
            ("mean_mismatch", Unit::Metre, seam.mean_mismatch()),
        ])?;
        Ok(GraphCutOut { labels: Mask::new(grid.clone(), cells)?, report })
    }
}
