//! The size of patches, which synthesis and what prepares or judges it have in common.

use orograph_core::prelude::*;

/// The size of the patches that terrain is made of.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct PatchSize {
    /// Side of the patches that terrain is made of. Lines of a sketch should lie further apart than this.
    #[param(default = 80u32, range = 16..=512, slider = 40..=160, unit = "cells")]
    pub patch: u32,
}

impl PatchSize {
    /// The side of a patch, in cells.
    pub(crate) fn side(self) -> usize {
        self.patch as usize
    }
}
