//! Curves that meet, cross, miss and close.

use orograph_core::{PointKind, prelude::*};

use crate::{
    feature::{
        chains::{distance, length},
        from_curves::{FromCurves, FromCurvesIn},
        plan::{ItemKind, Order, plan},
    },
    test_fields::field,
};

/// Lines of (x, y) in cells, all at height 0, on 200 × 200 cells.
fn curves(lines: &[&[[f64; 2]]]) -> Features {
    let shares = |line: &&[[f64; 2]]| line.iter().map(|at| [at[0] / 199.0, at[1] / 199.0, 0.0]).collect();
    raised(lines.iter().map(shares).collect())
}

fn raised(lines: Vec<Vec<[f64; 3]>>) -> Features {
    let node = FromCurves { lines: lines.into(), smooth_passes: 0, ..FromCurves::default() };
    let like = field(200, 200, |_, _| 0.0);
    node.run(FromCurvesIn { like: Some(&like), points: None }, &Job::detached()).unwrap().features
}

/// Numbers of branch points, ends and lines.
fn counts(features: &Features) -> (usize, usize, usize) {
    let branches = features.points.iter().filter(|point| point.kind == PointKind::Branch).count();
    (branches, features.points.len() - branches, features.lines.len())
}

#[test]
fn a_crossing_is_one_branch_point_of_four_lines() {
    let cross = curves(&[&[[50.0, 100.0], [150.0, 100.0]], &[[100.0, 50.0], [100.0, 150.0]]]);
    assert_eq!(counts(&cross), (1, 4, 4));
    let branch = cross.points.iter().find(|point| point.kind == PointKind::Branch).unwrap();
    assert!(distance([branch.row, branch.col], [100.0, 100.0]) < 1e-9);
    assert!((length(&cross) - 200.0).abs() < 1e-6);
}

#[test]
fn near_misses_are_snapped_and_wider_ones_are_not() {
    let tee = |gap: f64| curves(&[&[[50.0, 100.0], [150.0, 100.0]], &[[90.0, 100.0 + gap], [90.0, 150.0]]]);
    assert_eq!(counts(&tee(0.0)), (1, 3, 3));
    assert_eq!(counts(&tee(1.4)), (1, 3, 3));
    assert_eq!(counts(&tee(2.0)), (0, 4, 2));
    let joined = curves(&[&[[20.0, 20.0], [60.0, 60.0]], &[[61.0, 60.5], [120.0, 60.0]]]);
    assert_eq!(counts(&joined), (0, 2, 1));
}

#[test]
fn drawing_a_line_twice_changes_nothing() {
    let once: &[[f64; 2]] = &[[20.0, 20.0], [60.0, 80.0], [150.0, 90.0]];
    let back: Vec<[f64; 2]> = once.iter().rev().copied().collect();
    assert_eq!(curves(&[once]).lines, curves(&[once, &back]).lines);
}

#[test]
fn a_ring_is_opened_and_remembered() {
    let ring: Vec<[f64; 2]> = (0..=60)
        .map(|i| {
            let angle = f64::from(i % 60) * std::f64::consts::TAU / 60.0;
            [100.0 + 60.0 * libm::cos(angle), 100.0 + 60.0 * libm::sin(angle)]
        })
        .collect();
    let features = curves(&[&ring]);
    assert_eq!((counts(&features), features.rings.len()), ((0, 2, 1), 1));
    assert!((length(&features) - 376.8).abs() < 2.0);
    let items = plan(&features, 40.0, Order::TreeBfs, &Job::detached()).unwrap();
    assert_eq!(items.iter().filter(|item| item.kind == ItemKind::Ring).count(), 1);
    assert!(items.iter().all(|item| item.kind != ItemKind::End && item.arms.len() == 2));
    // With a stem the loop is opened opposite it, so that both ends face each other away from the junction.
    let stem: &[[f64; 2]] = &[[160.0, 100.0], [195.0, 100.0]];
    let stemmed = curves(&[&ring, stem]);
    assert_eq!((counts(&stemmed), stemmed.rings.len()), ((1, 3, 3), 1));
    let [a, _] = stemmed.rings[0];
    assert!(stemmed.points[a as usize].col < 60.0);
}

#[test]
fn loops_are_opened_at_their_lowest_or_for_valleys_highest_place() {
    let square = |kind| {
        let corner = |x: f64, y: f64, height: f64| [x / 199.0, y / 199.0, height];
        let line = vec![
            corner(50.0, 50.0, 100.0),
            corner(150.0, 50.0, 90.0),
            corner(150.0, 150.0, 20.0),
            corner(50.0, 150.0, 60.0),
            corner(50.0, 50.0, 100.0),
        ];
        let node = FromCurves { lines: vec![line].into(), kind, smooth_passes: 0, ..FromCurves::default() };
        let like = field(200, 200, |_, _| 0.0);
        let features =
            node.run(FromCurvesIn { like: Some(&like), points: None }, &Job::detached()).unwrap().features;
        [features.points[0].row, features.points[0].col]
    };
    assert!(distance(square(crate::feature::settings::Kind::Ridge), [150.0, 150.0]) < 2.0);
    assert!(distance(square(crate::feature::settings::Kind::Valley), [50.0, 50.0]) < 2.0);
}

#[test]
fn points_make_a_line_and_odd_curves_are_taken_or_refused() {
    let job = Job::detached();
    let like = field(200, 200, |_, _| 0.0);
    let points = Points::new(vec![100.0, 900.0], vec![-100.0, -900.0], vec![1.0, 2.0]).unwrap();
    let node = FromCurves::default();
    let features =
        node.run(FromCurvesIn { like: Some(&like), points: Some(&points) }, &job).unwrap().features;
    assert_eq!(counts(&features), (0, 2, 1));
    assert_eq!(features.lines[0].vertices[0], [10.0, 10.0]);
    for line in [vec![], vec![[0.5; 3]], vec![[0.5; 3]; 3]] {
        assert_eq!(counts(&raised(vec![line])), (0, 0, 0));
    }
    let far = FromCurves { lines: vec![vec![[0.0; 3], [1e9, 0.0, 0.0]]].into(), ..FromCurves::default() };
    assert!(far.run(FromCurvesIn { like: Some(&like), points: None }, &job).is_err());
    let wild = Points::new(vec![0.0, f64::NAN], vec![0.0; 2], vec![0.0; 2]).unwrap();
    assert!(node.run(FromCurvesIn { like: Some(&like), points: Some(&wild) }, &job).is_err());
}
