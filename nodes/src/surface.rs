//! The shape of the ground around a cell: its 3 × 3 neighbourhood and the gradient there.
//!
//! Horn, B. K. P. (1981), "Hill shading and the reflectance map", Proceedings of the IEEE 69 (1): differences
//! across the neighbourhood, the middle row and column counted twice. Departures: cells need not be square,
//! and at borders and beside voids the missing neighbours continue the ground as a plane: a tilted plane has
//! its own gradient in every cell that has a neighbour in both directions.

use glam::DVec2;
use orograph_core::{CellSize, Heightfield};
use pulp::{Arch, NullaryFnOnce};

/// Cells of a row worked out together; few enough for the nearest cache.
pub(crate) const STRETCH: usize = 256;

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
    let cell = terrain.grid().cell;
    window(terrain, row, col).map(|window| {
        let [east, north] = differences(window);
        DVec2::new(east / (8.0 * cell.x), north / (8.0 * cell.y))
    })
}

/// The gradients of a whole row, a stretch at a time: `take` gets the first column of the stretch and, for each of
/// its cells, the rise per metre towards the east and towards the north, NaN where the cell is a void.
pub fn gradients(terrain: &Heightfield, row: usize, mut take: impl FnMut(usize, &[f64], &[f64])) {
    let (rows, cols) = terrain.grid().size();
    let arch = Arch::new();
    let (mut east, mut north) = ([f64::NAN; STRETCH], [f64::NAN; STRETCH]);
    for start in (0..cols).step_by(STRETCH) {
        let n = STRETCH.min(cols - start);
        let (east, north) = (&mut east[..n], &mut north[..n]);
        east.fill(f64::NAN);
        // Nearly every cell has all its neighbours: those go the short way, in wide registers.
        let inner = start.max(1)..(start + n).min(cols.saturating_sub(1));
        if (1..rows.saturating_sub(1)).contains(&row) && !inner.is_empty() {
            let around = inner.start - 1..inner.end + 1;
            let at = inner.start - start..inner.end - start;
            arch.dispatch(Inner {
                lines: [row - 1, row, row + 1].map(|row| &terrain.row(row)[around.clone()]),
                eight_cells: [8.0 * terrain.grid().cell.x, 8.0 * terrain.grid().cell.y],
                east: &mut east[at.clone()],
                north: &mut north[at],
            });
        }
        for (i, (east, north)) in east.iter_mut().zip(north.iter_mut()).enumerate() {
            if east.is_nan() {
                (*east, *north) = match gradient(terrain, row, start + i) {
                    Some(gradient) => gradient.into(),
                    None => (f64::NAN, f64::NAN),
                };
            }
        }
        take(start, east, north);
    }
}

/// Cells that have neighbours all around, and what is to be known of them.
struct Inner<'a> {
    /// Three rows, one cell longer on either side than the rows below.
    lines: [&'a [f32]; 3],
    eight_cells: [f64; 2],
    east: &'a mut [f64],
    north: &'a mut [f64],
}

impl NullaryFnOnce for Inner<'_> {
    type Output = ();

    /// Leaves NaN towards the east where a height is missing.
    #[inline(always)]
    fn call(self) {
        let [above, at, below] = self.lines.map(|line| line.windows(3));
        let lines = above.zip(at).zip(below);
        for ((east, north), ((above, at), below)) in self.east.iter_mut().zip(self.north).zip(lines) {
            let window = [above[0], above[1], above[2], at[0], at[1], at[2], below[0], below[1], below[2]];
            let window = window.map(f64::from);
            let rise = differences(window);
            // A missing height shows in the sums, since f32 heights cannot overflow them.
            let whole = (rise[0] + rise[1] + window[4]).is_finite();
            *east = if whole { rise[0] / self.eight_cells[0] } else { f64::NAN };
            *north = rise[1] / self.eight_cells[1];
        }
    }
}

/// Horn's weighted differences, east less west and north less south: eight cells' rise.
#[inline(always)]
fn differences([nw, n, ne, w, _, e, sw, s, se]: [f64; 9]) -> [f64; 2] {
    let east = (ne + 2.0 * e + se) - (nw + 2.0 * w + sw);
    let north = (nw + 2.0 * n + ne) - (sw + 2.0 * s + se);
    [east, north]
}

/// Laplacian in 1/m between cells so far apart; `None` where one of them is not known or outside.
pub(crate) fn laplacian(terrain: &Heightfield, [row, col]: [usize; 2], apart: usize) -> Option<f64> {
    let (rows, cols) = terrain.grid().size();
    if row < apart || col < apart || row + apart >= rows || col + apart >= cols {
        return None;
    }
    let height = |row: usize, col: usize| f64::from(terrain.at(row, col));
    let CellSize { x, y } = terrain.grid().cell;
    let twice = 2.0 * height(row, col);
    let across = (height(row, col - apart) - twice + height(row, col + apart)) / (x * x);
    let down = (height(row - apart, col) - twice + height(row + apart, col)) / (y * y);
    let value = (across + down) / (apart * apart) as f64;
    value.is_finite().then_some(value)
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
    fn the_short_way_gives_the_bits_of_the_long_one() {
        let noise = |i: usize| orograph_core::gaussian(3, 4, i as i64, 0) as f32 * 100.0;
        let (rows, cols) = (5, 2 * STRETCH + 3);
        let grid = Grid::new(rows, cols, CellSize { x: 30.0, y: 20.0 }).unwrap();
        let mut cells: Vec<f32> = (0..rows * cols).map(noise).collect();
        for (i, odd) in [(1337, f32::NAN), (1340, f32::INFINITY), (1900, f32::NEG_INFINITY), (0, f32::NAN)] {
            cells[i] = odd;
        }
        let terrain = Heightfield::new(grid, cells).unwrap();
        for row in 0..rows {
            let mut seen = 0;
            gradients(&terrain, row, |start, east, north| {
                assert_eq!(start, seen);
                for (i, (&east, &north)) in east.iter().zip(north).enumerate() {
                    let short = (!east.is_nan()).then_some(DVec2::new(east, north));
                    assert_eq!(short, gradient(&terrain, row, start + i), "cell {row}, {}", start + i);
                    assert!(short.is_none_or(DVec2::is_finite));
                }
                seen += east.len();
            });
            assert_eq!(seen, cols);
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
