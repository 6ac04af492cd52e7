//! Constant: the same height everywhere.

use orograph_core::prelude::*;

use super::ground::{Ground, GroundIn, GroundOut};

/// Makes level ground.
#[derive(Params, Clone, Debug)]
pub struct Constant {
    /// Height of the ground.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub level: f64,
    /// Extent of the ground from west to east, when no grid is given.
    #[param(default = 10_000, range = 1.0..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub width: f64,
    /// Extent of the ground from north to south, when no grid is given.
    #[param(default = 10_000, range = 1.0..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub height: f64,
    /// Cells along the longer side, when neither a grid nor the run's resolution is given.
    #[param(default = 512u32, range = 1..=65_536, slider = 64..=4096, unit = "cells")]
    pub cells: u32,
}

impl Node for Constant {
    const ID: &'static str = "generate.constant";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        let ground = Ground { width: self.width, height: self.height, cells: self.cells };
        ground.cells(&inputs, job, |_, _| self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_is_level() {
        let node = Constant { level: 12.5, cells: 3, ..Constant::default() };
        let out = node.run(GroundIn { like: None }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells(), [12.5; 9]);
    }
}
