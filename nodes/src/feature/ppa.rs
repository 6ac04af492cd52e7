//! PPA: profile recognition and polygon breaking, from heights to ridges or valleys.
//!
//! Chang, Song, Hsu (1998) as used by Zhou, Sun, Turk, Rehg, "Terrain Synthesis from Digital Elevation Models" (2007),
//! section 4. The four steps are nodes of their own, each in a file that tells its departures. Departures here: the
//! drop may be found from the share of ground that lines are to cover, since one fixed share of the height range fits
//! the Alps and leaves nothing of a plain; working cells are made as square on the ground as whole blocks allow.

use orograph_core::{PointKind, Unit, prelude::*};

use super::{
    branch_reduction::reduce,
    chains::{length, shape},
    forest::{Forest, Frame},
    lattice::Blocks,
    polygon_breaking::spanning_forest,
    profile_recognition::Relief,
    profiles,
    settings::{
        Drop, Falls, Importance, Joining, Kind, LADDER, Preset, Profiles, Reduction, Shaping, Steps, crest,
    },
    target_connection::connect,
};
use crate::PatchSize;

/// How the drop is found.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropBy {
    /// The largest of eight shares of the height range, 0.05 to 0.004, whose lines cover `density`.
    Density,
    /// The parameter `drop`.
    Share,
}

/// Finds the ridges or valleys of a terrain: branch points, ends and the lines between them.
///
/// Lengths are counted in working cells, blocks of the terrain's cells that are as square on the ground as whole
/// blocks allow. A terrain without lines gives none and a remark.
#[derive(Params, Clone, Debug)]
pub struct Ppa {
    /// Settings by name; what it fixes overrides the parameters below.
    #[param(default = Preset::Default)]
    pub preset: Preset,
    /// Ridges or valleys.
    #[param(default = Kind::Ridge)]
    pub kind: Kind,
    /// The patches that the lines are for: they set where lines point.
    #[param(flatten)]
    pub patches: PatchSize,
    /// Side of a working cell; 0 takes a sixteenth of the patch size.
    #[param(default = 0u32, range = 0..=32, slider = 0..=10, unit = "cells")]
    pub working_cell: u32,
    /// The profiles.
    #[param(flatten)]
    pub across: Profiles,
    /// How the drop is found.
    #[param(default = DropBy::Density)]
    pub drop_by: DropBy,
    /// How far a profile must fall, as a share of the height range, when it is set by share.
    #[param(default = 0.05, range = 0.0..=1.0, slider = 0.0..=0.1, unit = "1")]
    pub drop: f64,
    /// Share of the ground that lines are to cover, when the drop is found by density.
    #[param(default = 0.04, range = 0.0..=1.0, slider = 0.005..=0.15, unit = "1")]
    pub density: f64,
    /// Which falls count.
    #[param(flatten)]
    pub falls: Falls,
    /// What makes one of two segments more important.
    #[param(default = Importance::MeanEndpoint)]
    pub importance: Importance,
    /// What is taken off.
    #[param(flatten)]
    pub reduction: Reduction,
    /// What becomes of junctions and lines.
    #[param(flatten)]
    pub joining: Joining,
    /// Takes heights across the lines along.
    #[param(default = true)]
    pub profiles: bool,
}

/// Inputs of [`Ppa`].
#[derive(Inputs)]
pub struct PpaIn<'a> {
    /// Terrain to look at.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Ppa`].
#[derive(Outputs)]
pub struct PpaOut {
    /// The ridges or valleys.
    pub features: Features,
    /// The drop used, the share of ground on lines, and the numbers of points and lines.
    pub report: Table,
}

impl Node for Ppa {
    const ID: &'static str = "feature.ppa";
    const VERSION: u32 = 2; // 2 keeps rings whole, and lines where they are when junctions become one
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PpaIn<'a>;
    type Outputs = PpaOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn run(&self, inputs: PpaIn<'_>, job: &Job) -> Result<PpaOut> {
        let steps = self.steps();
        let mut found = find(inputs.terrain, &steps, &self.shaping(&steps), job)?;
        if found.features.lines.is_empty() {
            job.warn("the terrain shows no such lines: lower `drop` or `density`, or look at smaller working cells");
        } else if matches!(steps.drop, Drop::Density(_)) {
            job.warn(format!(
                "a drop of {} of the height range leaves {:.1} % of the ground on lines",
                found.drop,
                100.0 * found.share
            ));
        }
        if self.profiles {
            profiles::take(&mut found.features, inputs.terrain, steps.working_cell as f64, job)?;
        }
        let report = found.report()?;
        Ok(PpaOut { features: found.features, report })
    }
}

impl Ppa {
    /// The numbers of the four steps, preset included.
    #[must_use]
    pub fn steps(&self) -> Steps {
        let kind = self.kind.into();
        let mut steps = Steps::for_patch(kind, self.patches.side());
        if self.working_cell > 0 {
            steps.working_cell = self.working_cell as usize;
        }
        let drop = match self.drop_by {
            DropBy::Density => Drop::Density(self.density),
            DropBy::Share => Drop::Share(self.drop),
        };
        Steps {
            sigma: self.across.sigma,
            half_profile: self.across.half_profile as usize,
            drop,
            sided: self.falls.sided,
            floor: self.falls.floor,
            importance: self.importance,
            reduction: self.reduction,
            ..steps
        }
        .under(self.preset)
    }

    /// The numbers of classification that go with those steps.
    #[must_use]
    pub fn shaping(&self, steps: &Steps) -> Shaping {
        Shaping {
            joining: self.joining,
            ..Shaping::for_patch(self.patches.side(), steps.reduction.parallel_radius)
        }
    }
}

/// What [`find`] found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The ridges or valleys, without profiles.
    pub features: Features,
    /// The drop used, as a share of the height range.
    pub drop: f64,
    /// Share of the known working cells that lie on lines.
    pub share: f64,
}

impl Found {
    /// Drop, share of ground, counts and length, as a table of one row.
    ///
    /// # Errors
    /// None in practice; a table refuses two columns of one name.
    pub fn report(&self) -> Result<Table> {
        let count = |kind| self.features.points.iter().filter(|point| point.kind == kind).count() as f64;
        Table::metrics([
            ("drop", Unit::One, self.drop),
            ("share", Unit::Percent, 100.0 * self.share),
            ("branch_points", Unit::One, count(PointKind::Branch)),
            ("ends", Unit::One, count(PointKind::End)),
            ("lines", Unit::One, self.features.lines.len() as f64),
            ("rings", Unit::One, self.features.rings.len() as f64),
            ("length", Unit::Cell, length(&self.features)),
        ])
    }
}

/// The ridges or valleys of a terrain, classified.
///
/// # Errors
/// [`Error::BadSize`] below 3 × 3 cells; [`Error::AllVoid`]; [`Error::NonFinite`]; [`Error::TooLarge`];
/// [`Error::Cancelled`].
pub fn find(terrain: &Heightfield, steps: &Steps, shaping: &Shaping, job: &Job) -> Result<Found> {
    let blocks = Blocks::square(terrain.grid().cell, steps.working_cell);
    let raw = forest(terrain, blocks, steps, job)?;
    let frame = Frame { grid: terrain.grid(), blocks, heights: &raw.heights, kind: steps.kind };
    let features = shape(&raw.forest, &frame, shaping, job)?;
    Ok(Found { features, drop: raw.drop, share: raw.share })
}

/// A forest of working cells and how it was found.
#[derive(Clone, Debug)]
pub struct Raw {
    /// The forest.
    pub forest: Forest,
    /// Height of each working cell in metres; NaN where unknown.
    pub heights: Vec<f32>,
    /// The drop used, as a share of the height range.
    pub drop: f64,
    /// Share of the known working cells that lie on lines.
    pub share: f64,
}

/// The four steps of the algorithm on working cells of the given blocks.
///
/// # Errors
/// As [`find`].
pub fn forest(terrain: &Heightfield, blocks: Blocks, steps: &Steps, job: &Job) -> Result<Raw> {
    let relief = Relief::new(terrain, steps.kind, blocks, steps.sigma, job)?;
    let falls = relief.falls(steps.half_profile, steps.sided, job)?;
    let (ladder, density) = match &steps.drop {
        Drop::Share(share) => (std::slice::from_ref(share), 0.0),
        Drop::Density(density) => (&LADDER[..], *density),
    };
    let mut found = None;
    for &drop in ladder {
        let marked = relief.candidates(&falls, drop, steps.floor);
        let segments = connect(relief.lattice, &relief.crests, &marked, steps.importance, job)?;
        let whole = spanning_forest(relief.lattice, segments, job)?;
        let forest = reduce(whole, &relief.crests, &steps.reduction, job)?;
        let share = forest.nodes() as f64 / relief.known.max(1) as f64;
        found = Some((forest, drop, share));
        if share >= density {
            break;
        }
    }
    let (forest, drop, share) = found.unwrap_or_else(|| (Forest::new(relief.lattice), 0.0, 0.0));
    let heights = relief.crests.into_iter().map(|height| crest(height, steps.kind)).collect();
    Ok(Raw { forest, heights, drop, share })
}
