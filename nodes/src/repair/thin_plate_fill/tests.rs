use orograph_core::{key, unit};

use super::*;
use crate::test_fields::field;

/// As good as no tension.
const STIFF: Stiffness = Stiffness { stiffness: 1e9 };

fn filled(terrain: &Heightfield) -> Heightfield {
    thin_plate_fill(terrain, None, STIFF, &Job::detached()).unwrap()
}

/// A blot, a notch in the border, a corner and specks.
fn is_void(row: usize, col: usize) -> bool {
    let (dy, dx) = (row as f64 - 30.0, col as f64 - 40.0);
    dx * dx + 2.0 * dy * dy < 300.0
        || row > 50 && (60..66).contains(&col)
        || row + col < 5
        || key(1, 1, row as i64, col as i64).is_multiple_of(60)
}

fn holed(of: impl Fn(usize, usize) -> f64, is_void: impl Fn(usize, usize) -> bool) -> Heightfield {
    field(60, 80, |row, col| if is_void(row, col) { f64::NAN } else { of(row, col) })
}

#[test]
fn planes_go_on_into_every_void_and_known_cells_stay() {
    let plane = |row: usize, col: usize| 500.0 + 3.5 * row as f64 - 1.25 * col as f64;
    let terrain = holed(plane, is_void);
    let out = filled(&terrain);
    for row in 0..60 {
        for col in 0..80 {
            let (height, expected) = (out.at(row, col), plane(row, col) as f32);
            assert!((height - expected).abs() < 5e-3, "{height} {expected} at {row}, {col}");
            assert!(is_void(row, col) || height.to_bits() == expected.to_bits());
        }
    }
}

#[test]
fn cubics_are_reproduced_where_the_rim_is_closed() {
    // Fourth differences of cubics vanish; at the border, where the plate is free, third ones would have to.
    let cubic = |row: usize, col: usize| {
        let (y, x) = (row as f64 / 20.0 - 1.5, col as f64 / 20.0 - 2.0);
        100.0 * (x * x * x - 2.0 * x * y * y + y * x - y * y * y)
    };
    let inner = |row: usize, col: usize| {
        is_void(row, col) && (2..58).contains(&row) && (2..78).contains(&col) && row < 49
    };
    let out = filled(&holed(cubic, inner));
    for row in 0..60 {
        for col in 0..80 {
            let error = f64::from(out.at(row, col)) - cubic(row, col);
            assert!(error.abs() < 2e-2, "{error} at {row}, {col}");
        }
    }
}

#[test]
fn the_surface_is_that_of_a_dense_solve() {
    let (rows, cols) = (9, 10);
    let known = |i: usize| key(4, 4, i as i64, 0).is_multiple_of(4);
    let height = |i: usize| 100.0 * unit(key(5, 5, i as i64, 0));
    let terrain = field(rows, cols, |row, col| {
        let i = row * cols + col;
        if known(i) { height(i) } else { f64::NAN }
    });
    // The energy's derivative as a matrix, one column for each unit vector.
    let bending = bending::Bending::new((rows, cols), terrain.grid().cell, STIFF.stiffness);
    let n = rows * cols;
    let column = |i: usize| {
        let (mut at, mut out) = (vec![0.0; n], vec![0.0; n]);
        at[i] = 1.0;
        bending.derivative(&at, &mut out, |_, _| ());
        out
    };
    let free: Vec<usize> = (0..n).filter(|&i| !known(i)).collect();
    let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
    let mut matrix: Vec<Vec<f64>> = free
        .iter()
        .map(|&i| {
            let mut line: Vec<f64> = free.iter().map(|&j| columns[j][i]).collect();
            line.push(
                -(0..n)
                    .filter(|&j| known(j))
                    .map(|j| columns[j][i] * f64::from(terrain.cells()[j]))
                    .sum::<f64>(),
            );
            line
        })
        .collect();
    let m = free.len();
    for k in 0..m {
        for i in k + 1..m {
            let share = matrix[i][k] / matrix[k][k];
            let above = matrix[k].clone();
            matrix[i].iter_mut().zip(&above).skip(k).for_each(|(value, above)| *value -= share * above);
        }
    }
    let mut solution = vec![0.0; m];
    for k in (0..m).rev() {
        let after: f64 = (k + 1..m).map(|j| matrix[k][j] * solution[j]).sum();
        solution[k] = (matrix[k][m] - after) / matrix[k][k];
    }
    let out = filled(&terrain);
    for (&i, expected) in free.iter().zip(&solution) {
        assert!((f64::from(out.cells()[i]) - expected).abs() < 1e-2, "{} {expected}", out.cells()[i]);
    }
}

#[test]
fn nothing_known_stays_void_and_single_heights_spread() {
    assert_eq!(filled(&field(5, 5, |_, _| f64::NAN)).void_count(), 25);
    assert!(filled(&field(0, 0, |_, _| 0.0)).grid().is_empty());
    for (rows, cols) in [(1, 1), (1, 9), (9, 1), (2, 2), (5, 5)] {
        let out = filled(&field(rows, cols, |row, col| if row + col == 0 { 42.0 } else { f64::NAN }));
        assert!(out.cells().iter().all(|height| (height - 42.0).abs() < 1e-3), "{:?}", out.cells());
    }
}

#[test]
fn a_mask_chooses_the_cells_and_leaves_other_voids() {
    let plane = |row: usize, col: usize| (row + 2 * col) as f64;
    let mut spiked = field(9, 9, plane);
    spiked.cells_mut()[0] = f32::NAN;
    spiked.cells_mut()[40] = 99.0;
    let mut holes: Mask = spiked.map(&Job::detached(), |_| 0.0).unwrap();
    holes.cells_mut()[40] = 1.0;
    let out = thin_plate_fill(&spiked, Some(&holes), STIFF, &Job::detached()).unwrap();
    assert!(out.at(0, 0).is_nan());
    assert!((f64::from(out.cells()[40]) - plane(4, 4)).abs() < 1e-3);
    spiked.cells_mut()[7] = f32::INFINITY;
    assert!(matches!(
        thin_plate_fill(&spiked, None, STIFF, &Job::detached()),
        Err(Error::NonFinite { row: 0, col: 7, .. })
    ));
}

#[test]
fn under_tension_a_wide_plate_is_a_membrane() {
    // Far more tension than a cell can bend against: the harmonic fill.
    let rough = |row: usize, col: usize| 100.0 * unit(key(3, 3, row as i64, col as i64));
    let terrain = holed(rough, is_void);
    let slack = thin_plate_fill(&terrain, None, Stiffness { stiffness: 0.01 }, &Job::detached()).unwrap();
    let harmonic = crate::repair::harmonic_fill::harmonic_fill(&terrain, None, &Job::detached()).unwrap();
    let apart = slack.cells().iter().zip(harmonic.cells()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 0.05, "{apart}");
    // A flank beside a void goes on for less far.
    let step = |_: usize, col: usize| if col < 10 { col as f64 } else { 0.0 };
    let bay = field(60, 80, |row, col| {
        if (10..70).contains(&col) && (5..55).contains(&row) { f64::NAN } else { step(row, col) }
    });
    let highest = |stiffness: f64| {
        let out = thin_plate_fill(&bay, None, Stiffness { stiffness }, &Job::detached()).unwrap();
        out.range().unwrap().1
    };
    assert!(highest(1e9) > highest(50.0) + 1.0);
}

#[test]
fn threads_do_not_change_a_bit() {
    let rough = |row: usize, col: usize| unit(key(3, 3, row as i64, col as i64));
    let terrain =
        field(300, 200, |row, col| if (row * 7 + col * 3) % 13 == 0 { rough(row, col) } else { f64::NAN });
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filled(&terrain)).into_cells()
    };
    assert!(on(1) == on(2) && on(1) == on(8));
}
