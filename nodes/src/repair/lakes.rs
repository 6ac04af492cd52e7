//! Lakes: where water may end, and the ground stays as it is.

use orograph_core::prelude::*;

/// The cells that are lakes: those where a mask is at least one half.
#[derive(Clone, Copy, Debug)]
pub struct Lakes<'a>(Option<&'a Mask>);

impl<'a> Lakes<'a> {
    /// The lakes of a mask; none without one.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`] unless the mask has the terrain's size.
    pub fn new(terrain: &Heightfield, mask: Option<&'a Mask>) -> Result<Self> {
        if let Some(mask) = mask {
            terrain.grid().match_size("terrain", mask.grid(), "lakes")?;
        }
        Ok(Self(mask))
    }

    /// Whether a cell is part of a lake.
    #[must_use]
    pub fn at(self, cell: usize) -> bool {
        self.0.is_some_and(|mask| mask.cells()[cell] >= 0.5)
    }
}
