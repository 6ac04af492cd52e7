//! Replay: another layer of the exemplar, carried to where a synthesis put its ground.
//!
//! Zhou 2007 names this as future work. Each cell of a synthesis knows where in the exemplar it came from; any layer
//! that lies over the exemplar follows through the same patches, cuts and warps.

use orograph_core::prelude::*;
use orograph_core::{Kind, Placement};

use crate::transform::sample::{Interpolation, sample};

/// Carries a raster that lies over the exemplar, such as snow depth or a map of soils, to where synthesis put its ground.
///
/// Cells that came from no exemplar are voids.
#[derive(Params, Clone, Debug)]
pub struct Replay {
    /// How values between cells are made; classes want the nearest.
    #[param(default = Interpolation::Cubic)]
    pub interpolation: Interpolation,
    /// Adds what synthesis added to the heights of each patch: for terrain, not for other measures.
    #[param(default = false)]
    pub lift: bool,
}

/// Inputs of [`Replay`].
#[derive(Inputs)]
pub struct ReplayIn<'a> {
    /// Which patch went where.
    pub placement: &'a Placement,
    /// The layer over each exemplar, in the order in which synthesis had them.
    pub layers: Vec<&'a Heightfield>,
}

/// Outputs of [`Replay`].
#[derive(Outputs)]
pub struct ReplayOut {
    /// The layer over the synthesised terrain.
    pub layer: Heightfield,
}

impl Node for Replay {
    const ID: &'static str = "synthesis.replay";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ReplayIn<'a>;
    type Outputs = ReplayOut;

    fn run(&self, inputs: ReplayIn<'_>, job: &Job) -> Result<ReplayOut> {
        let origins = Origins::new(inputs.placement, inputs.layers.len())?;
        let layer = Heightfield::build(inputs.placement.grid.clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                if let Some((exemplar, [row, col], lift)) = origins.at(row, col) {
                    let value = sample(inputs.layers[exemplar], row, col, self.interpolation);
                    *out = if self.lift { value + lift as f32 } else { value };
                }
            }
            Ok(())
        })?;
        Ok(ReplayOut { layer })
    }
}

/// Where the cells of a placement came from, in the cells of the layers as they are.
pub(super) struct Origins<'a> {
    placement: &'a Placement,
    n_layers: usize,
}

impl<'a> Origins<'a> {
    pub(super) fn new(placement: &'a Placement, n_layers: usize) -> Result<Self> {
        let cells = placement.grid.len();
        if placement.labels.len() != cells || placement.sources.len() != cells {
            return Err(Error::invalid("the placement is damaged", "make it with `synthesis.synthesise`"));
        }
        let needed = placement.patches.iter().map(|patch| patch.exemplar as usize + 1).max().unwrap_or(0);
        if needed > n_layers {
            return Err(Error::invalid(
                format!("the placement took from {needed} exemplars, but there are {n_layers} layers"),
                "connect a layer for each exemplar, in the same order",
            ));
        }
        Ok(Self { placement, n_layers })
    }

    /// Which layer, where in it, and what was added to its heights.
    pub(super) fn at(&self, row: usize, col: usize) -> Option<(usize, [f64; 2], f64)> {
        let i = row * self.placement.grid.cols + col;
        let patch = self.placement.patches.get((self.placement.labels[i] as usize).checked_sub(1)?)?;
        let exemplar = patch.exemplar as usize;
        let scale = self.placement.scales.get(exemplar).copied().unwrap_or([1.0; 2]);
        let [row, col] = self.placement.sources[i].map(f64::from);
        let at = [(row + 0.5) / scale[0] - 0.5, (col + 0.5) / scale[1] - 0.5];
        (exemplar < self.n_layers).then_some((exemplar, at, patch.offset))
    }
}

/// The cell of a raster nearest to a position; `None` outside.
pub(super) fn nearest<K: Kind>(raster: &Raster<K>, [row, col]: [f64; 2]) -> Option<K::Cell> {
    let (rows, cols) = raster.grid().size();
    let (row, col) = ((row + 0.5).floor(), (col + 0.5).floor());
    // Written so that NaN is outside.
    let inside = row >= 0.0 && col >= 0.0 && row < rows as f64 && col < cols as f64;
    inside.then(|| raster.at(row as usize, col as usize))
}
