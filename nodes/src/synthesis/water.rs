//! Water: sea, lakes and rivers after a mask.
//!
//! Zhou 2007 §6 carves coasts, lakes and rivers with simple masks. A river's level falls monotonely from its highest
//! reach to its mouth, along distances within the mask; a skeleton is not needed for that.

use std::collections::VecDeque;

use orograph_core::prelude::*;

use crate::mask::distance::distances;

/// What the mask is.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The sea: ground inside goes below the level and falls away from the coast.
    Sea,
    /// Lakes: each connected part lies level with the lowest ground around it.
    Lake,
    /// Rivers: each connected part falls from its highest reach to its mouth.
    River,
}

/// Lowers the ground under a mask to make sea, lakes or rivers; ground outside stays to the bit.
#[derive(Params, Clone, Debug)]
pub struct Water {
    /// What the mask is.
    #[param(default = Kind::Lake)]
    pub kind: Kind,
    /// Level of the sea.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -100.0..=1000.0, unit = "m")]
    pub level: f64,
    /// How steeply the sea's ground falls away from the coast.
    #[param(default = 0.02, range = 0.0..=100.0, slider = 0.0..=0.5, unit = "m/m")]
    pub depth_slope: f64,
    /// Width within the mask over which a river's bank falls to the water.
    #[param(default = 60, range = 0.0..=100_000.0, slider = 0.0..=500.0, unit = "m")]
    pub bank: f64,
}

/// Inputs of [`Water`].
#[derive(Inputs)]
pub struct WaterIn<'a> {
    /// Terrain to put water on.
    pub terrain: &'a Heightfield,
    /// Where there is water, where at least one half, on the terrain's grid.
    pub mask: &'a Mask,
}

/// Outputs of [`Water`].
#[derive(Outputs)]
pub struct WaterOut {
    /// Terrain with its water surfaces, or for the sea its ground.
    pub terrain: Heightfield,
    /// 1 where there is water.
    pub water: Mask,
}

impl Node for Water {
    const ID: &'static str = "synthesis.water";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = WaterIn<'a>;
    type Outputs = WaterOut;

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, inputs: WaterIn<'_>, job: &Job) -> Result<WaterOut> {
        let WaterIn { terrain, mask } = inputs;
        terrain.grid().match_size("terrain", mask.grid(), "mask")?;
        let water: Mask = mask.map(job, |share| f32::from(u8::from(share >= 0.5)))?;
        let mut out = terrain.map(job, |height| height)?;
        if self.kind == Kind::Lake {
            for part in parts(&water, job)? {
                let level = around(&part, terrain, &water).fold(f32::INFINITY, f32::min);
                if level.is_finite() {
                    part.iter().for_each(|&i| out.cells_mut()[i] = level);
                }
            }
            return Ok(WaterOut { terrain: out, water });
        }
        let to_coast = distances(&water, |share| share < 0.5, job)?;
        if self.kind == Kind::Sea {
            for (i, out) in out.cells_mut().iter_mut().enumerate() {
                if water.cells()[i] >= 0.5 {
                    // A sea without coast has no distance to it and lies at its level.
                    let away = f64::from(to_coast.cells()[i]);
                    let away = if away.is_nan() { 0.0 } else { away };
                    let floor = (self.level - self.depth_slope * away) as f32;
                    *out = if out.is_nan() { floor } else { out.min(floor) };
                }
            }
            return Ok(WaterOut { terrain: out, water });
        }
        for part in parts(&water, job)? {
            let levels = self.river(&part, terrain, &water);
            for (&i, level) in part.iter().zip(levels) {
                let ground = terrain.cells()[i];
                if level.is_nan() {
                    continue;
                }
                let away = f64::from(to_coast.cells()[i]);
                // Half a cosine from the bank's edge to the water.
                let share = if self.bank > 0.0 && away < self.bank {
                    0.5 - 0.5 * libm::cos(std::f64::consts::PI * away / self.bank)
                } else {
                    1.0
                };
                let wanted = ground + (level - ground) * share as f32;
                out.cells_mut()[i] = if ground.is_nan() { level } else { wanted.min(ground) };
            }
        }
        Ok(WaterOut { terrain: out, water })
    }
}

impl Water {
    /// The water's level at each cell of a river: the lowest ground upstream at its distance from the mouth, or less.
    fn river(&self, part: &[usize], terrain: &Heightfield, water: &Mask) -> Vec<f32> {
        let (rows, cols) = terrain.grid().size();
        let heights = terrain.cells();
        let known = || part.iter().copied().filter(|&i| !heights[i].is_nan());
        // The mouth is the lowest cell, at the border where the river reaches it.
        let at_border = |i: usize| {
            i / cols == 0 || i / cols + 1 == rows || i.is_multiple_of(cols) || (i + 1).is_multiple_of(cols)
        };
        let lowest = |cells: &mut dyn Iterator<Item = usize>| {
            cells.min_by(|&a, &b| heights[a].total_cmp(&heights[b]).then(a.cmp(&b)))
        };
        let Some(mouth) = lowest(&mut known().filter(|&i| at_border(i))).or_else(|| lowest(&mut known()))
        else {
            return vec![f32::NAN; part.len()];
        };
        let mut distance = vec![u32::MAX; part.len()];
        let number = |i: usize| part.binary_search(&i).ok();
        let mut queue = VecDeque::new();
        if let Some(first) = number(mouth) {
            distance[first] = 0;
            queue.push_back(first);
        }
        let mut level = vec![f32::INFINITY];
        while let Some(at) = queue.pop_front() {
            let far = distance[at] as usize;
            if level.len() <= far {
                level.resize(far + 1, f32::INFINITY);
            }
            if !heights[part[at]].is_nan() {
                level[far] = level[far].min(heights[part[at]]);
            }
            for next in near(part[at], rows, cols).filter(|&j| water.cells()[j] >= 0.5).filter_map(number) {
                if distance[next] == u32::MAX {
                    distance[next] = far as u32 + 1;
                    queue.push_back(next);
                }
            }
        }
        // From the source down no reach lies above the one before.
        for far in (0..level.len().saturating_sub(1)).rev() {
            level[far] = level[far].min(level[far + 1]);
        }
        let at = |far: &u32| {
            level.get(*far as usize).copied().filter(|level| level.is_finite()).unwrap_or(f32::NAN)
        };
        distance.iter().map(at).collect()
    }
}

fn near(i: usize, rows: usize, cols: usize) -> impl Iterator<Item = usize> {
    let (row, col) = (i / cols, i % cols);
    let four = [
        (col > 0).then(|| i.wrapping_sub(1)),
        (row > 0).then(|| i.wrapping_sub(cols)),
        (col + 1 < cols).then_some(i + 1),
        (row + 1 < rows).then_some(i + cols),
    ];
    four.into_iter().flatten()
}

/// Connected parts of the water, each in row-major order.
fn parts(water: &Mask, job: &Job<'_>) -> Result<Vec<Vec<usize>>> {
    let (rows, cols) = water.grid().size();
    let mut seen = vec![false; water.cells().len()];
    let mut out = Vec::new();
    for first in 0..seen.len() {
        if first % cols == 0 {
            job.check()?;
        }
        if seen[first] || water.cells()[first] < 0.5 {
            continue;
        }
        seen[first] = true;
        let (mut part, mut at) = (vec![first], 0);
        while at < part.len() {
            for next in near(part[at], rows, cols) {
                if !seen[next] && water.cells()[next] >= 0.5 {
                    seen[next] = true;
                    part.push(next);
                }
            }
            at += 1;
        }
        part.sort_unstable();
        out.push(part);
    }
    Ok(out)
}

/// Known heights beside a part of the water.
fn around<'a>(
    part: &'a [usize],
    terrain: &'a Heightfield,
    water: &'a Mask,
) -> impl Iterator<Item = f32> + 'a {
    let (rows, cols) = terrain.grid().size();
    part.iter()
        .flat_map(move |&i| near(i, rows, cols))
        .filter(|&j| water.cells()[j] < 0.5)
        .map(|j| terrain.cells()[j])
        .filter(|height| !height.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn run(node: &Water, terrain: &Heightfield, mask: impl Fn(usize, usize) -> bool) -> Heightfield {
        let cols = terrain.cols();
        let cells =
            (0..terrain.cells().len()).map(|i| f32::from(u8::from(mask(i / cols, i % cols)))).collect();
        let mask = Mask::new(terrain.grid().clone(), cells).unwrap();
        node.run(WaterIn { terrain, mask: &mask }, &Job::detached()).unwrap().terrain
    }

    #[test]
    fn a_lake_lies_level_with_its_lowest_shore_and_the_shore_stays() {
        let terrain = field(9, 9, |row, col| (row * 10 + col) as f64);
        let inside = |row: usize, col: usize| (3..6).contains(&row) && (3..6).contains(&col);
        let out = run(&Water { kind: Kind::Lake, ..Water::default() }, &terrain, inside);
        for row in 0..9 {
            for col in 0..9 {
                let truth = if inside(row, col) { 23.0 } else { terrain.at(row, col) };
                assert_eq!(out.at(row, col), truth);
            }
        }
    }

    #[test]
    fn a_river_never_rises_and_the_sea_falls_away_from_the_coast() {
        let terrain = field(30, 11, |row, _| 100.0 - row as f64 + 20.0 * libm::sin(row as f64));
        let river = Water { kind: Kind::River, bank: 0.0, ..Water::default() };
        let out = run(&river, &terrain, |_, col| (4..7).contains(&col));
        let middle: Vec<f32> = (0..30).map(|row| out.at(row, 5)).collect();
        assert!(middle.windows(2).all(|pair| pair[1] <= pair[0]), "{middle:?}");
        assert_eq!(out.at(3, 0), terrain.at(3, 0));
        let sea = Water { kind: Kind::Sea, level: 50.0, depth_slope: 0.5, ..Water::default() };
        let flat = field(5, 10, |_, _| 80.0);
        let out = run(&sea, &flat, |_, col| col >= 4);
        // Cells of 10 m: the first wet cell is one cell from the coast's last dry one.
        assert_eq!((out.at(2, 3), out.at(2, 4), out.at(2, 6)), (80.0, 45.0, 35.0));
    }
}
