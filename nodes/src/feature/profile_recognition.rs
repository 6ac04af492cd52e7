//! Profile recognition: the cells that stand above the ground on both sides.
//!
//! Chang, Song, Hsu (1998), "Automatic extraction of ridge and valley axes using the profile recognition and
//! polygon-breaking algorithm", first step, as Zhou et al. (2007) use it. Eight half-profiles run outward from each
//! working cell; a half is low where any of its samples falls short of the middle by more than the drop. Departure:
//! the two halves of one axis must both be low, where the papers are content with one.

use orograph_core::prelude::*;

use super::{
    lattice::{Blocks, Lattice, STEPS, block_means},
    settings::{Falls, Profiles, Sided, WorkingCells, crest},
};
use crate::filter::gaussian_blur::blur;

/// Marks the cells that stand above, or for valleys below, the ground on both sides of some axis.
///
/// The first of four steps; `feature.ppa` takes them all at once.
#[derive(Params, Clone, Debug)]
pub struct ProfileRecognition {
    /// The working cells.
    #[param(flatten)]
    pub cells: WorkingCells,
    /// The profiles.
    #[param(flatten)]
    pub profiles: Profiles,
    /// How far a profile must fall, as a share of the height range.
    #[param(default = 0.05, range = 0.0..=1.0, slider = 0.0..=0.1, unit = "1")]
    pub drop: f64,
    /// Which falls count.
    #[param(flatten)]
    pub falls: Falls,
}

/// Inputs of [`ProfileRecognition`].
#[derive(Inputs)]
pub struct ProfileRecognitionIn<'a> {
    /// Terrain to look at.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`ProfileRecognition`].
#[derive(Outputs)]
pub struct ProfileRecognitionOut {
    /// Working cells that may lie on a line, on the grid of the terrain.
    pub candidates: Mask,
}

impl Node for ProfileRecognition {
    const ID: &'static str = "feature.profile_recognition";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ProfileRecognitionIn<'a>;
    type Outputs = ProfileRecognitionOut;

    fn cost(&self) -> f64 {
        4.0
    }

    fn run(&self, inputs: ProfileRecognitionIn<'_>, job: &Job) -> Result<ProfileRecognitionOut> {
        let grid = inputs.terrain.grid();
        let blocks = Blocks::square(grid.cell, self.cells.working_cell as usize);
        let relief = Relief::new(inputs.terrain, self.cells.kind.into(), blocks, self.profiles.sigma, job)?;
        let falls = relief.falls(self.profiles.half_profile as usize, self.falls.sided, job)?;
        let marked = relief.candidates(&falls, self.drop, self.falls.floor);
        if !marked.contains(&true) {
            job.warn("no cell stands out: lower `drop` or `working_cell`");
        }
        let cols = relief.lattice.cols;
        let candidates = Mask::build(grid.clone(), job, |row, out| {
            let marked = &marked[row / blocks.down * cols..][..cols];
            for (col, out) in out.iter_mut().enumerate() {
                *out = f32::from(u8::from(marked[col / blocks.across]));
            }
            Ok(())
        })?;
        Ok(ProfileRecognitionOut { candidates })
    }
}

/// Mean heights of the working cells, turned so that the lines sought are crests.
#[derive(Clone, Debug)]
pub struct Relief {
    /// The working grid.
    pub lattice: Lattice,
    /// Height of each working cell, negative for valleys; NaN where unknown.
    pub crests: Vec<f32>,
    /// Lowest and highest of them.
    pub range: (f64, f64),
    /// How many are known.
    pub known: usize,
}

impl Relief {
    /// The relief of a terrain; `sigma` smooths it, in working cells.
    ///
    /// # Errors
    /// As [`block_means`].
    pub fn new(
        terrain: &Heightfield,
        kind: FeatureKind,
        blocks: Blocks,
        sigma: f64,
        job: &Job,
    ) -> Result<Self> {
        let mut means = block_means(terrain, blocks, job)?;
        if sigma > 0.0 {
            means = blur(&means, sigma, job)?;
        }
        let lattice = blocks.lattice(terrain.grid());
        let known = means.cells().len() - means.void_count();
        let range = match (means.range(), kind == FeatureKind::Ridge) {
            (Some((low, high)), true) => (f64::from(low), f64::from(high)),
            (Some((low, high)), false) => (-f64::from(high), -f64::from(low)),
            (None, _) => (0.0, 0.0),
        };
        let mut crests = means.into_cells();
        crests.iter_mut().for_each(|height| *height = crest(*height, kind));
        Ok(Self { lattice, crests, range, known })
    }

    /// How far the profiles of each working cell fall at best: from the sample that falls furthest on each half,
    /// the lesser of the two halves (or the greater, for any one side), over the axis where that is most.
    ///
    /// A cell is a candidate for exactly the drops below this. Negative infinity where no profile has the samples.
    ///
    /// # Errors
    /// [`Error::TooLarge`] and [`Error::Cancelled`].
    pub fn falls(&self, half_profile: usize, sided: Sided, job: &Job) -> Result<Vec<f32>> {
        let Self { lattice, crests, .. } = self;
        let grid = Grid::new(lattice.rows, lattice.cols, CellSize::square(1.0))?;
        let falls = Heightfield::build(grid, job, |row, out| {
            let lows = STEPS.map(|step| self.lowest(row, step, half_profile));
            for (col, out) in out.iter_mut().enumerate() {
                let crest = crests[row * lattice.cols + col];
                let axis = |direction: usize| {
                    let half = |direction: usize| crest - lows[direction][col];
                    let (a, b) = (half(direction), half(direction + 4));
                    if sided == Sided::TwoSided { a.min(b) } else { a.max(b) }
                };
                // A void's falls are NaN, which the maximum passes over.
                *out = (0..4).map(axis).fold(f32::NEG_INFINITY, f32::max);
            }
            Ok(())
        })?;
        Ok(falls.into_cells())
    }

    /// For each cell of a row the lowest of the `n` samples in a direction; infinite where there is none. Whole rows
    /// at a time, which the processor does many cells at once.
    fn lowest(&self, row: usize, (down, across): (i32, i32), n: usize) -> Vec<f32> {
        let Lattice { rows, cols } = self.lattice;
        let mut lows = vec![f32::INFINITY; cols];
        for n in 1..=n {
            let shift = n.min(cols);
            let Some(row) = row.checked_add_signed(down as isize * n as isize).filter(|row| *row < rows)
            else {
                break;
            };
            let samples = &self.crests[row * cols..(row + 1) * cols];
            let (lows, samples) = match across {
                0 => (&mut lows[..], samples),
                1 => (&mut lows[..cols - shift], &samples[shift..]),
                _ => (&mut lows[shift..], &samples[..cols - shift]),
            };
            // The minimum passes over voids.
            lows.iter_mut().zip(samples).for_each(|(low, sample)| *low = low.min(*sample));
        }
        lows
    }

    /// Which working cells fall by more than `drop` of the range and lie no lower than `floor` of it.
    #[must_use]
    pub fn candidates(&self, falls: &[f32], drop: f64, floor: f64) -> Vec<bool> {
        let (low, high) = self.range;
        let (least, lowest) = (drop * (high - low), low + floor * (high - low));
        let high_enough = |crest: f32| floor <= 0.0 || f64::from(crest) >= lowest;
        falls
            .iter()
            .zip(&self.crests)
            .map(|(&fall, &crest)| f64::from(fall) > least && high_enough(crest))
            .collect()
    }
}
