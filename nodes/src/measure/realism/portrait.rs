//! All figures of one terrain, and the distances between two.

use orograph_core::{Unit, prelude::*};

use crate::measure::{
    curvature::{Curvature, Curvatures},
    drainage::{Drainage, Figures},
    geomorphons::{Geomorphons, Search, Shares, classify},
    hypsometry::Heights,
    slope_distribution::Slopes,
    spectrum::Rings,
    variogram::Semivariances,
};

/// What the metric nodes at their defaults find in one terrain.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// See [`Slopes`].
    pub slopes: Slopes,
    /// See [`Curvatures`].
    pub curvatures: Curvatures,
    /// See [`Heights`].
    pub heights: Heights,
    /// See [`Rings`].
    pub rings: Rings,
    /// See [`Semivariances`].
    pub semivariances: Semivariances,
    /// See [`Shares`].
    pub forms: Shares,
    /// See [`Figures`].
    pub drainage: Figures,
}

impl Portrait {
    /// Measures a terrain.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, job: &Job) -> Result<Self> {
        let forms = Geomorphons::default();
        let search =
            Search { radius: forms.search as usize, skip: forms.skip as usize, flatness: forms.flatness };
        Ok(Self {
            slopes: Slopes::of(terrain, job)?,
            curvatures: Curvatures::of(terrain, Curvature::default().reach as usize, job)?,
            heights: Heights::of(terrain, job)?,
            rings: Rings::of(terrain, job)?,
            semivariances: Semivariances::of(terrain, job)?,
            forms: Shares::of(&classify(terrain, search, job)?),
            drainage: Drainage::default().figures(terrain, job)?.0,
        })
    }
}

/// A distance between two terrains.
pub struct Distance {
    /// Its column's name in the node that measures it alone.
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// The figure of one terrain that says most of it, and its unit; empty where there is none.
    pub of_one: &'static str,
    /// That figure; NaN where there is none.
    pub figure: fn(&Portrait) -> f64,
    /// Whether the exemplar's halves can set a bar: the exponents of drainage rest on the few large rivers of a
    /// map, and how alike those of two halves are is chance.
    pub judged: bool,
    /// The distance from a terrain to a reference, 0 for equal ones.
    pub between: fn(&Portrait, &Portrait) -> f64,
}

/// The distances by which terrain is judged.
pub const DISTANCES: [Distance; 12] = [
    Distance {
        name: "slope_w1",
        of_one: "slope_mean, deg",
        judged: true,
        unit: Unit::Degree,
        figure: |own| own.slopes.mean,
        between: |own, other| own.slopes.degrees.wasserstein(&other.slopes.degrees),
    },
    Distance {
        name: "slope_js",
        of_one: "",
        judged: true,
        unit: Unit::One,
        figure: |_| f64::NAN,
        between: |own, other| own.slopes.degrees.jensen_shannon(&other.slopes.degrees),
    },
    Distance {
        name: "profile_curvature_w1",
        of_one: "profile_curvature_deviation, 1/m",
        judged: true,
        unit: Unit::One,
        figure: |own| own.curvatures.profile.deviation,
        between: |own, other| own.curvatures.profile.distance(&other.curvatures.profile),
    },
    Distance {
        name: "plan_curvature_w1",
        of_one: "plan_curvature_deviation, 1/m",
        judged: true,
        unit: Unit::One,
        figure: |own| own.curvatures.plan.deviation,
        between: |own, other| own.curvatures.plan.distance(&other.curvatures.plan),
    },
    Distance {
        name: "hypsometry_w1",
        of_one: "hypsometric_integral",
        judged: true,
        unit: Unit::One,
        figure: |own| own.heights.integral,
        between: |own, other| own.heights.relative.wasserstein(&other.heights.relative),
    },
    Distance {
        name: "beta_difference",
        of_one: "beta",
        judged: true,
        unit: Unit::One,
        figure: |own| own.rings.beta,
        between: |own, other| own.rings.beta_difference(&other.rings),
    },
    Distance {
        name: "spectrum_rms",
        of_one: "",
        judged: true,
        unit: Unit::One,
        figure: |_| f64::NAN,
        between: |own, other| own.rings.distance(&other.rings),
    },
    Distance {
        name: "hurst_difference",
        of_one: "hurst",
        judged: true,
        unit: Unit::One,
        figure: |own| own.semivariances.hurst(),
        between: |own, other| (own.semivariances.hurst() - other.semivariances.hurst()).abs(),
    },
    Distance {
        name: "geomorphon_js",
        of_one: "",
        judged: true,
        unit: Unit::One,
        figure: |_| f64::NAN,
        between: |own, other| own.forms.divergence(&other.forms),
    },
    Distance {
        name: "geomorphon_l1",
        of_one: "",
        judged: true,
        unit: Unit::Percent,
        figure: |_| f64::NAN,
        between: |own, other| 100.0 * own.forms.total_difference(&other.forms),
    },
    Distance {
        name: "exceedance_difference",
        of_one: "exceedance_exponent",
        judged: false,
        unit: Unit::One,
        figure: |own| own.drainage.exceedance,
        between: |own, other| (own.drainage.exceedance - other.drainage.exceedance).abs(),
    },
    Distance {
        name: "hack_difference",
        of_one: "hack_exponent",
        judged: false,
        unit: Unit::One,
        figure: |own| own.drainage.hack,
        between: |own, other| (own.drainage.hack - other.drainage.hack).abs(),
    },
];
