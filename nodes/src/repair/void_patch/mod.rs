//! Void patching whole: a smooth patch, details, and a rim without step.
//!
//! Wecker, J. D. B., Samavati, F. F. and Gavrilova, M. L. (2007), "Contextual void patching for digital elevation models",
//! The Visual Computer 23. Departures of the default: the smooth patch is a thin plate, which lies nearer to the truth than
//! curves; and the details are those of [`area_details`]. Both are parameters, and
//! [`Preset::PaperStrict`] has none of them.

mod edges;
mod offsets;

use orograph_core::prelude::*;

use super::{
    area_details::{self, Details, From, Match},
    combine_by_relevance::{close, relevant},
    curve_patch::bridge,
    curves::{CurveDetails, Direction},
    feather::{Feather, Joining, feather},
    harmonic_fill::harmonic_fill,
    thin_plate_fill::{Stiffness, thin_plate_fill},
    voids,
};
use crate::filter::chaikin::Boundary;

/// Whose rules are followed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The parameters as they are set.
    Default,
    /// Wecker et al. 2007 to the letter: curves, clamped ends, no margin, the eight boxes beside the void's, details as
    /// found, averages along the rim. Levels, gain and the kind of details stay as they are set.
    PaperStrict,
}

/// The smooth form of a patch.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smooth {
    /// The surface that bends least: nearest to the truth.
    ThinPlate,
    /// Curves in four directions, joined by relevance: the paper's.
    Curves,
    /// The flattest surface through the rim, which never overshoots.
    Harmonic,
}

/// Where a patch's details come from.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From an area of ground near by.
    Area,
    /// From the ground beside each curve, mirrored; too regular, by the paper's own judgement.
    Curves,
    /// From nowhere: patches stay smooth.
    None,
}

/// Fills voids with ground that goes on from their rim and is as rough as their surroundings.
///
/// Known heights stay to the bit. The default lies as near to the truth as a smooth fill and looks like the terrain around;
/// more levels look richer and lie farther from it. For voids wider than the forms around them no filling can know the
/// truth: leave them out by `largest` and give them to `synthesis.fill`.
#[derive(Params, Clone, Debug)]
pub struct VoidPatch {
    /// Whose rules are followed.
    #[param(default = Preset::Default)]
    pub preset: Preset,
    /// The smooth form of patches.
    #[param(default = Smooth::ThinPlate)]
    pub smooth: Smooth,
    /// How stiff a thin plate is.
    #[param(flatten)]
    pub stiff: Stiffness,
    /// Where details come from.
    #[param(default = Kind::Area)]
    pub details: Kind,
    /// How voids get details.
    #[param(flatten)]
    pub area: Details,
    /// How patches are joined.
    #[param(flatten)]
    pub joining: Joining,
    /// Most cells of a void that is filled; larger ones stay.
    #[param(default = 4_294_967_295u32, range = 1..=4_294_967_295u32, slider = 1..=100_000, unit = "cells")]
    pub largest: u32,
}

/// Inputs of [`VoidPatch`].
#[derive(Inputs)]
pub struct VoidPatchIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
    /// The same terrain with ground beyond its edges, as `io.read_tile` gives it: voids at an edge are filled looking across,
    /// and the tile on the other side fills what both share alike.
    pub around: Option<&'a Heightfield>,
}

/// Outputs of [`VoidPatch`].
#[derive(Outputs)]
pub struct VoidPatchOut {
    /// Terrain with its voids filled.
    pub terrain: Heightfield,
    /// The smooth form alone.
    pub smooth: Heightfield,
    /// One row for each void, where details come from an area: its cells, its box, the levels used, where details came from
    /// and their gain. Otherwise empty.
    pub report: Table,
}

impl Node for VoidPatch {
    const ID: &'static str = "repair.void_patch";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = VoidPatchIn<'a>;
    type Outputs = VoidPatchOut;

    fn cost(&self) -> f64 {
        400.0
    }

    fn run(&self, inputs: VoidPatchIn<'_>, job: &Job) -> Result<VoidPatchOut> {
        let settings = self.settings();
        let patch = |terrain: &Heightfield, job: &Job<'_>| settings.patch(terrain, job);
        match inputs.around {
            Some(around) if inputs.terrain.void_count() > 0 => {
                edges::patch_within(inputs.terrain, around, patch, job)
            }
            _ => patch(inputs.terrain, job),
        }
    }
}

impl VoidPatch {
    /// Patches all voids, by settings without preset.
    fn patch(&self, terrain: &Heightfield, job: &Job<'_>) -> Result<VoidPatchOut> {
        if terrain.void_count() == 0 {
            job.warn("the terrain has no voids and stays as it is");
        }
        let smooth = match (self.smooth, self.details) {
            (Smooth::Curves, _) | (_, Kind::Curves) => self.curves(terrain, job)?,
            (Smooth::ThinPlate, _) => thin_plate_fill(terrain, None, self.stiff, job)?,
            (Smooth::Harmonic, _) => harmonic_fill(terrain, None, job)?,
        };
        let (patch, report) = match self.details {
            Kind::Area => area_details::transplant(terrain, &smooth, &self.area, job)?,
            Kind::Curves | Kind::None => (smooth.clone(), Table::new(Vec::new())?),
        };
        let mut filled = feather(terrain, &patch, self.joining, job)?;
        self.leave_large(terrain, &mut filled, job)?;
        Ok(VoidPatchOut { terrain: filled, smooth, report })
    }

    /// The parameters that the preset leaves.
    fn settings(&self) -> Self {
        match self.preset {
            Preset::Default => self.clone(),
            Preset::PaperStrict => Self {
                smooth: Smooth::Curves,
                area: Details {
                    boundary: Boundary::Clamped,
                    margin: 0,
                    strength: Match::Source,
                    source: From::Neighbours,
                    ..self.area
                },
                joining: Joining { feather: Feather::Average, feather_radius: 1 },
                ..self.clone()
            },
        }
    }

    /// Curves in four directions, joined by relevance, with details of their own where they are wanted.
    fn curves(&self, terrain: &Heightfield, job: &Job<'_>) -> Result<Heightfield> {
        let Details { levels, boundary, detail_gain: gain, .. } = self.area;
        let details = (self.details == Kind::Curves).then_some(CurveDetails { levels, boundary, gain });
        let mut all: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut place: Vec<u32> = Vec::new();
        let n = terrain.grid().len();
        job.admit(n as u64 * 4 + terrain.void_count() as u64 * 96, || "the curves through all voids".into())?;
        place.resize(n, u32::MAX);
        for direction in Direction::ALL {
            for filled in bridge(terrain, direction, details, job)? {
                let at = &mut place[filled.cell];
                if *at == u32::MAX {
                    *at = all.len() as u32;
                    all.push(Vec::with_capacity(4));
                }
                all[*at as usize].push((filled.height, filled.distance));
            }
        }
        let mut out = terrain.map(job, |height| height)?;
        for (height, &at) in out.cells_mut().iter_mut().zip(&place).filter(|(_, at)| **at != u32::MAX) {
            *height = relevant(all[at as usize].iter().copied()) as f32;
        }
        close(out, job)
    }

    fn leave_large(&self, terrain: &Heightfield, filled: &mut Heightfield, job: &Job<'_>) -> Result<()> {
        if terrain.void_count() <= self.largest as usize {
            return Ok(());
        }
        let voids = voids::find(terrain.grid().size(), 0, |i| terrain.cells()[i].is_nan(), job)?;
        let large: Vec<_> = voids.iter().filter(|void| void.cells.len() > self.largest as usize).collect();
        if !large.is_empty() {
            job.warn(format!("{} voids of more than {} cells stay void", large.len(), self.largest));
        }
        large.iter().flat_map(|void| &void.cells).for_each(|&cell| filled.cells_mut()[cell] = f32::NAN);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
