//! Stars, forests, invariances, cones and voids.

use std::collections::BTreeSet;

use orograph_core::{FeatureKind, FeaturePoint, PointKind, key, prelude::*, signed_unit, unit};

use super::drawings::{arm_of, star};
use crate::{
    feature::{
        chains::{distance, shape},
        forest::{Forest, Frame},
        lattice::{Blocks, Lattice},
        polygon_breaking::spanning_forest,
        ppa::{Found, Raw, find, forest},
        settings::{Drop, Importance, Joining, LADDER, Reduction, Shaping, Sided, Steps},
        target_connection::{Segment, connect},
    },
    test_fields::field,
};

const CELLS: Blocks = Blocks { down: 1, across: 1 };

fn steps(drop: f64) -> Steps {
    Steps { working_cell: 1, drop: Drop::Share(drop), ..Steps::default() }
}

fn raw(terrain: &Heightfield, steps: &Steps) -> Raw {
    forest(terrain, CELLS, steps, &Job::detached()).unwrap()
}

fn found(terrain: &Heightfield, steps: &Steps, shaping: &Shaping) -> Found {
    find(terrain, steps, shaping, &Job::detached()).unwrap()
}

/// Groups of joined points.
fn components(features: &Features) -> usize {
    let mut tree: Vec<usize> = (0..features.points.len()).collect();
    for line in &features.lines {
        let (a, b) = (tree[line.from as usize], tree[line.to as usize]);
        tree.iter_mut().filter(|root| **root == b).for_each(|root| *root = a);
    }
    tree.into_iter().collect::<BTreeSet<_>>().len()
}

fn of_kind(features: &Features, kind: PointKind) -> Vec<(usize, FeaturePoint)> {
    features.points.iter().copied().enumerate().filter(|(_, point)| point.kind == kind).collect()
}

fn degree(features: &Features, point: usize) -> usize {
    let at = |end: u32| usize::from(end as usize == point);
    features.lines.iter().map(|line| at(line.from) + at(line.to)).sum()
}

/// Hills of many sizes, no two cells equally high.
fn hills(side: usize) -> Heightfield {
    let value = |octave: u64, x: usize, y: usize| signed_unit(key(7, octave, x as i64, y as i64));
    field(side, side, |row, col| {
        (0..6).fold(0.0, |sum, octave| {
            let step = 64_usize >> octave;
            let (x, y) = (col / step, row / step);
            let (fx, fy) = ((col % step) as f64 / step as f64, (row % step) as f64 / step as f64);
            let top = value(octave, x, y) * (1.0 - fx) + value(octave, x + 1, y) * fx;
            let bottom = value(octave, x, y + 1) * (1.0 - fx) + value(octave, x + 1, y + 1) * fx;
            sum + (top * (1.0 - fy) + bottom * fy) * 250.0 / f64::from(1 << octave)
        })
    })
}

/// Joined pairs of (row, column).
fn edges(forest: &Forest) -> BTreeSet<[(usize, usize); 2]> {
    let mut edges = BTreeSet::new();
    for cell in 0..forest.links.len() {
        for other in forest.neighbours(cell).filter(|&other| other > cell) {
            edges.insert([forest.lattice.place(cell), forest.lattice.place(other)]);
        }
    }
    edges
}

#[test]
fn stars_come_out_with_one_branch_point_of_their_degree() {
    for arms in 3..=8 {
        for turn in 0..10 {
            let turn = f64::from(turn) / 10.0;
            let terrain = star(arms, turn);
            for drop in [0.005, 0.01] {
                for merge_radius in [3.0, 8.0] {
                    let joining = Joining { merge_radius, smooth_passes: 0 };
                    let shaping = Shaping { joining, ..Shaping::default() };
                    let features = found(&terrain, &steps(drop), &shaping).features;
                    let case = format!("{arms} arms turned by {turn}, drop {drop}, merged at {merge_radius}");
                    let branches = of_kind(&features, PointKind::Branch);
                    assert_eq!(branches.len(), 1, "{case}");
                    assert_eq!(components(&features), 1, "{case}");
                    let (id, apex) = branches[0];
                    assert_eq!(degree(&features, id), arms, "{case}");
                    assert_eq!(of_kind(&features, PointKind::End).len(), arms, "{case}");
                    assert!(distance([apex.row, apex.col], [64.0, 64.0]) <= 3.0, "{case}");
                    for arm in 0..arms {
                        let [a, b] = arm_of(arms, turn, arm);
                        for t in 4..50 {
                            let share = f64::from(t) / 1000.0;
                            let at = [a[1] + (b[1] - a[1]) * share, a[0] + (b[0] - a[0]) * share];
                            let vertices = features.lines.iter().flat_map(|line| &line.vertices);
                            let near = vertices.map(|&vertex| distance(vertex, at)).fold(f64::MAX, f64::min);
                            assert!(near <= 1.5, "{case}: {near} at {t} on arm {arm}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_comes_out_is_a_forest() {
    let terrain = hills(97);
    for drop in [0.0, 0.004, 0.02, 0.05] {
        for sided in [Sided::TwoSided, Sided::AnyPath] {
            let forest = raw(&terrain, &Steps { sided, ..steps(drop) }).forest;
            let mut trees: Vec<usize> = (0..forest.links.len()).collect();
            for [a, b] in edges(&forest) {
                let root = |trees: &[usize], mut i: usize| {
                    while trees[i] != i {
                        i = trees[i];
                    }
                    i
                };
                let (a, b) = (root(&trees, a.0 * 97 + a.1), root(&trees, b.0 * 97 + b.1));
                assert_ne!(a, b, "a closed polygon at drop {drop}");
                trees[a] = b;
            }
        }
    }
}

/// Removes, again and again, the least important segment that lies on a closed polygon.
fn break_polygons(mut segments: Vec<Segment>, cells: usize) -> BTreeSet<(u32, u32)> {
    let joined = |segments: &[Segment], without: usize| {
        let (from, to) = (segments[without].from, segments[without].to);
        let mut seen = vec![false; cells];
        let mut queue = vec![from];
        seen[from as usize] = true;
        while let Some(cell) = queue.pop() {
            for (i, segment) in segments.iter().enumerate().filter(|(i, _)| *i != without) {
                let _ = i;
                let next = match cell {
                    c if c == segment.from => segment.to,
                    c if c == segment.to => segment.from,
                    _ => continue,
                };
                if !std::mem::replace(&mut seen[next as usize], true) {
                    queue.push(next);
                }
            }
        }
        seen[to as usize]
    };
    loop {
        let weakest = (0..segments.len()).filter(|&i| joined(&segments, i)).min_by(|&a, &b| {
            let (a, b) = (&segments[a], &segments[b]);
            let by = |i: usize| a.importance[i].total_cmp(&b.importance[i]);
            // Of equals, the one that comes first by place matters more.
            by(0).then_with(|| by(1)).then_with(|| (b.from, b.to).cmp(&(a.from, a.to)))
        });
        let Some(weakest) = weakest else { break };
        segments.remove(weakest);
    }
    segments.iter().map(|segment| (segment.from, segment.to)).collect()
}

#[test]
fn polygon_breaking_is_the_paper_s_process_on_every_small_grid() {
    let job = Job::detached();
    for case in 0..300 {
        let (rows, cols) = (2 + case % 3, 2 + case / 3 % 3);
        let lattice = Lattice { rows, cols };
        // Few different heights, so that ties abound.
        let crests: Vec<f32> = (0..lattice.len())
            .map(|i| (unit(key(case as u64, 1, i as i64, 0)) * 4.0).floor() as f32)
            .collect();
        let marked: Vec<bool> =
            (0..lattice.len()).map(|i| unit(key(case as u64, 2, i as i64, 0)) < 0.85).collect();
        for by in [Importance::MeanEndpoint, Importance::MinEndpoint] {
            let segments = connect(lattice, &crests, &marked, by, &job).unwrap();
            let expected = break_polygons(segments.clone(), lattice.len());
            let forest = spanning_forest(lattice, segments, &job).unwrap();
            let got: BTreeSet<(u32, u32)> = edges(&forest)
                .into_iter()
                .map(|[a, b]| ((a.0 * cols + a.1) as u32, (b.0 * cols + b.1) as u32))
                .collect();
            assert_eq!(got, expected, "case {case}");
        }
    }
}

#[test]
fn every_pair_of_candidates_is_joined_but_for_the_weaker_of_crossing_diagonals() {
    let job = Job::detached();
    let lattice = Lattice { rows: 2, cols: 2 };
    let joined = |crests: [f32; 4]| {
        let segments = connect(lattice, &crests, &[true; 4], Importance::MeanEndpoint, &job).unwrap();
        segments.iter().map(|segment| (segment.from, segment.to)).collect::<BTreeSet<_>>()
    };
    assert!(joined([5.0, 1.0, 1.0, 5.0]).contains(&(0, 3)));
    assert!(joined([1.0, 5.0, 5.0, 1.0]).contains(&(1, 2)));
    let tie = joined([1.0; 4]);
    assert!(tie.contains(&(0, 3)) && !tie.contains(&(1, 2)) && tie.len() == 5);
}

#[test]
fn candidates_are_those_of_the_definition() {
    let terrain = hills(40);
    let lattice = Lattice { rows: 40, cols: 40 };
    let job = Job::detached();
    let steps = steps(0.02);
    let relief =
        crate::feature::profile_recognition::Relief::new(&terrain, FeatureKind::Ridge, CELLS, 0.0, &job)
            .unwrap();
    let (low, high) = relief.range;
    for sided in [Sided::TwoSided, Sided::AnyPath] {
        let falls = relief.falls(steps.half_profile, sided, &job).unwrap();
        let marked = relief.candidates(&falls, 0.02, 0.0);
        for (cell, &marked) in marked.iter().enumerate() {
            let is_low = |direction: usize| {
                (1..=3).any(|n| {
                    lattice.far(cell, direction, n).is_some_and(|at| {
                        f64::from(relief.crests[cell] - relief.crests[at]) > 0.02 * (high - low)
                    })
                })
            };
            let expected = (0..4).any(|d| match sided {
                Sided::TwoSided => is_low(d) && is_low(d + 4),
                Sided::AnyPath => is_low(d) || is_low(d + 4),
            });
            assert_eq!(marked, expected, "{cell}");
        }
    }
}

#[test]
fn height_and_scale_do_not_count_and_valleys_are_ridges_upside_down() {
    let job = Job::detached();
    // Halves of metres, so that shifting and scaling lose no bit.
    let terrain =
        hills(97).map::<orograph_core::Metres>(&job, |height| (height * 2.0).round() / 2.0).unwrap();
    let ridges = edges(&raw(&terrain, &steps(0.01)).forest);
    assert!(ridges.len() > 500);
    let other = terrain.map::<orograph_core::Metres>(&job, |height| height * 4.0 + 1024.0).unwrap();
    assert_eq!(edges(&raw(&other, &steps(0.01)).forest), ridges);
    let turned = terrain.map::<orograph_core::Metres>(&job, |height| -height).unwrap();
    let valleys = Steps { kind: FeatureKind::Valley, ..steps(0.01) };
    assert_eq!(edges(&raw(&turned, &valleys).forest), ridges);
}

#[test]
fn turning_and_mirroring_commute_where_no_two_heights_are_equal() {
    let terrain = hills(97);
    let ridges = edges(&raw(&terrain, &steps(0.01)).forest);
    let turned = |place: &dyn Fn(usize, usize) -> (usize, usize)| -> BTreeSet<_> {
        let turned = field(97, 97, |row, col| {
            let (row, col) = place(row, col);
            f64::from(terrain.at(row, col))
        });
        let back = |(row, col): (usize, usize)| place(row, col);
        let edges = edges(&raw(&turned, &steps(0.01)).forest);
        edges
            .into_iter()
            .map(|[a, b]| {
                let mut e = [back(a), back(b)];
                e.sort_unstable();
                e
            })
            .collect()
    };
    assert_eq!(turned(&|row, col| (row, 96 - col)), ridges);
    assert_eq!(turned(&|row, col| (col, 96 - row)), ridges);
}

#[test]
fn level_ground_and_planes_have_no_lines() {
    let none = |terrain: &Heightfield| {
        for drop in [0.0, 0.01] {
            assert_eq!(raw(terrain, &steps(drop)).forest.nodes(), 0);
        }
        let features = found(terrain, &Steps::default(), &Shaping::default()).features;
        assert!(features.points.is_empty() && features.lines.is_empty());
    };
    none(&field(64, 50, |_, _| 7.0));
    none(&field(64, 50, |row, col| 3.0 * row as f64 - 2.0 * col as f64));
}

#[test]
fn a_smooth_cone_has_no_false_ridges_beyond_the_stated_radius() {
    let cone = field(129, 129, |row, col| -libm::hypot(row as f64 - 64.0, col as f64 - 64.0));
    let reach = |drop: f64| {
        let forest = raw(&cone, &steps(drop)).forest;
        let off = |(row, col): (usize, usize)| libm::hypot(row as f64 - 64.0, col as f64 - 64.0);
        edges(&forest).into_iter().flatten().map(off).fold(0.0, f64::max)
    };
    assert!(reach(0.0) > 30.0);
    assert!(reach(0.01) <= 9.0);
    assert_eq!(reach(0.02), 0.0);
}

#[test]
fn a_ring_stays_whole_but_for_one_link_where_spurs_leave_beside_its_lowest_place() {
    let spurs: Vec<[[f64; 2]; 2]> = [-0.12, 0.12, 1.4, 2.9]
        .map(|angle| {
            let at = |radius: f64| [64.0 + radius * libm::cos(angle), 64.0 + radius * libm::sin(angle)];
            [at(40.0), at(58.0)]
        })
        .into();
    let terrain = field(129, 129, |row, col| {
        let (x, y) = (col as f64, row as f64);
        let to_ring = (libm::hypot(x - 64.0, y - 64.0) - 40.0).abs();
        // Lowest in the east, between the first two spurs.
        100.0 - 2.0 * to_ring.min(super::drawings::off(&spurs, x, y) + 1.0) - 0.1 * x
    });
    let Found { features, .. } = found(&terrain, &steps(0.02), &Shaping::default());
    assert_eq!(features.rings.len(), 1);
    let [a, b] = features.rings[0].map(|end| end as usize);
    let place = |point: usize| [features.points[point].row, features.points[point].col];
    assert!(distance(place(a), place(b)) < 1.5);
    let vertices: Vec<[f64; 2]> = features.lines.iter().flat_map(|line| line.vertices.clone()).collect();
    for step in 0..360 {
        let (sin, cos) = libm::sincos(f64::from(step).to_radians());
        let at = [64.0 + 40.0 * sin, 64.0 + 40.0 * cos];
        let off = vertices.iter().map(|&vertex| distance(vertex, at)).fold(f64::INFINITY, f64::min);
        assert!(off < 2.0, "{step}: {off}");
    }
}

#[test]
fn a_broad_crest_is_no_ring() {
    let terrain = field(60, 140, |row, col| {
        let off = (row as f64 - 30.0).abs();
        // Flat for five cells but for a trough, so that two rails run along it with rungs between.
        let trough = if off < 0.5 && col % 9 != 0 { 0.02 } else { 0.0 };
        100.0 - (off - 2.0).max(0.0) - trough
    });
    let Found { features, .. } = found(&terrain, &steps(0.01), &Shaping::default());
    assert_eq!((features.lines.len(), features.rings.len()), (1, 0));
}

#[test]
fn lines_stay_where_they_are_when_junctions_become_one() {
    let lattice = Lattice { rows: 41, cols: 61 };
    let mut forest = Forest::new(lattice);
    let cell = |row: usize, col: usize| row * lattice.cols + col;
    (0..60).for_each(|col| forest.join(cell(30, col), 0));
    // Two cells off the long line a branch parts in two, and one of them parts again.
    (28..30).for_each(|row| forest.join(cell(row, 30), 2));
    (16..28).for_each(|row| forest.join(cell(row, row + 2), 1));
    (16..28).for_each(|row| forest.join(cell(row, 58 - row), 3));
    (16..26).for_each(|row| forest.join(cell(row, 28), 2));
    let grid = Grid::new(41, 61, CellSize::square(1.0)).unwrap();
    let heights = vec![0.0; lattice.len()];
    let frame = Frame { grid: &grid, blocks: CELLS, heights: &heights, kind: FeatureKind::Ridge };
    let features = shape(&forest, &frame, &Shaping::default(), &Job::detached()).unwrap();
    let branches = of_kind(&features, PointKind::Branch);
    assert_eq!(branches.len(), 1);
    assert_eq!((degree(&features, branches[0].0), features.lines.len()), (5, 5));
    let vertices: Vec<[f64; 2]> = features.lines.iter().flat_map(|line| line.vertices.clone()).collect();
    for cell in (0..lattice.len()).filter(|&cell| forest.degree(cell) > 0) {
        let (row, col) = lattice.place(cell);
        let off = |vertex: &[f64; 2]| distance(*vertex, [row as f64, col as f64]);
        assert!(vertices.iter().map(off).fold(f64::INFINITY, f64::min) < 1.0, "{row} {col}");
    }
}

#[test]
fn a_hole_splits_a_ridge() {
    let ridge = |hole: bool| {
        let terrain = field(41, 81, |row, col| {
            let void = hole && (18..=22).contains(&row) && (36..=44).contains(&col);
            if void { f64::NAN } else { 100.0 - (row as f64 - 20.0).abs() + 0.01 * col as f64 }
        });
        found(&terrain, &steps(0.02), &Shaping::default()).features
    };
    assert_eq!((components(&ridge(false)), components(&ridge(true))), (1, 2));
    for line in &ridge(true).lines {
        assert!(
            line.vertices
                .iter()
                .all(|[row, col]| { !((18.5..=21.5).contains(row) && (36.5..=43.5).contains(col)) })
        );
    }
}

#[test]
fn density_takes_the_first_rung_that_suffices() {
    let terrain = hills(97);
    let share = |drop: f64| raw(&terrain, &steps(drop)).share;
    for density in [0.0, 0.02, 0.05, 0.08, 0.5] {
        let rung = raw(&terrain, &Steps { drop: Drop::Density(density), ..steps(0.0) }).drop;
        let expected = LADDER.into_iter().find(|&drop| share(drop) >= density).unwrap_or(0.004);
        assert_eq!(rung, expected, "{density}");
    }
}

#[test]
fn odd_settings_and_grids_do_not_panic() {
    let job = Job::detached();
    for (rows, cols) in [(3, 3), (3, 40), (5, 5), (12, 7)] {
        let terrain = field(
            rows,
            cols,
            |row, col| if (row + col) % 4 == 0 { f64::NAN } else { (row * col % 5) as f64 },
        );
        for working_cell in [1, 2, 5, 32] {
            let reduction = Reduction {
                end_trim: 0,
                min_branch: 0,
                parallel_radius: 0.0,
                min_group: 0,
                regrow: true,
                rings: true,
            };
            let steps =
                Steps { working_cell, half_profile: 32, drop: Drop::Share(0.0), reduction, ..steps(0.0) };
            find(&terrain, &steps, &Shaping::default(), &job).unwrap();
            let rounds = Reduction { end_trim: 32, ..Reduction::default() };
            find(&terrain, &Steps { reduction: rounds, sigma: 3.0, ..steps }, &Shaping::default(), &job)
                .unwrap();
        }
    }
}
