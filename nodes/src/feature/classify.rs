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
    /// Branch points become one if the line between them is shorter than this many working cells.
    #[param(default = 4, range = 0.0..=64.0, slider = 0.0..=16.0, unit = "1")]
    pub merge_radius: f64,
    /// Smoothing passes over each line.
    #[param(default = 2u32, range = 0..=32, slider = 0..=10, unit = "1")]
    pub smooth_passes: u32,
    /// Ends nearer than this many working cells that face each other close a ring.
    #[param(default = 3, range = 0.0..=64.0, slider = 0.0..=12.0, unit = "1")]
    pub ring_gap: f64,
    /// Length of line that tells where an end points.
    #[param(default = 10, range = 1.0..=512.0, slider = 1.0..=40.0, unit = "cells")]
    pub heading: f64,
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
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ClassifyIn<'a>;
    type Outputs = ClassifyOut;

    fn run(&self, inputs: ClassifyIn<'_>, job: &Job) -> Result<ClassifyOut> {
        let raw = inputs.forest;
        let (forest, heights) = Forest::from_features(raw, job)?;
        let frame = Frame { grid: &raw.grid, blocks: blocks_of(raw)?, heights: &heights, kind: raw.kind };
        let shaping = Shaping {
            merge_radius: self.merge_radius,
            smooth_passes: self.smooth_passes as usize,
            ring_gap: self.ring_gap,
            heading: self.heading,
        };
        Ok(ClassifyOut { features: chains::shape(&forest, &frame, &shaping, job)? })
    }
}
