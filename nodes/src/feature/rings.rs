//! Rings: the ends that polygon breaking left facing each other.

use orograph_core::{Features, PointKind};

use super::{chains::distance, lattice::Blocks, settings::Shaping};

/// The cosine of the angle that the directions of two ends must differ by, 120°.
const FACING: f64 = -0.5;

/// Pairs of ends nearer than the ring gap whose lines lead away from each other: nearest first, each end once.
pub(crate) fn close(features: &Features, blocks: Blocks, shaping: &Shaping) -> Vec<[u32; 2]> {
    // Ends in working cells, by row, so that only the next few rows need be looked through.
    let mut ends: Vec<([f64; 2], [f64; 2], u32)> = headings(features, shaping.heading)
        .into_iter()
        .enumerate()
        .filter_map(|(i, heading)| {
            let point = &features.points[i];
            let at = [point.row / blocks.down as f64, point.col / blocks.across as f64];
            Some((at, heading?, i as u32))
        })
        .collect();
    ends.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]).then(a.2.cmp(&b.2)));
    let mut pairs: Vec<(f64, u32, u32)> = Vec::new();
    for (i, (at, from, a)) in ends.iter().enumerate() {
        let below = ends[i + 1..].iter().take_while(|end| end.0[0] - at[0] < shaping.ring_gap);
        for (other, to, b) in below {
            let gap = distance(*at, *other);
            if gap < shaping.ring_gap && from[0] * to[0] + from[1] * to[1] <= FACING {
                pairs.push((gap, *a.min(b), *a.max(b)));
            }
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut taken = vec![false; features.points.len()];
    let mut rings = Vec::new();
    for (_, a, b) in pairs {
        if !taken[a as usize] && !taken[b as usize] {
            (taken[a as usize], taken[b as usize]) = (true, true);
            rings.push([a, b]);
        }
    }
    rings
}

/// For each end the direction in which its line leaves it; nothing for other points.
pub(crate) fn headings(features: &Features, length: f64) -> Vec<Option<[f64; 2]>> {
    let mut headings = vec![None; features.points.len()];
    let is_end = |id: u32| features.points[id as usize].kind == PointKind::End;
    for line in &features.lines {
        if is_end(line.from) {
            headings[line.from as usize] = heading(line.vertices.iter().copied(), length);
        }
        if is_end(line.to) {
            headings[line.to as usize] = heading(line.vertices.iter().rev().copied(), length);
        }
    }
    headings
}

/// Unit vector from the start of a path to the place `length` along it, or to its end if that comes first.
fn heading(mut path: impl Iterator<Item = [f64; 2]>, length: f64) -> Option<[f64; 2]> {
    let start = path.next()?;
    let (mut at, mut left) = (start, length);
    for next in path {
        let step = distance(at, next);
        if step >= left {
            let share = if step > 0.0 { left / step } else { 0.0 };
            at = [0, 1].map(|k| at[k] + (next[k] - at[k]) * share);
            break;
        }
        left -= step;
        at = next;
    }
    let far = distance(start, at);
    (far > 0.0).then(|| [0, 1].map(|k| (at[k] - start[k]) / far))
}
