//! Random decimation: scattered samples of a terrain (Belhadj 2007, figures 9 and 10).

use orograph_core::key;
use orograph_core::prelude::*;

use crate::{Chance, mcmd::selection::keep_least};

/// Stream of the ranks.
const STREAM: u64 = 0x6465_6369;

/// Keeps a random share of the measured cells and makes voids of the others.
///
/// A higher share keeps every cell that a lower one keeps. Kept cells keep their heights to the bit.
#[derive(Params, Clone, Debug)]
pub struct RandomDecimate {
    /// Share of the measured cells that is kept, rounded up to a whole cell.
    #[param(default = 0.034, range = 0.0..=1.0, slider = 0.001..=0.2, unit = "1")]
    pub keep: f64,
    /// The choice.
    #[param(flatten)]
    pub chance: Chance,
}

/// Inputs of [`RandomDecimate`].
#[derive(Inputs)]
pub struct RandomDecimateIn<'a> {
    /// Terrain to thin out.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`RandomDecimate`].
#[derive(Outputs)]
pub struct RandomDecimateOut {
    /// The cells kept; all others are voids.
    pub constraints: Heightfield,
}

impl Node for RandomDecimate {
    const ID: &'static str = "mcmd.random_decimate";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = RandomDecimateIn<'a>;
    type Outputs = RandomDecimateOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn run(&self, inputs: RandomDecimateIn<'_>, job: &Job) -> Result<RandomDecimateOut> {
        let seed = self.chance.key(job);
        let rank = |row: usize, col: usize| {
            let (row, col) = inputs.terrain.grid().base(row, col);
            key(seed, STREAM, col, row)
        };
        let constraints = keep_least(inputs.terrain, self.keep, rank, |_, _| false, job)?;
        Ok(RandomDecimateOut { constraints })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn the_share_is_exact_and_grows_by_adding() {
        let terrain = field(205, 205, |row, col| (row * 205 + col) as f64);
        let kept = |keep: f64, seed: u64| {
            let node = RandomDecimate { keep, chance: Chance { seed } };
            node.run(RandomDecimateIn { terrain: &terrain }, &Job::detached()).unwrap().constraints
        };
        let (few, more) = (kept(0.034, 1), kept(0.1, 1));
        assert_eq!(42_025 - few.void_count(), 1429);
        assert_eq!(42_025 - more.void_count(), 4203);
        for i in 0..42_025 {
            let (few, more) = (few.cells()[i], more.cells()[i]);
            assert!(few.is_nan() || few == more);
            assert!(more.is_nan() || more == terrain.cells()[i]);
        }
        // About 3.4 % of one seed's cells are kept by another seed as well.
        let other = kept(0.034, 2);
        let both = few.cells().iter().zip(other.cells()).filter(|(a, b)| !a.is_nan() && !b.is_nan()).count();
        assert!((25..80).contains(&both), "{both}");
    }
}
