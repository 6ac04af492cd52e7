use orograph_core::gaussian;

use super::*;
use crate::{
    repair::thin_plate_fill::{Stiffness, thin_plate_fill},
    test_fields::field,
};

fn rough(row: usize, col: usize) -> f64 {
    1000.0 + 4.0 * row as f64 + 10.0 * gaussian(1, 1, row as i64, col as i64)
}

fn is_void(row: usize, col: usize) -> bool {
    let (y, x) = (row as f64 - 60.0, col as f64 - 60.0);
    x * x + 2.0 * y * y < 300.0 || row < 6 && col < 9 || row == 100 && col == 30
}

fn holed() -> (Heightfield, Heightfield) {
    let terrain = field(120, 120, |row, col| if is_void(row, col) { f64::NAN } else { rough(row, col) });
    let smooth = thin_plate_fill(&terrain, None, Stiffness::default(), &Job::detached()).unwrap();
    (terrain, smooth)
}

fn paper() -> Details {
    Details {
        levels: 3,
        boundary: Boundary::Clamped,
        margin: 0,
        strength: Match::Source,
        source: From::Neighbours,
        ..Details::default()
    }
}

#[test]
fn known_cells_stay_and_voids_are_as_rough_as_the_ground_around() {
    let (terrain, smooth) = holed();
    for details in [Details::default(), Details { levels: 4, ..Details::default() }, paper()] {
        let node = AreaDetails { details };
        let out = node.run(AreaDetailsIn { terrain: &terrain, smooth: &smooth }, &Job::detached()).unwrap();
        assert_eq!(out.terrain.void_count(), 0);
        for (out, height) in out.terrain.cells().iter().zip(terrain.cells()) {
            assert!(height.is_nan() || out.to_bits() == height.to_bits());
        }
        let square = |terrain: &Heightfield, inside: bool| {
            let (mut sum, mut n) = (0.0, 0.0);
            for row in 52..69 {
                for col in 48..73 {
                    if is_void(row, col) == inside {
                        let value = crate::surface::laplacian(terrain, [row, col], 1).unwrap();
                        (sum, n) = (sum + value * value, n + 1.0);
                    }
                }
            }
            sum / n
        };
        let truth = field(120, 120, rough);
        let ratio = libm::sqrt(square(&out.terrain, true) / square(&truth, true));
        let range = if details == paper() { 0.7..1.5 } else { 0.8..1.25 };
        assert!(range.contains(&ratio), "{details:?}: {ratio}");
    }
}

#[test]
fn the_papers_box_has_the_details_of_its_source() {
    let (terrain, smooth) = holed();
    let (patch, report) = transplant(&terrain, &smooth, &paper(), &Job::detached()).unwrap();
    let number = |name: &str, row: usize| match &report.column(name).unwrap().cells {
        Cells::Numbers(numbers) => numbers[row] as usize,
        Cells::Texts(_) => panic!("numbers expected"),
    };
    // The second void, the blot: its box and its source have one size.
    let (rows, cols) = (number("rows", 1), number("cols", 1));
    let cut = |raster: &Heightfield, row: usize, col: usize| Surface {
        size: (rows, cols),
        cells: (0..rows * cols).map(|i| f64::from(raster.at(row + i / cols, col + i % cols))).collect(),
    };
    let source = cut(&terrain, number("source_row", 1), number("source_col", 1));
    let base = cut(&smooth, number("row", 1), number("col", 1));
    let wanted = source.details(3, Boundary::Clamped, &Job::detached()).unwrap();
    let own = base.details(3, Boundary::Clamped, &Job::detached()).unwrap();
    for i in 0..rows * cols {
        let (row, col) = (number("row", 1) + i / cols, number("col", 1) + i % cols);
        if is_void(row, col) {
            let expected = base.cells[i] - own.cells[i] + wanted.cells[i];
            assert!((f64::from(patch.at(row, col)) - expected).abs() < 1e-3);
        }
    }
}

#[test]
fn smooth_ground_stays_smooth() {
    let plane = |row: usize, col: usize| 100.0 + 3.0 * row as f64 - col as f64;
    let terrain = field(120, 120, |row, col| if is_void(row, col) { f64::NAN } else { plane(row, col) });
    let smooth = field(120, 120, plane);
    for details in [Details::default(), Details { boundary: Boundary::Natural, ..paper() }] {
        let (patch, _) = transplant(&terrain, &smooth, &details, &Job::detached()).unwrap();
        for row in 0..120 {
            for col in 0..120 {
                assert!(
                    (f64::from(patch.at(row, col)) - plane(row, col)).abs() < 2e-3,
                    "{details:?} {row} {col}"
                );
            }
        }
    }
}

#[test]
fn no_gain_is_no_change_and_little_room_no_failure() {
    let (terrain, smooth) = holed();
    let none = Details { detail_gain: 0.0, ..Details::default() };
    let (patch, _) = transplant(&terrain, &smooth, &none, &Job::detached()).unwrap();
    assert!(patch.cells().iter().zip(smooth.cells()).all(|(a, b)| (a - b).abs() < 1e-3));
    for (rows, cols) in [(0, 0), (1, 1), (3, 3), (7, 9), (16, 5)] {
        let terrain =
            field(rows, cols, |row, col| if row == 1 && col == 1 { f64::NAN } else { rough(row, col) });
        let smooth = field(rows, cols, rough);
        let (patch, report) = transplant(&terrain, &smooth, &Details::default(), &Job::detached()).unwrap();
        assert_eq!(patch.void_count(), 0);
        assert_eq!(report.rows(), usize::from(rows > 1 && cols > 1));
    }
    let nothing = field(30, 30, |_, _| f64::NAN);
    let (patch, _) = transplant(&nothing, &nothing, &Details::default(), &Job::detached()).unwrap();
    assert_eq!(patch.void_count(), 900);
}
