//! Medial lines: vertices moved onto the middle of the strokes that they were traced in.
//!
//! Lines of working cells lie on the middle only as nearly as those cells are wide, and end in little hooks where
//! the search ran on into a stroke's cap. The distance to the stroke's edge climbs by a cell each cell towards the
//! middle and not at all along it, so every vertex climbs until the slope gives out.

use orograph_core::{PointKind, prelude::*};

use super::{
    chains::{distance, resample, smooth},
    lattice::Blocks,
    network::unit,
    rings,
    settings::Shaping,
};
use crate::transform::sample::{Interpolation, sample};

/// Slope of the distance to the edge, in cells per cell, below which a place counts as the middle.
const STEEP: f64 = 0.7;
/// Cells climbed at a time.
const STEP: f64 = 0.25;
/// Distance from the middle over which the slope is taken, in cells.
const ARM: f64 = 1.0;

/// Moves all points and vertices to the middle of their strokes, takes hooks off the ends, smooths the lines and
/// spaces their vertices anew. Rings are found again.
///
/// `edges` is the distance in cells to the edge of the strokes, negative outside, on the features' grid.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn centre(
    features: &mut Features,
    edges: &Heightfield,
    blocks: Blocks,
    shaping: &Shaping,
    job: &Job,
) -> Result<()> {
    let Some((_, most)) = edges.range() else { return Ok(()) };
    // As far as from the edge to the middle, and as far again from outside.
    let steps = (2.0 * f64::from(most) / STEP) as usize;
    for point in &mut features.points {
        [point.row, point.col] = climb([point.row, point.col], edges, steps);
    }
    for line in &mut features.lines {
        job.check()?;
        let mut path: Vec<[f64; 2]> = line.vertices.iter().map(|&at| climb(at, edges, steps)).collect();
        let (first, last) = (path[0], path[path.len() - 1]);
        path.dedup_by(|a, b| distance(*a, *b) < STEP);
        // The ends stay where their points went, whatever lay too near to them.
        match path.len() {
            0 | 1 => path = vec![first, last],
            n => path[n - 1] = last,
        }
        for (point, at_start) in [(line.from, true), (line.to, false)] {
            let point = &mut features.points[point as usize];
            if point.kind == PointKind::End {
                [point.row, point.col] = unhook(&mut path, at_start, 2.0 * f64::from(most));
            }
        }
        smooth(&mut path, shaping.joining.smooth_passes);
        line.vertices = resample(&path, features.scale.max(1.0));
    }
    features.rings = rings::close(features, blocks, shaping);
    Ok(())
}

/// Cuts a path off at the first place, seen from its end, beyond which it never turns back within `reach`; the end
/// that is left.
fn unhook(path: &mut Vec<[f64; 2]>, at_start: bool, reach: f64) -> [f64; 2] {
    if at_start {
        path.reverse();
    }
    let (mut length, mut keep) = (0.0, path.len());
    for (i, three) in path.windows(3).enumerate().rev() {
        let [a, b, c] = [three[0], three[1], three[2]];
        length += distance(b, c);
        if length > reach {
            break;
        }
        if (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0.0 {
            keep = i + 2;
        }
    }
    path.truncate(keep);
    let end = path[path.len() - 1];
    if at_start {
        path.reverse();
    }
    end
}

/// The place uphill from one at which the slope gives out, after so many steps at most.
fn climb(start: [f64; 2], edges: &Heightfield, steps: usize) -> [f64; 2] {
    let height = |[row, col]: [f64; 2]| f64::from(sample(edges, row, col, Interpolation::Bilinear));
    let mut at = start;
    for _ in 0..steps {
        let slope = [
            (height([at[0] + ARM, at[1]]) - height([at[0] - ARM, at[1]])) / (2.0 * ARM),
            (height([at[0], at[1] + ARM]) - height([at[0], at[1] - ARM])) / (2.0 * ARM),
        ];
        // Beyond the border there is no height, and NaN climbs nowhere.
        let Some(up) = unit([0.0; 2], slope).filter(|_| distance([0.0; 2], slope) > STEEP) else { break };
        let next = [at[0] + STEP * up[0], at[1] + STEP * up[1]];
        if height(next) > height(at) {
            at = next;
        } else {
            break;
        }
    }
    at
}
