//! Fill depressions: closed depressions are filled to where they spill, with a fall towards the spill.
//!
//! Priority-flood, and its variant that leaves no level ground (Barnes, R., Lehman, C. and Mulla, D. (2014),
//! "Priority-flood", Computers & Geosciences 62). Departures: only ground that has to be raised gets the fall, so that
//! terrain without depressions stays to the bit, flats included; the fall is in metres on a metre, not the least number.

use std::{cmp::Reverse, collections::BinaryHeap};

use orograph_core::{Unit, prelude::*};

use super::lakes::Lakes;
use crate::measure::drainage::flood::{NEIGHBOURS, around, leaves, rank};

/// Fills closed depressions, so that water finds its way from everywhere to the border.
///
/// Water leaves over the border and into voids. Nothing is ever lowered.
#[derive(Params, Clone, Debug)]
pub struct FillDepressions {
    /// Fall of filled ground towards the spill; 0 leaves it level.
    #[param(default = 0.0001, range = 0.0..=0.1, slider = 0.0..=0.01, unit = "m/m")]
    pub fall: f64,
}

/// Inputs of [`FillDepressions`].
#[derive(Inputs)]
pub struct FillDepressionsIn<'a> {
    /// Terrain to fill.
    pub terrain: &'a Heightfield,
    /// Lakes, where at least one half: they stay as they are, and water may end there.
    pub lakes: Option<&'a Mask>,
}

/// Outputs of [`FillDepressions`].
#[derive(Outputs)]
pub struct FillDepressionsOut {
    /// Terrain without closed depressions outside lakes.
    pub terrain: Heightfield,
    /// Share of the known ground that was raised, and by how much at most and on the mean of all ground.
    pub report: Table,
}

impl Node for FillDepressions {
    const ID: &'static str = "repair.fill_depressions";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FillDepressionsIn<'a>;
    type Outputs = FillDepressionsOut;

    fn cost(&self) -> f64 {
        60.0
    }

    fn run(&self, inputs: FillDepressionsIn<'_>, job: &Job) -> Result<FillDepressionsOut> {
        let lakes = Lakes::new(inputs.terrain, inputs.lakes)?;
        let terrain = fill(inputs.terrain, lakes, self.fall, job)?;
        let rises = terrain.cells().iter().zip(inputs.terrain.cells());
        let (mut known, mut raised, mut sum, mut most) = (0u64, 0u64, 0.0, 0.0);
        for rise in rises.map(|(&new, &old)| f64::from(new) - f64::from(old)).filter(|rise| !rise.is_nan()) {
            known += 1;
            raised += u64::from(rise > 0.0);
            sum += rise;
            most = f64::max(most, rise);
        }
        let report = Table::metrics([
            ("raised_share", Unit::Percent, 100.0 * raised as f64 / known as f64),
            ("raised_max", Unit::Metre, most),
            ("raised_mean", Unit::Metre, sum / known as f64),
        ])?;
        Ok(FillDepressionsOut { terrain, report })
    }
}

/// Fills the depressions of `terrain` outside lakes, filled ground falling by `fall` metres on a metre.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory or cells are too many to count, [`Error::Cancelled`].
pub fn fill(terrain: &Heightfield, lakes: Lakes<'_>, fall: f64, job: &Job) -> Result<Heightfield> {
    let grid = terrain.grid();
    let (size, n) = (grid.size(), grid.len());
    let bytes = n as u64 * 18;
    if n > u32::MAX as usize {
        let limit = u64::from(u32::MAX) * 18;
        return Err(Error::TooLarge { what: format!("a flood over {n} cells"), bytes, limit });
    }
    job.admit(bytes, || format!("a flood over {n} cells"))?;
    let CellSize { x, y } = grid.cell;
    let far = NEIGHBOURS.map(|(down, right)| libm::hypot(down as f64 * y, right as f64 * x));
    let mut out: Heightfield = terrain.map(job, |height| height)?;
    let heights = out.cells_mut();
    let (mut seen, mut raised) = (vec![false; n], vec![false; n]);
    let mut heap = BinaryHeap::new();
    for cell in 0..n {
        if cell.is_multiple_of(1 << 14) {
            job.check()?;
        }
        if !heights[cell].is_finite() {
            seen[cell] = true;
        } else if lakes.at(cell) || leaves(terrain, cell) {
            seen[cell] = true;
            heap.push(Reverse(rank(heights[cell], cell)));
        }
    }
    let done = job.stage(n as u64);
    let mut n_done = 0_u64;
    while let Some(Reverse(next)) = heap.pop() {
        n_done += 1;
        if n_done.is_multiple_of(1 << 13) {
            job.check()?;
            done.advance(1 << 13);
        }
        let cell = (next & u64::from(u32::MAX)) as usize;
        let level = heights[cell];
        for (direction, other) in around(size, cell) {
            if seen[other] {
                continue;
            }
            seen[other] = true;
            let fallen = (f64::from(level) + fall * far[direction]) as f32;
            if heights[other] < level || raised[cell] && heights[other] < fallen {
                // A fall too small for the number of digits is the least that there is.
                heights[other] = if fall > 0.0 { fallen.max(level.next_up()) } else { level };
                raised[other] = true;
            }
            heap.push(Reverse(rank(heights[other], other)));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::drainage::{flood::flood, pits::Pits},
        repair::test_terrain::{mask, rough},
        test_fields::field,
    };

    fn filled(terrain: &Heightfield, lakes: Option<&Mask>, fall: f64) -> Heightfield {
        fill(terrain, Lakes::new(terrain, lakes).unwrap(), fall, &Job::detached()).unwrap()
    }

    #[test]
    fn no_depression_is_left_and_water_runs_everywhere() {
        for seed in 0..5 {
            let terrain = rough(seed);
            let job = Job::detached();
            let level = filled(&terrain, None, 0.0);
            let flooded = flood(&terrain, &job).unwrap().filled;
            assert!(
                level.cells().iter().zip(flooded.cells()).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
            );
            for fall in [1e-4, 0.01, 1e-12] {
                let out = filled(&terrain, None, fall);
                assert_eq!(Pits::of(&out, &flood(&out, &job).unwrap().filled, 0.0, &job).unwrap().count, 0);
                for cell in 0..out.cells().len() {
                    let (old, new) = (terrain.cells()[cell], out.cells()[cell]);
                    assert!(new >= old || old.is_nan());
                    // Raised ground has a lower neighbour, or lies where water leaves anyway.
                    let lower = |(_, other): (usize, usize)| out.cells()[other] < new;
                    let drains = around(out.grid().size(), cell).any(lower);
                    assert!(new <= old || old.is_nan() || drains, "{seed} {fall} {cell}");
                }
            }
        }
    }

    #[test]
    fn ground_without_depressions_stays_to_the_bit() {
        // A slope with a terrace.
        let terrain =
            field(40, 30, |row, col| (row as f64 * 3.0).min(60.0) + if row > 30 { col as f64 } else { 0.0 });
        let out = filled(&terrain, None, 0.01);
        assert!(terrain.cells().iter().zip(out.cells()).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn lakes_stay() {
        // Two bowls; one of them is a lake below its middle.
        let terrain = field(21, 42, |row, col| {
            let (down, right) = (row as f64 - 10.0, (col % 21) as f64 - 10.0);
            down * down + right * right
        });
        let lakes = mask(&terrain, |row, col| (9..12).contains(&row) && (9..12).contains(&col));
        let out = filled(&terrain, Some(&lakes), 0.0);
        for row in 0..21 {
            for col in 0..21 {
                assert_eq!(out.at(row, col), terrain.at(row, col));
            }
        }
        assert_eq!(out.at(10, 31), 100.0);
    }
}
