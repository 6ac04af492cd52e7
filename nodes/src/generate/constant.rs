//! Constant: the same height everywhere.

use orograph_core::prelude::*;

use super::ground::{GroundIn, GroundOut, bands, sample_cells};
use crate::Ground;

/// Makes level ground.
#[derive(Params, Clone, Debug)]
pub struct Constant {
    /// Height of the ground.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub level: f64,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

impl Node for Constant {
    const ID: &'static str = "generate.constant";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        bands(self, &self.ground, job)
    }

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        sample_cells(&self.ground, &inputs, job, |_, _| self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_is_level() {
        let node = Constant { level: 12.5, ground: Ground { cells: 3, ..Ground::default() } };
        let out = node.run(GroundIn { like: None }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells(), [12.5; 9]);
    }
}
