//! Each figure beside what the exemplar's own halves say, and whether it is good enough.

use orograph_core::{Placement, Unit, prelude::*};

use super::portrait::{DISTANCES, Portrait};
use crate::measure::seams::Joins;

/// One line of the report.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The metric, by its column's name in the node that measures it alone.
    pub name: &'static str,
    /// Unit of the value.
    pub unit: Unit,
    /// What the figures of the two terrains are, and their unit.
    pub of_one: &'static str,
    /// The terrain's own figure, NaN where there is none.
    pub terrain: f64,
    /// The exemplar's.
    pub exemplar: f64,
    /// The metric.
    pub value: f64,
    /// The metric between halves of the exemplar.
    pub halves: f64,
    /// The number that is held against the bar.
    pub judged: f64,
    /// The most that is good enough; NaN where nothing is asked.
    pub bar: f64,
}

impl Verdict {
    /// Whether it is good enough; `None` where there is nothing to judge.
    #[must_use]
    pub fn met(&self) -> Option<bool> {
        if self.judged.is_nan() || self.bar.is_nan() { None } else { Some(self.judged.abs() <= self.bar) }
    }
}

/// The most that is good enough.
#[derive(Clone, Copy, Debug)]
pub struct Bars {
    /// Distances, over those between the exemplar's halves.
    pub ratio: f64,
    /// Depressions' density and depth, over the exemplar's.
    pub pits: f64,
    /// Logarithms of steps and bends at seams, either way.
    pub seams: f64,
}

/// Mean over both ways to halve a terrain of each distance between its halves, in the order of [`DISTANCES`].
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub fn between_halves(terrain: &Heightfield, job: &Job) -> Result<[f64; DISTANCES.len()]> {
    let (rows, cols) = terrain.grid().size();
    let (high, wide) = (rows / 2, cols / 2);
    let mut sums = [0.0; DISTANCES.len()];
    for (first, second) in [
        (terrain.crop(0, 0, rows, wide, job)?, terrain.crop(0, cols - wide, rows, wide, job)?),
        (terrain.crop(0, 0, high, cols, job)?, terrain.crop(rows - high, 0, high, cols, job)?),
    ] {
        let (first, second) = (Portrait::of(&first, job)?, Portrait::of(&second, job)?);
        for (sum, distance) in sums.iter_mut().zip(&DISTANCES) {
            // Either half may be the reference.
            let there_and_back = (distance.between)(&first, &second) + (distance.between)(&second, &first);
            *sum += there_and_back / 4.0;
        }
    }
    Ok(sums)
}

/// All lines of the report; those on seams where there is a placement.
///
/// # Errors
/// Those of [`Joins::of`].
pub fn judge(
    (terrain, own): (&Heightfield, &Portrait),
    exemplar: &Portrait,
    halves: [f64; DISTANCES.len()],
    placement: Option<&Placement>,
    bars: Bars,
    job: &Job,
) -> Result<Vec<Verdict>> {
    let mut lines: Vec<Verdict> = DISTANCES
        .iter()
        .zip(halves)
        .map(|(distance, halves)| {
            let value = (distance.between)(own, exemplar);
            Verdict {
                name: distance.name,
                unit: distance.unit,
                of_one: distance.of_one,
                terrain: (distance.figure)(own),
                exemplar: (distance.figure)(exemplar),
                value,
                halves,
                judged: ratio(value, halves),
                bar: if distance.judged { bars.ratio } else { f64::NAN },
            }
        })
        .collect();
    let depressions = [
        ("pit_density_ratio", "pits_per_km2", own.drainage.pits_per_km2, exemplar.drainage.pits_per_km2),
        (
            "pit_depth_ratio",
            "pit_depth_mean, m",
            own.drainage.pit_depth_mean,
            exemplar.drainage.pit_depth_mean,
        ),
    ];
    lines.extend(depressions.map(|(name, of_one, terrain, exemplar)| {
        let value = ratio(terrain, exemplar);
        let (unit, halves, bar) = (Unit::One, f64::NAN, bars.pits);
        Verdict { name, unit, of_one, terrain, exemplar, value, halves, judged: value, bar }
    }));
    if let Some(placement) = placement {
        let joins = Joins::of(terrain, placement, job)?;
        lines.extend([("seam_step", joins.step), ("seam_bend", joins.bend)].map(|(name, value)| Verdict {
            name,
            unit: Unit::One,
            of_one: "",
            terrain: f64::NAN,
            exemplar: f64::NAN,
            value,
            halves: f64::NAN,
            judged: value,
            bar: bars.seams,
        }));
    }
    Ok(lines)
}

/// One where both are equal, nothing included.
fn ratio(value: f64, of: f64) -> f64 {
    if value == of { 1.0 } else { value / of }
}

/// The lines as a table.
///
/// # Errors
/// None: its columns are as long as each other.
pub fn table(lines: &[Verdict]) -> Result<Table> {
    let texts = |name: &str, of: &dyn Fn(&Verdict) -> String| Column {
        name: name.into(),
        unit: Unit::One,
        cells: Cells::Texts(lines.iter().map(of).collect()),
    };
    let numbers = |name: &str, of: fn(&Verdict) -> f64| Column {
        name: name.into(),
        unit: Unit::One,
        cells: Cells::Numbers(lines.iter().map(of).collect()),
    };
    Table::new(vec![
        texts("metric", &|line| line.name.into()),
        texts("unit", &|line| line.unit.symbol().into()),
        texts("figure", &|line| line.of_one.into()),
        numbers("terrain", |line| line.terrain),
        numbers("exemplar", |line| line.exemplar),
        numbers("value", |line| line.value),
        numbers("halves", |line| line.halves),
        numbers("ratio", |line| line.judged),
        numbers("bar", |line| line.bar),
        texts("met", &|line| word(line.met()).into()),
    ])
}

/// How the report says whether a bar is met.
#[must_use]
pub fn word(met: Option<bool>) -> &'static str {
    match met {
        Some(true) => "yes",
        Some(false) => "no",
        None => "",
    }
}
