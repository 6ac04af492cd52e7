//! Feathering: the step between a patch and the ground around it is taken away.

use orograph_core::prelude::*;

use super::{
    harmonic_fill::harmonic_fill,
    voids::{around, fill_by_cell},
};

/// How patches are feathered.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feather {
    /// The mismatch along the rim is spread smoothly over the whole patch: all details stay, and planes stay exact.
    HarmonicOffset,
    /// Cells near the rim become the mean of themselves and the known ones around: the paper's rule, which blurs the rim.
    Average,
    /// Patches stay as they are.
    None,
}

/// How patches are joined to the ground around.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Joining {
    /// How patches are feathered.
    #[param(default = Feather::HarmonicOffset)]
    pub feather: Feather,
    /// How far averages reach.
    #[param(default = 1u32, range = 1..=32, slider = 1..=8, unit = "cells")]
    pub feather_radius: u32,
}

/// Joins patches to the ground around them without a step.
///
/// Known heights stay to the bit.
#[derive(Params, Clone, Debug)]
pub struct FeatherRim {
    /// How patches are joined.
    #[param(flatten)]
    pub joining: Joining,
}

/// Inputs of [`FeatherRim`].
#[derive(Inputs)]
pub struct FeatherRimIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
    /// Its patched voids; known cells beside them may have the height that the patch would have there, as
    /// `repair.area_details` tells.
    pub patch: &'a Heightfield,
}

/// Outputs of [`FeatherRim`].
#[derive(Outputs)]
pub struct FeatherRimOut {
    /// Terrain with its voids filled.
    pub terrain: Heightfield,
}

impl Node for FeatherRim {
    const ID: &'static str = "repair.feather";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FeatherRimIn<'a>;
    type Outputs = FeatherRimOut;

    fn run(&self, inputs: FeatherRimIn<'_>, job: &Job) -> Result<FeatherRimOut> {
        inputs.terrain.grid().match_size("terrain", inputs.patch.grid(), "patch")?;
        Ok(FeatherRimOut { terrain: feather(inputs.terrain, inputs.patch, self.joining, job)? })
    }
}

/// The voids of `terrain` filled from `patch`, joined to the ground around.
///
/// # Errors
/// Those of [`harmonic_fill`].
pub fn feather(
    terrain: &Heightfield,
    patch: &Heightfield,
    joining: Joining,
    job: &Job<'_>,
) -> Result<Heightfield> {
    match joining.feather {
        Feather::HarmonicOffset => harmonic_offset(terrain, patch, job),
        Feather::Average => average(terrain, patch, joining.feather_radius as usize, job),
        Feather::None => fill_by_cell(terrain, job, |row, col| patch.at(row, col)),
    }
}

fn harmonic_offset(terrain: &Heightfield, patch: &Heightfield, job: &Job<'_>) -> Result<Heightfield> {
    let size = terrain.grid().size();
    let is_void = |i: usize| terrain.cells()[i].is_nan();
    let offset = Heightfield::build(terrain.grid().clone(), job, |row, out| {
        for (col, out) in out.iter_mut().enumerate() {
            let i = row * size.1 + col;
            if !is_void(i) {
                let beside_void = around(i, size).into_iter().flatten().any(is_void);
                let step = terrain.cells()[i] - patch.cells()[i];
                *out = if beside_void && !step.is_nan() { step } else { 0.0 };
            }
        }
        Ok(())
    })?;
    let steps = offset.cells().iter().any(|step| !step.is_nan() && *step != 0.0);
    let offset = if steps { harmonic_fill(&offset, None, job)? } else { offset };
    fill_by_cell(terrain, job, |row, col| {
        let by = offset.at(row, col);
        patch.at(row, col) + if by.is_nan() { 0.0 } else { by }
    })
}

fn average(terrain: &Heightfield, patch: &Heightfield, radius: usize, job: &Job<'_>) -> Result<Heightfield> {
    let (rows, cols) = terrain.grid().size();
    fill_by_cell(terrain, job, |row, col| {
        let (mut sum, mut n) = (f64::from(patch.at(row, col)), 1.0);
        for row in row.saturating_sub(radius)..(row + radius + 1).min(rows) {
            for height in &terrain.row(row)[col.saturating_sub(radius)..(col + radius + 1).min(cols)] {
                if !height.is_nan() {
                    (sum, n) = (sum + f64::from(*height), n + 1.0);
                }
            }
        }
        (sum / n) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn is_void(row: usize, col: usize) -> bool {
        (10..20).contains(&row) && (8..25).contains(&col)
    }

    fn joined(
        of: impl Fn(usize, usize) -> f64,
        patch: impl Fn(usize, usize) -> f64,
        feather_by: Feather,
    ) -> Heightfield {
        let terrain = field(30, 40, |row, col| if is_void(row, col) { f64::NAN } else { of(row, col) });
        let joining = Joining { feather: feather_by, feather_radius: 1 };
        feather(&terrain, &field(30, 40, patch), joining, &Job::detached()).unwrap()
    }

    #[test]
    fn a_patch_that_is_too_high_comes_down_to_its_rim() {
        let plane = |row: usize, col: usize| 3.0 * row as f64 + 2.0 * col as f64;
        let details = |row: usize, col: usize| f64::from(u8::from((row + col).is_multiple_of(2)));
        let patched = |row: usize, col: usize| {
            plane(row, col) + 50.0 + if is_void(row, col) { details(row, col) } else { 0.0 }
        };
        let out = joined(plane, patched, Feather::HarmonicOffset);
        for row in 0..30 {
            for col in 0..40 {
                let detail = if is_void(row, col) { details(row, col) } else { 0.0 };
                assert!((f64::from(out.at(row, col)) - plane(row, col) - detail).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn averages_are_those_of_the_paper() {
        let out = joined(|_, _| 9.0, |row, col| if is_void(row, col) { 0.0 } else { 9.0 }, Feather::Average);
        // Three known cells beside a side, five at a corner, none in the middle.
        assert_eq!([out.at(10, 12), out.at(10, 8), out.at(14, 14)], [9.0 * 3.0 / 4.0, 9.0 * 5.0 / 6.0, 0.0]);
        let none = joined(|_, _| 9.0, |_, _| 1.0, Feather::None);
        assert_eq!([none.at(0, 0), none.at(10, 12)], [9.0, 1.0]);
    }
}
