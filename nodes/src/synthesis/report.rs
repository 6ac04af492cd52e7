//! What a synthesis placed, and what it did not.

use orograph_core::{Unit, prelude::*};

use super::{crests::Raised, fill_windows::Counts, outlets::Opened};
use crate::adjust::elevation_constraints::Wanted;

/// What was placed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Places planned; a branch that was split counts as the paths that it became.
    pub planned: usize,
    /// Patches placed, by role: branches, ends, paths.
    pub placed: [usize; 3],
    /// Places that no candidate fitted.
    pub unmatched: usize,
    /// Patches placed that have a line more than their place.
    pub arms_ignored: usize,
    /// Patches placed that have a line less than their place.
    pub arms_unmatched: usize,
    /// Branches that no candidate fitted and that paths were placed for.
    pub branches_split: usize,
    /// Candidates left out at the exemplar's rim or beside voids.
    pub left_out: usize,
    /// Mean mismatch along the features' seams before they were removed, in metres.
    pub seam: f64,
    /// What was filled.
    pub fill: Counts,
    /// What was raised so that lines stand out.
    pub raised: Raised,
    /// What was given an outlet.
    pub opened: Opened,
    /// How far the terrain is off the heights that were wanted, if any.
    pub off: Option<Off>,
}

/// How far terrain is off the heights that are wanted of it, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Off {
    /// The mean.
    pub mean: f64,
    /// At the cell where it is most.
    pub most: f64,
}

impl Off {
    /// That of `heights`, by cell; `None` when none are wanted of any that is known.
    pub(super) fn of(heights: &[f32], wanted: &Wanted) -> Option<Self> {
        let (mut sum, mut n, mut most) = (0.0, 0.0, 0.0_f64);
        for (cell, height) in wanted.iter() {
            let off = f64::from((heights[cell] - height).abs());
            if !off.is_nan() {
                (sum, n, most) = (sum + off, n + 1.0, most.max(off));
            }
        }
        (n > 0.0).then(|| Self { mean: sum / n, most })
    }
}

impl Report {
    /// Says what a user should know of.
    pub(super) fn tell(&self, job: &Job<'_>) {
        if self.unmatched > 0 {
            job.warn(format!("{} places of the sketch found no patch that fits", self.unmatched));
        }
        if self.arms_ignored > 0 {
            job.warn(format!(
                "{} places found no patch with as many lines as meet there: one with a line more serves them",
                self.arms_ignored
            ));
        }
        if self.arms_unmatched > 0 {
            job.warn(format!(
                "{} places found no patch with as many lines as meet there: one with a line less serves them",
                self.arms_unmatched
            ));
        }
        if self.branches_split > 0 {
            job.warn(format!(
                "{} branch points found no patch that fits: several patches of single lines serve them",
                self.branches_split
            ));
        }
    }

    /// As a table of one row.
    pub(super) fn table(&self) -> Result<Table> {
        let n = |n: usize| n as f64;
        let mut metrics = vec![
            ("planned", Unit::One, n(self.planned)),
            ("branches", Unit::One, n(self.placed[0])),
            ("ends", Unit::One, n(self.placed[1])),
            ("paths", Unit::One, n(self.placed[2])),
            ("unmatched", Unit::One, n(self.unmatched)),
            ("arms_ignored", Unit::One, n(self.arms_ignored)),
            ("arms_unmatched", Unit::One, n(self.arms_unmatched)),
            ("branches_split", Unit::One, n(self.branches_split)),
            ("candidates_left_out", Unit::One, n(self.left_out)),
            ("seam_mismatch", Unit::Metre, self.seam),
            ("fill_windows", Unit::One, n(self.fill.pasted)),
            ("smoothed_cells", Unit::Cell, n(self.fill.smoothed)),
            ("raised_cells", Unit::Cell, n(self.raised.cells)),
            ("most_raised", Unit::Metre, self.raised.most),
            ("depressions_opened", Unit::One, n(self.opened.opened)),
            ("depressions_left", Unit::One, n(self.opened.left)),
            ("most_opened", Unit::Metre, self.opened.most),
        ];
        if let Some(off) = self.off {
            metrics.push(("off_wanted_mean", Unit::Metre, off.mean));
            metrics.push(("off_wanted_max", Unit::Metre, off.most));
        }
        Table::metrics(metrics)
    }
}
