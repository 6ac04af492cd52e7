//! Figures of adherence on ground that is known.

use orograph_core::{FeaturePoint, PointKind, Polyline, prelude::*};

use crate::{
    feature::adherence::{Adherence, AdherenceIn, AdherenceOut, Measured},
    test_fields::field,
};

/// Straight lines, vertices a cell apart, on 200 × 200 cells.
fn lines(ends: &[[[f64; 2]; 2]]) -> Features {
    let point = |at: [f64; 2]| FeaturePoint { row: at[0], col: at[1], height: 0.0, kind: PointKind::End };
    let line = |(i, [a, b]): (usize, &[[f64; 2]; 2])| Polyline {
        from: 2 * i as u32,
        to: 2 * i as u32 + 1,
        vertices: vec![*a, *b],
        profiles: Vec::new(),
    };
    Features {
        grid: Grid::new(200, 200, CellSize::square(10.0)).unwrap(),
        kind: FeatureKind::Ridge,
        points: ends.iter().flatten().map(|&at| point(at)).collect(),
        lines: ends.iter().enumerate().map(line).collect(),
        rings: Vec::new(),
        scale: 1.0,
        profile_len: 0,
        profile_step: 0.0,
    }
}

/// A ridge along row 40.
fn ridge() -> Heightfield {
    field(200, 200, |row, _| 500.0 - 5.0 * (row as f64 - 40.0).abs())
}

fn run(drawn: &Features, terrain: &Heightfield, found: Option<&Features>) -> AdherenceOut {
    Adherence::default().run(AdherenceIn { drawn, terrain, found }, &Job::detached()).unwrap()
}

fn metric(out: &AdherenceOut, name: &str) -> f64 {
    out.report.metric(name).unwrap()
}

#[test]
fn a_line_on_a_ridge_is_followed_and_not_by_chance() {
    let drawn = lines(&[[[40.0, 10.0], [40.0, 190.0]]]);
    let out = run(&drawn, &ridge(), Some(&drawn));
    for name in ["recall", "precision", "f1", "lift", "standing_out", "longest_run_mean", "longest_run_least"]
    {
        assert_eq!(metric(&out, name), 1.0, "{name}");
    }
    for name in
        ["recall_by_chance", "recall_turned", "standing_out_by_chance", "mean_distance", "components_apart"]
    {
        assert_eq!(metric(&out, name), 0.0, "{name}");
    }
}

#[test]
fn without_lines_given_they_are_looked_for() {
    let drawn = lines(&[[[40.0, 20.0], [40.0, 180.0]]]);
    let out = run(&drawn, &ridge(), None);
    assert!(metric(&out, "recall") == 1.0 && metric(&out, "longest_run_least") == 1.0);
}

#[test]
fn gaps_and_offsets_are_measured_in_cells() {
    // Of 100 cells the found lines follow the first 40, 3 off, and the last 30, 8 off.
    let drawn = lines(&[[[40.0, 50.0], [40.0, 150.0]]]);
    let found = lines(&[[[43.0, 50.0], [43.0, 90.0]], [[48.0, 120.0], [48.0, 150.0]]]);
    let measured = Measured::new(&drawn, &found, &ridge(), &Adherence::default(), &Job::detached()).unwrap();
    // The place 4 cells beyond the end of the line is 5 off, and a sample sits on every cell, both ends included.
    assert!((measured.recall(5.0) - 45.0 / 101.0).abs() < 1e-9, "{}", measured.recall(5.0));
    assert!((measured.runs(5.0)[0] - 45.0 / 101.0).abs() < 1e-9);
    assert_eq!(measured.recall(2.9), 0.0);
    assert!((measured.recall(8.0) - (48.0 + 31.0) / 101.0).abs() < 0.02);
    let out = run(&drawn, &ridge(), Some(&found));
    assert_eq!(metric(&out, "components_apart"), 1.0);
    assert!((metric(&out, "precision") - 41.0 / 72.0).abs() < 1e-9);
}

#[test]
fn a_line_down_a_slope_does_not_stand_out_and_a_valley_lies_below() {
    let slope = field(200, 200, |row, _| 5.0 * row as f64);
    let drawn = lines(&[[[40.0, 20.0], [40.0, 180.0]]]);
    assert_eq!(metric(&run(&drawn, &slope, Some(&drawn)), "standing_out"), 0.0);
    let valley = Features { kind: FeatureKind::Valley, ..drawn.clone() };
    let ground = field(200, 200, |row, _| 5.0 * (row as f64 - 40.0).abs());
    assert_eq!(metric(&run(&valley, &ground, Some(&valley)), "standing_out"), 1.0);
    assert!(Measured::new(&drawn, &valley, &ground, &Adherence::default(), &Job::detached()).is_err());
}

#[test]
fn only_the_strongest_lines_count_for_precision() {
    let drawn = lines(&[[[40.0, 20.0], [40.0, 180.0]]]);
    // The flat land's own lines are longer together, but they rise over nothing.
    let found = lines(&[
        [[120.0, 10.0], [120.0, 190.0]],
        [[40.0, 20.0], [40.0, 180.0]],
        [[160.0, 10.0], [160.0, 190.0]],
    ]);
    let out = run(&drawn, &ridge(), Some(&found));
    assert_eq!(metric(&out, "precision"), 1.0);
}

#[test]
fn nothing_drawn_and_nothing_found_are_said_in_words() {
    let none = lines(&[]);
    let drawn = lines(&[[[40.0, 20.0], [40.0, 180.0]]]);
    assert!(metric(&run(&none, &ridge(), None), "recall").is_nan());
    let out = run(&drawn, &ridge(), Some(&none));
    assert_eq!((metric(&out, "recall"), metric(&out, "f1")), (0.0, 0.0));
}

#[test]
fn around_a_ring_a_run_passes_the_place_where_it_was_opened() {
    let corners = [[40.0, 40.0], [40.0, 140.0], [140.0, 140.0], [140.0, 40.0]];
    let mut drawn = lines(&[[corners[0], [41.0, 40.0]]]);
    drawn.lines[0].vertices = [&corners[..], &[[41.0, 40.0]]].concat();
    // All but the second side.
    let found = lines(&[[corners[2], corners[3]], [corners[3], corners[0]], [corners[0], corners[1]]]);
    let run = |drawn: &Features, found: &Features| {
        Measured::new(drawn, found, &ridge(), &Adherence::default(), &Job::detached()).unwrap().runs(5.0)[0]
    };
    let open = run(&drawn, &found);
    assert!((open - 204.0 / 400.0).abs() < 0.01, "{open}");
    drawn.rings = vec![[0, 1]];
    let closed = run(&drawn, &found);
    assert!((closed - 310.0 / 400.0).abs() < 0.01, "{closed}");
    // Ends that the search knows to belong together leave no gap.
    let mut whole = found.clone();
    whole.rings = vec![[0, 5]];
    assert_eq!(run(&drawn, &whole), 1.0);
}
