//! How strong details must be: as rough as the ground around, less what the smooth patch has already.
//!
//! A smooth patch is roughest along its rim, where it still bends with the ground outside. Details of one strength
//! everywhere would make the rim too rough or the middle too smooth, so that the strength grows inward.

use orograph_core::prelude::*;

use super::frame::Frame;
use crate::{
    filter::chaikin::Surface,
    repair::voids::{Void, around},
    surface::laplacian,
};

/// Distance from the rim, in cells, from which on the patch counts as its middle.
const DEEP: usize = 8;

/// Most that details are multiplied by.
const MOST: f64 = 4.0;

/// Multipliers by the distance from the rim: the last for everything deeper, and the first at known cells too, so that the
/// step which details make at the rim can be told.
pub(super) struct Strength {
    depths: Vec<u8>,
    by_depth: [f64; DEEP + 1],
}

impl Strength {
    /// Multipliers for a void in its box: `rough` is the mean square of the Laplacian that is wanted.
    pub(super) fn new(base: &Heightfield, void: &Void, frame: &Frame, details: &Surface, rough: f64) -> Self {
        let depths = depths(void, frame);
        let cell = base.grid().cell;
        let (mut own, mut added, mut counts) = ([0.0; DEEP + 1], 0.0, [0.0; DEEP + 1]);
        let mut n_added = 0.0;
        for (i, &depth) in depths.iter().enumerate().filter(|(_, depth)| **depth > 0) {
            if let Some(value) = laplacian(base, frame.cell(i), 1) {
                own[depth as usize] += value * value;
                counts[depth as usize] += 1.0;
            }
            if let Some(value) = laplacian_inside(details, i, cell) {
                added += value * value;
                n_added += 1.0;
            }
        }
        let mut by_depth = [0.0; DEEP + 1];
        for depth in 1..=DEEP {
            let lacking = rough - own[depth] / counts[depth];
            let gain = libm::sqrt(lacking.max(0.0) * n_added / added);
            by_depth[depth] = if gain.is_finite() { gain.min(MOST) } else { 0.0 };
        }
        by_depth[0] = by_depth[1];
        Self { depths, by_depth }
    }

    /// The multiplier at a cell of the box.
    pub(super) fn at(&self, i: usize) -> f64 {
        self.by_depth[self.depths[i] as usize]
    }

    /// The multiplier in the middle of the void.
    pub(super) fn middle(&self) -> f64 {
        let deepest = self.depths.iter().copied().max().unwrap_or(0);
        self.by_depth[deepest as usize]
    }
}

/// Steps from known ground to each cell of the box, held at [`DEEP`].
fn depths(void: &Void, frame: &Frame) -> Vec<u8> {
    let mut depths = vec![0; frame.len()];
    let cols = frame.size[1];
    let local: Vec<usize> = void.cells.iter().filter_map(|&cell| frame.find(void.place(cell))).collect();
    local.iter().for_each(|&i| depths[i] = DEEP as u8);
    let mut front: Vec<usize> = Vec::new();
    for depth in 1..DEEP as u8 {
        front.clear();
        // Beyond the box lies the border of the raster, which is no known ground.
        let beside_shallow = |&i: &usize| {
            let near = around(i, (frame.size[0], cols)).into_iter().flatten();
            depths[i] == DEEP as u8 && near.into_iter().any(|near| depths[near] == depth - 1)
        };
        front.extend(local.iter().copied().filter(beside_shallow));
        front.iter().for_each(|&i| depths[i] = depth);
    }
    depths
}

/// Laplacian in 1/m of details, beside one another.
fn laplacian_inside(details: &Surface, i: usize, cell: CellSize) -> Option<f64> {
    let (rows, cols) = details.size;
    let (row, col) = (i / cols, i % cols);
    if row == 0 || col == 0 || row + 1 >= rows || col + 1 >= cols {
        return None;
    }
    let at = |i: usize| details.cells[i];
    let across = (at(i - 1) - 2.0 * at(i) + at(i + 1)) / (cell.x * cell.x);
    let down = (at(i - cols) - 2.0 * at(i) + at(i + cols)) / (cell.y * cell.y);
    Some(across + down)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{repair::voids, test_fields::field};
    use orograph_core::gaussian;

    #[test]
    fn depth_grows_from_the_rim_inward() {
        let hole = |i: usize| (3..8).contains(&(i / 12)) && (2..9).contains(&(i % 12));
        let void = voids::find((12, 12), 0, hole, &Job::detached()).unwrap().remove(0);
        let frame = Frame::around(&void, 1, 1, (12, 12)).unwrap();
        let depths = depths(&void, &frame);
        let at = |row: usize, col: usize| depths[frame.find([row, col]).unwrap()];
        assert_eq!([at(2, 5), at(3, 5), at(4, 5), at(5, 5), at(6, 5), at(7, 5)], [0, 1, 2, 3, 2, 1]);
    }

    #[test]
    fn smooth_ground_gets_all_of_the_roughness_and_rough_ground_none() {
        let hole = |i: usize| (10..30).contains(&(i / 40)) && (10..30).contains(&(i % 40));
        let void = voids::find((40, 40), 0, hole, &Job::detached()).unwrap().remove(0);
        let frame = Frame::around(&void, 2, 2, (40, 40)).unwrap();
        let size = (frame.size[0], frame.size[1]);
        let cells = (0..frame.len()).map(|i| gaussian(1, 1, i as i64, 0)).collect();
        let details = Surface { size, cells };
        let plane = field(40, 40, |row, col| (3 * row + col) as f64);
        // White noise of variance 1 has a Laplacian of variance 20 between cells, here of 10 m.
        let rough = 4.0 * 20.0 / 1e4;
        let strength = Strength::new(&plane, &void, &frame, &details, rough);
        assert!((strength.middle() - 2.0).abs() < 0.2, "{}", strength.middle());
        assert_eq!(strength.at(0), strength.at(frame.find([10, 15]).unwrap()));
        let noise = field(40, 40, |row, col| 5.0 * gaussian(2, 2, row as i64, col as i64));
        assert_eq!(Strength::new(&noise, &void, &frame, &details, rough).middle(), 0.0);
    }
}
