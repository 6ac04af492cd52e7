//! Random voids: elliptical blots scattered over a terrain.
//!
//! A Boolean model: centres are a Poisson process, drawn bucket by bucket of ground from the bucket's place
//! and the seed, so that a crop has the blots of the whole. With λ centres per square metre and blots of mean
//! area A, a share of 1 − exp(−λA) of the ground is covered; λ follows from the share asked for.

use orograph_core::{key, mix64, prelude::*, unit};

/// Scatters elliptical blots, such as the voids that radar leaves.
#[derive(Params, Clone, Debug)]
pub struct RandomVoids {
    /// Share of the ground that blots cover, on average.
    #[param(default = 0.05, range = 0.0..=0.9, slider = 0.0..=0.5, unit = "1")]
    pub share: f64,
    /// Smallest mean diameter of a blot.
    #[param(default = 200, range = 0.1..=1_000_000.0, slider = 10.0..=5000.0, unit = "m")]
    pub smallest: f64,
    /// Largest mean diameter of a blot.
    #[param(default = 800, range = 0.1..=1_000_000.0, slider = 10.0..=5000.0, unit = "m")]
    pub largest: f64,
    /// Length of the longest blots relative to their width.
    #[param(default = 2, range = 1.0..=4.0, unit = "1")]
    pub elongation: f64,
    /// Which of all such scatterings; the run's seed counts as well.
    #[param(default = 0u32, range = 0..=4_294_967_295u32, slider = 0..=999, unit = "seed")]
    pub seed: u32,
}

/// Inputs of [`RandomVoids`].
#[derive(Inputs)]
pub struct RandomVoidsIn<'a> {
    /// Terrain whose grid to use; its heights do not count.
    pub like: &'a Heightfield,
}

/// Outputs of [`RandomVoids`].
#[derive(Outputs)]
pub struct RandomVoidsOut {
    /// 1 in blots, 0 elsewhere.
    pub mask: Mask,
}

impl Node for RandomVoids {
    const ID: &'static str = "mask.random_voids";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = RandomVoidsIn<'a>;
    type Outputs = RandomVoidsOut;

    fn check(&self) -> Result<()> {
        if self.smallest <= self.largest {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`smallest` ({} m) lies above `largest` ({} m)", self.smallest, self.largest),
            "swap them",
        ))
    }

    fn run(&self, inputs: RandomVoidsIn<'_>, job: &Job) -> Result<RandomVoidsOut> {
        self.check()?;
        let grid = inputs.like.grid();
        let seed = mix64(job.seed() ^ mix64(u64::from(self.seed)));
        let side = self.bucket();
        let mask = Mask::build(grid.clone(), job, |row, out| {
            let mut near: (i64, Vec<Blot>) = (i64::MIN, Vec::new());
            for (col, out) in out.iter_mut().enumerate() {
                let place = grid.position(row, col);
                let bucket = ((place.x / side).floor() as i64, (place.y / side).floor() as i64);
                if col == 0 || bucket.0 != near.0 {
                    job.check()?;
                    near = (bucket.0, self.blots_near(seed, bucket));
                }
                *out = f32::from(u8::from(near.1.iter().any(|blot| blot.covers(place.x, place.y))));
            }
            Ok(())
        })?;
        Ok(RandomVoidsOut { mask })
    }

    fn cost(&self) -> f64 {
        20.0
    }
}

/// Stream of random numbers for blots.
const STREAM: u64 = 0x626C_6F74;

/// An ellipse: its centre, and the two rows of the matrix that takes it to the unit circle.
struct Blot {
    x: f64,
    y: f64,
    to_circle: [[f64; 2]; 2],
}

impl Blot {
    fn covers(&self, x: f64, y: f64) -> bool {
        let (dx, dy) = (x - self.x, y - self.y);
        let [u, v] = self.to_circle.map(|row| row[0] * dx + row[1] * dy);
        u * u + v * v <= 1.0
    }
}

impl RandomVoids {
    /// Side of a bucket in metres: no blot reaches beyond the buckets around its own.
    fn bucket(&self) -> f64 {
        self.largest * self.elongation.sqrt()
    }

    fn blots_near(&self, seed: u64, bucket: (i64, i64)) -> Vec<Blot> {
        let mut blots = Vec::new();
        for dy in -1..=1 {
            for dx in -1..=1 {
                let place = (bucket.0.saturating_add(dx), bucket.1.saturating_add(dy));
                self.blots_in(seed, place, &mut blots);
            }
        }
        blots
    }

    /// The blots whose centres lie in a bucket.
    fn blots_in(&self, seed: u64, (column, row): (i64, i64), blots: &mut Vec<Blot>) {
        let seed = mix64(key(seed, STREAM, column, row));
        let side = self.bucket();
        let mut draws = (0..).map(|i| unit(key(seed, STREAM, i, 0)));
        let mut draw = || draws.next().unwrap_or(0.0);
        // Knuth's Poisson draw; the mean stays below 100, so the loop is short.
        let (limit, mut product) = (libm::exp(-self.density() * side * side), draw());
        while product > limit {
            let (x, y) = ((column as f64 + draw()) * side, (row as f64 + draw()) * side);
            let diameter = self.smallest + (self.largest - self.smallest) * draw();
            let stretch = (1.0 + (self.elongation - 1.0) * draw()).sqrt();
            let (sin, cos) = libm::sincos(std::f64::consts::PI * draw());
            // The area stays that of the circle, whatever the elongation.
            let (long, wide) = (diameter / 2.0 * stretch, diameter / 2.0 / stretch);
            blots.push(Blot { x, y, to_circle: [[cos / long, sin / long], [-sin / wide, cos / wide]] });
            product *= draw();
        }
    }

    /// Blots per square metre.
    fn density(&self) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        // The mean square of a diameter that is uniform from a to b.
        let mean_area = std::f64::consts::FRAC_PI_4 * (a * a + a * b + b * b) / 3.0;
        -libm::log(1.0 - self.share) / mean_area
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn run(node: &RandomVoids, like: &Heightfield) -> Mask {
        node.run(RandomVoidsIn { like }, &Job::detached()).unwrap().mask
    }

    #[test]
    fn blots_cover_the_share_asked_for() {
        let like = field(600, 600, |_, _| 0.0);
        for share in [0.0, 0.1, 0.4] {
            let mut covered = 0.0;
            for seed in 0..4 {
                let node =
                    RandomVoids { share, smallest: 50.0, largest: 200.0, seed, ..RandomVoids::default() };
                covered += run(&node, &like).cells().iter().sum::<f32>() / (4.0 * 360_000.0);
            }
            assert!((f64::from(covered) - share).abs() < 0.15 * share + 1e-9, "{share}: {covered}");
        }
    }

    #[test]
    fn a_crop_has_the_blots_of_the_whole() {
        let like = field(100, 150, |_, _| 0.0);
        let node = RandomVoids { share: 0.3, smallest: 30.0, largest: 90.0, ..RandomVoids::default() };
        let whole = run(&node, &like);
        let job = Job::detached();
        let crop = run(&node, &like.crop(40, 30, 50, 60, &job).unwrap());
        assert_eq!(crop.cells(), whole.crop(40, 30, 50, 60, &job).unwrap().cells());
    }
}
