//! Chaikin subdivision of a terrain, with details.

use orograph_core::prelude::*;

use super::{
    chaikin::{Bands, Surface, coarse_len},
    chaikin_decompose::{Axes, Halving, surface_of},
};

/// Puts a coarse terrain and its details together, by Chaikin subdivision: the reverse of `filter.chaikin_decompose`.
///
/// Details that are not connected are none; then the terrain is rounded as if its corners were cut.
#[derive(Params, Clone, Debug)]
pub struct ChaikinCompose {
    /// How the terrain was taken apart.
    #[param(flatten)]
    pub halving: Halving,
}

/// Inputs of [`ChaikinCompose`].
#[derive(Inputs)]
pub struct ChaikinComposeIn<'a> {
    /// Terrain of twice the cell size.
    pub coarse: &'a Heightfield,
    /// Details along rows.
    pub across: Option<&'a Heightfield>,
    /// Details down columns.
    pub down: Option<&'a Heightfield>,
    /// Details along both.
    pub diagonal: Option<&'a Heightfield>,
    /// Terrain whose cells the result is to have; its heights do not count.
    pub like: &'a Heightfield,
}

/// Outputs of [`ChaikinCompose`].
#[derive(Outputs)]
pub struct ChaikinComposeOut {
    /// The terrain.
    pub terrain: Heightfield,
}

impl Node for ChaikinCompose {
    const ID: &'static str = "filter.chaikin_compose";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ChaikinComposeIn<'a>;
    type Outputs = ChaikinComposeOut;

    fn run(&self, inputs: ChaikinComposeIn<'_>, job: &Job) -> Result<ChaikinComposeOut> {
        job.check()?;
        let size = inputs.like.grid().size();
        let (rows, cols) = size;
        let Halving { axes, .. } = self.halving;
        let (n, m) = (coarse_len(rows), coarse_len(cols));
        let (n, m) = match axes {
            Axes::Both => (n, m),
            Axes::Across => (rows, m),
            Axes::Down => (n, cols),
        };
        let coarse = surface_of(inputs.coarse, "coarse", job)?;
        fits("coarse", &coarse, (n, m), size)?;
        let band = |raster: Option<&Heightfield>, what: &str, wanted: (usize, usize)| match raster {
            Some(raster) => {
                let surface = surface_of(raster, what, job)?;
                fits(what, &surface, wanted, size)?;
                Ok(surface)
            }
            None => Ok(Surface::zeros(wanted)),
        };
        let none = Surface::default;
        let bands = match axes {
            Axes::Both => Bands {
                size,
                across: band(inputs.across, "across", (n, m.saturating_sub(2)))?,
                down: band(inputs.down, "down", (n.saturating_sub(2), m))?,
                diagonal: band(inputs.diagonal, "diagonal", (n.saturating_sub(2), m.saturating_sub(2)))?,
                coarse,
            },
            Axes::Across => {
                let across = band(inputs.across, "across", (n, m.saturating_sub(2)))?;
                Bands { size, across, down: none(), diagonal: none(), coarse }
            }
            Axes::Down => {
                let down = band(inputs.down, "down", (n.saturating_sub(2), m))?;
                Bands { size, down, across: none(), diagonal: none(), coarse }
            }
        };
        if inputs.like.grid().is_empty() {
            return Err(Error::EmptyInput { what: "like".into() });
        }
        let surface = self.halving.compose(&bands, job)?;
        let cells = surface.cells.iter().map(|&height| height as f32).collect();
        Ok(ChaikinComposeOut { terrain: Heightfield::new(inputs.like.grid().clone(), cells)? })
    }
}

fn fits(what: &str, surface: &Surface, wanted: (usize, usize), like: (usize, usize)) -> Result<()> {
    if surface.size == wanted && like.0.min(like.1) > 0 {
        return Ok(());
    }
    let (rows, cols) = surface.size;
    Err(Error::invalid(
        format!(
            "`{what}` has {rows} × {cols} cells; for terrain of {} × {} it must have {} × {}",
            like.0, like.1, wanted.0, wanted.1
        ),
        "connect what filter.chaikin_decompose made, with the same axes, and the terrain that it was made of to `like`",
    ))
}
