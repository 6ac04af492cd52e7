//! Arms and placement plans.

use orograph_core::{FeaturePoint, PointKind, Polyline, key, prelude::*, unit};

use super::drawings::{LAMBDA, Stroke, TREE, circle, drawn};
use crate::feature::{
    chains::distance,
    from_sketch::{FromSketch, FromSketchIn},
    network::Network,
    plan::{Item, ItemKind, Order, Place, plan, radius},
};

fn traced(strokes: &[Stroke]) -> Features {
    let sketch = drawn(strokes, 257, 7.0);
    FromSketch::default().run(FromSketchIn { sketch: &sketch }, &Job::detached()).unwrap().features
}

fn planned(features: &Features, patch: f64, order: Order) -> Vec<Item> {
    plan(features, patch, order, &Job::detached()).unwrap()
}

/// Points and lines as given, straight.
fn features(points: &[[f64; 2]], lines: &[(u32, u32)]) -> Features {
    let degree = |i: usize| {
        lines.iter().map(|line| u32::from(line.0 as usize == i) + u32::from(line.1 as usize == i)).sum()
    };
    let kind = |degree: u32| match degree {
        1 => PointKind::End,
        2 => PointKind::Path,
        _ => PointKind::Branch,
    };
    let point = |(i, &[row, col]): (usize, &[f64; 2])| FeaturePoint {
        row,
        col,
        height: i as f32,
        kind: kind(degree(i)),
    };
    let line = |&(from, to): &(u32, u32)| {
        let (a, b) = (points[from as usize], points[to as usize]);
        let vertices = (0..=20).map(|n| [0, 1].map(|k| a[k] + (b[k] - a[k]) * f64::from(n) / 20.0)).collect();
        Polyline { from, to, vertices, profiles: Vec::new() }
    };
    Features {
        grid: Grid::new(400, 400, CellSize::square(10.0)).unwrap(),
        kind: FeatureKind::Ridge,
        points: points.iter().enumerate().map(point).collect(),
        lines: lines.iter().map(line).collect(),
        rings: Vec::new(),
        scale: 1.0,
        profile_len: 0,
        profile_step: 0.0,
    }
}

/// Greatest distance from any vertex to the nearest item.
fn gap(features: &Features, items: &[Item]) -> f64 {
    let near = |at: &[f64; 2]| items.iter().map(|item| distance(item.centre, *at)).fold(f64::MAX, f64::min);
    features.lines.iter().flat_map(|line| &line.vertices).map(near).fold(0.0, f64::max)
}

#[test]
fn arms_lie_on_the_circle_in_cyclic_order() {
    let cross = features(
        &[[200.0, 200.0], [200.0, 300.0], [300.0, 200.0], [200.0, 100.0], [100.0, 200.0]],
        &[(4, 0), (0, 1), (3, 0), (0, 2)],
    );
    let network = Network::new(&cross).unwrap();
    let arms = network.arms(0, 39.5);
    let expected = [[200.0, 239.5], [239.5, 200.0], [200.0, 160.5], [160.5, 200.0]];
    let half = [[200.0, 219.75], [219.75, 200.0], [200.0, 180.25], [180.25, 200.0]];
    assert_eq!(arms.iter().map(|arm| arm.line).collect::<Vec<_>>(), [1, 3, 2, 0]);
    for ((arm, expected), half) in arms.iter().zip(expected).zip(half) {
        assert!(distance(arm.position, expected) < 1e-9 && arm.whole);
        assert!(distance(arm.joint, half) < 1e-9);
        let outward = [0, 1].map(|k| (expected[k] - 200.0) / 39.5);
        assert!(distance(arm.tangent, outward) < 1e-9);
    }
}

#[test]
fn a_short_line_goes_on_where_it_turns_least_and_stubs_give_no_arm() {
    // From the middle a line of 20 cells to a fork, straight on and sideways; and a stub of 10.
    let fork = features(
        &[[200.0, 200.0], [200.0, 220.0], [202.0, 300.0], [300.0, 222.0], [190.0, 200.0], [200.0, 100.0]],
        &[(0, 1), (1, 2), (1, 3), (0, 4), (5, 0)],
    );
    let network = Network::new(&fork).unwrap();
    let arms = network.arms(0, 40.0);
    assert_eq!(arms.len(), 2);
    assert!((distance(arms[0].position, [200.0, 200.0]) - 40.0).abs() < 1e-9);
    assert!(arms[0].position[1] > 239.0 && arms[0].position[0] < 201.0, "{:?}", arms[0]);
    assert_eq!(arms[1].line, 4);
    // The stub's own end sees the whole way; a lone stroke shorter than half the radius still has a direction.
    assert_eq!(network.arms(4, 40.0).len(), 1);
    let dash = features(&[[200.0, 200.0], [200.0, 212.0]], &[(0, 1)]);
    let arms = Network::new(&dash).unwrap().arms(0, 40.0);
    assert!(arms.len() == 1 && !arms[0].whole && distance(arms[0].position, [200.0, 240.0]) < 1e-9);
}

#[test]
fn arms_of_traced_sketches_lie_at_the_radius() {
    let both: Vec<Stroke> = circle(128.0, 100.0).into_iter().chain(LAMBDA).collect();
    for strokes in [&TREE[..], &LAMBDA, &both] {
        let features = traced(strokes);
        let network = Network::new(&features).unwrap();
        for patch in [16.0, 40.0, 81.0] {
            for item in planned(&features, patch, Order::TreeBfs) {
                for arm in item.arms.iter().filter(|arm| arm.whole) {
                    assert!((distance(arm.position, item.centre) - radius(patch)).abs() < 0.01);
                }
                assert!(item.arms.iter().all(|arm| arm.position.iter().all(|at| at.is_finite())));
                let angles: Vec<f64> = item.arms.iter().map(|arm| arm.angle).collect();
                let on_point = matches!(item.place, Place::Point(_));
                assert!(!on_point || angles.is_sorted(), "{angles:?}");
            }
        }
        for line in 0..features.lines.len() {
            assert_eq!(network.at(line, 0.0), features.lines[line].vertices[0]);
        }
    }
}

#[test]
fn every_line_is_covered_and_parents_come_first() {
    let both: Vec<Stroke> = circle(128.0, 100.0).into_iter().chain(LAMBDA).collect();
    for strokes in [&TREE[..], &LAMBDA, &both, &circle(128.0, 100.0)] {
        let features = traced(strokes);
        for patch in [16.0, 40.0, 80.0, 120.0] {
            let items = planned(&features, patch, Order::TreeBfs);
            let uncovered = gap(&features, &items);
            // A ring's gap is covered from its middle, half the gap further off.
            assert!(uncovered <= patch / 2.0 + 1e-9, "{uncovered} with patches of {patch}");
            for (i, item) in items.iter().enumerate() {
                assert!(item.parent.is_none_or(|parent| parent < i));
            }
            let roots = items.iter().filter(|item| item.parent.is_none()).count();
            assert!(roots >= 1 && items[0].parent.is_none());
            let rings = items.iter().filter(|item| item.kind == ItemKind::Ring).count();
            assert_eq!(rings, features.rings.len());
        }
    }
}

#[test]
fn steps_along_a_line_are_even_and_no_longer_than_half_a_patch() {
    for length in [10.0, 40.0, 41.0, 79.0, 80.0, 81.0, 300.0] {
        let line = features(&[[50.0, 20.0], [50.0, 20.0 + length]], &[(0, 1)]);
        let items = planned(&line, 80.0, Order::TreeBfs);
        let mut cols: Vec<f64> = items.iter().map(|item| item.centre[1] - 20.0).collect();
        cols.sort_by(f64::total_cmp);
        let expected = (length / 40.0).ceil() as usize + 1;
        assert_eq!(cols.len(), expected.max(2), "{length}");
        for pair in cols.windows(2) {
            assert!((pair[1] - pair[0] - length / (cols.len() - 1) as f64).abs() < 1e-9);
            assert!(pair[1] - pair[0] <= 40.0 + 1e-9);
        }
        // The root is the higher end; the other comes last.
        assert_eq!(items[0].place, Place::Point(1));
        assert_eq!(items.last().unwrap().place, Place::Point(0));
    }
}

#[test]
fn a_plan_moves_with_its_features() {
    let here = traced(&TREE);
    let mut there = here.clone();
    there.grid = Grid::new(1000, 1000, CellSize::square(10.0)).unwrap();
    there.points.iter_mut().for_each(|point| (point.row, point.col) = (point.row + 256.0, point.col + 512.0));
    there
        .lines
        .iter_mut()
        .flat_map(|line| &mut line.vertices)
        .for_each(|at| *at = [at[0] + 256.0, at[1] + 512.0]);
    let (a, b) = (planned(&here, 40.0, Order::TreeBfs), planned(&there, 40.0, Order::TreeBfs));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(
            (a.kind, a.parent, a.component, a.arms.len()),
            (b.kind, b.parent, b.component, b.arms.len())
        );
        assert!(distance([a.centre[0] + 256.0, a.centre[1] + 512.0], b.centre) < 1e-9);
    }
}

#[test]
fn the_variants_hold_the_same_patches_or_a_grid() {
    let features = traced(&TREE);
    let tree = planned(&features, 40.0, Order::TreeBfs);
    let rows = planned(&features, 40.0, Order::RasterItems);
    assert_eq!(tree.len(), rows.len());
    let band = |item: &Item| (item.centre[0] / 20.0).floor();
    for pair in rows.windows(2) {
        assert!((band(&pair[0]), pair[0].centre[1]) <= (band(&pair[1]), pair[1].centre[1]));
    }
    let grid = planned(&features, 40.0, Order::Raster);
    for i in 0..100 {
        let at = [1, 2].map(|stream| 256.0 * unit(key(3, stream, i, 0)));
        let covered = |item: &Item| [0, 1].iter().all(|&k| (item.centre[k] - at[k]).abs() <= 20.0);
        assert!(grid.iter().any(covered), "{at:?}");
    }
    assert!(grid.iter().all(|item| item.kind == ItemKind::Plain));
}

#[test]
fn damaged_features_are_refused_and_loops_are_walked_once() {
    let job = Job::detached();
    let sound = features(&[[10.0, 10.0], [10.0, 90.0], [90.0, 10.0]], &[(0, 1), (1, 2), (2, 0)]);
    assert!(plan(&sound, 40.0, Order::TreeBfs, &job).unwrap().len() > 3);
    let damaged = |change: &dyn Fn(&mut Features)| {
        let mut features = sound.clone();
        change(&mut features);
        assert!(Network::new(&features).is_err());
        assert!(plan(&features, 40.0, Order::TreeBfs, &job).is_err());
    };
    damaged(&|features| features.lines[0].to = 99);
    damaged(&|features| features.rings.push([0, 7]));
    damaged(&|features| features.lines[1].vertices.truncate(1));
    damaged(&|features| features.lines[1].vertices[3][0] = f64::NAN);
    damaged(&|features| features.points[0].row = f64::INFINITY);
    let mut own = sound;
    own.lines[0].to = 0;
    plan(&own, 40.0, Order::TreeBfs, &job).unwrap();
}
