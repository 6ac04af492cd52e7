//! Greedy insertion: the cell that a triangulation misses worst becomes its next corner, until none is missed by much.
//!
//! Garland, M. and Heckbert, P. S. (1995), "Fast Polygonal Approximation of Terrains and Height Fields", CMU-CS-95-181,
//! algorithm III: each triangle knows its worst cell, a heap knows the worst of all, and only triangles around a new
//! corner are looked at again. Departures: cells beside voids are corners from the start, so that no triangle
//! reaches over a void; among equal errors the cell first in rows and columns goes first, so that the result is one.

use std::{
    cmp::{Ordering, Reverse},
    collections::BinaryHeap,
};

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::delaunay::{Delaunay, Place, area};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// No cell is missed by more, in metres.
    pub(super) error: f64,
    /// No more triangles than this, voids' counted.
    pub(super) triangles: usize,
}

/// A triangulation whose triangles lie over known cells alone or over none.
pub(super) struct Approximation {
    pub(super) triangles: Delaunay,
    /// The most by which a cell is missed, in metres.
    pub(super) error: f64,
}

/// The worst cell of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Miss {
    error: f64,
    place: Place,
}

/// A triangle in the heap and its worst cell; out of date once the triangle misses another cell worst. As one number
/// the greatest goes first: the error, then the cell first in rows and columns, then the first triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u128);

/// Bits for the number of a cell, and of a triangle. The 63 bits of an error that is not negative are left above them.
const CELL_BITS: u32 = 34;
const TRIANGLE_BITS: u32 = 31;
/// Cells and triangles that can be told apart.
const MOST_CELLS: u64 = 1 << CELL_BITS;
const MOST_TRIANGLES: u64 = 1 << TRIANGLE_BITS;

impl Entry {
    fn new(miss: Miss, triangle: u32, cols: usize) -> Self {
        let cell = miss.place[0] as u64 * cols as u64 + miss.place[1] as u64;
        let first = (MOST_CELLS - 1 - cell) << TRIANGLE_BITS | (MOST_TRIANGLES - 1 - u64::from(triangle));
        Self(u128::from(miss.error.to_bits()) << (CELL_BITS + TRIANGLE_BITS) | u128::from(first))
    }

    fn triangle(self) -> u32 {
        let from_last = self.0 as u64 & (MOST_TRIANGLES - 1);
        (MOST_TRIANGLES - 1 - from_last) as u32
    }
}

/// Bytes for each corner of what is kept here: two triangles, their worst cells, places in the heap.
const BYTES_PER_CORNER: u64 = 192;
/// Cells looked at between two questions whether to stop.
const PATIENCE: i64 = 1 << 18;
/// Cells from which on it pays to look at triangles in parallel.
const MANY_CELLS: i64 = 1 << 15;

/// Approximates a terrain of two rows and columns at least.
///
/// # Errors
/// [`Error::Invalid`] for more cells than can be told apart; [`Error::TooLarge`]; [`Error::Cancelled`].
pub(super) fn approximate(terrain: &Heightfield, limits: Limits, job: &Job) -> Result<Approximation> {
    let grid = terrain.grid();
    if grid.len() as u64 > MOST_CELLS {
        return Err(Error::invalid(
            format!("{} × {} cells are too many to triangulate at once", grid.rows, grid.cols),
            "cut the terrain into pieces with transform.crop",
        ));
    }
    let mut triangles = Delaunay::new(grid.rows as i32, grid.cols as i32, grid.cell);
    insert_borders(terrain, &mut triangles, job)?;
    let mut misses: Vec<Miss> = (0..triangles.len() as u32)
        .into_par_iter()
        .map(|triangle| {
            job.check()?;
            Ok(worst(terrain, triangles.triangle(triangle)))
        })
        .collect::<Result<_>>()?;
    let mut heap: BinaryHeap<Entry> = (0..)
        .zip(&misses)
        .filter(|(_, miss)| miss.error > limits.error)
        .map(|(triangle, &miss)| Entry::new(miss, triangle, grid.cols))
        .collect();
    let mut admitted = admit(0, triangles.places.len(), job)?;
    let (mut around, mut again) = (Vec::new(), Vec::new());
    let (mut patience, mut reported) = (PATIENCE, 0.0_f64);
    while let Some(entry) = heap.pop() {
        let triangle = entry.triangle();
        let miss = misses[triangle as usize];
        if entry != Entry::new(miss, triangle, grid.cols) {
            continue;
        }
        // A new corner brings two triangles, at the rim one.
        if triangles.len() + 2 > limits.triangles {
            break;
        }
        if triangles.places.len() > admitted {
            admitted = admit(admitted, triangles.places.len(), job)?;
        }
        triangles.insert(triangle, miss.place);
        triangles.around_newest(triangle, &mut around);
        misses.resize(triangles.len(), Miss { error: 0.0, place: miss.place });
        let cells = look_again(terrain, &triangles, &around, &mut again);
        for (&triangle, &miss) in around.iter().zip(&again) {
            misses[triangle as usize] = miss;
            if miss.error > limits.error {
                heap.push(Entry::new(miss, triangle, grid.cols));
            }
        }
        patience -= cells + 64;
        if patience < 0 {
            patience = PATIENCE;
            job.check()?;
            // The error falls about as the number of triangles grows.
            let share = (limits.error / miss.error).max(triangles.len() as f64 / limits.triangles as f64);
            reported = reported.max(share.min(1.0));
            job.progress(reported);
        }
    }
    let error = misses.iter().map(|miss| miss.error).fold(0.0, f64::max);
    Ok(Approximation { triangles, error })
}

/// Admits room for twice the corners there are, and returns how many that is.
fn admit(before: usize, corners: usize, job: &Job) -> Result<usize> {
    let wanted = (corners * 2).max(before).max(1 << 12);
    job.admit(wanted as u64 * BYTES_PER_CORNER, || format!("a triangulation with {corners} corners"))?;
    Ok(wanted)
}

/// Worst cells of the triangles around a new corner; returns about how many cells were looked at.
fn look_again(terrain: &Heightfield, triangles: &Delaunay, around: &[u32], out: &mut Vec<Miss>) -> i64 {
    let cells: i64 = around
        .iter()
        .map(|&triangle| {
            let [a, b, c] = triangles.triangle(triangle);
            area(a, b, c) / 2
        })
        .sum();
    let look = |&triangle: &u32| worst(terrain, triangles.triangle(triangle));
    out.clear();
    if cells > MANY_CELLS {
        out.par_extend(around.par_iter().map(look));
    } else {
        out.extend(around.iter().map(look));
    }
    cells
}

/// A cell and when its turn comes: by how coarse a lattice it lies on, then along a curve that keeps neighbours together.
type Turn = (Reverse<u32>, u64, Place);

/// Makes every cell a corner that shares a square of four cells with a void, and the void with it: then each edge
/// along such squares is in the triangulation, and no triangle lies over both known cells and voids but in those
/// squares.
fn insert_borders(terrain: &Heightfield, triangles: &mut Delaunay, job: &Job) -> Result<()> {
    let rows: Vec<Vec<Turn>> = (0..terrain.rows())
        .into_par_iter()
        .map(|row| {
            job.check()?;
            Ok(border_cells(terrain, row))
        })
        .collect::<Result<_>>()?;
    let mut borders = rows.concat();
    // Coarse to fine, and neighbours in turn: then walks are short and few flips are undone.
    borders.par_sort_unstable();
    let mut admitted = admit(0, borders.len() / 2, job)?;
    let mut triangle = 0;
    for (done, (_, _, place)) in borders.into_iter().enumerate() {
        if done.is_multiple_of(1024) {
            job.check()?;
            if triangles.places.len() > admitted {
                admitted = admit(admitted, triangles.places.len(), job)?;
            }
        }
        triangle = triangles.locate(triangle, place);
        triangles.insert(triangle, place);
    }
    Ok(())
}

/// The cells of a row that share a square with a cell of the other kind, each with its turn.
fn border_cells(terrain: &Heightfield, row: usize) -> Vec<Turn> {
    let (rows, cols) = terrain.grid().size();
    let lines: Vec<&[f32]> =
        (row.saturating_sub(1)..(row + 2).min(rows)).map(|near| terrain.row(near)).collect();
    let mut found = Vec::new();
    for (col, height) in terrain.row(row).iter().enumerate() {
        let near = col.saturating_sub(1)..(col + 2).min(cols);
        let void = height.is_nan();
        if lines.iter().any(|line| line[near.clone()].iter().any(|height| height.is_nan() != void)) {
            let level = (row | col).trailing_zeros();
            let turn = (spread(row as u32) << 1) | spread(col as u32);
            found.push((Reverse(level), turn, [row as i32, col as i32]));
        }
    }
    found
}

/// The bits of a number with a gap between each.
fn spread(number: u32) -> u64 {
    let mut bits = u64::from(number);
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        bits = (bits | (bits << shift)) & mask;
    }
    bits
}

/// The cell that a triangle, rim included, misses worst. Voids are not missed, and a triangle with a corner on a void
/// misses nothing.
fn worst(terrain: &Heightfield, corners: [Place; 3]) -> Miss {
    let [a, b, c] = corners;
    let mut worst = Miss { error: 0.0, place: a };
    let twice = area(a, b, c);
    let [at_a, at_b, at_c] = corners.map(|[row, col]| f64::from(terrain.at(row as usize, col as usize)));
    // Half a square has no other cells.
    if twice <= 1 || (at_a + at_b + at_c).is_nan() {
        return worst;
    }
    let [b_row, b_col, c_row, c_col] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]].map(f64::from);
    let (rise_b, rise_c) = (at_b - at_a, at_c - at_a);
    let per_row = (rise_b * c_col - rise_c * b_col) / twice as f64;
    let per_col = (rise_c * b_row - rise_b * c_row) / twice as f64;
    let (top, bottom) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
    for row in top..=bottom {
        let Some((west, east)) = stretch(corners, row) else { continue };
        let heights = &terrain.row(row as usize)[west as usize..=east as usize];
        let level = at_a + per_row * f64::from(row - a[0]);
        for (col, &height) in (west..).zip(heights) {
            let error = (level + per_col * f64::from(col - a[1]) - f64::from(height)).abs();
            // Rounding may miss a corner by a hair; it is one already.
            if error > worst.error && !corners.contains(&[row, col]) {
                worst = Miss { error, place: [row, col] };
            }
        }
    }
    worst
}

/// First and last column of a triangle in a row that it crosses.
fn stretch(corners: [Place; 3], row: i32) -> Option<(i32, i32)> {
    let (mut west, mut east) = (i64::MIN, i64::MAX);
    for side in 0..3 {
        let ([from_row, from_col], [to_row, to_col]) = (corners[side], corners[(side + 1) % 3]);
        let down = i64::from(to_row - from_row);
        let across = i64::from(to_col - from_col) * i64::from(row - from_row);
        // Counter-clockwise, the inside lies east of an edge that runs south.
        match down.cmp(&0) {
            Ordering::Greater => west = west.max(i64::from(from_col) + ceiling(across, down)),
            Ordering::Less => east = east.min(i64::from(from_col) + (-across).div_euclid(-down)),
            Ordering::Equal => {}
        }
    }
    (west <= east).then_some((west as i32, east as i32))
}

fn ceiling(number: i64, by: i64) -> i64 {
    -(-number).div_euclid(by)
}
