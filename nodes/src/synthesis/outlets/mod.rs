//! Closed depressions that real ground does not have are given an outlet, or made as shallow as real ones.
//!
//! Patches know nothing of where water runs: where they meet, basins of hundreds of metres come about (Scott, J. and
//! Dodgson, N. (2021), "Example-based terrain synthesis with pit removal", Computers & Graphics 99, find the same).
//! Such a basin rises by part of its depth, all of it under its spill level, as if it had silted up. From its lowest places
//! ways then lead over the lowest saddles to lower ground, as water would overflow; saddles are cut down, and the ground
//! beside follows without kinks. What is still deep after that silts up altogether.

mod usual;
mod ways;

use orograph_core::prelude::*;

pub(super) use usual::usual_depth;
use ways::Ways;

use super::{canvas::Canvas, network::Network};
use crate::{
    adjust::elevation_constraints::{ElevationConstraints, Fit, Shape, constrain},
    measure::drainage::{
        flood::{Flood, around, flood_along_lows},
        pits::{Depression, each_depression},
    },
};

/// The share of its depth that a basin keeps as it silts up; saddles are cut by the rest.
const KEPT: f64 = 0.8;

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opened {
    /// Depressions that were given an outlet.
    pub opened: usize,
    /// Deep ones that are left, as drawn ridges or given ground enclose them.
    pub left: usize,
    /// The farthest that a cell moved, in metres.
    pub most: f64,
}

/// Makes every closed depression shallower than `limit` metres, but where ridges of the `networks` or given ground enclose
/// it; ground sinks within `reach` cells of the ways out, and rises within depressions. Those along drawn valleys stay:
/// which way these are to fall is not drawn.
///
/// # Errors
/// Refusal of the memory, and cancellation.
pub(super) fn open(
    canvas: &mut Canvas,
    networks: &[Network],
    limit: f64,
    reach: f64,
    job: &Job<'_>,
) -> Result<Opened> {
    let (rows, cols) = canvas.size;
    let mut terrain =
        Heightfield::new(Grid::new(rows, cols, CellSize::square(1.0))?, std::mem::take(&mut canvas.heights))?;
    let (low, high) = terrain.range().unwrap_or_default();
    // Twice the range above ground no basin without a wall is as deep as any within.
    let wall = 2.0 * (high - low) + 1.0;
    // A cell to either side leaves no gap at corners.
    let mut walls = near(networks, FeatureKind::Ridge, 1, canvas.size);
    walls.iter_mut().enumerate().for_each(|(cell, wall)| *wall |= canvas.is_frozen(cell));
    let drawn = near(networks, FeatureKind::Valley, (reach / 5.0) as usize, canvas.size);
    let stays = |cell: usize| drawn[cell] || walls[cell];
    let before = terrain.clone();
    // What walls enclose has its outlet at its bottom, and so has what is enclosed within that.
    let mut sinks = Vec::new();
    let (walled, flooded) = loop {
        let walled = raised(&terrain, &walls, wall);
        let flooded = flood_along_lows(&walled, |cell| sinks.binary_search(&cell).is_ok(), job)?;
        let found = enclosed(&walled, &flooded, wall, job)?;
        if found.is_empty() {
            break (walled, flooded);
        }
        sinks.extend(found);
        sinks.sort_unstable();
    };
    let mut done = Opened { left: sinks.len(), ..Opened::default() };
    let is_low = |&cell: &usize| {
        let height = |cell: usize| walled.cells()[cell];
        around(canvas.size, cell).all(|(_, other)| height(other).total_cmp(&height(cell)).is_ge())
    };
    let mut lows = Vec::new();
    squeeze(&mut terrain, &walled, &flooded, KEPT, limit, job, |found| {
        let is_deep = found.depth > limit && !stays(found.bottom);
        if is_deep {
            done.opened += 1;
            lows.extend(found.cells.iter().copied().filter(is_low));
        }
        is_deep
    })?;
    if done.opened > 0 {
        let settings = ElevationConstraints {
            shape: Shape::Smooth,
            influence: reach,
            fit: Fit::Exact,
            ..ElevationConstraints::default()
        };
        drop(walled);
        let ways = Ways::from(lows, limit, &raised(&terrain, &walls, wall), &flooded, job)?;
        drop(flooded);
        let ridges = near(networks, FeatureKind::Ridge, 0, canvas.size);
        let bent = constrain(&terrain, &ways.falling(&terrain, &ridges)?, &settings, job)?;
        for (cell, (height, &bent)) in terrain.cells_mut().iter_mut().zip(bent.cells()).enumerate() {
            if !canvas.is_frozen(cell) {
                *height = bent;
            }
        }
        let walled = raised(&terrain, &walls, wall);
        let flooded = flood_along_lows(&walled, |cell| sinks.binary_search(&cell).is_ok(), job)?;
        squeeze(&mut terrain, &walled, &flooded, 0.0, limit, job, |found| {
            found.depth > limit && !stays(found.bottom)
        })?;
    }
    let moved = before.cells().iter().zip(terrain.cells()).map(|(a, b)| f64::from((a - b).abs()));
    done.most = moved.fold(0.0, f64::max);
    canvas.heights = terrain.into_cells();
    Ok(done)
}

/// The terrain with walls that many metres high.
fn raised(terrain: &Heightfield, walls: &[bool], wall: f32) -> Heightfield {
    let mut walled = terrain.clone();
    let cells = walled.cells_mut().iter_mut().zip(walls).filter(|(_, is_wall)| **is_wall);
    cells.for_each(|(height, _)| *height += wall);
    walled
}

/// Makes the depressions that are `asked` for as deep as the share `kept` of their depth, or as `limit` metres where that is
/// more: hardly anything moves at their shores, nothing beyond, and what is lower stays lower.
fn squeeze(
    terrain: &mut Heightfield,
    walled: &Heightfield,
    flooded: &Flood,
    kept: f64,
    limit: f64,
    job: &Job<'_>,
    mut asked: impl FnMut(&Depression<'_>) -> bool,
) -> Result<()> {
    let heights = terrain.cells_mut();
    each_depression(walled, &flooded.filled, job, |found| {
        if asked(&found) {
            let (level, least) = (f64::from(found.level), (kept * found.depth).max(limit));
            let squeezed = |depth: f64| depth / (1.0 + depth * (1.0 / least - 1.0 / found.depth));
            for &cell in found.cells {
                let depth = level - f64::from(walled.cells()[cell]);
                heights[cell] = (f64::from(heights[cell]) + depth - squeezed(depth)) as f32;
            }
        }
    })
}

/// Cells within `reach` cells, along rows and columns, of the lines of a kind.
fn near(networks: &[Network], kind: FeatureKind, reach: usize, (rows, cols): (usize, usize)) -> Vec<bool> {
    let mut near = vec![false; rows * cols];
    let mut mark = |from: [f64; 2], to: [f64; 2]| {
        let steps = (2.0 * libm::hypot(to[0] - from[0], to[1] - from[1])).ceil().max(1.0);
        for i in 0..=steps as usize {
            let part = i as f64 / steps;
            let span = |axis: usize, n: usize| {
                let at = from[axis] + part * (to[axis] - from[axis]);
                let at = ((at + 0.5).max(0.0) as usize).min(n.saturating_sub(1));
                at.saturating_sub(reach)..(at + reach + 1).min(n)
            };
            for row in span(0, rows) {
                near[row * cols..][span(1, cols)].fill(true);
            }
        }
    };
    for network in networks.iter().filter(|network| network.kind == kind) {
        for chain in &network.chains {
            chain.track.windows(2).for_each(|pair| mark(pair[0], pair[1]));
        }
        // Rings are open at one place; as drawn they are closed.
        network.rings.iter().for_each(|&[a, b]| mark(network.knots[a].at, network.knots[b].at));
    }
    near
}

/// The bottoms of what walls of that height enclose.
fn enclosed(walled: &Heightfield, flooded: &Flood, wall: f32, job: &Job<'_>) -> Result<Vec<usize>> {
    let mut found = Vec::new();
    each_depression(walled, &flooded.filled, job, |Depression { bottom, depth, .. }| {
        if depth > f64::from(wall) / 2.0 {
            found.push(bottom);
        }
    })?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::drainage::{flood::flood, pits::Pits},
        synthesis::network::{Chain, Knot},
        test_fields::field,
    };

    const SIDE: usize = 120;
    const REACH: f64 = 20.0;

    fn canvas(height: impl Fn(f64, f64) -> f64) -> Canvas {
        let mut canvas = Canvas::new((SIDE, SIDE), &Job::detached()).unwrap();
        canvas.lay(&field(SIDE, SIDE, |row, col| height(row as f64, col as f64)));
        canvas
    }

    /// Ground that falls to the south by a metre a cell, with a bowl 60 m deep in its middle.
    fn bowl(row: f64, col: f64) -> f64 {
        let square = (row - 60.0) * (row - 60.0) + (col - 60.0) * (col - 60.0);
        300.0 - row - 60.0 * (1.0 - square / 400.0).max(0.0)
    }

    fn line(kind: FeatureKind, track: Vec<[f64; 2]>) -> Network {
        let mut along = vec![0.0];
        for pair in track.windows(2) {
            along
                .push(along[along.len() - 1] + libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]));
        }
        Network {
            kind,
            knots: Vec::new(),
            chains: vec![Chain { ends: [0, 1], track, along }],
            rings: Vec::new(),
        }
    }

    /// A ring as planning has it: open at one place, and its ends are known to belong together.
    fn ring(kind: FeatureKind, radius: f64) -> Network {
        let at = |i: usize| {
            let turn = i as f64 / 60.0 * std::f64::consts::TAU;
            [60.0 + radius * libm::sin(turn), 60.0 + radius * libm::cos(turn)]
        };
        let knot = |i: usize| Knot { at: at(i), height: 0.0, chains: Vec::new() };
        // The gap is to the south, where the bowl is lowest.
        Network {
            knots: vec![knot(17), knot(13)],
            rings: vec![[0, 1]],
            ..line(kind, (17..=73).map(at).collect())
        }
    }

    fn deepest(canvas: &Canvas) -> f64 {
        let (terrain, job) =
            (field(SIDE, SIDE, |row, col| canvas.heights[row * SIDE + col].into()), Job::detached());
        Pits::of(&terrain, &flood(&terrain, &job).unwrap().filled, 0.0, &job).unwrap().deepest
    }

    fn opened(canvas: &mut Canvas, networks: &[Network], limit: f64) -> Opened {
        open(canvas, networks, limit, REACH, &Job::detached()).unwrap()
    }

    #[test]
    fn a_basin_rises_its_lowest_saddle_sinks_and_what_is_far_stays() {
        let (before, mut canvas) = (canvas(bowl), canvas(bowl));
        let depth = deepest(&before);
        let done = opened(&mut canvas, &[], 5.0);
        assert!(depth > 35.0 && deepest(&canvas) <= 5.001 && done.opened == 1 && done.left == 0, "{done:?}");
        let change = |i: usize| f64::from(canvas.heights[i] - before.heights[i]);
        // The bowl is 40 cells wide; its saddle is to the south, and ground sinks within 20 cells of the way out.
        let far = |i: usize| i / SIDE < 40 || i / SIDE < 58 && !(38..=82).contains(&(i % SIDE));
        assert!((0..SIDE * SIDE).filter(|&i| far(i)).all(|i| change(i) == 0.0));
        let changes = (0..SIDE * SIDE).map(change);
        let (rise, sink) = changes.fold((0.0_f64, 0.0_f64), |(up, down), by| (up.max(by), down.min(by)));
        assert!(
            (0.15..0.3).contains(&(rise / depth)) && (0.6..0.85).contains(&(-sink / depth)),
            "{rise} {sink} {depth}"
        );
        assert!(done.most < 0.85 * depth);
    }

    #[test]
    fn squeezed_depressions_keep_their_shores_and_their_order() {
        let terrain = field(SIDE, SIDE, |row, col| bowl(row as f64, col as f64));
        let (mut squeezed, job) = (terrain.clone(), Job::detached());
        let flooded = flood(&terrain, &job).unwrap();
        squeeze(&mut squeezed, &terrain, &flooded, 0.0, 5.0, &job, |_| true).unwrap();
        let mut under: Vec<[f64; 2]> = Vec::new();
        for (i, (&own, &new)) in terrain.cells().iter().zip(squeezed.cells()).enumerate() {
            let level = flooded.filled.cells()[i];
            if own == level {
                assert_eq!(new, own);
            } else {
                under.push([own, new].map(|height| f64::from(level) - f64::from(height)));
            }
        }
        under.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(under.windows(2).all(|pair| pair[0][1] <= pair[1][1]));
        let [[first, above], [deep, kept]] = [under[0], under[under.len() - 1]];
        // A tenth of a metre below the shore hardly anything changes; the bottom is just as deep as wanted.
        assert!(first < 0.5 && above > 0.9 * first && deep > 35.0 && (kept - 5.0).abs() < 1e-3);
    }

    #[test]
    fn rough_ground_keeps_no_depression_deeper_than_wanted() {
        let mut canvas = canvas(|row, col| {
            let waves = libm::sin(row / 7.0) * libm::sin(col / 9.0) + 0.5 * libm::sin((row + col) / 3.0);
            40.0 * waves + 2.0 * orograph_core::gaussian(3, 1, row as i64, col as i64)
        });
        assert!(deepest(&canvas) > 40.0);
        let done = opened(&mut canvas, &[], 12.0);
        assert!(deepest(&canvas) <= 12.001, "{} {done:?}", deepest(&canvas));
    }

    #[test]
    fn shallow_depressions_stay_to_the_bit() {
        let mut canvas = canvas(bowl);
        let before = canvas.heights.clone();
        assert_eq!(opened(&mut canvas, &[], 50.0), Opened::default());
        assert_eq!(canvas.heights, before);
    }

    #[test]
    fn drawn_ridges_are_not_cut_and_what_they_enclose_stays_closed() {
        let mut closed = canvas(bowl);
        let before = closed.heights.clone();
        let done = opened(&mut closed, &[ring(FeatureKind::Ridge, 24.0)], 5.0);
        assert_eq!((done.opened, done.left, done.most), (0, 1, 0.0));
        assert_eq!(closed.heights, before);
        // Whatever heights are counted in.
        let mut fine = canvas(|row, col| 1e4 * bowl(row, col));
        assert_eq!(opened(&mut fine, &[ring(FeatureKind::Ridge, 24.0)], 5e4), done);
        // A ridge across the lowest saddle is gone around.
        let (mut barred, ridge) = (canvas(bowl), line(FeatureKind::Ridge, vec![[82.0, 50.0], [82.0, 70.0]]));
        let done = opened(&mut barred, &[ridge], 5.0);
        assert!(done.opened > 0 && deepest(&barred) <= 5.001);
    }

    #[test]
    fn depressions_along_drawn_valleys_and_given_ground_stay() {
        let mut drawn = canvas(bowl);
        let before = drawn.heights.clone();
        let valley = line(FeatureKind::Valley, vec![[60.0, 40.0], [60.0, 80.0]]);
        assert_eq!(opened(&mut drawn, &[valley], 5.0).opened, 0);
        assert_eq!(drawn.heights, before);
        let mut given = Canvas::new((SIDE, SIDE), &Job::detached()).unwrap();
        given.freeze(&field(SIDE, SIDE, |row, col| bowl(row as f64, col as f64)));
        let before = given.heights.clone();
        opened(&mut given, &[], 5.0);
        assert_eq!(given.heights, before);
    }
}
