use orograph_core::{key, signed_unit, unit};

use super::*;
use crate::test_fields::field;

fn exemplar(voids: bool) -> Exemplar {
    let terrain = field(61, 47, |row, col| {
        let bits = key(3, 1, row as i64, col as i64);
        let void = voids && (row * 47 + col).is_multiple_of(411);
        let smooth = 300.0 * libm::sin(row as f64 / 9.0) * libm::cos(col as f64 / 7.0);
        if void { f64::NAN } else { (1000.0 + smooth + 20.0 * signed_unit(bits)).round() }
    });
    Exemplar::new(&terrain, &Job::detached()).unwrap()
}

/// A window of random heights of which some are known.
fn window(rows: usize, cols: usize) -> Vec<f32> {
    (0..rows * cols)
        .map(|i| {
            let known = unit(key(9, 1, i as i64, 0)) < 0.4;
            if known { (1000.0 + 300.0 * signed_unit(key(9, 2, i as i64, 0))) as f32 } else { f32::NAN }
        })
        .collect()
}

#[test]
fn transforms_give_the_sums_that_loops_give() {
    for voids in [false, true] {
        let exemplar = exemplar(voids);
        let searcher = Searcher::at(&exemplar, &[], 1, &Job::detached()).unwrap();
        let (rows, cols) = (13, 9);
        let template = window(rows, cols);
        let mut field = vec![Complex64::new(0.0, 0.0); searcher.plane.rows * searcher.plane.cols];
        for (i, height) in template.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
            let at = i / cols * searcher.plane.cols + i % cols;
            field[at] = Complex64::new(f64::from(*height) - searcher.mean, 1.0);
        }
        let found = searcher.correlate(field, 61 - rows + 1);
        for (row, col) in [(0, 0), (48, 38), (7, 21), (33, 5)] {
            let (mut sum, mut mixed) = (0.0, 0.0);
            for (i, height) in template.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
                let source = f64::from(exemplar.terrain.at(row + i / cols, col + i % cols)) - searcher.mean;
                let source = if source.is_nan() { 0.0 } else { source };
                sum += source;
                mixed += source * source - 2.0 * source * (f64::from(*height) - searcher.mean);
            }
            let value = found[row * searcher.plane.cols + col];
            assert!((value.re - mixed).abs() < 1e-9 * 1e7, "{} {mixed}", value.re);
            assert!((value.im - sum).abs() < 1e-9 * 1e5, "{} {sum}", value.im);
        }
    }
}

#[test]
fn a_window_of_the_exemplar_is_found_at_its_place_at_any_level() {
    let exemplar = exemplar(true);
    for factor in [1, 2] {
        let searcher = Searcher::at(&exemplar, &[], factor, &Job::detached()).unwrap();
        let (rows, cols, row, col) = (14, 12, 20, 30);
        let at = |i: usize| exemplar.terrain.at(row + i / cols, col + i % cols) + 55.0;
        let heights: Vec<f32> = (0..rows * cols).map(|i| if i % 5 == 0 { f32::NAN } else { at(i) }).collect();
        let query = Query {
            cols,
            heights: &heights,
            open: &vec![false; rows * cols],
            lift: Some(1000.0),
            most_lines: f64::INFINITY,
            usual_lines: 0.0,
            balanced: false,
            n: 3,
        };
        let found = searcher.search(&query, &[1], |_| 0, &Job::detached()).unwrap();
        assert_eq!((found[0].row, found[0].col), (row, col), "{factor}");
        assert!(found[0].mismatch < 1e-6 && (found[0].lift - 55.0).abs() < 1e-6);
        // Held to its level it costs the square of what is missing.
        let held = searcher
            .search(&Query { lift: Some(50.0), n: 1, ..query }, &[1], |_| 0, &Job::detached())
            .unwrap();
        assert!((held[0].mismatch - 25.0).abs() < 1e-3, "{:?}", held[0]);
    }
}

#[test]
fn a_window_larger_than_the_exemplar_fits_nowhere() {
    let exemplar = exemplar(false);
    let searcher = Searcher::new(&exemplar, &[], &Job::detached()).unwrap();
    let heights = vec![1.0; 62 * 10];
    let open = vec![false; 620];
    let query = Query {
        cols: 10,
        heights: &heights,
        open: &open,
        lift: None,
        most_lines: 0.0,
        usual_lines: 0.0,
        balanced: false,
        n: 1,
    };
    assert!(searcher.search(&query, &[1], |_| 0, &Job::detached()).unwrap().is_empty());
}
