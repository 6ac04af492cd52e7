//! The stretch of ground that nodes cover which make terrain from nothing.

use orograph_core::prelude::*;

/// How much ground to cover, and in how many cells.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Extent of the ground from west to east, when no grid is given.
    #[param(default = 10_000, range = 0.001..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub width: f64,
    /// Extent of the ground from north to south, when no grid is given.
    #[param(default = 10_000, range = 0.001..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub height: f64,
    /// Cells along the longer side, when neither a grid nor the run's resolution is given.
    #[param(default = 512u32, range = 1..=65_537, slider = 64..=4097, unit = "cells")]
    pub cells: u32,
}

impl Ground {
    /// Cells and extent of the longer side, in metres; the run's resolution overrides the settings'.
    pub(crate) fn longer_side(&self, job: &Job) -> (u32, f64) {
        (job.resolution().unwrap_or(self.cells).max(1), self.width.max(self.height))
    }
}
