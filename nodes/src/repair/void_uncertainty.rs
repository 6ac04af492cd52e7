//! Uncertainty of filled voids: how wrong a smooth fill is on ground like this.
//!
//! The same hole is cut into known ground elsewhere, in random places and orientations, and filled by a thin plate; what
//! the plate misses there is a sample of what it misses here. It is conditional simulation as geostatistics knows it
//! (Journel, A. G. and Huijbregts, C. J. (1978), "Mining Geostatistics"), with real ground in place of a random field.

use orograph_core::{Unit, key, prelude::*, unit};
use rayon::prelude::*;

use super::{
    area_details::{Frame, Source, Turn},
    thin_plate_fill::{Stiffness, thin_plate_fill},
    voids::{self, Void},
};
use crate::Chance;

/// Estimates how far the heights of filled voids may be from the truth, cell by cell.
///
/// Small along the rim, large in the middle of wide voids and in rough terrain. The ground within reach must be like that
/// which was lost; where none is known within reach the estimate is void.
#[derive(Params, Clone, Debug)]
pub struct VoidUncertainty {
    /// Places at which each void is tried. Errors of the estimate fall with its root.
    #[param(default = 12u32, range = 2..=256, slider = 4..=64, unit = "1")]
    pub samples: u32,
    /// How far away they lie at most; at least twice as far as the void is long.
    #[param(default = 10000, range = 0.0..=1_000_000.0, slider = 0.0..=50_000.0, unit = "m")]
    pub reach: f64,
    /// How stiff the plate is.
    #[param(flatten)]
    pub stiff: Stiffness,
    /// The random numbers.
    #[param(flatten)]
    pub chance: Chance,
}

/// Inputs of [`VoidUncertainty`].
#[derive(Inputs)]
pub struct VoidUncertaintyIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`VoidUncertainty`].
#[derive(Outputs)]
pub struct VoidUncertaintyOut {
    /// Standard deviation of the heights of a smooth fill, in metres; 0 at known cells.
    pub spread: Heightfield,
    /// Mean square, as its root, and largest spread in voids, and the cells for which there is none.
    pub report: Table,
}

impl Node for VoidUncertainty {
    const ID: &'static str = "repair.void_uncertainty";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = VoidUncertaintyIn<'a>;
    type Outputs = VoidUncertaintyOut;

    fn cost(&self) -> f64 {
        300.0 * f64::from(self.samples)
    }

    fn run(&self, inputs: VoidUncertaintyIn<'_>, job: &Job) -> Result<VoidUncertaintyOut> {
        let terrain = inputs.terrain;
        let voids = voids::find(terrain.grid().size(), 0, |i| terrain.cells()[i].is_nan(), job)?;
        let done = job.stage(voids.len() as u64);
        let spreads: Vec<Option<Vec<f32>>> = voids
            .par_iter()
            .map(|void| {
                let spread = self.spread(terrain, void, job)?;
                done.advance(1);
                Ok(spread)
            })
            .collect::<Result<_>>()?;
        let mut spread: Heightfield = terrain.map(job, |_| 0.0)?;
        let (mut square, mut n, mut most, mut unknown) = (0.0, 0.0, 0.0_f64, 0.0);
        for (void, spreads) in voids.iter().zip(spreads) {
            for (k, &cell) in void.cells.iter().enumerate() {
                let value = spreads.as_ref().map_or(f32::NAN, |spreads| spreads[k]);
                spread.cells_mut()[cell] = value;
                if value.is_nan() {
                    unknown += 1.0;
                } else {
                    let value = f64::from(value);
                    (square, n, most) = (square + value * value, n + 1.0, most.max(value));
                }
            }
        }
        if unknown > 0.0 {
            job.warn(format!("{unknown} cells lie in voids like which no ground is known within reach"));
        }
        let report = Table::metrics([
            ("spread_rms", Unit::Metre, libm::sqrt(square / n)),
            ("spread_max", Unit::Metre, most),
            ("unknown", Unit::Cell, unknown),
        ])?;
        Ok(VoidUncertaintyOut { spread, report })
    }
}

/// Cells around a void that hold the plate, and trials for each sample before there is none.
const MARGIN: usize = 3;
const TRIALS: u64 = 24;

impl VoidUncertainty {
    /// Spread at each cell of a void; `None` where no ground can stand in for it.
    fn spread(&self, terrain: &Heightfield, void: &Void, job: &Job<'_>) -> Result<Option<Vec<f32>>> {
        let size = terrain.grid().size();
        let Some(frame) = Frame::around(void, MARGIN, 1, size) else { return Ok(None) };
        let local: Vec<usize> = void.cells.iter().filter_map(|&cell| frame.find(void.place(cell))).collect();
        let seed = self.chance.key(job);
        let (row, col) = terrain.grid().base(void.first[0], void.first[1]);
        let cell = terrain.grid().cell;
        let reach = frame.reach(self.reach, cell);
        let (turns, raster) = (Turn::all(cell), [size.0, size.1]);
        let (mut squares, mut n) = (vec![0.0; local.len()], 0.0);
        for sample in 0..u64::from(self.samples) {
            job.check()?;
            let found = (0..TRIALS).find_map(|trial| {
                let number = |k: u64| unit(key(seed, 4 * (TRIALS * sample + trial) + k, row, col));
                let turn = turns[(number(2) * turns.len() as f64) as usize % turns.len()];
                let box_size = turn.size(frame.size);
                let by = [0, 1].map(|axis| {
                    frame.offset(axis, box_size[axis], reach[axis], raster[axis], number(axis as u64))
                });
                Source::beside(&frame, by, turn, size).filter(|source| source.missing(terrain, &frame) == 0)
            });
            let Some(source) = found else { continue };
            let truth = |i: usize| {
                let [row, col] = source.over(i, &frame);
                terrain.at(row, col)
            };
            let mut holed: Vec<f32> = (0..frame.len()).map(truth).collect();
            local.iter().for_each(|&i| holed[i] = f32::NAN);
            let holed = Heightfield::new(Grid::new(frame.size[0], frame.size[1], cell)?, holed)?;
            let filled = thin_plate_fill(&holed, None, self.stiff, job)?;
            for (square, &i) in squares.iter_mut().zip(&local) {
                let missed = f64::from(truth(i)) - f64::from(filled.cells()[i]);
                *square += missed * missed;
            }
            n += 1.0;
        }
        Ok((n > 0.0).then(|| squares.iter().map(|square| libm::sqrt(square / n) as f32).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;
    use orograph_core::gaussian;

    fn holed(of: impl Fn(usize, usize) -> f64) -> Heightfield {
        let hole = |row: usize, col: usize| {
            (50..70).contains(&row) && (40..75).contains(&col) || row == 0 && col == 0
        };
        field(120, 120, |row, col| if hole(row, col) { f64::NAN } else { of(row, col) })
    }

    fn run(terrain: &Heightfield) -> VoidUncertaintyOut {
        let node = VoidUncertainty { samples: 24, ..VoidUncertainty::default() };
        node.run(VoidUncertaintyIn { terrain }, &Job::detached()).unwrap()
    }

    /// A walk of many steps in both directions: rough on all scales.
    fn walk() -> Vec<f64> {
        let mut sums = vec![0.0; 120 * 120];
        let step = |axis: u64, at: i64| gaussian(11, axis, at, 0);
        let (mut down, mut across) = (vec![0.0; 120], vec![0.0; 120]);
        for i in 1..120 {
            down[i] = down[i - 1] + 10.0 * step(1, i as i64);
            across[i] = across[i - 1] + 10.0 * step(2, i as i64);
        }
        (0..120 * 120).for_each(|i| sums[i] = down[i / 120] + across[i % 120]);
        sums
    }

    #[test]
    fn even_ground_is_certain_and_known_cells_are() {
        let out = run(&holed(|row, col| 2.0 * row as f64 - col as f64));
        assert!(out.spread.cells().iter().all(|spread| spread.abs() < 0.05));
        let rough = walk();
        let out = run(&holed(|row, col| rough[row * 120 + col]));
        assert_eq!(out.spread.at(10, 10), 0.0);
        assert!(out.spread.at(60, 57) > 2.0 * out.spread.at(50, 57));
    }

    #[test]
    fn the_spread_is_the_error_that_is_made() {
        // Over many seeds of terrain, errors are as large as they are said to be.
        let (mut squares, mut said) = (0.0, 0.0);
        for seed in 0..6 {
            let waves = |row: usize, col: usize| {
                (1..9).fold(0.0, |sum, k| {
                    let phase = |axis: u64| 6.0 * gaussian(seed, axis, k, 0);
                    let scale = 2.0 * k as f64;
                    sum + 40.0 / k as f64
                        * libm::sin(row as f64 * scale / 30.0 + phase(1))
                        * libm::cos(col as f64 * scale / 34.0 + phase(2))
                })
            };
            let terrain = holed(waves);
            let out = run(&terrain);
            let filled = thin_plate_fill(&terrain, None, Stiffness::default(), &Job::detached()).unwrap();
            for row in 50..70 {
                for col in 40..75 {
                    let error = f64::from(filled.at(row, col)) - waves(row, col);
                    squares += error * error;
                    let spread = f64::from(out.spread.at(row, col));
                    said += spread * spread;
                }
            }
        }
        let ratio = libm::sqrt(squares / said);
        assert!((0.6..1.6).contains(&ratio), "{ratio}");
    }

    #[test]
    fn ground_that_is_all_lost_is_unknown() {
        let out = run(&field(20, 20, |row, col| if row + col < 3 { 1.0 } else { f64::NAN }));
        assert!(out.spread.at(10, 10).is_nan());
        assert_eq!(out.report.metric("unknown"), Some(394.0));
    }
}
