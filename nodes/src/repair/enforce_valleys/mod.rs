//! Enforce valleys: heights along drawn or found valleys are made to fall to the outlet, and the ground follows.
//!
//! Each connected part of the network is cut into trees of cells, each rooted at an outlet. Isotonic regression gives the
//! nearest heights that never rise on the way there, and these are constraints of [`elevation_constraints`]: slopes
//! beside the valley keep their forms.

mod isotonic;
mod tree;

use orograph_core::{Unit, prelude::*};

use super::lakes::Lakes;
use crate::{
    adjust::elevation_constraints::{self, ElevationConstraints, Fit, Shape, Wanted},
    measure::drainage::flood::{NEIGHBOURS, beside, leaves},
};
use isotonic::isotonic;
use tree::Trees;

/// Makes valleys fall steadily to their outlets, raising and lowering ground as little as that takes.
///
/// A network's outlets are where it comes to the border, to a void or to a lake, else its lowest end; between two of
/// them lies a divide, at the network's highest place there. Depressions beside the valleys are for `repair.breach_depressions` and `repair.fill_depressions`.
#[derive(Params, Clone, Debug)]
pub struct EnforceValleys {
    /// Least fall along a valley.
    #[param(default = 0.001, range = 0.0..=1.0, slider = 0.0..=0.1, unit = "m/m")]
    pub fall: f64,
    /// Beyond this distance from every valley nothing changes.
    #[param(default = 500, range = 0.001..=1e7, slider = 10.0..=5000.0, unit = "m")]
    pub influence: f64,
}

/// Inputs of [`EnforceValleys`].
#[derive(Inputs)]
pub struct EnforceValleysIn<'a> {
    /// Terrain to bend.
    pub terrain: &'a Heightfield,
    /// Valleys on the terrain's grid.
    pub valleys: &'a Features,
    /// Lakes, where at least one half: they stay as they are, and valleys may end there.
    pub lakes: Option<&'a Mask>,
}

/// Outputs of [`EnforceValleys`].
#[derive(Outputs)]
pub struct EnforceValleysOut {
    /// The terrain with its valleys.
    pub terrain: Heightfield,
    /// Heights along the valleys, void elsewhere.
    pub constraints: Heightfield,
    /// Cells of valleys, outlets, and how far valleys were lowered and raised at most.
    pub report: Table,
}

impl Node for EnforceValleys {
    const ID: &'static str = "repair.enforce_valleys";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = EnforceValleysIn<'a>;
    type Outputs = EnforceValleysOut;

    fn cost(&self) -> f64 {
        150.0
    }

    fn run(&self, inputs: EnforceValleysIn<'_>, job: &Job) -> Result<EnforceValleysOut> {
        job.check()?;
        let EnforceValleysIn { terrain, valleys, lakes } = inputs;
        terrain.grid().match_size("terrain", &valleys.grid, "valleys")?;
        let lakes = Lakes::new(terrain, lakes)?;
        let heights = terrain.cells();
        let size = terrain.grid().size();
        let beside_lake = |cell: usize| {
            (0..NEIGHBOURS.len()).filter_map(|d| beside(size, cell, d)).any(|other| lakes.at(other))
        };
        let trees = Trees::new(
            valleys,
            heights,
            |cell| heights[cell].is_finite() && !lakes.at(cell),
            |cell| leaves(terrain, cell) || beside_lake(cell),
            job,
        )?;
        let wanted = falling(&trees, heights, self.fall);
        let (mut raised, mut lowered) = (0.0, 0.0);
        for (&cell, wanted) in trees.cells.iter().zip(&wanted) {
            let rise = wanted - f64::from(heights[cell]);
            (raised, lowered) = (f64::max(raised, rise), f64::max(lowered, -rise));
        }
        let report = Table::metrics([
            ("valley_cells", Unit::Cell, trees.cells.len() as f64),
            ("outlets", Unit::One, trees.outlets as f64),
            ("raised_max", Unit::Metre, raised),
            ("lowered_max", Unit::Metre, lowered),
        ])?;
        let wanted = Wanted::new(trees.cells.iter().copied().zip(wanted).collect())?;
        let mut constraints = Heightfield::filled(terrain.grid().clone(), f32::NAN, job)?;
        wanted.iter().for_each(|(cell, height)| constraints.cells_mut()[cell] = height);
        let settings = ElevationConstraints {
            shape: Shape::Smooth,
            influence: self.influence,
            fit: Fit::Exact,
            ..ElevationConstraints::default()
        };
        let mut bent = elevation_constraints::constrain(terrain, &wanted, &settings, job)?;
        for (cell, height) in bent.cells_mut().iter_mut().enumerate().filter(|(cell, _)| lakes.at(*cell)) {
            *height = heights[cell];
        }
        Ok(EnforceValleysOut { terrain: bent, constraints, report })
    }
}

/// Heights along valleys, nearest to their own, that fall by at least `fall` metres on a metre.
fn falling(trees: &Trees, heights: &[f32], fall: f64) -> Vec<f64> {
    // Above the least fall, all that is wanted is not to rise.
    let above = |(&cell, length): (&usize, &f64)| f64::from(heights[cell]) - fall * length;
    let above: Vec<f64> = trees.cells.iter().zip(&trees.lengths).map(above).collect();
    let steady = isotonic(&trees.parents, &above);
    steady.iter().zip(&trees.lengths).map(|(height, length)| height + fall * length).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::drainage::{flood::flood, flow::Flow},
        repair::test_terrain::mask,
        test_fields::field,
    };
    use orograph_core::{FeatureKind, Polyline, gaussian};

    fn valleys(terrain: &Heightfield, lines: &[&[[f64; 2]]]) -> Features {
        let line = |vertices: &&[[f64; 2]]| Polyline {
            from: 0,
            to: 0,
            vertices: vertices.to_vec(),
            profiles: Vec::new(),
        };
        Features {
            grid: terrain.grid().clone(),
            kind: FeatureKind::Valley,
            points: Vec::new(),
            lines: lines.iter().map(line).collect(),
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 1.0,
        }
    }

    fn enforced(
        terrain: &Heightfield,
        valleys: &Features,
        lakes: Option<&Mask>,
        fall: f64,
    ) -> EnforceValleysOut {
        let node = EnforceValleys { fall, ..EnforceValleys::default() };
        node.run(EnforceValleysIn { terrain, valleys, lakes }, &Job::detached()).unwrap()
    }

    /// A Y of valleys in rough ground, which leaves over the southern border.
    fn rough() -> (Heightfield, Features) {
        let terrain = field(90, 81, |row, col| {
            let middle = if row < 40 {
                (col as f64 - 40.0).abs() - (40.0 - row as f64) / 2.0
            } else {
                col as f64 - 40.0
            };
            300.0 + 2.0 * middle.abs() - 0.5 * row as f64 + 4.0 * gaussian(7, 1, row as i64, col as i64)
        });
        let valleys = valleys(
            &terrain,
            &[&[[5.0, 22.5], [40.0, 40.0]], &[[5.0, 57.5], [40.0, 40.0]], &[[40.0, 40.0], [89.0, 40.0]]],
        );
        (terrain, valleys)
    }

    #[test]
    fn valleys_fall_to_the_outlet_and_gather_the_water() {
        let (terrain, valleys) = rough();
        let out = enforced(&terrain, &valleys, None, 0.01);
        assert_eq!(out.report.metric("outlets"), Some(1.0));
        for row in 41..90 {
            let (above, here) = (out.terrain.at(row - 1, 40), out.terrain.at(row, 40));
            assert!(above - here >= 0.0999, "{row}: {above} {here}");
        }
        for (cell, height) in
            out.constraints.cells().iter().enumerate().filter(|(_, height)| !height.is_nan())
        {
            assert_eq!(out.terrain.cells()[cell], *height);
        }
        let flow = |terrain: &Heightfield| {
            let job = Job::detached();
            Flow::of(&flood(terrain, &job).unwrap(), &job).unwrap().share_on_streams(&valleys)
        };
        assert!(flow(&out.terrain) >= flow(&terrain), "{} {}", flow(&out.terrain), flow(&terrain));
    }

    #[test]
    fn a_line_over_a_pass_drains_to_both_sides() {
        // From border to border over a roof; both flanks fall steadily.
        let terrain =
            field(41, 31, |row, col| 100.0 - (row as f64 - 20.0).abs() + 3.0 * (col as f64 - 15.0).abs());
        let valleys = valleys(&terrain, &[&[[0.0, 15.0], [40.0, 15.0]]]);
        let out = enforced(&terrain, &valleys, None, 0.05);
        assert_eq!(out.report.metric("outlets"), Some(2.0));
        assert_eq!(out.terrain.cells(), terrain.cells());
    }

    #[test]
    fn valleys_that_fall_already_stay_to_the_bit() {
        let terrain = field(50, 31, |row, col| 100.0 - row as f64 + 3.0 * (col as f64 - 15.0).abs());
        // Drawn against the water.
        let valleys = valleys(&terrain, &[&[[49.0, 15.0], [3.0, 15.0]]]);
        let out = enforced(&terrain, &valleys, None, 0.05);
        assert_eq!(out.terrain.cells(), terrain.cells());
    }

    #[test]
    fn lakes_stay_and_take_valleys() {
        let (terrain, valleys) = rough();
        let lakes = mask(&terrain, |row, col| (50..60).contains(&row) && (30..50).contains(&col));
        let out = enforced(&terrain, &valleys, Some(&lakes), 0.0);
        // The Y ends in the lake; what lies below it, between the lake and the border, may end in either.
        assert_eq!(out.report.metric("outlets"), Some(3.0));
        for (i, lake) in lakes.cells().iter().enumerate() {
            assert!(*lake == 0.0 || out.terrain.cells()[i].to_bits() == terrain.cells()[i].to_bits());
        }
    }

    #[test]
    fn damaged_valleys_are_refused() {
        let terrain = field(9, 9, |_, _| 0.0);
        let valleys = valleys(&terrain, &[&[[f64::NAN, 0.0], [3.0, 3.0]]]);
        let node = EnforceValleys::default();
        assert!(
            node.run(
                EnforceValleysIn { terrain: &terrain, valleys: &valleys, lakes: None },
                &Job::detached()
            )
            .is_err()
        );
    }
}
