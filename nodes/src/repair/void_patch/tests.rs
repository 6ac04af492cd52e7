use orograph_core::gaussian;

use super::*;
use crate::test_fields::field;

const SMOOTH: [Smooth; 3] = [Smooth::ThinPlate, Smooth::Curves, Smooth::Harmonic];
const KINDS: [Kind; 3] = [Kind::Area, Kind::Curves, Kind::None];

fn patched(node: &VoidPatch, terrain: &Heightfield) -> Heightfield {
    node.run(VoidPatchIn { terrain, around: None }, &Job::detached()).unwrap().terrain
}

/// All ways to fill.
fn ways() -> Vec<VoidPatch> {
    let mut ways = vec![VoidPatch { preset: Preset::PaperStrict, ..VoidPatch::default() }];
    for smooth in SMOOTH {
        ways.extend(KINDS.map(|details| VoidPatch { smooth, details, ..VoidPatch::default() }));
    }
    ways
}

/// A blot, a ring around an island, a corner, a notch in the border and specks.
fn is_void(row: usize, col: usize) -> bool {
    let apart = |r: f64, c: f64| libm::hypot(row as f64 - r, col as f64 - c);
    apart(40.0, 40.0) < 12.0
        || (8.0..16.0).contains(&apart(90.0, 90.0))
        || row + col < 12
        || row > 110 && (60..75).contains(&col)
        || row * 31 % 97 == 5 && col * 17 % 89 == 3
}

fn holed(of: impl Fn(usize, usize) -> f64) -> Heightfield {
    field(130, 140, |row, col| if is_void(row, col) { f64::NAN } else { of(row, col) })
}

#[test]
fn every_way_fills_everything_and_keeps_what_is_known() {
    let rough =
        |row: usize, col: usize| 500.0 + 3.0 * col as f64 + 20.0 * gaussian(1, 1, row as i64, col as i64);
    let terrain = holed(rough);
    for node in ways() {
        let out = patched(&node, &terrain);
        assert_eq!(out.void_count(), 0, "{node:?}");
        assert_eq!(out.grid(), terrain.grid());
        for (out, height) in out.cells().iter().zip(terrain.cells()) {
            assert!(height.is_nan() || out.to_bits() == height.to_bits(), "{node:?}");
        }
    }
}

#[test]
fn planes_are_continued_exactly_where_both_ends_are_known() {
    let plane = |row: usize, col: usize| 500.0 + 2.5 * col as f64 - 4.0 * row as f64;
    let terrain = holed(plane);
    // The corner and the border's notch are beyond what the flattest surface and averages can know.
    let inside = |row: usize, col: usize| row + col >= 12 && row <= 110;
    for node in ways().into_iter().filter(|node| node.preset == Preset::Default) {
        let out = patched(&node, &terrain);
        for row in 0..130 {
            for col in 0..140 {
                let error = f64::from(out.at(row, col)) - plane(row, col);
                assert!(!inside(row, col) || error.abs() < 2e-2, "{node:?}: {error} at {row}, {col}");
            }
        }
    }
}

#[test]
fn terrain_without_voids_and_voids_without_terrain_stay() {
    for node in ways() {
        let whole = field(20, 30, |row, col| (row * col) as f64);
        assert_eq!(patched(&node, &whole).cells(), whole.cells());
        assert_eq!(patched(&node, &field(20, 30, |_, _| f64::NAN)).void_count(), 600);
        assert_eq!(patched(&node, &field(0, 0, |_, _| 0.0)).cells().len(), 0);
        let speck = field(9, 9, |row, col| if row + col == 0 { 7.0 } else { f64::NAN });
        let out = patched(&node, &speck);
        assert!(out.cells().iter().all(|height| (height - 7.0).abs() < 1e-3), "{node:?}");
    }
}

#[test]
fn large_voids_can_be_left() {
    let terrain = holed(|row, col| (row + col) as f64);
    let node = VoidPatch { largest: 300, ..VoidPatch::default() };
    let out = patched(&node, &terrain);
    assert!(out.at(40, 40).is_nan() && out.at(90, 78).is_nan());
    assert!(!out.at(0, 0).is_nan());
}

#[test]
fn threads_do_not_change_a_bit() {
    let terrain = holed(|row, col| 20.0 * gaussian(1, 1, row as i64, col as i64));
    for node in ways() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| patched(&node, &terrain)).into_cells()
        };
        assert!(on(1) == on(2) && on(1) == on(8));
    }
}
