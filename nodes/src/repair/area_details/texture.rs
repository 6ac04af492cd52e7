//! What ground feels like: how rough, how steep, how fine-grained.

use orograph_core::prelude::*;

use crate::{
    repair::voids::{Void, around},
    surface::laplacian,
};

/// Mean squares over sampled ground. NaN where nothing is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Texture {
    /// Of the Laplacian between cells beside one another.
    pub(super) rough: f64,
    /// Of the Laplacian between cells two apart.
    coarse: f64,
    /// Of the slope.
    steep: f64,
}

/// Steps from a void over which known ground counts as its surroundings. What lies nearest foretells best how rough the
/// lost ground was.
const COLLAR: usize = 8;

impl Texture {
    /// Of the known ground around a void.
    pub(super) fn around(terrain: &Heightfield, void: &Void) -> Self {
        let (rows, cols) = terrain.grid().size();
        let first = void.first.map(|at| at.saturating_sub(COLLAR));
        let size = [
            (void.last[0] + COLLAR + 1).min(rows) - first[0],
            (void.last[1] + COLLAR + 1).min(cols) - first[1],
        ];
        let mut seen = vec![false; size[0] * size[1]];
        let local = |cell: usize| (cell / cols - first[0]) * size[1] + cell % cols - first[1];
        let mut front: Vec<usize> = void.cells.iter().map(|&cell| local(cell)).collect();
        front.iter().for_each(|&i| seen[i] = true);
        let mut collar = Vec::new();
        for _ in 0..COLLAR {
            let mut next = Vec::new();
            for i in front {
                for near in around(i, (size[0], size[1])).into_iter().flatten() {
                    if !std::mem::replace(&mut seen[near], true) {
                        next.push(near);
                    }
                }
            }
            collar.extend_from_slice(&next);
            front = next;
        }
        Self::of_cells(terrain, collar.into_iter().map(|i| [first[0] + i / size[1], first[1] + i % size[1]]))
    }

    /// Of at most about so many cells of a box, evenly spread.
    pub(super) fn of_box(terrain: &Heightfield, first: [usize; 2], size: [usize; 2], samples: usize) -> Self {
        let step = (size[0] * size[1]).div_ceil(samples).max(1);
        let cells = (0..size[0] * size[1]).step_by(step);
        Self::of_cells(terrain, cells.map(|i| [first[0] + i / size[1], first[1] + i % size[1]]))
    }

    fn of_cells(terrain: &Heightfield, cells: impl Iterator<Item = [usize; 2]>) -> Self {
        let cell = terrain.grid().cell;
        let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
        for at in cells {
            let values =
                [laplacian(terrain, at, 1), laplacian(terrain, at, 2), slope_square(terrain, at, cell)];
            for (k, value) in values.into_iter().enumerate() {
                if let Some(value) = value {
                    sums[k] += if k < 2 { value * value } else { value };
                    counts[k] += 1.0;
                }
            }
        }
        let [rough, coarse, steep] = [0, 1, 2].map(|k| sums[k] / counts[k]);
        Self { rough, coarse, steep }
    }

    /// How far two grounds are apart: the sum of differences of logarithms.
    pub(super) fn apart(&self, other: &Self) -> f64 {
        let ratio = |a: f64, b: f64| if a > 0.0 && b > 0.0 { 0.5 * libm::log(a / b).abs() } else { 0.0 };
        ratio(self.rough, other.rough)
            + ratio(self.steep, other.steep)
            + ratio(self.rough * other.coarse, other.rough * self.coarse)
    }
}

fn slope_square(terrain: &Heightfield, [row, col]: [usize; 2], cell: CellSize) -> Option<f64> {
    let (rows, cols) = terrain.grid().size();
    if row + 1 >= rows || col + 1 >= cols {
        return None;
    }
    let height = |row: usize, col: usize| f64::from(terrain.at(row, col));
    let across = (height(row, col + 1) - height(row, col)) / cell.x;
    let down = (height(row + 1, col) - height(row, col)) / cell.y;
    let square = across * across + down * down;
    square.is_finite().then_some(square)
}
