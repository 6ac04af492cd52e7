//! MCMD of one dimension: a profile through known heights (Belhadj 2007, figures 2 and 3), with m = 1.

use orograph_core::Unit;
use orograph_core::prelude::*;

use crate::Chance;
use crate::mcmd::{
    axis::Axis,
    bottom_up::bottom_up,
    params::{Displacement, Flanks, LargeForms, Level, Limits, Named},
    settings::{Known, Scheme, Settings},
    top_down::top_down,
};

/// Builds a profile through known heights, which shows what the settings of `mcmd.mcmd` do.
#[derive(Params, Clone, Debug)]
pub struct Curve {
    /// Known heights: distance along the profile and height, both in metres. Each counts at the nearest sample.
    #[param(default = [[0.0, 0.0], [1000.0, 0.0]], range = -20_000.0..=20_000.0, slider = 0.0..=1_000_000.0)]
    pub points: orograph_core::Curve,
    /// Length of the profile.
    #[param(default = 1000, range = 0.001..=1_000_000.0, slider = 100.0..=10_000.0, unit = "m")]
    pub length: f64,
    /// Samples along the profile; 2^n + 1 subdivides evenly.
    #[param(default = 257u32, range = 1..=1_048_577, slider = 17..=4097, unit = "1")]
    pub samples: u32,
    /// Settings by name.
    #[param(flatten)]
    pub named: Named,
    /// The flanks of known cells.
    #[param(flatten)]
    pub flanks: Flanks,
    /// The large forms.
    #[param(flatten)]
    pub large_forms: LargeForms,
    /// The random part of heights.
    #[param(flatten)]
    pub displacement: Displacement,
    /// The level about which heights are scaled.
    #[param(flatten)]
    pub level: Level,
    /// What holds computed heights back.
    #[param(flatten)]
    pub limits: Limits,
    /// The random numbers.
    #[param(flatten)]
    pub chance: Chance,
}

/// Outputs of [`Curve`].
#[derive(Outputs)]
pub struct CurveOut {
    /// One row a sample: x and height in metres, and the pass that set it: 0 a known height, 1 bottom-up, 2 top-down.
    pub profile: Table,
    /// What the passes did: constraints, mdbu_rounds, known_after_mdbu, relief and datum.
    pub report: Table,
}

impl Node for Curve {
    const ID: &'static str = "mcmd.curve";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = ();
    type Outputs = CurveOut;

    fn check(&self) -> Result<()> {
        self.limits.check()?;
        match self.points.0.iter().find(|point| point[0] > self.length) {
            None => Ok(()),
            Some(point) => Err(Error::invalid(
                format!(
                    "a known height at {} m lies beyond the profile's end at {} m",
                    point[0], self.length
                ),
                "lengthen the profile or move the point",
            )),
        }
    }

    fn run(&self, (): (), job: &Job) -> Result<CurveOut> {
        let n = self.samples.max(1) as usize;
        let step = if n > 1 { self.length / (n - 1) as f64 } else { self.length };
        let grid = Grid::new(1, n, CellSize::square(step))?;
        let mut heights = Heightfield::filled(grid, f32::NAN, job)?;
        for point in &self.points.0 {
            let at = ((point[0] / step).round() as usize).min(n - 1);
            heights.cells_mut()[at] = point[1] as f32;
        }
        let known = Known::of(&heights)?;
        let custom = self.displacement.shape(self.flanks, self.large_forms);
        let settings = Settings {
            scheme: Scheme::TriangleEdge,
            shape: self.named.preset.shape(custom, self.named.flip_l),
            relief: known.relief(self.displacement.relief),
            datum: self.level.of(&known),
            center_gain: 1.0,
            limits: self.limits.of(&known),
            dimensions: 1.0,
            seed: self.chance.key(job),
        };
        let (cols, rows) = (Axis::new(n)?, Axis::new(1)?);
        let void = |heights: &Heightfield| heights.cells().iter().map(|height| height.is_nan()).collect();
        let unknown: Vec<bool> = void(&heights);
        let done = bottom_up(&mut heights, (&cols, &rows), &settings, job)?;
        let untold: Vec<bool> = void(&heights);
        top_down(&mut heights, (&cols, &rows), &settings, job)?;
        let passes = unknown.iter().zip(untold).map(|(&a, b)| f64::from(u8::from(a) + u8::from(b)));
        let column =
            |name: &str, unit, cells| Column { name: name.into(), unit, cells: Cells::Numbers(cells) };
        let profile = Table::new(vec![
            column("x", Unit::Metre, (0..n).map(|i| i as f64 * step).collect()),
            column("height", Unit::Metre, heights.cells().iter().map(|&height| f64::from(height)).collect()),
            column("pass", Unit::One, passes.collect()),
        ])?;
        let report = Table::metrics([
            ("constraints", Unit::One, known.cells as f64),
            ("mdbu_rounds", Unit::One, done.rounds as f64),
            ("known_after_mdbu", Unit::One, known.cells as f64 + done.found as f64),
            ("relief", Unit::Metre, settings.relief),
            ("datum", Unit::Metre, settings.datum),
        ])?;
        Ok(CurveOut { profile, report })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(curve: &Curve, name: &str) -> Vec<f64> {
        let profile = curve.run((), &Job::detached()).unwrap().profile;
        match &profile.column(name).unwrap().cells {
            Cells::Numbers(numbers) => numbers.clone(),
            Cells::Texts(_) => panic!("numbers expected"),
        }
    }

    #[test]
    fn plain_settings_give_straight_lines_through_the_points() {
        let curve = Curve {
            points: [[0.0, 0.0], [500.0, 100.0], [1000.0, 40.0]].into(),
            samples: 17,
            ..Curve::default()
        };
        let expected: Vec<f64> = (0..17)
            .map(|i| if i <= 8 { f64::from(i) * 12.5 } else { 100.0 - f64::from(i - 8) * 7.5 })
            .collect();
        assert_eq!(column(&curve, "height"), expected);
        assert_eq!(column(&curve, "pass")[..3], [0.0, 2.0, 2.0]);
        assert_eq!(column(&curve, "x")[16], 1000.0);
    }

    /// A lone summit at the middle with l > 0: bells below 1, peaks above.
    #[test]
    fn l_shapes_the_flanks() {
        let summit = |l: f64| Curve {
            points: [[0.0, 0.0], [500.0, 100.0], [1000.0, 0.0]].into(),
            flanks: Flanks { l },
            samples: 129,
            ..Curve::default()
        };
        let quarter = |l: f64| column(&summit(l), "height")[32];
        assert!(quarter(2.0) < quarter(0.4) && quarter(0.4) < quarter(0.0));
        assert!(quarter(0.0) < quarter(-0.4) && quarter(-0.4) < quarter(-2.0));
        // One ascendant at 0 m and one at 100 m, a quarter of the profile away: 100 (1 - 1/4)^2 / 2.
        assert!((quarter(2.0) - 28.125).abs() < 1e-5);
    }

    #[test]
    fn the_bottom_up_pass_reaches_the_ends() {
        // Sample 1 of 9 is halfway from 0 to 2, 2 from 0 to 4, 4 from 0 to 8: all of them and the ends are told.
        let curve = Curve { points: [[125.0, 10.0]].into(), samples: 9, ..Curve::default() };
        assert_eq!(column(&curve, "pass"), [1.0, 0.0, 1.0, 2.0, 1.0, 2.0, 2.0, 2.0, 1.0]);
        assert!(column(&curve, "height").iter().all(|&height| height == 10.0));
        assert_eq!(
            column(&Curve { points: [[0.0, 3.0]].into(), samples: 1, ..Curve::default() }, "height"),
            [3.0]
        );
    }

    #[test]
    fn points_beyond_the_end_are_refused() {
        assert!(Curve { length: 10.0, ..Curve::default() }.check().is_err());
    }
}
