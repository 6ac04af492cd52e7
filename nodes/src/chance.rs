//! The seed of nodes that leave something to chance.

use orograph_core::{mix64, prelude::*};

/// The random numbers.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Chance {
    /// Seed of the random numbers; the run's seed counts too.
    #[param(default = 0u64, range = 0..=4_294_967_295i64, slider = 0..=1000, unit = "seed")]
    pub seed: u64,
}

impl Chance {
    /// The node's own seed and the run's, as one.
    pub(crate) fn key(self, job: &Job<'_>) -> u64 {
        mix64(self.seed) ^ job.seed()
    }
}
