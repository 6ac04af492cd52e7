//! Breach depressions: a channel is cut from the bottom of each closed depression to the nearest lower ground.
//!
//! Lindsay, J. B. (2016), "Efficient hybrid breaching-filling sink removal methods for flow path enforcement in digital
//! elevation models", Hydrological Processes 30 (6): the channel is the one that cuts least, found by Dijkstra's
//! algorithm with the depth of cut as the cost of each cell. Depressions are taken from the lowest up, so that a higher
//! one can use the channels of those below. A channel falls evenly where the limit of depth allows, else less. It only
//! lowers ground, never below its own end, and so makes no new depression. What would take too deep or too long a
//! channel is left for `repair.fill_depressions`.

mod channel;

use orograph_core::{Unit, prelude::*};

use super::lakes::Lakes;
use crate::measure::drainage::flood::{around, leaves};
use channel::Search;

/// Cuts channels out of closed depressions, so that water runs off with little change to the ground.
///
/// Water leaves over the border and into voids. Nothing is ever raised.
#[derive(Params, Clone, Debug)]
pub struct BreachDepressions {
    /// Deepest cut; depressions that need a deeper one are left. 0 for no limit.
    #[param(default = 0, range = 0.0..=20_000.0, slider = 0.0..=100.0, unit = "m")]
    pub max_depth: f64,
    /// How far from a depression's bottom its channel may go; 0 for no limit.
    #[param(default = 0, range = 0.0..=1e7, slider = 0.0..=5000.0, unit = "m")]
    pub max_length: f64,
}

/// Inputs of [`BreachDepressions`].
#[derive(Inputs)]
pub struct BreachDepressionsIn<'a> {
    /// Terrain to cut.
    pub terrain: &'a Heightfield,
    /// Lakes, where at least one half: they stay as they are, and water may end there.
    pub lakes: Option<&'a Mask>,
}

/// Outputs of [`BreachDepressions`].
#[derive(Outputs)]
pub struct BreachDepressionsOut {
    /// Terrain with its channels.
    pub terrain: Heightfield,
    /// How many depressions there were and are left, how many cells were cut, and how deep at most.
    pub report: Table,
}

impl Node for BreachDepressions {
    const ID: &'static str = "repair.breach_depressions";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = BreachDepressionsIn<'a>;
    type Outputs = BreachDepressionsOut;

    fn cost(&self) -> f64 {
        100.0
    }

    fn run(&self, inputs: BreachDepressionsIn<'_>, job: &Job) -> Result<BreachDepressionsOut> {
        let lakes = Lakes::new(inputs.terrain, inputs.lakes)?;
        let (terrain, found, left) = breach(inputs.terrain, lakes, self, job)?;
        let depths = inputs.terrain.cells().iter().zip(terrain.cells());
        let cuts = depths.map(|(&old, &new)| f64::from(old) - f64::from(new)).filter(|&cut| cut > 0.0);
        let (n_cut, deepest) = cuts.fold((0_u64, 0.0), |(n, most), cut| (n + 1, f64::max(most, cut)));
        if left > 0 {
            job.warn(format!("{left} of {found} depressions would need too deep or too long a channel"));
        }
        let report = Table::metrics([
            ("depressions", Unit::One, found as f64),
            ("left", Unit::One, left as f64),
            ("cut", Unit::Cell, n_cut as f64),
            ("cut_max", Unit::Metre, deepest),
        ])?;
        Ok(BreachDepressionsOut { terrain, report })
    }
}

/// The terrain with channels out of its depressions; how many those were, and how many are left.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory or cells are too many to count, [`Error::Cancelled`].
pub fn breach(
    terrain: &Heightfield,
    lakes: Lakes<'_>,
    settings: &BreachDepressions,
    job: &Job,
) -> Result<(Heightfield, u64, u64)> {
    let ground = Ground { size: terrain.grid().size(), is_outlet: outlets(terrain, lakes, job)?, lakes };
    let mut out: Heightfield = terrain.map(job, |height| height)?;
    let bottoms = bottoms(terrain, &ground, job)?;
    let mut search = Search::new(terrain.grid(), [settings.max_depth, settings.max_length], job)?;
    let done = job.stage(bottoms.len() as u64);
    let mut left = 0;
    for &bottom in &bottoms {
        job.check()?;
        // A channel may have drained this one already.
        if out.cells()[bottom] == terrain.cells()[bottom] {
            match search.channel(out.cells(), &ground, bottom, job)? {
                Some(channel) => channel::cut(out.cells_mut(), &channel, search.max_depth),
                None => left += 1,
            }
        }
        done.advance(1);
    }
    Ok((out, bottoms.len() as u64, left))
}

/// What stays the same while channels are cut.
struct Ground<'a> {
    size: (usize, usize),
    /// Where water may leave the terrain or end.
    is_outlet: Vec<bool>,
    lakes: Lakes<'a>,
}

fn outlets(terrain: &Heightfield, lakes: Lakes<'_>, job: &Job) -> Result<Vec<bool>> {
    let n = terrain.grid().len();
    job.admit(n as u64, || format!("the outlets among {n} cells"))?;
    let mut out = vec![false; n];
    for (cell, out) in out.iter_mut().enumerate() {
        if cell.is_multiple_of(1 << 14) {
            job.check()?;
        }
        *out = terrain.cells()[cell].is_finite() && (lakes.at(cell) || leaves(terrain, cell));
    }
    Ok(out)
}

/// A cell of the bottom of each depression, the lowest depression first: level ground without lower neighbour or outlet.
fn bottoms(terrain: &Heightfield, ground: &Ground<'_>, job: &Job) -> Result<Vec<usize>> {
    let (heights, n) = (terrain.cells(), terrain.grid().len());
    job.admit(n as u64, || format!("the depressions among {n} cells"))?;
    let mut seen = vec![false; n];
    let mut bottoms = Vec::new();
    let mut open = Vec::new();
    for start in 0..n {
        if start.is_multiple_of(1 << 14) {
            job.check()?;
        }
        if seen[start] || !heights[start].is_finite() {
            continue;
        }
        let height = heights[start];
        let mut closed = true;
        seen[start] = true;
        open.push(start);
        let mut n_open = 0_u64;
        while let Some(cell) = open.pop() {
            n_open += 1;
            if n_open.is_multiple_of(1 << 14) {
                job.check()?;
            }
            closed &= !ground.is_outlet[cell];
            for (_, other) in around(ground.size, cell) {
                // Beside a void, from which water leaves, nothing is lower or level.
                closed &= heights[other] >= height || heights[other].is_nan();
                if heights[other] == height && !seen[other] {
                    seen[other] = true;
                    open.push(other);
                }
            }
        }
        if closed {
            bottoms.push(start);
        }
    }
    bottoms.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]).then(a.cmp(&b)));
    Ok(bottoms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::drainage::{flood::flood, pits::Pits},
        repair::test_terrain::{mask, rough},
        test_fields::field,
    };

    fn breached(terrain: &Heightfield, lakes: Option<&Mask>, limits: [f64; 2]) -> (Heightfield, u64, u64) {
        let settings = BreachDepressions { max_depth: limits[0], max_length: limits[1] };
        breach(terrain, Lakes::new(terrain, lakes).unwrap(), &settings, &Job::detached()).unwrap()
    }

    fn n_pits(terrain: &Heightfield) -> u64 {
        let job = Job::detached();
        Pits::of(terrain, &flood(terrain, &job).unwrap().filled, 0.0, &job).unwrap().count
    }

    /// A valley that falls along its rows, with a dam across it.
    fn dammed() -> Heightfield {
        field(60, 41, |row, col| {
            let dam = if (30..33).contains(&row) { 12.0 } else { 0.0 };
            200.0 + 5.0 * (col as f64 - 20.0).abs() - row as f64 + dam
        })
    }

    #[test]
    fn a_dam_is_cut_through_and_nothing_else() {
        let terrain = dammed();
        let (out, found, left) = breached(&terrain, None, [0.0; 2]);
        assert_eq!((found, left), (1, 0));
        for row in 0..60 {
            for col in 0..41 {
                let (old, new) = (terrain.at(row, col), out.at(row, col));
                if (30..33).contains(&row) && col == 20 {
                    // Back to the valley as it was without the dam.
                    assert_eq!(new, 200.0 - row as f32);
                } else {
                    assert_eq!(new.to_bits(), old.to_bits());
                }
            }
        }
    }

    #[test]
    fn limits_leave_what_they_forbid() {
        let terrain = dammed();
        // The bottom lies at 171 m, the dam's crown at 182 m; beyond, 40 m off, the valley is lower.
        for (limits, expected) in
            [([10.9, 0.0], 1), ([11.1, 0.0], 0), ([0.0, 39.0], 1), ([0.0, 41.0], 0), ([11.1, 41.0], 0)]
        {
            let (out, _, left) = breached(&terrain, None, limits);
            assert_eq!(left, expected, "{limits:?}");
            assert_eq!(out.cells() == terrain.cells(), expected == 1);
        }
    }

    #[test]
    fn no_depression_is_left_and_nothing_is_raised() {
        for seed in 0..5 {
            let terrain = rough(seed);
            let (out, found, left) = breached(&terrain, None, [0.0; 2]);
            assert!(found > 20 && left == 0 && n_pits(&terrain) > 0);
            assert_eq!(n_pits(&out), 0, "{seed}");
            assert!(out.cells().iter().zip(terrain.cells()).all(|(new, old)| new <= old || old.is_nan()));
            // Once drained, all stays to the bit.
            let (again, found, _) = breached(&out, None, [0.0; 2]);
            assert_eq!(found, 0);
            assert!(again.cells().iter().zip(out.cells()).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    #[test]
    fn lakes_are_left_and_take_water() {
        let terrain = rough(1);
        let lakes = mask(&terrain, |row, col| (10..20).contains(&row) && (10..30).contains(&col));
        let (out, _, left) = breached(&terrain, Some(&lakes), [0.0; 2]);
        assert_eq!(left, 0);
        for (i, lake) in lakes.cells().iter().enumerate() {
            assert!(*lake == 0.0 || out.cells()[i].to_bits() == terrain.cells()[i].to_bits());
        }
        let flooded = crate::measure::drainage::flood::flood_to(
            &out,
            |cell| lakes.cells()[cell] > 0.5,
            &Job::detached(),
        );
        assert_eq!(Pits::of(&out, &flooded.unwrap().filled, 0.0, &Job::detached()).unwrap().count, 0);
    }
}
