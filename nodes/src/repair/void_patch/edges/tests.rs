use orograph_core::gaussian;

use super::*;
use crate::{repair::void_patch::*, test_fields::field};

/// Cells from one edge of a tile to the other, and how far the ground around reaches.
const STEP: usize = 100;
const MARGIN: usize = 40;
/// Four tiles, which share edges.
const TILES: [[usize; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];

/// Hills of all sizes.
fn height(row: usize, col: usize) -> f64 {
    let wave = |length: f64, turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        length * libm::sin((row as f64 * sin + col as f64 * cos) / length + turn)
    };
    let rough = 2.0 * gaussian(1, 1, row as i64, col as i64);
    900.0 + wave(31.0, 0.4) + wave(17.0, 1.3) + wave(9.0, 2.2) + wave(5.0, 2.9) + rough
}

/// Voids across each of the inner edges, across the middle, along an edge, and away from all.
fn is_void(row: usize, col: usize) -> bool {
    let within = |at: [f64; 2], radius: f64| libm::hypot(row as f64 - at[0], col as f64 - at[1]) < radius;
    let [row_is, col_is] = [row, col].map(|at| at == STEP);
    within([100.0, 100.0], 14.0)
        || within([97.0, 40.0], 12.0)
        || within([160.0, 103.0], 17.0)
        || within([99.5, 170.0], 9.0)
        || row_is && (10..20).contains(&col)
        || col_is && (20..40).contains(&row)
        || within([45.0, 50.0], 11.0)
}

fn whole(is_void: impl Fn(usize, usize) -> bool) -> Heightfield {
    let n = 2 * STEP + 1;
    field(n, n, |row, col| if is_void(row, col) { f64::NAN } else { height(row, col) })
}

/// A tile, and with the ground of the others as far as `margin` around.
fn cut(whole: &Heightfield, [row, col]: [usize; 2], margin: usize) -> Heightfield {
    let part = |at: usize| {
        let first = (at * STEP).saturating_sub(margin);
        (first, (at * STEP + STEP + 1 + margin).min(2 * STEP + 1) - first)
    };
    let ((row, rows), (col, cols)) = (part(row), part(col));
    whole.crop(row, col, rows, cols, &Job::detached()).unwrap()
}

fn patched(node: &VoidPatch, terrain: &Heightfield, around: Option<&Heightfield>) -> Heightfield {
    node.run(VoidPatchIn { terrain, around }, &Job::detached()).unwrap().terrain
}

/// The four tiles, each patched by itself with the ground around.
fn all(node: &VoidPatch, whole: &Heightfield) -> [Heightfield; 4] {
    TILES.map(|tile| patched(node, &cut(whole, tile, 0), Some(&cut(whole, tile, MARGIN))))
}

/// Root mean square error over voids.
fn error(tiles: &[Heightfield]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for tile in tiles {
        for i in 0..tile.cells().len() {
            let (row, col) = tile.grid().base(i / tile.cols(), i % tile.cols());
            let (row, col) = (row as usize, col as usize);
            if is_void(row, col) {
                let off = f64::from(tile.cells()[i]) - height(row, col);
                (sum, n) = (sum + off * off, n + 1.0);
            }
        }
    }
    libm::sqrt(sum / n)
}

#[test]
fn tiles_share_what_they_fill_to_the_bit() {
    let terrain = whole(is_void);
    for kind in [Kind::Area, Kind::None] {
        let node = VoidPatch { details: kind, ..VoidPatch::default() };
        let [nw, ne, sw, se] = all(&node, &terrain);
        let same = |a: f32, b: f32| assert_eq!(a.to_bits(), b.to_bits(), "{kind:?}: {a} {b}");
        for i in 0..=STEP {
            same(nw.at(i, STEP), ne.at(i, 0));
            same(sw.at(i, STEP), se.at(i, 0));
            same(nw.at(STEP, i), sw.at(0, i));
            same(ne.at(STEP, i), se.at(0, i));
        }
        for tile in [nw, ne, sw, se] {
            assert_eq!(tile.void_count(), 0);
            for i in 0..tile.cells().len() {
                let (row, col) = tile.grid().base(i / tile.cols(), i % tile.cols());
                let known = terrain.at(row as usize, col as usize);
                assert!(known.is_nan() || known.to_bits() == tile.cells()[i].to_bits());
            }
        }
    }
}

#[test]
fn tiles_are_as_near_to_the_truth_as_the_whole_and_nearer_than_alone() {
    let terrain = whole(is_void);
    let node = VoidPatch { details: Kind::None, ..VoidPatch::default() };
    let together = error(&all(&node, &terrain));
    let alone = error(&TILES.map(|tile| patched(&node, &cut(&terrain, tile, 0), None)));
    let at_once = patched(&node, &terrain, None);
    let at_once = error(&TILES.map(|tile| cut(&at_once, tile, 0)));
    assert!(together < 1.01 * at_once, "{together} {at_once}");
    assert!(together < 0.8 * alone, "{together} {alone}");
}

#[test]
fn what_crosses_an_edge_has_no_step_there() {
    // Rows that cross an edge are as rough there as the whole patched at once.
    let terrain = whole(is_void);
    let node = VoidPatch::default();
    let [nw, ne, ..] = all(&node, &terrain);
    let at_once = patched(&node, &terrain, None);
    let (mut joined, mut whole) = (0.0, 0.0);
    for row in 90..=STEP {
        let bend = |west: f32, middle: f32, east: f32| libm::pow(f64::from(west - 2.0 * middle + east), 2.0);
        joined += bend(nw.at(row, STEP - 1), nw.at(row, STEP), ne.at(row, 1));
        whole += bend(at_once.at(row, STEP - 1), at_once.at(row, STEP), at_once.at(row, STEP + 1));
    }
    assert!(joined < 2.0 * whole, "{joined} {whole}");
}

#[test]
fn a_missing_neighbour_costs_the_others_nothing() {
    // Without the south-eastern tile: what the others share they still fill alike, but for the corner itself.
    let terrain = whole(|row, col| is_void(row, col) || row > STEP && col > STEP);
    let node = VoidPatch::default();
    let around = |tile| patched(&node, &cut(&terrain, tile, 0), Some(&cut(&terrain, tile, MARGIN)));
    let nw = around([0, 0]);
    // These two have a neighbour on one side alone.
    let ne = patched(
        &node,
        &cut(&terrain, [0, 1], 0),
        Some(&terrain.crop(0, 60, 101, 141, &Job::detached()).unwrap()),
    );
    let sw = patched(
        &node,
        &cut(&terrain, [1, 0], 0),
        Some(&terrain.crop(60, 0, 141, 101, &Job::detached()).unwrap()),
    );
    for i in 0..STEP {
        assert_eq!(nw.at(i, STEP).to_bits(), ne.at(i, 0).to_bits(), "row {i}");
        assert_eq!(nw.at(STEP, i).to_bits(), sw.at(0, i).to_bits(), "column {i}");
    }
}

#[test]
fn without_ground_around_nothing_changes() {
    let terrain = cut(&whole(is_void), [0, 0], 0);
    let node = VoidPatch::default();
    let inputs = VoidPatchIn { terrain: &terrain, around: Some(&terrain) };
    let with = node.run(inputs, &Job::detached()).unwrap();
    let without = node.run(VoidPatchIn { terrain: &terrain, around: None }, &Job::detached()).unwrap();
    assert_eq!(with.terrain.cells(), without.terrain.cells());
    assert_eq!(with.report, without.report);
    let full = cut(&whole(|_, _| false), [0, 0], 0);
    assert_eq!(patched(&node, &full, Some(&whole(is_void))).cells(), full.cells());
}

#[test]
fn reports_tell_of_the_tile() {
    let terrain = whole(is_void);
    let inputs =
        VoidPatchIn { terrain: &cut(&terrain, [0, 1], 0), around: Some(&cut(&terrain, [0, 1], MARGIN)) };
    let report = VoidPatch::default().run(inputs, &Job::detached()).unwrap().report;
    let column = |name: &str| match &report.column(name).unwrap().cells {
        orograph_core::Cells::Numbers(numbers) => numbers.clone(),
        orograph_core::Cells::Texts(_) => panic!("{name}"),
    };
    // One across the middle, one on the southern edge, and the line on the western edge; the others lie beyond.
    assert_eq!(column("cells").len(), 3);
    assert!(column("col").iter().zip(column("cols")).all(|(col, cols)| col + cols > 0.0 && *col < 101.0));
}

#[test]
fn ground_from_elsewhere_is_refused() {
    let terrain = whole(is_void);
    let tile = cut(&terrain, [1, 1], 0);
    for around in [
        &cut(&terrain, [0, 0], MARGIN),
        &cut(&terrain, [1, 1], 0).crop(1, 1, 9, 9, &Job::detached()).unwrap(),
    ] {
        let inputs = VoidPatchIn { terrain: &tile, around: Some(around) };
        assert!(matches!(VoidPatch::default().run(inputs, &Job::detached()), Err(Error::Invalid { .. })));
    }
    let nothing = field(0, 0, |_, _| 0.0);
    assert_eq!(patched(&VoidPatch::default(), &nothing, Some(&terrain)).cells().len(), 0);
}
