//! Squares between four cells, and the triangles that they make where heights are known.
//!
//! Corners are numbers of cells, row by row; triangles run counter-clockwise seen from above.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{delaunay::Place, greedy::Approximation};

/// Every known cell a corner: two triangles for each square of known cells, one where a single corner is a void.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Cancelled`].
pub(super) fn regular(terrain: &Heightfield, job: &Job) -> Result<Vec<[u32; 3]>> {
    let squares = (terrain.rows() as u64 - 1) * (terrain.cols() as u64 - 1);
    job.admit(squares * 48, || format!("a mesh of {} triangles", squares * 2))?;
    let rows: Vec<Vec<[u32; 3]>> = (0..terrain.rows() - 1)
        .into_par_iter()
        .map(|row| {
            job.check()?;
            let mut triangles = Vec::with_capacity(terrain.cols() * 2);
            for col in 0..terrain.cols() - 1 {
                match around(terrain, row, col).map(f64::from) {
                    [nw, ne, sw, se] if !(nw + ne + sw + se).is_nan() => {
                        let [nw_at, ne_at, sw_at, se_at] = numbers(terrain, row, col);
                        // Along the diagonal that rises less: it follows crests and talwegs.
                        if (nw - se).abs() <= (ne - sw).abs() {
                            triangles.extend([[nw_at, sw_at, se_at], [nw_at, se_at, ne_at]]);
                        } else {
                            triangles.extend([[nw_at, sw_at, ne_at], [ne_at, sw_at, se_at]]);
                        }
                    }
                    _ => triangles.extend(beside_void(terrain, row, col)),
                }
            }
            Ok(triangles)
        })
        .collect::<Result<_>>()?;
    Ok(rows.concat())
}

/// The triangles of an approximation that lie over known cells.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Cancelled`].
pub(super) fn adaptive(
    terrain: &Heightfield,
    approximation: &Approximation,
    job: &Job,
) -> Result<Vec<[u32; 3]>> {
    let triangles = &approximation.triangles;
    job.admit(triangles.len() as u64 * 12, || format!("a mesh of {} triangles", triangles.len()))?;
    let number = |[row, col]: Place| row as u32 * terrain.cols() as u32 + col as u32;
    let whole = terrain.void_count() == 0;
    let mut found: Vec<[u32; 3]> = (0..triangles.len() as u32)
        .into_par_iter()
        .map(|triangle| triangles.triangle(triangle))
        .filter(|corners| whole || lies_on_ground(terrain, corners))
        .map(|corners| corners.map(number))
        .collect();
    if !whole {
        for row in 0..terrain.rows() - 1 {
            job.check()?;
            found.extend((0..terrain.cols() - 1).filter_map(|col| beside_void(terrain, row, col)));
        }
    }
    // In the order of the ground, whatever the order of insertion was: neighbours lie near each other in the file.
    found.par_iter_mut().for_each(|corners| {
        let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
        corners.rotate_left(first);
    });
    found.par_sort_unstable();
    Ok(found)
}

/// Known cells that no square of at least three known cells holds.
pub(super) fn lonely_cells(terrain: &Heightfield) -> usize {
    let (rows, cols) = terrain.grid().size();
    let meshed = |row: usize, col: usize| {
        let known = around(terrain, row, col).iter().filter(|height| !height.is_nan()).count();
        known >= 3
    };
    let lonely = |row: usize, col: usize| {
        let mut squares = (row.saturating_sub(1)..(row + 1).min(rows - 1))
            .flat_map(|r| (col.saturating_sub(1)..(col + 1).min(cols - 1)).map(move |c| (r, c)));
        !terrain.at(row, col).is_nan() && !squares.any(|(row, col)| meshed(row, col))
    };
    (0..rows).into_par_iter().map(|row| (0..cols).filter(|&col| lonely(row, col)).count()).sum()
}

/// Whether a triangle has known corners, and lies in no square with a void: those make their own.
fn lies_on_ground(terrain: &Heightfield, corners: &[Place; 3]) -> bool {
    let void = |[row, col]: Place| terrain.at(row as usize, col as usize).is_nan();
    if corners.iter().any(|&corner| void(corner)) {
        return false;
    }
    let least = |axis: usize| corners[0][axis].min(corners[1][axis]).min(corners[2][axis]);
    let most = |axis: usize| corners[0][axis].max(corners[1][axis]).max(corners[2][axis]);
    let in_a_square = (0..2).all(|axis| most(axis) - least(axis) == 1);
    !in_a_square
        || around(terrain, least(0) as usize, least(1) as usize).iter().all(|height| !height.is_nan())
}

/// Heights of the square whose north-western corner is given: north-west, north-east, south-west, south-east.
fn around(terrain: &Heightfield, row: usize, col: usize) -> [f32; 4] {
    let (north, south) = (terrain.row(row), terrain.row(row + 1));
    [north[col], north[col + 1], south[col], south[col + 1]]
}

fn numbers(terrain: &Heightfield, row: usize, col: usize) -> [u32; 4] {
    let cols = terrain.cols() as u32;
    let first = row as u32 * cols + col as u32;
    [first, first + 1, first + cols, first + cols + 1]
}

/// The triangle of a square with one void.
fn beside_void(terrain: &Heightfield, row: usize, col: usize) -> Option<[u32; 3]> {
    let [nw, ne, sw, se] = numbers(terrain, row, col);
    match around(terrain, row, col).map(f32::is_nan) {
        [true, false, false, false] => Some([ne, sw, se]),
        [false, true, false, false] => Some([nw, sw, se]),
        [false, false, true, false] => Some([nw, se, ne]),
        [false, false, false, true] => Some([nw, sw, ne]),
        _ => None,
    }
}
