//! Difference map: where one terrain lies above or below another, and by how much.

use orograph_core::prelude::*;

use super::{
    colour::Palette,
    legend::{Legend, with_legend},
};

/// Colours the difference between two terrains: red where the first lies higher, blue where it lies lower.
///
/// The range is the same on both sides, so white is no difference at all. Cells that are void in either
/// terrain take the void colour.
#[derive(Params, Clone, Debug)]
pub struct DifferenceMap {
    /// Takes the range from the differences themselves; `largest` is then unused.
    #[param(default = true)]
    pub automatic: bool,
    /// Share of the cells whose differences an automatic range takes in; the rest take the end colours.
    #[param(default = 99, range = 1.0..=100.0, slider = 90.0..=100.0, unit = "%")]
    pub coverage: f64,
    /// Difference that takes the end colours.
    #[param(default = 10, range = 1e-6..=40_000.0, slider = 0.1..=100.0, unit = "m")]
    pub largest: f64,
    /// Colour of voids, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xa8_acb4))]
    pub void_colour: Colour,
    /// Adds a colour bar with differences on the right; the picture then has more columns than the terrain.
    #[param(default = true)]
    pub legend: bool,
}

/// Inputs of [`DifferenceMap`].
#[derive(Inputs)]
pub struct DifferenceMapIn<'a> {
    /// Terrain that is judged.
    pub terrain: &'a Heightfield,
    /// Terrain that is subtracted from it.
    pub reference: &'a Heightfield,
}

/// Outputs of [`DifferenceMap`].
#[derive(Outputs)]
pub struct DifferenceMapOut {
    /// The coloured differences.
    pub picture: Texture,
}

impl Node for DifferenceMap {
    const ID: &'static str = "look.difference_map";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = DifferenceMapIn<'a>;
    type Outputs = DifferenceMapOut;

    fn run(&self, inputs: DifferenceMapIn<'_>, job: &Job) -> Result<DifferenceMapOut> {
        let DifferenceMapIn { terrain, reference } = inputs;
        terrain.grid().match_size("terrain", reference.grid(), "reference")?;
        let void = self.void_colour.0;
        let difference = Heightfield::build(terrain.grid().clone(), job, |row, out| {
            for ((out, a), b) in out.iter_mut().zip(terrain.row(row)).zip(reference.row(row)) {
                *out = (f64::from(*a) - f64::from(*b)) as f32;
            }
            Ok(())
        })?;
        let largest =
            if self.automatic { covering(&difference, self.coverage / 100.0, job)? } else { self.largest };
        let palette = Palette::Diverging;
        let picture = difference.map(job, |metres| {
            if metres.is_nan() { void } else { palette.at((f64::from(metres) / largest + 1.0) / 2.0) }
        })?;
        let legend = Legend { colours: palette.gradient(), low: -largest, high: largest, unit: "m" };
        let picture = if self.legend { with_legend(&picture, &legend, job)? } else { picture };
        Ok(DifferenceMapOut { picture })
    }
}

/// The least round number that `share` of the differences do not exceed; 1 m where there is no difference.
fn covering(difference: &Heightfield, share: f64, job: &Job) -> Result<f64> {
    job.admit(difference.grid().len() as u64 * 4, || "the sorted differences".into())?;
    let mut sizes: Vec<f32> =
        difference.cells().iter().map(|metres| metres.abs()).filter(|size| size.is_finite()).collect();
    if sizes.is_empty() {
        return Ok(1.0);
    }
    let last = sizes.len() - 1;
    let rank = ((sizes.len() as f64 * share).ceil() as usize).saturating_sub(1).min(last);
    let (_, &mut size, _) = sizes.select_nth_unstable_by(rank, f32::total_cmp);
    Ok(round_up(f64::from(size)))
}

/// The next of 1, 1.5, 2, 2.5, 3, 4, 5, 6 and 8 times a power of ten.
fn round_up(value: f64) -> f64 {
    if value < 1e-6 {
        return 1.0;
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(value)));
    let steps = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
    steps.into_iter().find(|step| value <= step * power).unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    fn run(node: &DifferenceMap, a: &[f32], b: &[f32]) -> Texture {
        let (terrain, reference) = (&row(a), &row(b));
        node.run(DifferenceMapIn { terrain, reference }, &Job::detached()).unwrap().picture
    }

    #[test]
    fn equal_ground_is_white_and_the_ends_lie_opposite() {
        let plain = DifferenceMap { legend: false, ..DifferenceMap::default() };
        let out = run(&plain, &[1.0, 5.0, -3.0, f32::NAN], &[1.0, 1.0, 1.0, 1.0]);
        let palette = Palette::Diverging;
        assert_eq!(out.cells(), [palette.at(0.5), palette.at(1.0), palette.at(0.0), [0xa8, 0xac, 0xb4, 255]]);
        assert_eq!(palette.at(0.5), [0xf7, 0xf7, 0xf7, 255]);
    }

    #[test]
    fn an_automatic_range_covers_its_share() {
        let job = Job::detached();
        let errors: Vec<f32> = (1..=100).map(|i| i as f32 * if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(covering(&row(&errors), 0.5, &job), Ok(50.0));
        assert_eq!(covering(&row(&errors), 1.0, &job), Ok(100.0));
        assert_eq!(covering(&row(&[f32::NAN, f32::INFINITY]), 1.0, &job), Ok(1.0));
        assert_eq!(round_up(1.2), 1.5);
        assert_eq!(round_up(9.0), 10.0);
    }

    #[test]
    fn grids_of_other_sizes_are_refused() {
        let (terrain, reference) = (&row(&[1.0]), &row(&[1.0, 2.0]));
        let out = DifferenceMap::default().run(DifferenceMapIn { terrain, reference }, &Job::detached());
        assert!(matches!(out, Err(Error::DimensionMismatch { .. })));
    }
}
