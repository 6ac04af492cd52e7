//! The shape of the ground around a cell: its 3 × 3 neighbourhood and the gradient there.
//!
//! Horn, B. K. P. (1981), "Hill shading and the reflectance map", Proceedings of the IEEE 69 (1): differences
//! across the neighbourhood, the middle row and column counted twice. Departures: cells need not be square,
//! and at borders and beside voids the missing neighbours continue the ground as a plane: a tilted plane has
//! its own gradient in every cell that has a neighbour in both directions.

use glam::DVec2;
use orograph_core::Heightfield;

/// Heights of the 3 × 3 cells around a cell, row by row from the north-west; `None` where the cell is a void.
///
/// A neighbour that lies outside the grid, is a void or is infinite continues the line from the opposite
/// neighbour through the centre; where that is missing too, an edge takes the centre's height and a corner
/// the plane through the centre and the two edges beside it.
#[must_use]
pub fn window(terrain: &Heightfield, row: usize, col: usize) -> Option<[f64; 9]> {
    let (rows, cols) = terrain.grid().size();
    if row >= rows || col >= cols {
        return None;
    }
    let mut window = [f64::NAN; 9];
    let first_col = col.saturating_sub(1);
    let into = usize::from(col == 0);
    for (dr, line) in window.chunks_exact_mut(3).enumerate() {
        // `row + dr` is one more than the row meant.
        let Some(source) = (row + dr).checked_sub(1).filter(|&source| source < rows) else { continue };
        let last_col = (col + 2).min(cols);
        for (height, &cell) in line[into..].iter_mut().zip(&terrain.row(source)[first_col..last_col]) {
            *height = f64::from(cell);
        }
    }
    let centre = window[4];
    if !centre.is_finite() {
        return None;
    }
    if window.iter().any(|height| !height.is_finite()) {
        continue_plane(&mut window);
    }
    Some(window)
}

/// Fills the missing neighbours of a known centre.
fn continue_plane(window: &mut [f64; 9]) {
    let given = *window;
    let centre = given[4];
    for edge in [1, 3, 5, 7] {
        if !given[edge].is_finite() {
            let opposite = given[8 - edge];
            window[edge] = if opposite.is_finite() { 2.0 * centre - opposite } else { centre };
        }
    }
    for (corner, beside) in [(0, (1, 3)), (2, (1, 5)), (6, (3, 7)), (8, (5, 7))] {
        if !given[corner].is_finite() {
            let opposite = given[8 - corner];
            window[corner] = if opposite.is_finite() {
                2.0 * centre - opposite
            } else {
                window[beside.0] + window[beside.1] - centre
            };
        }
    }
}

/// Rise per metre towards the east (x) and the north (y) at a cell, in m/m; `None` where the cell is a void.
#[must_use]
pub fn gradient(terrain: &Heightfield, row: usize, col: usize) -> Option<DVec2> {
    let [nw, n, ne, w, _, e, sw, s, se] = window(terrain, row, col)?;
    let cell = terrain.grid().cell;
    let east = (ne + 2.0 * e + se) - (nw + 2.0 * w + sw);
    let north = (nw + 2.0 * n + ne) - (sw + 2.0 * s + se);
    Some(DVec2::new(east / (8.0 * cell.x), north / (8.0 * cell.y)))
}

/// Steepness of a gradient, in degrees from the level: 0 to 90.
#[must_use]
pub fn slope_degrees(gradient: DVec2) -> f64 {
    libm::atan(gradient.length()).to_degrees()
}

/// The compass direction that a gradient faces (downhill), in degrees clockwise from north: 0 up to, not
/// including, 360. `None` on level ground.
#[must_use]
pub fn aspect_degrees(gradient: DVec2) -> Option<f64> {
    if gradient == DVec2::ZERO {
        return None;
    }
    let degrees = libm::atan2(-gradient.x, -gradient.y).to_degrees();
    let turned = if degrees < 0.0 { degrees + 360.0 } else { degrees };
    // A direction a hair west of north rounds up to a full turn.
    Some(if turned >= 360.0 { 0.0 } else { turned })
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::{CellSize, Grid};

    fn plane(rows: usize, cols: usize, tilt: DVec2, voids: &[usize]) -> Heightfield {
        let grid = Grid::new(rows, cols, CellSize { x: 30.0, y: 20.0 }).unwrap();
        let mut cells: Vec<f32> =
            (0..rows * cols).map(|i| (100.0 + tilt.dot(grid.position(i / cols, i % cols))) as f32).collect();
        voids.iter().for_each(|&i| cells[i] = f32::NAN);
        Heightfield::new(grid, cells).unwrap()
    }

    #[test]
    fn a_plane_on_oblong_cells_has_its_own_gradient_in_every_cell() {
        // 3/8 m a column and 1/2 m a row keep every height exact.
        let tilt = DVec2::new(0.0125, -0.025);
        for voids in [&[][..], &[17], &[0, 17, 20, 25]] {
            let terrain = plane(6, 7, tilt, voids);
            for i in 0..42 {
                match gradient(&terrain, i / 7, i % 7) {
                    Some(found) => assert!((found - tilt).length() < 1e-6, "cell {i}: {found}"),
                    None => assert!(voids.contains(&i)),
                }
            }
        }
    }

    #[test]
    fn tiny_and_odd_fields_have_a_gradient_too() {
        assert_eq!(gradient(&plane(1, 1, DVec2::X, &[]), 0, 0), Some(DVec2::ZERO));
        assert_eq!(gradient(&plane(0, 0, DVec2::X, &[]), 0, 0), None);
        let strip = gradient(&plane(1, 3, DVec2::new(0.5, 0.5), &[]), 0, 1).unwrap();
        assert!((strip - DVec2::new(0.5, 0.0)).length() < 1e-6);
    }

    #[test]
    fn slopes_and_aspects_are_those_of_the_compass() {
        assert!((slope_degrees(DVec2::new(0.6, 0.8)) - 45.0).abs() < 1e-12);
        for (uphill, facing) in
            [(DVec2::NEG_Y, 0.0), (DVec2::NEG_X, 90.0), (DVec2::Y, 180.0), (DVec2::X, 270.0)]
        {
            assert!((aspect_degrees(uphill).unwrap() - facing).abs() < 1e-12, "{uphill}");
        }
        assert_eq!(aspect_degrees(DVec2::ZERO), None);
    }
}
