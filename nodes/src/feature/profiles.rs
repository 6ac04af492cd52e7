//! Heights across the lines of a network (Zhou et al. 2007, figure 7).

use orograph_core::prelude::*;
use rayon::prelude::*;

use crate::transform::sample::{Interpolation, sample};

/// Samples in a profile, as the paper's text has it.
pub const PROFILE_LEN: u32 = 7;

/// Takes at every vertex of every line the heights of `terrain` on [`PROFILE_LEN`] places across it, `step` cells
/// apart, from left to right as the line runs. Voids stay NaN.
///
/// # Errors
/// [`Error::DimensionMismatch`] on another grid than the features'; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn take(features: &mut Features, terrain: &Heightfield, step: f64, job: &Job) -> Result<()> {
    features.grid.match_size("features", terrain.grid(), "terrain")?;
    let vertices: usize = features.lines.iter().map(|line| line.vertices.len()).sum();
    job.admit(vertices as u64 * 4 * u64::from(PROFILE_LEN), || "profiles across lines".into())?;
    let middle = f64::from(PROFILE_LEN / 2);
    features.lines.par_iter_mut().try_for_each(|line| {
        job.check()?;
        line.profiles.clear();
        for i in 0..line.vertices.len() {
            let [row, col] = line.vertices[i];
            let [down, across] = normal(&line.vertices, i);
            line.profiles.extend((0..PROFILE_LEN).map(|k| {
                let off = (f64::from(k) - middle) * step;
                sample(terrain, row + down * off, col + across * off, Interpolation::Bilinear)
            }));
        }
        Ok(())
    })?;
    (features.profile_len, features.profile_step) = (PROFILE_LEN, step);
    Ok(())
}

/// Unit vector (rows, columns) across a path at a vertex, to the right as the path runs; zero where it has no
/// direction.
#[must_use]
pub fn normal(path: &[[f64; 2]], i: usize) -> [f64; 2] {
    let (before, after) = (path[i.saturating_sub(1)], path[(i + 1).min(path.len() - 1)]);
    let (down, across) = (after[0] - before[0], after[1] - before[1]);
    let length = (down * down + across * across).sqrt();
    if length > 0.0 { [across / length, -down / length] } else { [0.0, 0.0] }
}
