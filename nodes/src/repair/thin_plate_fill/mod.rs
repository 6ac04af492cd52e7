//! Thin-plate fill: the surface that bends least through what is known.
//!
//! The discrete biharmonic equation with free edges, which is what minimum-curvature gridding solves (Briggs, I. C. (1974),
//! "Machine contouring using minimum curvature", Geophysics 39), with tension, which keeps wide plates from overshooting
//! (Smith, W. H. F. and Wessel, P. (1990), "Gridding with continuous curvature splines in tension", Geophysics 55). The
//! default tension did best over 210 holes of 24 to 200 cells in seven mountain terrains, with cells of 30 m as with cells of
//! 90 m. Multilevel: conjugate gradients, preconditioned by B-splines of doubling size, from a guess of means of doubling
//! size.

mod bending;
mod levels;
mod solve;
mod start;

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::voids::{self, Void};

/// How stiff a plate is.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Distance over which slopes go on from the rim; farther in, the plate hangs like a membrane and does not overshoot.
    #[param(default = 700, range = 1.0..=1_000_000_000.0, slider = 100.0..=10_000.0, unit = "m")]
    pub stiffness: f64,
}

/// Fills voids with the surface that bends least, or builds a terrain through scattered samples.
///
/// Slopes go on from the rim into the void, so that, unlike `repair.harmonic_fill`, filled ground may rise above and fall
/// below its rim. Every known height is kept to the bit. Between scattered samples it is the classical reconstruction by
/// minimum curvature, smoother than the ground was. What nothing known surrounds stays void, with a remark.
#[derive(Params, Clone, Debug)]
pub struct ThinPlateFill {
    /// How stiff the plate is.
    #[param(flatten)]
    pub stiff: Stiffness,
}

/// Inputs of [`ThinPlateFill`].
#[derive(Inputs)]
pub struct ThinPlateFillIn<'a> {
    /// Terrain with voids, or scattered samples.
    pub terrain: &'a Heightfield,
    /// Cells to fill, where at least one half; the terrain's own voids when unconnected.
    pub holes: Option<&'a Mask>,
}

/// Outputs of [`ThinPlateFill`].
#[derive(Outputs)]
pub struct ThinPlateFillOut {
    /// Terrain with its voids filled.
    pub terrain: Heightfield,
}

impl Node for ThinPlateFill {
    const ID: &'static str = "repair.thin_plate_fill";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ThinPlateFillIn<'a>;
    type Outputs = ThinPlateFillOut;

    fn cost(&self) -> f64 {
        300.0
    }

    fn run(&self, inputs: ThinPlateFillIn<'_>, job: &Job) -> Result<ThinPlateFillOut> {
        if let Some(holes) = inputs.holes {
            inputs.terrain.grid().match_size("terrain", holes.grid(), "holes")?;
        }
        Ok(ThinPlateFillOut { terrain: thin_plate_fill(inputs.terrain, inputs.holes, self.stiff, job)? })
    }
}

/// Differences of the plate reach this far, so that voids no farther apart are solved as one.
const REACH: usize = 2;

/// Fills `holes` (or the voids) of `terrain`. Voids outside `holes` stay, and bend with the plate as if they were filled.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::NonFinite`], [`Error::Cancelled`].
pub fn thin_plate_fill(
    terrain: &Heightfield,
    holes: Option<&Mask>,
    stiff: Stiffness,
    job: &Job<'_>,
) -> Result<Heightfield> {
    let mut out = terrain.map(job, |height| height)?;
    let size = terrain.grid().size();
    let cells = terrain.cells();
    if let Some(at) = cells.iter().position(|height| height.is_infinite()) {
        return Err(Error::NonFinite { what: "terrain".into(), row: at / size.1, col: at % size.1 });
    }
    let is_hole = |i: usize| holes.is_none_or(|holes| holes.cells()[i] >= 0.5);
    let is_free = |i: usize| cells[i].is_nan() || holes.is_some() && is_hole(i);
    let plates = voids::find(size, REACH, is_free, job)?;
    let windows: Vec<Window> = plates.iter().map(|void| Window::around(void, size)).collect();
    let largest = windows.iter().map(Window::len).max().unwrap_or(0) as u64;
    job.admit(largest * solve::BYTES, || format!("the plate over {largest} cells"))?;
    let n = plates.iter().map(|void| void.cells.len() as u64).sum();
    let done = job.stage(n);
    let solved: Vec<Option<Vec<f32>>> = plates
        .par_iter()
        .zip(&windows)
        .map(|(void, window)| {
            let (all, mut told) = (void.cells.len() as f64, 0);
            let mut tell = |share: f64| {
                // A plate may lose digits when it is corrected.
                let now = (all * share.clamp(0.0, 1.0)) as u64;
                done.advance(now.saturating_sub(told));
                told = told.max(now);
            };
            let filled = window.fill(terrain, void, stiff, job, &mut tell)?;
            tell(1.0);
            Ok(filled)
        })
        .collect::<Result<_>>()?;
    let mut lonely = 0;
    for (void, heights) in plates.iter().zip(solved) {
        let Some(heights) = heights else {
            lonely += 1;
            continue;
        };
        for (&i, height) in void.cells.iter().zip(heights).filter(|(i, _)| is_hole(**i)) {
            out.cells_mut()[i] = height;
        }
    }
    if lonely > 0 {
        job.warn(format!("{lonely} voids have no known cell beside them and stay void"));
    }
    Ok(out)
}

/// The part of the raster that a plate needs: its free cells and the known ones that bend it.
struct Window {
    first: [usize; 2],
    size: (usize, usize),
}

impl Window {
    fn around(void: &Void, size: (usize, usize)) -> Self {
        let first = void.first.map(|first| first.saturating_sub(REACH));
        let end = |axis: usize, n: usize| (void.last[axis] + REACH + 1).min(n);
        Self { first, size: (end(0, size.0) - first[0], end(1, size.1) - first[1]) }
    }

    fn len(&self) -> usize {
        self.size.0 * self.size.1
    }

    /// Heights for the void's cells; `None` where nothing known lies in the window.
    fn fill(
        &self,
        terrain: &Heightfield,
        void: &Void,
        stiff: Stiffness,
        job: &Job<'_>,
        tell: impl FnMut(f64),
    ) -> Result<Option<Vec<f32>>> {
        let cols = terrain.cols();
        let local = |i: usize| (i / cols - self.first[0]) * self.size.1 + i % cols - self.first[1];
        let mut free = vec![false; self.len()];
        void.cells.iter().for_each(|&i| free[local(i)] = true);
        // Cells of other plates are too far away to matter, whatever they hold.
        let (mut sum, mut n) = (0.0, 0.0);
        let mut heights = vec![0.0; self.len()];
        for (i, value) in heights.iter_mut().enumerate().filter(|(i, _)| !free[*i]) {
            let height = terrain.at(self.first[0] + i / self.size.1, self.first[1] + i % self.size.1);
            if !height.is_nan() {
                *value = f64::from(height);
                (sum, n) = (sum + *value, n + 1.0);
            }
        }
        if n == 0.0 {
            return Ok(None);
        }
        // Heights about their mean: rounding is relative to the relief.
        let mean = sum / n;
        heights.iter_mut().for_each(|height| *height -= mean);
        let (cell, stiff) = (terrain.grid().cell, stiff.stiffness);
        let surface = solve::solve(&heights, &free, self.size, cell, stiff, job, tell)?;
        Ok(Some(void.cells.iter().map(|&i| (mean + surface[local(i)]) as f32).collect()))
    }
}

#[cfg(test)]
mod tests;
