//! Warp: one patch of a synthesis, as it was bent to its place.

use orograph_core::prelude::*;
use orograph_core::{Placement, Unit};

use super::{
    exemplar::Exemplar,
    resample::cubic,
    tps::{Basis, Point},
};

/// Takes a patch from an exemplar and bends it by the thin-plate spline that a synthesis found for it.
#[derive(Params, Clone, Debug)]
pub struct Warp {
    /// Number of the patch, from 1, as the labels of the placement have it.
    #[param(default = 1u32, range = 1..=1_000_000, slider = 1..=200, unit = "1")]
    pub number: u32,
}

/// Inputs of [`Warp`].
#[derive(Inputs)]
pub struct WarpIn<'a> {
    /// Which patch went where.
    pub placement: &'a Placement,
    /// The exemplar that the patch came from.
    pub exemplar: &'a Heightfield,
}

/// Outputs of [`Warp`].
#[derive(Outputs)]
pub struct WarpOut {
    /// The patch in its own square window, raised as it was; one void when there is no patch of that number.
    pub patch: Heightfield,
    /// Bending energy, and the most and the least that the patch is stretched.
    pub report: Table,
}

impl Node for Warp {
    const ID: &'static str = "synthesis.warp";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = WarpIn<'a>;
    type Outputs = WarpOut;

    fn run(&self, inputs: WarpIn<'_>, job: &Job) -> Result<WarpOut> {
        let exemplar = Exemplar::new(inputs.exemplar, job)?;
        let cell = exemplar.terrain.grid().cell;
        let Some(patch) = inputs.placement.patches.get(self.number as usize - 1) else {
            job.warn(format!("there are only {} patches", inputs.placement.patches.len()));
            let place = inputs.exemplar.grid().crop(0, 0, 1, 1)?;
            let patch = Heightfield::filled(place, f32::NAN, job)?;
            return Ok(WarpOut { patch, report: report(f64::NAN, f64::NAN, f64::NAN)? });
        };
        let size = patch.size as usize;
        let half = (size / 2) as f64;
        let corner = patch.target_center.map(|x| (x + 0.5).floor() - half);
        let to: Vec<Point> = patch.controls.iter().map(|pair| [pair[0], pair[1]]).collect();
        let from: Vec<Point> = patch.controls.iter().map(|pair| [pair[2], pair[3]]).collect();
        let spline =
            Basis::new(&to, (size as f64 - 1.0) / 2.0).and_then(|basis| Some((basis.fit(&from)?, basis)));
        let source = |at: Point| match &spline {
            Some((spline, basis)) => basis.map(spline, at),
            // Fills are moved, not bent.
            None => [0, 1].map(|axis| at[axis] - patch.target_center[axis] + patch.source_center[axis]),
        };
        let out = Heightfield::build(Grid::new(size, size, cell)?, job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let at = source([corner[0] + row as f64, corner[1] + col as f64]);
                *out = cubic(&exemplar.terrain, at) + patch.offset as f32;
            }
            job.check()
        })?;
        let report = match &spline {
            Some((spline, basis)) => {
                let stretch = spline.stretch(basis);
                report(spline.energy(), stretch.most, stretch.least)?
            }
            None => report(0.0, 1.0, 1.0)?,
        };
        Ok(WarpOut { patch: out, report })
    }
}

fn report(energy: f64, most: f64, least: f64) -> Result<Table> {
    Table::metrics([
        ("bending_energy", Unit::One, energy),
        ("most_stretch", Unit::One, most),
        ("least_stretch", Unit::One, least),
    ])
}
