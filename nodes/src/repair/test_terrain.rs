//! Terrain for the tests of this family.

use orograph_core::{Heightfield, Job, Mask, gaussian, key};

use crate::test_fields::field;

/// Rough ground of 40 × 53 cells with many depressions, level parts and a few voids.
pub(super) fn rough(seed: u64) -> Heightfield {
    field(40, 53, |row, col| {
        let (r, c) = (row as i64, col as i64);
        let void = key(seed, 9, r, c).is_multiple_of(97);
        let height =
            20.0 * libm::sin(row as f64 / 6.0) * libm::cos(col as f64 / 7.0) + gaussian(seed, 1, r, c) * 3.0;
        if void { f64::NAN } else { height.round() }
    })
}

/// The mask of the cells that `is_in`.
pub(super) fn mask(like: &Heightfield, is_in: impl Fn(usize, usize) -> bool + Sync) -> Mask {
    Mask::build(like.grid().clone(), &Job::detached(), |row, out| {
        out.iter_mut().enumerate().for_each(|(col, out)| *out = f32::from(u8::from(is_in(row, col))));
        Ok(())
    })
    .unwrap()
}
