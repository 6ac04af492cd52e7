//! Classification: branch points, ends and the lines between them.
//!
//! Zhou et al. (2007), section 4: cells with one neighbour end a line, cells with three or more branch it.
//! Departures: junctions a few cells apart, which is how an 8-connected grid shows a crossing, become one; lines are
//! smoothed by (¼, ½, ¼), the paper names no filter; ends that polygon breaking left facing each other are paired, so
//! that a drawn ring can be closed again.

use orograph_core::prelude::*;

use super::{
    chains,
    forest::{Forest, Frame, blocks_of},
    settings::Shaping,
};

/// Turns a forest of working cells into branch points, ends and smooth lines between them.
#[derive(Params, Clone, Debug)]
pub struct Classify {
    /// How lines are made.
    #[param(flatten)]
    pub shaping: Shaping,
}

/// Inputs of [`Classify`].
#[derive(Inputs)]
pub struct ClassifyIn<'a> {
    /// A forest of working cells, from `feature.branch_reduction`.
    pub forest: &'a Features,
}

/// Outputs of [`Classify`].
#[derive(Outputs)]
pub struct ClassifyOut {
    /// Branch points and ends, joined by lines.
    pub features: Features,
}

impl Node for Classify {
    const ID: &'static str = "feature.classify";
    const VERSION: u32 = 2; // 2 leaves lines where they are when junctions become one
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ClassifyIn<'a>;
    type Outputs = ClassifyOut;

    fn run(&self, inputs: ClassifyIn<'_>, job: &Job) -> Result<ClassifyOut> {
        let raw = inputs.forest;
        let (forest, heights) = Forest::from_features(raw, job)?;
        let frame = Frame { grid: &raw.grid, blocks: blocks_of(raw)?, heights: &heights, kind: raw.kind };
        Ok(ClassifyOut { features: chains::shape(&forest, &frame, &self.shaping, job)? })
    }
}
