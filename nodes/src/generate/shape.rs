//! Shape: a single hill.

use orograph_core::prelude::*;

use super::ground::{GroundIn, GroundOut, bands, sample_cells};
use crate::Ground;

/// How a hill falls from its centre to its foot.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Straight flanks up to a point.
    Cone,
    /// The upper half of an ellipsoid: steep at the foot, flat on top.
    Dome,
    /// A smooth bell, flat on top and at the foot.
    Bell,
    /// A ring-shaped rim, halfway out, around a bowl.
    Crater,
}

/// Makes a round hill on level ground.
#[derive(Params, Clone, Debug)]
pub struct Shape {
    /// How the hill falls from its centre to its foot.
    #[param(default = Profile::Cone)]
    pub profile: Profile,
    /// World position of the hill's centre, towards the east.
    #[param(default = 5000, range = -100_000_000.0..=100_000_000.0, slider = 0.0..=10_000.0, unit = "m")]
    pub center_x: f64,
    /// World position of the hill's centre, towards the north; ground without a grid lies south of 0.
    #[param(default = -5000, range = -100_000_000.0..=100_000_000.0, slider = -10_000.0..=0.0, unit = "m")]
    pub center_y: f64,
    /// From the centre to the foot.
    #[param(default = 4000, range = 0.01..=10_000_000.0, slider = 10.0..=20_000.0, unit = "m")]
    pub radius: f64,
    /// From the ground up to the highest point; below zero, a hollow.
    #[param(default = 1000, range = -20_000.0..=20_000.0, slider = -2000.0..=4000.0, unit = "m")]
    pub rise: f64,
    /// Height of the ground around the hill.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub base: f64,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

impl Profile {
    /// Height as a share of the rise, at `t` times the radius from the centre.
    fn at(self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        match self {
            Self::Cone => 1.0 - t,
            Self::Dome => (1.0 - t * t).sqrt(),
            Self::Bell => {
                let level = 1.0 - t * t;
                level * level * level
            }
            Self::Crater => {
                let from_rim = 1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0);
                from_rim * from_rim
            }
        }
    }
}

impl Node for Shape {
    const ID: &'static str = "generate.shape";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        bands(self, &self.ground, job)
    }

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        sample_cells(&self.ground, &inputs, job, |x, y| {
            let (dx, dy) = (x - self.center_x, y - self.center_y);
            self.base + self.rise * self.profile.at((dx * dx + dy * dy).sqrt() / self.radius)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_falls_in_proportion_to_distance() {
        let node = Shape {
            center_x: 50.0,
            center_y: -50.0,
            radius: 40.0,
            rise: 80.0,
            base: 7.0,
            ground: Ground { width: 100.0, height: 100.0, cells: 100 },
            ..Shape::default()
        };
        let out = node.run(GroundIn { like: None }, &Job::detached()).unwrap().terrain;
        for (row, col) in [(50, 50), (50, 60), (20, 30), (0, 0)] {
            let (dx, dy) = (col as f64 + 0.5 - 50.0, row as f64 + 0.5 - 50.0);
            let expected = 7.0 + 2.0 * (40.0 - (dx * dx + dy * dy).sqrt()).max(0.0);
            assert!((f64::from(out.at(row, col)) - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn profiles_meet_the_ground_at_the_foot_and_reach_their_height() {
        for (profile, top) in
            [(Profile::Cone, 0.0), (Profile::Dome, 0.0), (Profile::Bell, 0.0), (Profile::Crater, 0.5)]
        {
            assert_eq!(profile.at(top), 1.0, "{profile:?}");
            assert_eq!(profile.at(1.0), 0.0, "{profile:?}");
            assert!(profile.at(1.0 - 1e-9) < 1e-4, "{profile:?}");
        }
    }
}
