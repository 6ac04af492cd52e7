//! What the nodes of this family have in common: kinds, presets, and the numbers behind the steps.

use orograph_core::FeatureKind;
use orograph_core::prelude::*;

/// Ridges or valleys.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Crests: lines that stand above the ground on both sides.
    Ridge,
    /// Talwegs: lines that lie below the ground on both sides.
    Valley,
}

impl From<Kind> for FeatureKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Ridge => Self::Ridge,
            Kind::Valley => Self::Valley,
        }
    }
}

/// A height turned so that lines of the kind are crests: as it is for ridges, negated for valleys.
#[must_use]
pub fn crest(height: f32, kind: FeatureKind) -> f32 {
    match kind {
        // Adding zero makes one zero of the two, so that equal heights compare as equal.
        FeatureKind::Ridge => height + 0.0,
        FeatureKind::Valley => 0.0 - height,
    }
}

/// Whose numbers are taken.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The parameters as they are set.
    Default,
    /// Zhou et al. 2007 to the letter: every cell, half of the height range, a drop on any one side, no test for
    /// parallel branches, no growing back.
    PaperStrict,
    /// The defaults of the authors' own plug-in: blocks of 5 cells and a drop of 0.05, otherwise as set.
    PlugIn,
}

/// On which sides a profile must fall.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sided {
    /// On both sides of the cell along one of four axes.
    TwoSided,
    /// On any one side: every slope steep enough counts, as in the paper.
    AnyPath,
}

/// How much a segment between two cells matters when polygons are broken.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Importance {
    /// The mean height of its two cells.
    MeanEndpoint,
    /// The height of its lower cell.
    MinEndpoint,
}

/// How far a profile must fall, as a share of the height range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drop {
    /// This share.
    Share(f64),
    /// The largest of [`LADDER`] that leaves at least this share of the known working cells on lines.
    Density(f64),
}

/// The shares of the height range that [`Drop::Density`] tries, in order.
pub const LADDER: [f64; 8] = [0.05, 0.035, 0.025, 0.018, 0.0125, 0.009, 0.006, 0.004];

/// The numbers of profile recognition and polygon breaking. Counts and radii are in working cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Ridges or valleys.
    pub kind: FeatureKind,
    /// Cells along the shorter side of a working cell.
    pub working_cell: usize,
    /// Standard deviation of the smoothing before, 0 for none.
    pub sigma: f64,
    /// Samples on each side of a profile.
    pub half_profile: usize,
    /// How far a profile must fall.
    pub drop: Drop,
    /// On which sides.
    pub sided: Sided,
    /// Share of the height range below which no cell is a candidate.
    pub floor: f64,
    /// How much a segment matters.
    pub importance: Importance,
    /// What is taken off afterwards.
    pub reduction: Reduction,
}

/// What branch reduction takes off. Counts and radii are in working cells.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Rounds that take the outermost segment off every end before branches are judged.
    #[param(default = 3u32, range = 0..=32, slider = 0..=10, unit = "1")]
    pub end_trim: u32,
    /// Least segments of a branch.
    #[param(default = 7u32, range = 0..=256, slider = 0..=40, unit = "1")]
    pub min_branch: u32,
    /// A branch that never gets further than this many working cells from the rest goes; 0 lets it be.
    #[param(default = 3, range = 0.0..=32.0, slider = 0.0..=12.0, unit = "1")]
    pub parallel_radius: f64,
    /// Least segments of a connected group.
    #[param(default = 10u32, range = 0..=4096, slider = 0..=100, unit = "1")]
    pub min_group: u32,
    /// Gives ends that stay the segments back that trimming took.
    #[param(default = true)]
    pub regrow: bool,
    /// Keeps lines whole that close around ground, but for one segment. What is left of them beside the place where
    /// polygon breaking opened them is no branch then. Such rings are wider than the parallel radius.
    #[param(default = true)]
    pub rings: bool,
}

/// The profiles across a working cell.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Profiles {
    /// Smoothing before, as a standard deviation in working cells; 0 for none.
    #[param(default = 0, range = 0.0..=32.0, slider = 0.0..=4.0, unit = "1")]
    pub sigma: f64,
    /// Working cells on each side of a profile.
    #[param(default = 3u32, range = 1..=32, slider = 1..=12, unit = "1")]
    pub half_profile: u32,
}

/// Which falls of a profile count.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Falls {
    /// On which sides a profile must fall.
    #[param(default = Sided::TwoSided)]
    pub sided: Sided,
    /// Share of the height range below which, or for valleys above which, there are no lines.
    #[param(default = 0, range = 0.0..=1.0, unit = "1")]
    pub floor: f64,
}

/// The working cells of the steps that are nodes of their own.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct WorkingCells {
    /// Ridges or valleys; the same in each step.
    #[param(default = Kind::Ridge)]
    pub kind: Kind,
    /// Side of the blocks whose mean heights are looked at; the same in each step. A sixteenth of the patch size suits
    /// synthesis.
    #[param(default = 5u32, range = 1..=32, slider = 1..=10, unit = "cells")]
    pub working_cell: u32,
}

impl Default for Steps {
    fn default() -> Self {
        Self {
            kind: FeatureKind::Ridge,
            working_cell: 5,
            sigma: 0.0,
            half_profile: 3,
            drop: Drop::Density(0.04),
            sided: Sided::TwoSided,
            floor: 0.0,
            importance: Importance::MeanEndpoint,
            reduction: Reduction::default(),
        }
    }
}

impl Steps {
    /// For patches of `patch` cells: working cells of a sixteenth of a patch.
    #[must_use]
    pub fn for_patch(kind: FeatureKind, patch: usize) -> Self {
        let working_cell = ((patch as f64 / 16.0).round() as usize).max(1);
        Self { kind, working_cell, ..Self::default() }
    }

    /// The same with what a preset overrides.
    #[must_use]
    pub fn under(self, preset: Preset) -> Self {
        match preset {
            Preset::Default => self,
            Preset::PaperStrict => Self {
                working_cell: 1,
                sigma: 0.0,
                half_profile: 3,
                drop: Drop::Share(0.5),
                sided: Sided::AnyPath,
                floor: 0.0,
                importance: Importance::MeanEndpoint,
                reduction: Reduction {
                    parallel_radius: 0.0,
                    regrow: false,
                    rings: false,
                    ..Reduction::default()
                },
                ..self
            },
            Preset::PlugIn => Self { working_cell: 5, drop: Drop::Share(0.05), ..self },
        }
    }
}

/// The numbers that turn a forest of working cells into points and lines.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Shaping {
    /// What becomes of junctions and lines.
    #[param(flatten)]
    pub joining: Joining,
    /// Ends nearer than this many working cells that face each other close a ring.
    #[param(default = 4, range = 0.0..=64.0, slider = 0.0..=12.0, unit = "1")]
    pub ring_gap: f64,
    /// Length of line that tells where an end points.
    #[param(default = 10, range = 1.0..=512.0, slider = 1.0..=40.0, unit = "cells")]
    pub heading: f64,
}

/// What becomes of junctions and of the lines between them.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Joining {
    /// Branch points become one if the line between them is shorter than this many working cells.
    #[param(default = 4, range = 0.0..=64.0, slider = 0.0..=16.0, unit = "1")]
    pub merge_radius: f64,
    /// Smoothing passes over each line.
    #[param(default = 2u32, range = 0..=32, slider = 0..=10, unit = "1")]
    pub smooth_passes: u32,
}

impl Shaping {
    /// For patches of `patch` cells and the parallel radius of the reduction.
    #[must_use]
    pub fn for_patch(patch: usize, parallel_radius: f64) -> Self {
        // Where branch reduction would take a gap's stub off, a little more than that lies between the ends.
        Self { ring_gap: (parallel_radius + 1.0).max(2.5), heading: patch as f64 / 8.0, ..Self::default() }
    }
}
