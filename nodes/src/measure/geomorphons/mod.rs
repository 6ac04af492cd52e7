//! Geomorphons: ground classed by the pattern of higher and lower ground around it.
//!
//! Jasiewicz, J. and Stepinski, T. F. (2013), "Geomorphons: a pattern recognition approach to classification and
//! mapping of landforms", Geomorphology 182: in eight directions the highest and lowest elevation angle up to a
//! search radius say whether the ground there rises, falls or stays level; how many rise and how many fall gives
//! one of ten forms. Departures: rays end at borders, voids are passed over; the threshold is the same everywhere.

mod forms;
mod rays;

use orograph_core::{Unit, prelude::*};

pub use forms::Form;
pub use rays::{Search, classify};

use super::distribution::jensen_shannon;

/// Classes ground into ten forms, and measures how far their shares are from a reference's.
///
/// Codes run from 1 to 10: flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley, pit. Without a
/// reference the distances are NaN; they are 0 for equal shares.
#[derive(Params, Clone, Debug)]
pub struct Geomorphons {
    /// How far to look in each direction.
    #[param(default = 20u32, range = 1..=512, slider = 3..=100, unit = "cells")]
    pub search: u32,
    /// Cells next to the middle that do not count, so that small bumps do not decide.
    #[param(default = 0u32, range = 0..=511, slider = 0..=10, unit = "cells")]
    pub skip: u32,
    /// Ground that rises or falls by less counts as level.
    #[param(default = 1, range = 0.0..=45.0, slider = 0.0..=5.0, unit = "deg")]
    pub flatness: f64,
}

/// Inputs of [`Geomorphons`].
#[derive(Inputs)]
pub struct GeomorphonsIn<'a> {
    /// Terrain to class.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Geomorphons`].
#[derive(Outputs)]
pub struct GeomorphonsOut {
    /// Code of each cell's form, 1 to 10; voids stay voids.
    pub forms: Heightfield,
    /// The forms in their usual colours; voids are transparent.
    pub picture: Texture,
    /// One row of metrics: share of each form, Jensen–Shannon and L1 distance.
    pub metrics: Table,
    /// Share of each form, one below the other.
    pub shares: Table,
}

impl Node for Geomorphons {
    const ID: &'static str = "measure.geomorphons";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = GeomorphonsIn<'a>;
    type Outputs = GeomorphonsOut;

    fn check(&self) -> Result<()> {
        if self.skip < self.search {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`skip` ({} cells) leaves nothing of `search` ({} cells)", self.skip, self.search),
            "make `skip` smaller than `search`",
        ))
    }

    fn cost(&self) -> f64 {
        4.0 * f64::from(self.search)
    }

    fn run(&self, inputs: GeomorphonsIn<'_>, job: &Job) -> Result<GeomorphonsOut> {
        let search =
            Search { radius: self.search as usize, skip: self.skip as usize, flatness: self.flatness };
        let forms = classify(inputs.terrain, search, job)?;
        let own = Shares::of(&forms);
        let reference = inputs
            .reference
            .map(|reference| Ok::<_, Error>(Shares::of(&classify(reference, search, job)?)))
            .transpose()?;
        let distance = |of: fn(&Shares, &Shares) -> f64| {
            reference.as_ref().map_or(f64::NAN, |reference| of(&own, reference))
        };
        let names = Form::ALL.map(|form| format!("{}_share", form.name()));
        let mut metrics: Vec<_> = names
            .iter()
            .zip(own.0)
            .map(|(name, share)| (name.as_str(), Unit::Percent, 100.0 * share))
            .collect();
        metrics.push(("geomorphon_js", Unit::One, distance(Shares::divergence)));
        metrics.push(("geomorphon_l1", Unit::Percent, 100.0 * distance(Shares::total_difference)));
        let metrics = Table::metrics(metrics)?;
        let percent = |shares: Option<&Shares>| {
            Cells::Numbers(shares.map_or([f64::NAN; 10], |shares| shares.0.map(|share| 100.0 * share)).into())
        };
        let column = |name: &str, unit, cells| Column { name: name.into(), unit, cells };
        let shares = Table::new(vec![
            column("form", Unit::One, Cells::Texts(Form::ALL.map(|form| form.name().to_owned()).into())),
            column("share", Unit::Percent, percent(Some(&own))),
            column("reference_share", Unit::Percent, percent(reference.as_ref())),
        ])?;
        let picture = forms.map(job, |code| Form::of_code(code).map_or([0; 4], Form::colour))?;
        Ok(GeomorphonsOut { forms, picture, metrics, shares })
    }
}

/// Share of each form among the cells that are no voids, in the order of [`Form::ALL`]; NaN for voids alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares(pub [f64; 10]);

impl Shares {
    /// The shares in a raster of codes.
    #[must_use]
    pub fn of(forms: &Heightfield) -> Self {
        let mut counts = [0u64; 10];
        for form in forms.cells().iter().filter_map(|&code| Form::of_code(code)) {
            counts[form as usize] += 1;
        }
        let all = counts.iter().sum::<u64>() as f64;
        Self(counts.map(|count| count as f64 / all))
    }

    /// Jensen–Shannon divergence from a reference's shares, 0 to 1.
    #[must_use]
    pub fn divergence(&self, reference: &Self) -> f64 {
        jensen_shannon(&self.0, &reference.0)
    }

    /// Sum of the absolute differences from a reference's shares, 0 to 2.
    #[must_use]
    pub fn total_difference(&self, reference: &Self) -> f64 {
        self.0.iter().zip(reference.0).map(|(own, other)| (own - other).abs()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn shares_sum_to_the_whole_and_do_not_differ_from_themselves() {
        let hills = |row: usize, col: usize| 80.0 * libm::sin(row as f64 / 6.0) * libm::cos(col as f64 / 9.0);
        let terrain = field(70, 80, |row, col| if row == col { f64::NAN } else { hills(row, col) });
        let inputs = GeomorphonsIn { terrain: &terrain, reference: Some(&terrain) };
        let out = Geomorphons::default().run(inputs, &Job::detached()).unwrap();
        let metric = |name: &str| out.metrics.metric(name).unwrap();
        let sum: f64 = Form::ALL.iter().map(|form| metric(&format!("{}_share", form.name()))).sum();
        assert!((sum - 100.0).abs() < 1e-9);
        assert_eq!((metric("geomorphon_js"), metric("geomorphon_l1")), (0.0, 0.0));
        assert_eq!(out.forms.void_count(), 70);
        assert_eq!(out.picture.at(3, 3), [0; 4]);
    }

    #[test]
    fn skip_must_be_smaller_than_search() {
        assert!(Geomorphons { search: 5, skip: 5, ..Geomorphons::default() }.check().is_err());
    }
}
