use orograph_core::{key, signed_unit};

use super::*;
use crate::test_fields::field;

/// A rough hillside of 90 × 110 cells of 20 × 30 m.
fn hills() -> Heightfield {
    let rough = |row: usize, col: usize| 10.0 * signed_unit(key(4, 1, row as i64, col as i64));
    let terrain = field(90, 110, |row, col| {
        1000.0 + 100.0 * libm::sin(row as f64 / 9.0) * libm::cos(col as f64 / 14.0) + rough(row, col)
    });
    terrain.with_grid(Grid::new(90, 110, CellSize { x: 20.0, y: 30.0 }).unwrap()).unwrap()
}

/// Five points and a line of heights that falls evenly.
fn wishes(terrain: &Heightfield) -> Wanted {
    let cols = terrain.cols();
    let mut all: Vec<(usize, f64)> = [(20, 20), (21, 21), (70, 15), (50, 90), (10, 100)]
        .into_iter()
        .zip([300.0, 280.0, -300.0, 150.0, -80.0])
        .map(|((row, col), rise)| (row * cols + col, f64::from(terrain.at(row, col)) + rise))
        .collect();
    all.extend((30..80).map(|col| (60 * cols + col, 1200.0 - col as f64)));
    Wanted::new(all).unwrap()
}

fn settings(shape: Shape) -> ElevationConstraints {
    ElevationConstraints { shape, ..ElevationConstraints::default() }
}

fn met(terrain: &Heightfield, wanted: &Wanted, settings: &ElevationConstraints) -> (Vec<f64>, Heightfield) {
    let job = Job::detached();
    let change = change(terrain, wanted, settings, &job).unwrap();
    (change, constrain(terrain, wanted, settings, &job).unwrap())
}

#[test]
fn wanted_heights_are_met_and_far_ground_and_voids_stay() {
    let mut terrain = hills();
    for row in 30..60 {
        terrain.cells_mut()[row * 110 + 60] = f32::NAN;
    }
    let wanted = wishes(&terrain);
    for shape in [Shape::Smooth, Shape::Membrane] {
        for influence in [0.0, 400.0] {
            let (change, out) =
                met(&terrain, &wanted, &ElevationConstraints { influence, ..settings(shape) });
            for (cell, height) in wanted.iter() {
                assert_eq!(out.cells()[cell], height);
                let raw = f64::from(terrain.cells()[cell]) + change[cell];
                assert!((raw - f64::from(height)).abs() < 1e-4, "{shape:?} {raw} {height}");
            }
            for i in 0..terrain.cells().len() {
                let (row, col) = (i / 110, i % 110);
                assert_eq!(terrain.cells()[i].is_nan(), out.cells()[i].is_nan());
                let away = |(cell, _): (usize, f32)| {
                    let (dy, dx) = ((row.abs_diff(cell / 110)) as f64, (col.abs_diff(cell % 110)) as f64);
                    libm::hypot(30.0 * dy, 20.0 * dx)
                };
                let near = wanted.iter().map(away).fold(f64::INFINITY, f64::min);
                if influence > 0.0 && near > influence && !terrain.cells()[i].is_nan() {
                    assert_eq!(terrain.cells()[i].to_bits(), out.cells()[i].to_bits());
                }
            }
        }
    }
}

#[test]
fn what_is_met_already_changes_nothing() {
    let terrain = hills();
    let own = (0..110).map(|col| (40 * 110 + col, f64::from(terrain.at(40, col)))).collect();
    for wanted in [Wanted::new(own).unwrap(), Wanted::default()] {
        for shape in [Shape::Smooth, Shape::Membrane] {
            for fit in [Fit::Exact, Fit::Weighted] {
                let (_, out) = met(&terrain, &wanted, &ElevationConstraints { fit, ..settings(shape) });
                assert_eq!(out.cells(), terrain.cells());
            }
        }
    }
}

#[test]
fn a_membrane_is_harmonic_and_invents_no_extremum() {
    let terrain = hills();
    let wanted = wishes(&terrain);
    let (change, _) = met(&terrain, &wanted, &settings(Shape::Membrane));
    let sites: Vec<usize> = wanted.iter().map(|(cell, _)| cell).collect();
    let at_sites = sites.iter().map(|&cell| change[cell]);
    let (low, high) =
        at_sites.fold((f64::MAX, f64::MIN), |(low, high), change| (low.min(change), high.max(change)));
    assert!(change.iter().all(|change| (low - 1e-6..=high + 1e-6).contains(change)));
    for row in 0..90 {
        for col in 0..110 {
            let i = row * 110 + col;
            if sites.contains(&i) {
                continue;
            }
            let near = [
                (col > 0).then(|| (i - 1, 1.0)),
                (col < 109).then_some((i + 1, 1.0)),
                (row > 0).then(|| (i - 110, 4.0 / 9.0)),
                (row < 89).then_some((i + 110, 4.0 / 9.0)),
            ];
            let flow: f64 =
                near.into_iter().flatten().map(|(j, weight)| weight * (change[j] - change[i])).sum();
            assert!(flow.abs() < 1e-5, "{flow} at {row}, {col}");
        }
    }
}

#[test]
fn harmonic_and_even_changes_are_reproduced() {
    // Constraints all along the border of a part, from a harmonic function of true metres.
    let terrain = hills();
    let truth = |row: usize, col: usize| {
        let (x, y) = (col as f64 * 0.2, row as f64 * 0.3);
        (x * x - y * y) / 4.0 + 2.0 * x - 3.0 * y + 7.0
    };
    let rim = |row: usize, col: usize| row == 0 || col == 0 || row == 89 || col == 109;
    let wish = |i: usize| (i, f64::from(terrain.cells()[i]) + truth(i / 110, i % 110));
    let wanted = Wanted::new((0..90 * 110).filter(|&i| rim(i / 110, i % 110)).map(wish).collect()).unwrap();
    let (change, _) = met(&terrain, &wanted, &settings(Shape::Membrane));
    for (i, change) in change.iter().enumerate() {
        // Wanted heights are rounded to single precision.
        assert!((change - truth(i / 110, i % 110)).abs() < 1e-3, "{change} {}", truth(i / 110, i % 110));
    }
    // One point lifts a membrane with free borders as a whole.
    let wanted = Wanted::new(vec![(40 * 110 + 50, f64::from(terrain.at(40, 50)) + 25.0)]).unwrap();
    let (change, _) = met(&terrain, &wanted, &settings(Shape::Membrane));
    assert!(change.iter().all(|change| (change - 25.0).abs() < 1e-4));
}

#[test]
fn a_smooth_change_has_no_spike() {
    let terrain = field(101, 101, |_, _| 0.0);
    let wanted = Wanted::new(vec![(50 * 101 + 50, 100.0)]).unwrap();
    let settings = |shape| ElevationConstraints { influence: 400.0, ..settings(shape) };
    let (smooth, _) = met(&terrain, &wanted, &settings(Shape::Smooth));
    let (membrane, _) = met(&terrain, &wanted, &settings(Shape::Membrane));
    // Wendland's bell falls by 1 - (39/40)⁴ (1 + 4/40) over one cell.
    let bell = |far: f64| libm::pow(1.0 - far / 40.0, 4.0) * (1.0 + far / 10.0);
    assert!((smooth[50 * 101 + 51] - 100.0 * bell(1.0)).abs() < 1e-6);
    assert!((smooth[50 * 101 + 60] - 100.0 * bell(10.0)).abs() < 1e-6);
    assert!(membrane[50 * 101 + 51] < 80.0);
}

#[test]
fn weights_lead_from_nothing_to_exactness() {
    let terrain = hills();
    let wanted = wishes(&terrain);
    for shape in [Shape::Smooth, Shape::Membrane] {
        let with = |weight: f64| {
            let fit = Fit::Weighted;
            met(&terrain, &wanted, &ElevationConstraints { fit, weight, influence: 600.0, ..settings(shape) })
                .0
        };
        let exact = met(&terrain, &wanted, &ElevationConstraints { influence: 600.0, ..settings(shape) }).0;
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart(&with(1e6), &exact) < 0.01, "{}", apart(&with(1e6), &exact));
        assert!(apart(&with(1e-6), &vec![0.0; exact.len()]) < 0.01);
        let off = |change: &[f64]| {
            wanted.iter().map(|(cell, _)| (change[cell] - exact[cell]).abs()).fold(0.0, f64::max)
        };
        let offs = [0.01, 0.1, 1.0, 10.0, 100.0].map(|weight| off(&with(weight)));
        assert!(offs.windows(2).all(|pair| pair[0] > pair[1]), "{offs:?}");
    }
}

#[test]
fn a_weighted_membrane_solves_the_equations_of_least_squares() {
    let terrain = hills();
    let wanted = wishes(&terrain);
    let weight = 0.7;
    let settings = ElevationConstraints { fit: Fit::Weighted, weight, ..settings(Shape::Membrane) };
    let (change, _) = met(&terrain, &wanted, &settings);
    let mut force = vec![0.0; change.len()];
    for (cell, height) in wanted.iter() {
        force[cell] = weight * (f64::from(height) - f64::from(terrain.cells()[cell]) - change[cell]);
    }
    for i in 0..change.len() {
        let (row, col) = (i / 110, i % 110);
        let near = [
            (col > 0).then(|| (i - 1, 1.0)),
            (col < 109).then_some((i + 1, 1.0)),
            (row > 0).then(|| (i - 110, 4.0 / 9.0)),
            (row < 89).then_some((i + 110, 4.0 / 9.0)),
        ];
        let flow: f64 = near.into_iter().flatten().map(|(j, w)| w * (change[j] - change[i])).sum();
        assert!((flow + force[i]).abs() < 1e-5, "{flow} {}", force[i]);
    }
}

#[test]
fn points_win_over_the_raster_and_share_cells_by_their_mean() {
    let terrain = field(5, 5, |_, _| 10.0);
    let raster = field(5, 5, |row, _| if row == 2 { 30.0 } else { f64::NAN });
    let points =
        Points::new(vec![20.0, 21.0, 40.0, 1e9], vec![-20.0, -19.0, 0.0, 0.0], vec![50.0, 60.0, 7.0, 1.0])
            .unwrap();
    let node = ElevationConstraints { influence: 12.0, ..ElevationConstraints::default() };
    let inputs =
        ElevationConstraintsIn { terrain: &terrain, constraints: Some(&raster), points: Some(&points) };
    let out = node.run(inputs, &Job::detached()).unwrap();
    assert_eq!((out.terrain.at(2, 2), out.terrain.at(2, 1), out.terrain.at(0, 4)), (55.0, 30.0, 7.0));
    assert_eq!(out.report.metric("constraints"), Some(6.0));
    assert_eq!(out.report.metric("off_after_max"), Some(0.0));
    assert_eq!(out.report.metric("off_before_max"), Some(45.0));
    assert_eq!(out.change.at(2, 2), 45.0);
}

#[test]
fn dense_and_contradictory_constraints_are_met() {
    let terrain = hills();
    let wish = |i: usize| (i, 500.0 + 500.0 * signed_unit(key(5, 2, i as i64, 0)));
    let wanted = Wanted::new((0..90 * 110).filter(|i| i % 3 != 0).map(wish).collect()).unwrap();
    let (_, out) = met(&terrain, &wanted, &settings(Shape::Smooth));
    assert!(wanted.iter().all(|(cell, height)| out.cells()[cell] == height));
    // Between them nothing flies off.
    let (low, high) = out.range().unwrap();
    assert!(low > -700.0 && high < 1700.0, "{low} {high}");
}
