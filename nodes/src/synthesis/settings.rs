//! What the nodes of this family have in common: presets, order, and the numbers behind the steps.

use orograph_core::{mix64, prelude::*};

use crate::{Chance, PatchSize};

use super::{cut::SeamWeight, poisson::seam::SeamGradient};

/// Whose rules are followed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Ours: warps that follow lines between their ends too, costs in common units, patches lifted to the ground around
    /// them, seams that keep their slope.
    Default,
    /// Zhou et al. 2007 to the letter: three control points to a path, costs in metres with the published weights, no
    /// lifting, seams without slope. Patches keep their crests where they were drawn, but what fills the rest may replace the
    /// ground from a sixteenth of a patch beside a line, so other crests come to lie close by and lines stand out less.
    PaperStrict,
}

/// Whose rules are followed, and on what scale.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Whose rules are followed. The paper's own override lift, crest, outlets, seams, repetition, variety and the user's terms
    /// where a node has them.
    #[param(default = Preset::Default)]
    pub preset: Preset,
    /// The patches.
    #[param(flatten)]
    pub patches: PatchSize,
}

impl Manner {
    /// The numbers behind it, for patches no larger than `most` cells.
    pub(super) fn rules(self, most: usize) -> Rules {
        Rules::of(self.preset, self.patches.side().min(most))
    }
}

/// What candidates for a place are judged by beside the costs that the paper prints: the terms that it leaves to the user,
/// each with a weight of its own. A weight of 0 leaves a term out. The published rules have none of them.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct UserTerms {
    /// Weight of wanted heights: 1 for ground a tenth of the exemplar's height range off. That is before it is lifted, and
    /// where heights are wanted within a quarter of a patch from its centre. Much of it takes the few patches of that
    /// height, whatever else is wrong with them.
    #[param(default = 0.3, range = 0.0..=10_000.0, slider = 0.0..=10.0, unit = "1")]
    pub wanted_heights: f64,
    /// Weight of bends between the lines of neighbouring patches: a right angle costs 1. Lines break less often with it.
    #[param(default = 10.0, range = 0.0..=10_000.0, slider = 0.0..=50.0, unit = "1")]
    pub tangents: f64,
    /// Weight of closed depressions where a patch is pasted: 1 for a hundredth of its window's cells. Those count that lie
    /// deeper in them than a usual step between cells of the exemplar. Most depressions lie off the lines, where
    /// `repair.breach_depressions` helps more.
    #[param(default = 0.0, range = 0.0..=10_000.0, slider = 0.0..=10.0, unit = "1")]
    pub pits: f64,
}

impl UserTerms {
    /// None of them.
    pub const NONE: Self = Self { wanted_heights: 0.0, tangents: 0.0, pits: 0.0 };
}

/// The seed of a node's choices and the run's, as one. Kept apart from [`Chance::key`]: mixed its way, graphs would make
/// other terrain than they did.
pub(super) fn seed_of(chance: Chance, job: &Job) -> u64 {
    mix64(chance.seed ^ mix64(job.seed()))
}

/// Of how many of the best candidates one is drawn, unless told otherwise.
pub(super) const VARIETY: u32 = 3;

/// The order in which patches are placed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Breadth first along the feature tree, from its root.
    Tree,
    /// The same patches from top to bottom, for comparison.
    RasterItems,
    /// Features are ignored: overlapping windows from top to bottom, for comparison.
    Raster,
}

/// The numbers that synthesis works with. Lengths are in cells of the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Whose rules.
    pub preset: Preset,
    /// Side of a patch.
    pub patch: usize,
    /// Branch candidates that are cut.
    pub n_branch: usize,
    /// Path and end candidates that are cut.
    pub n_path: usize,
    /// Fill candidates that are cut.
    pub n_fill: usize,
    /// Of the candidates for a place, those whose seams are cut: the ones that differ least from the ground there.
    pub n_cut: usize,
    /// Distance in cells beyond which the final merge keeps the heights; `None` for no merge.
    pub merge: Option<f64>,
    /// Most that a patch is lifted, as a share of the exemplar's height range; `None` for no lifting.
    pub lift: Option<f64>,
    /// What drawn lines stand out by at least, as a share of what the exemplar's usually do; 0 for whatever they do.
    pub crest: f64,
    /// Closed depressions deeper than what is usual in the exemplar, times this, are given an outlet; 0 leaves all.
    pub outlets: f64,
    /// How seams are weighed.
    pub seam_weight: SeamWeight,
    /// What step is wanted across a seam.
    pub seam_gradient: SeamGradient,
    /// Cells beyond the overlap over which a seam is spread.
    pub grow: usize,
    /// Cells beyond its window that a patch reaches where ground goes on there, so that it never just abuts on it.
    pub margin: usize,
    /// Whether patches may be mirrored.
    pub mirror: bool,
    /// Of how many of the best candidates for a place one is drawn.
    pub variety: usize,
    /// How far borders between styles waver, in quarters of a patch.
    pub transition: f64,
    /// Weights of what the paper leaves to the user.
    pub terms: UserTerms,
    /// Weight of each earlier use of a source window.
    pub repetition: f64,
    /// Most uses of a source window while others are left.
    pub max_uses: usize,
    /// Seed of all choices.
    pub seed: u64,
}

impl Rules {
    /// The rules of a preset for patches of a size.
    #[must_use]
    pub fn of(preset: Preset, patch: usize) -> Self {
        let strict = preset == Preset::PaperStrict;
        Self {
            preset,
            patch,
            n_branch: 10,
            n_path: if strict { 32 } else { 12 },
            n_fill: if strict { 10 } else { 4 },
            n_cut: if strict { usize::MAX } else { 3 },
            merge: (!strict).then_some(2.0 * patch as f64),
            lift: (!strict).then_some(0.1),
            crest: if strict { 0.0 } else { 0.9 },
            outlets: if strict { 0.0 } else { 1.0 },
            seam_weight: if strict { SeamWeight::Plain } else { SeamWeight::Slope },
            seam_gradient: if strict { SeamGradient::Zero } else { SeamGradient::Average },
            grow: 0,
            margin: if strict { 0 } else { patch / 10 },
            mirror: true,
            variety: if strict { 1 } else { VARIETY as usize },
            transition: 0.0,
            terms: if strict { UserTerms::NONE } else { UserTerms::default() },
            repetition: if strict { 0.0 } else { 1.0 },
            max_uses: if strict { usize::MAX } else { 8 },
            seed: 0,
        }
    }

    /// Whether the paper is followed to the letter.
    #[must_use]
    pub fn strict(&self) -> bool {
        self.preset == Preset::PaperStrict
    }

    /// Radius of the circle inside a patch.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.patch as f64 - 1.0) / 2.0
    }

    /// Side of the windows that fill what features leave open.
    #[must_use]
    pub fn fill_window(&self) -> usize {
        (self.patch as f64 * 1.875).round() as usize
    }

    /// Distance between those windows.
    #[must_use]
    pub fn fill_step(&self) -> usize {
        (self.patch as f64 * 1.25).round() as usize
    }
}
