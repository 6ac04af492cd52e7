//! Four sketches at four stroke widths.

use orograph_core::{PointKind, prelude::*};

use super::drawings::{LAMBDA, Stroke, TREE, circle, drawn, off};
use crate::feature::{
    chains::distance,
    from_sketch::{FromSketch, FromSketchIn, trace},
    lattice::Blocks,
    medial,
    ppa::Ppa,
    settings::{Joining, Kind, Profiles, Reduction},
    sketch::{Sketch, SketchIn, Strokes, prepare},
};

fn traced(sketch: &Heightfield, settings: &Sketch) -> Features {
    let job = Job::detached();
    let prepared = prepare(sketch, settings, &job).unwrap().unwrap();
    trace(&prepared, sketch.grid(), 80, 2, &job).unwrap().features
}

/// Degrees of the branch points, number of ends, number of trees.
fn topology(features: &Features) -> (Vec<usize>, usize, usize) {
    let degree = |point: usize| {
        let at = |end: u32| usize::from(end as usize == point);
        features.lines.iter().map(|line| at(line.from) + at(line.to)).sum::<usize>()
    };
    let degrees: Vec<usize> = (0..features.points.len())
        .filter(|&i| features.points[i].kind == PointKind::Branch)
        .map(degree)
        .collect();
    let ends = features.points.len() - degrees.len();
    (degrees, ends, features.points.len() - features.lines.len())
}

#[test]
fn four_sketches_at_four_widths_have_the_drawn_topology() {
    let ring = circle(128.0, 100.0);
    let both: Vec<Stroke> = ring.iter().chain(&LAMBDA).copied().collect();
    for width in [3.0, 7.0, 13.0, 21.0] {
        let features = |strokes: &[Stroke]| traced(&drawn(strokes, 257, width), &Sketch::default());
        assert_eq!(topology(&features(&LAMBDA)), (vec![3], 3, 1), "lambda, {width}");
        assert_eq!(topology(&features(&TREE)), (vec![3, 3], 4, 1), "tree, {width}");
        let circle = features(&ring);
        assert_eq!(topology(&circle), (vec![], 2, 1), "circle, {width}");
        assert_eq!(circle.rings, [[0, 1]], "circle, {width}");
        let trees = topology(&features(&both)).2;
        assert_eq!(trees, if width > 20.0 { 1 } else { 2 }, "circle and lambda, {width}");
        if width > 13.0 {
            continue;
        }
        for strokes in [&LAMBDA[..], &TREE, &ring, &both] {
            let features = features(strokes);
            let vertices: Vec<[f64; 2]> =
                features.lines.iter().flat_map(|line| line.vertices.iter().copied()).collect();
            let near = vertices.iter().filter(|[row, col]| off(strokes, *col, *row) <= 2.0).count();
            assert!(near as f64 >= 0.93 * vertices.len() as f64, "{width}: {near} of {}", vertices.len());
            for i in 0..257 * 257 {
                let at = [(i / 257) as f64, (i % 257) as f64];
                if off(strokes, at[1], at[0]) <= 0.5 {
                    let far = vertices.iter().map(|&vertex| distance(vertex, at)).fold(f64::MAX, f64::min);
                    assert!(far <= 3.0, "{width}: {at:?} is {far} off");
                }
            }
        }
    }
}

#[test]
fn valleys_are_drawn_dark_on_bright_or_as_one_says() {
    let bright = drawn(&TREE, 257, 7.0);
    let dark = bright.map::<orograph_core::Metres>(&Job::detached(), |grey| 1.0 - grey).unwrap();
    let ridges = traced(&bright, &Sketch::default());
    let valley = Sketch { kind: Kind::Valley, ..Sketch::default() };
    for (sketch, settings) in
        [(&dark, valley.clone()), (&bright, Sketch { strokes: Strokes::Bright, ..valley })]
    {
        let valleys = traced(sketch, &settings);
        assert_eq!(valleys.kind, FeatureKind::Valley);
        assert_eq!(valleys.lines, ridges.lines);
        assert!(valleys.points.iter().zip(&ridges.points).all(|(a, b)| a.height == -b.height));
    }
}

#[test]
fn the_two_nodes_do_what_the_one_does() {
    let job = Job::detached();
    for (kind, width) in [(Kind::Ridge, 7.0), (Kind::Ridge, 40.0), (Kind::Valley, 30.0)] {
        let sketch = drawn(&TREE, 257, width);
        let settings = Sketch { kind, strokes: Strokes::Bright, ..Sketch::default() };
        let out = settings.run(SketchIn { sketch: &sketch }, &job).unwrap();
        let value = |name: &str| out.suggested.metric(name).unwrap();
        let ppa = Ppa {
            kind,
            working_cell: value("working_cell") as u32,
            across: Profiles { half_profile: value("half_profile") as u32, ..Profiles::default() },
            drop_by: crate::feature::ppa::DropBy::Share,
            drop: value("drop"),
            reduction: Reduction {
                min_branch: value("min_branch") as u32,
                parallel_radius: value("parallel_radius"),
                ..Reduction::default()
            },
            joining: Joining { merge_radius: value("merge_radius"), ..Joining::default() },
            profiles: false,
            ..Ppa::default()
        };
        let mut two = ppa.run(crate::feature::ppa::PpaIn { terrain: &out.field }, &job).unwrap().features;
        // The one node also moves lines onto the middle, to which the field alone does not lead.
        let prepared = prepare(&sketch, &settings, &job).unwrap().unwrap();
        let blocks = Blocks { down: prepared.shrink, across: prepared.shrink };
        medial::centre(&mut two, &prepared.edges, blocks, &prepared.shaping(80), &job).unwrap();
        let one = FromSketch { kind, strokes: Strokes::Bright, ..FromSketch::default() };
        let one = one.run(FromSketchIn { sketch: &sketch }, &job).unwrap().features;
        assert!((one.lines, one.rings) == (two.lines, two.rings), "{kind:?} {width}");
    }
}

#[test]
fn blank_sketches_have_no_lines() {
    let job = Job::detached();
    for sketch in [drawn(&[], 20, 5.0), crate::test_fields::field(9, 9, |_, _| f64::NAN)] {
        let features = FromSketch::default().run(FromSketchIn { sketch: &sketch }, &job).unwrap().features;
        assert!(features.points.is_empty() && features.lines.is_empty());
        Sketch::default().run(SketchIn { sketch: &sketch }, &job).unwrap();
    }
}

#[test]
fn a_sketch_may_be_traced_at_another_resolution() {
    let sketch = drawn(&TREE, 257, 9.0);
    let node = FromSketch { cells: 514, ..FromSketch::default() };
    let features = node.run(FromSketchIn { sketch: &sketch }, &Job::detached()).unwrap().features;
    assert_eq!(features.grid.size(), (514, 514));
    assert_eq!(topology(&features), (vec![3, 3], 4, 1));
}

/// Where the strokes' middle lines are, half a pixel apart.
fn middles(strokes: &[Stroke]) -> Vec<[f64; 2]> {
    let steps = |[a, b]: &Stroke| {
        let n = (2.0 * distance(*a, *b)).ceil();
        let (a, b) = (*a, *b);
        (0..=n as usize).map(move |i| [1, 0].map(|k| a[k] + (b[k] - a[k]) * i as f64 / n))
    };
    strokes.iter().flat_map(steps).collect()
}

/// Share of places within `reach` of a vertex.
fn covered(places: &[[f64; 2]], vertices: &[[f64; 2]], reach: f64) -> f64 {
    let near = |place: &&[f64; 2]| vertices.iter().any(|vertex| distance(**place, *vertex) <= reach);
    places.iter().filter(near).count() as f64 / places.len() as f64
}

#[test]
fn the_width_of_strokes_does_not_matter() {
    let scaled = |strokes: &[Stroke]| -> Vec<Stroke> {
        strokes.iter().map(|stroke| stroke.map(|at| at.map(|share| share * 2.0))).collect()
    };
    let ring = circle(256.0, 200.0);
    for strokes in [scaled(&LAMBDA), scaled(&TREE), ring] {
        // Drawing a circle of so many sides takes its time.
        let widths = if strokes.len() > 9 {
            &[5.0, 20.0, 40.0][..]
        } else {
            &[5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0]
        };
        for &width in widths {
            let features = traced(&drawn(&strokes, 512, width), &Sketch::default());
            let vertices: Vec<[f64; 2]> = features
                .lines
                .iter()
                .flat_map(|line| crate::feature::chains::resample(&line.vertices, 0.5))
                .collect();
            assert_eq!(features.rings.len(), usize::from(strokes.len() == 180), "{width}");
            let (recall, precision) =
                (covered(&middles(&strokes), &vertices, 5.0), covered(&vertices, &middles(&strokes), 5.0));
            // Where wide strokes meet at an acute angle, their common middle leaves both.
            let least = if width < 40.0 { 0.98 } else { 0.95 };
            assert!(recall >= least && precision >= least, "{width}: {recall:.3} {precision:.3}");
        }
    }
}

#[test]
fn a_ring_on_a_stem_stays_a_ring_wherever_the_stem_is() {
    for width in [9.0, 25.0, 40.0] {
        for turn in 0..8 {
            let angle = 0.1 + std::f64::consts::TAU * f64::from(turn) / 8.0;
            let (ux, uy) = (libm::cos(angle), libm::sin(angle));
            let sketch = crate::test_fields::field(512, 512, |row, col| {
                let (x, y) = (col as f64 - 256.0, row as f64 - 256.0);
                let ring = (libm::hypot(x, y) - 130.0).abs();
                let t = (x * ux + y * uy).clamp(130.0, 230.0);
                let stem = libm::hypot(x - t * ux, y - t * uy);
                f64::from(u8::from(ring.min(stem) <= width / 2.0))
            });
            let features = traced(&sketch, &Sketch::default());
            assert_eq!(topology(&features), (vec![3], 3, 1), "{width} wide, turned {turn}");
            assert_eq!(features.rings.len(), 1, "{width} wide, turned {turn}");
        }
    }
}

#[test]
fn strokes_that_do_not_touch_are_not_joined() {
    // The foot of one stroke ends four pixels above the other.
    let strokes = [[[40.0, 200.0], [220.0, 200.0]], [[130.0, 40.0], [130.0, 183.0]]];
    for width in [9.0, 13.0] {
        let features = traced(&drawn(&strokes, 257, width), &Sketch::default());
        assert_eq!(topology(&features), (vec![], 4, 2), "{width}");
    }
}
