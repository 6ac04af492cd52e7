//! The sub-steps against the whole, and the rules of classification.

use orograph_core::{PointKind, prelude::*};

use super::drawings::{Stroke, drawn, star};
use crate::PatchSize;
use crate::feature::{
    branch_reduction::{BranchReduction, BranchReductionIn},
    chains::{distance, resample, smooth},
    classify::{Classify, ClassifyIn},
    from_sketch::{FromSketch, FromSketchIn},
    polygon_breaking::{PolygonBreaking, PolygonBreakingIn},
    ppa::{DropBy, Ppa, PpaIn},
    profile_recognition::{ProfileRecognition, ProfileRecognitionIn},
    settings::{Drop, Kind, Preset, Profiles, Sided, WorkingCells},
    target_connection::{TargetConnection, TargetConnectionIn},
};

/// A star on cells of 10 × 14 m.
fn oblong() -> Heightfield {
    let star = star(5, 0.3);
    let grid = Grid { cell: CellSize { x: 10.0, y: 14.0 }, ..star.grid().clone() };
    star.with_grid(grid).unwrap()
}

#[test]
fn the_steps_one_by_one_give_what_the_whole_gives() {
    let job = Job::detached();
    for (terrain, kind) in [(star(5, 0.3), Kind::Ridge), (oblong(), Kind::Ridge), (oblong(), Kind::Valley)] {
        for working_cell in [1, 3] {
            let drop = 0.01;
            let cells = WorkingCells { kind, working_cell };
            let recognition = ProfileRecognition { cells, drop, ..ProfileRecognition::default() };
            let candidates =
                recognition.run(ProfileRecognitionIn { terrain: &terrain }, &job).unwrap().candidates;
            let connection = TargetConnection { cells, ..TargetConnection::default() };
            let connected = TargetConnectionIn { terrain: &terrain, candidates: &candidates };
            let segments = connection.run(connected, &job).unwrap().segments;
            let breaking = PolygonBreaking::default();
            let forest = breaking.run(PolygonBreakingIn { segments: &segments }, &job).unwrap().forest;
            assert!(forest.lines.len() < segments.lines.len() || segments.lines.is_empty());
            let reduction = BranchReduction::default();
            let reduced = reduction.run(BranchReductionIn { forest: &forest }, &job).unwrap().forest;
            let one_by_one = Classify::default().run(ClassifyIn { forest: &reduced }, &job).unwrap().features;
            let whole =
                Ppa { kind, working_cell, drop, drop_by: DropBy::Share, profiles: false, ..Ppa::default() };
            let whole = whole.run(PpaIn { terrain: &terrain }, &job).unwrap().features;
            assert!(one_by_one == whole, "{kind:?} on working cells of {working_cell}");
        }
    }
}

#[test]
fn steps_in_the_wrong_order_are_refused() {
    let job = Job::detached();
    let features = Ppa::default().run(PpaIn { terrain: &star(4, 0.0) }, &job).unwrap().features;
    assert!(!features.lines.is_empty());
    let wrong = PolygonBreaking::default().run(PolygonBreakingIn { segments: &features }, &job);
    assert!(wrong.is_err_and(|error| error.hint().is_some()));
    let terrain = star(4, 0.0);
    let cells = WorkingCells { working_cell: 1, ..WorkingCells::default() };
    let recognition = ProfileRecognition { cells, drop: 0.005, ..ProfileRecognition::default() };
    let candidates = recognition.run(ProfileRecognitionIn { terrain: &terrain }, &job).unwrap().candidates;
    let connection = TargetConnection { cells, ..TargetConnection::default() };
    let connected = TargetConnectionIn { terrain: &terrain, candidates: &candidates };
    let segments = connection.run(connected, &job).unwrap().segments;
    assert!(BranchReduction::default().run(BranchReductionIn { forest: &segments }, &job).is_err());
}

#[test]
fn the_paper_s_preset_overrides_the_parameters() {
    let strict = Ppa {
        preset: Preset::PaperStrict,
        patches: PatchSize { patch: 160 },
        across: Profiles { half_profile: 9, ..Profiles::default() },
        ..Ppa::default()
    };
    let strict = strict.steps();
    assert_eq!((strict.working_cell, strict.half_profile, strict.drop), (1, 3, Drop::Share(0.5)));
    assert_eq!((strict.sided, strict.reduction.parallel_radius), (Sided::AnyPath, 0.0));
    assert!(!strict.reduction.regrow);
    let plug_in = Ppa { preset: Preset::PlugIn, ..Ppa::default() }.steps();
    assert_eq!((plug_in.working_cell, plug_in.drop), (5, Drop::Share(0.05)));
    // Working cells of a sixteenth of a patch.
    for (patch, cells) in [(16, 1), (40, 3), (80, 5), (120, 8)] {
        assert_eq!(Ppa { patches: PatchSize { patch }, ..Ppa::default() }.steps().working_cell, cells);
    }
    // Any slope steep enough counts, so the paper's letter finds lines on a pyramid's faces too.
    let out = Ppa { preset: Preset::PaperStrict, ..Ppa::default() };
    out.run(PpaIn { terrain: &star(4, 0.1) }, &Job::detached()).unwrap();
}

#[test]
fn every_end_has_one_line_and_every_branch_point_three() {
    // The tree of the paper's figure 6: three branch points and five ends.
    let tree: [Stroke; 7] = [
        [[128.0, 20.0], [128.0, 80.0]],
        [[128.0, 80.0], [70.0, 130.0]],
        [[128.0, 80.0], [190.0, 120.0]],
        [[70.0, 130.0], [30.0, 220.0]],
        [[70.0, 130.0], [110.0, 210.0]],
        [[190.0, 120.0], [160.0, 200.0]],
        [[190.0, 120.0], [235.0, 180.0]],
    ];
    for width in [3.0, 9.0, 15.0] {
        let sketch = drawn(&tree, 257, width);
        let features =
            FromSketch::default().run(FromSketchIn { sketch: &sketch }, &Job::detached()).unwrap().features;
        let mut degrees = vec![0; features.points.len()];
        for line in &features.lines {
            degrees[line.from as usize] += 1;
            degrees[line.to as usize] += 1;
            let (first, last) = (line.vertices[0], line.vertices[line.vertices.len() - 1]);
            let place =
                |point: u32| [features.points[point as usize].row, features.points[point as usize].col];
            assert_eq!((first, last), (place(line.from), place(line.to)));
        }
        let of = |kind: PointKind| {
            let points = features.points.iter().zip(&degrees);
            points.filter(|(point, _)| point.kind == kind).map(|(_, degree)| *degree).collect::<Vec<i32>>()
        };
        assert_eq!((of(PointKind::Branch), of(PointKind::End)), (vec![3; 3], vec![1; 5]), "{width}");
        assert_eq!(degrees.iter().sum::<i32>(), 2 * features.lines.len() as i32);
    }
}

#[test]
fn smoothing_keeps_the_length_of_circles() {
    for radius in [10.0, 25.0, 80.0] {
        let n = (radius * std::f64::consts::TAU) as usize;
        let circle: Vec<[f64; 2]> = (0..=n)
            .map(|i| {
                let angle = std::f64::consts::TAU * i as f64 / n as f64;
                [100.0 + radius * libm::cos(angle), 100.0 + radius * libm::sin(angle)]
            })
            .collect();
        let length = |path: &[[f64; 2]]| path.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
        let mut smoothed = circle.clone();
        smooth(&mut smoothed, 2);
        for path in [&smoothed, &resample(&smoothed, 1.0), &resample(&smoothed, 2.0)] {
            assert!((length(path) / length(&circle) - 1.0).abs() < 0.02, "{radius}");
        }
        let even = resample(&smoothed, 1.0);
        let steps: Vec<f64> = even.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        assert!(steps.iter().all(|step| (step - 1.0).abs() < 0.05));
    }
}
