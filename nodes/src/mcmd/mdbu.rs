//! MDBU alone: the bottom-up pass of MCMD (algorithm 1 and equation (3) of Belhadj 2007).

use orograph_core::Unit;
use orograph_core::prelude::*;

use crate::mcmd::{
    axis::Axis,
    bottom_up::bottom_up,
    params::{LargeForms, Level, Limits, Subdivision},
    settings::{Known, Settings, Shape},
};

/// Tells the ascendants of known cells what is known below them: the first pass of MCMD.
///
/// Known cells keep their heights to the bit; cells that are no ascendant of any stay voids.
#[derive(Params, Clone, Debug)]
pub struct Mdbu {
    /// The subdivision of the plane.
    #[param(flatten)]
    pub subdivision: Subdivision,
    /// The large forms.
    #[param(flatten)]
    pub large_forms: LargeForms,
    /// The level about which heights are scaled.
    #[param(flatten)]
    pub level: Level,
    /// What holds computed heights back.
    #[param(flatten)]
    pub limits: Limits,
}

/// Inputs of [`Mdbu`].
#[derive(Inputs)]
pub struct MdbuIn<'a> {
    /// Known heights; a void is an unknown cell.
    pub constraints: &'a Heightfield,
}

/// Outputs of [`Mdbu`].
#[derive(Outputs)]
pub struct MdbuOut {
    /// The known heights and those of their ascendants.
    pub constraints: Heightfield,
    /// What the pass did: cells, constraints, mdbu_rounds and known_after_mdbu.
    pub report: Table,
}

impl Node for Mdbu {
    const ID: &'static str = "mcmd.mdbu";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = MdbuIn<'a>;
    type Outputs = MdbuOut;

    fn cost(&self) -> f64 {
        4.0
    }

    fn check(&self) -> Result<()> {
        self.limits.check()
    }

    fn run(&self, inputs: MdbuIn<'_>, job: &Job) -> Result<MdbuOut> {
        let known = Known::of(inputs.constraints)?;
        let settings = Settings {
            scheme: self.subdivision.scheme,
            shape: Shape { l: 0.0, l_bu: self.large_forms.l_bu, hurst: 0.0, rt: 0.0, rs: 0.0 },
            relief: 1.0,
            datum: self.level.of(&known),
            center_gain: 1.0,
            limits: self.limits.of(&known),
            dimensions: 2.0,
            seed: 0,
        };
        let mut constraints = inputs.constraints.map(job, |height| height)?;
        let (cols, rows) = (Axis::new(constraints.cols())?, Axis::new(constraints.rows())?);
        let done = bottom_up(&mut constraints, (&cols, &rows), &settings, job)?;
        let report = Table::metrics([
            ("cells", Unit::One, constraints.grid().len() as f64),
            ("constraints", Unit::One, known.cells as f64),
            ("mdbu_rounds", Unit::One, done.rounds as f64),
            ("known_after_mdbu", Unit::One, known.cells as f64 + done.found as f64),
        ])?;
        Ok(MdbuOut { constraints, report })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    /// Figure 7 of the paper: two seeds on a 5 × 5 grid make ten cells known.
    #[test]
    fn two_seeds_on_five_by_five_make_ten_known_cells() {
        let seeds =
            field(5, 5, |row, col| if (col, row) == (1, 0) || (col, row) == (1, 3) { 7.0 } else { f64::NAN });
        let out = Mdbu::default().run(MdbuIn { constraints: &seeds }, &Job::detached()).unwrap();
        assert_eq!(out.report.metric("known_after_mdbu"), Some(10.0));
        assert_eq!(out.constraints.void_count(), 15);
        assert_eq!(out.constraints.range(), Some((7.0, 7.0)));
    }
}
