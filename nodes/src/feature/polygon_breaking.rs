//! Polygon breaking: a network made a forest.
//!
//! Chang, Song, Hsu (1998), third step. They delete, again and again, the least important segment that lies on a
//! closed polygon. What stays is the maximum spanning forest, which Kruskal's algorithm finds at once: from the most
//! important segment down, each is kept unless its ends are joined already. Importance is made a total order by the
//! segments' places, so the forest is unique.

use std::cmp::Ordering;

use orograph_core::prelude::*;
use petgraph::unionfind::UnionFind;
use rayon::prelude::*;

use super::{
    forest::{Forest, Frame, blocks_of},
    lattice::Lattice,
    settings::{Importance, crest},
    target_connection::Segment,
};

/// Deletes the least important segment of every closed polygon until none is left.
///
/// The third of the four steps of `feature.ppa`.
#[derive(Params, Clone, Debug)]
pub struct PolygonBreaking {
    /// What makes a segment important.
    #[param(default = Importance::MeanEndpoint)]
    pub importance: Importance,
}

/// Inputs of [`PolygonBreaking`].
#[derive(Inputs)]
pub struct PolygonBreakingIn<'a> {
    /// Segments between working cells, from `feature.target_connection`.
    pub segments: &'a Features,
}

/// Outputs of [`PolygonBreaking`].
#[derive(Outputs)]
pub struct PolygonBreakingOut {
    /// The same points, joined without closed polygons.
    pub forest: Features,
}

impl Node for PolygonBreaking {
    const ID: &'static str = "feature.polygon_breaking";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PolygonBreakingIn<'a>;
    type Outputs = PolygonBreakingOut;

    fn run(&self, inputs: PolygonBreakingIn<'_>, job: &Job) -> Result<PolygonBreakingOut> {
        let features = inputs.segments;
        let (network, heights) = Forest::from_features(features, job)?;
        let crests: Vec<f32> = heights.iter().map(|height| crest(*height, features.kind)).collect();
        let mut segments = Vec::with_capacity(network.segments());
        for cell in 0..network.links.len() {
            for direction in network.directions(cell).filter(|direction| *direction < 4) {
                let other = network.lattice.step(cell, direction);
                segments.push(Segment::new(&crests, cell, other, self.importance));
            }
        }
        let forest = spanning_forest(network.lattice, segments, job)?;
        let frame = Frame {
            grid: &features.grid,
            blocks: blocks_of(features)?,
            heights: &heights,
            kind: features.kind,
        };
        Ok(PolygonBreakingOut { forest: forest.to_features(&frame, job)? })
    }
}

/// Parts that segments are sorted into by importance before each part is sorted by itself, in parallel and with
/// looks at the job between.
const PARTS: usize = 1 << 12;

/// The maximum spanning forest of the segments.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn spanning_forest(lattice: Lattice, segments: Vec<Segment>, job: &Job) -> Result<Forest> {
    let (mut sorted, starts) = part(segments);
    let mut parts: Vec<&mut [Segment]> = Vec::with_capacity(PARTS);
    let mut rest = &mut sorted[..];
    for pair in starts.windows(2) {
        let (part, after) = rest.split_at_mut(pair[1] - pair[0]);
        parts.push(part);
        rest = after;
    }
    parts.into_par_iter().try_for_each(|part| {
        job.check()?;
        part.sort_unstable_by(most_important_first);
        Ok(())
    })?;
    let mut forest = Forest::new(lattice);
    let mut trees = UnionFind::<u32>::new(lattice.len());
    for (n, segment) in sorted.iter().enumerate() {
        if n.is_multiple_of(1 << 16) {
            job.check()?;
        }
        if trees.union(segment.from, segment.to) {
            segment.join(&mut forest);
        }
    }
    Ok(forest)
}

/// The segments in parts of descending importance, and where each part begins.
fn part(segments: Vec<Segment>) -> (Vec<Segment>, Vec<usize>) {
    let first = |segment: &Segment| segment.importance[0];
    let low = segments.iter().map(first).fold(f64::INFINITY, f64::min);
    let high = segments.iter().map(first).fold(f64::NEG_INFINITY, f64::max);
    let scale = if high > low { (PARTS - 1) as f64 / (high - low) } else { 0.0 };
    // Rounding is monotone, so parts never overlap in importance.
    let part_of = |segment: &Segment| ((high - first(segment)) * scale) as usize;
    let mut starts = vec![0_usize; PARTS + 1];
    for segment in &segments {
        starts[part_of(segment).min(PARTS - 1) + 1] += 1;
    }
    for i in 0..PARTS {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut sorted = segments.clone();
    for segment in segments {
        let next = &mut next[part_of(&segment).min(PARTS - 1)];
        sorted[*next] = segment;
        *next += 1;
    }
    (sorted, starts)
}

fn most_important_first(a: &Segment, b: &Segment) -> Ordering {
    let by = |i: usize| b.importance[i].total_cmp(&a.importance[i]);
    by(0).then_with(|| by(1)).then_with(|| (a.from, a.to).cmp(&(b.from, b.to)))
}
