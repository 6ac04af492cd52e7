//! Adherence: how well the lines of a terrain follow those that were drawn.
//!
//! Recall is the share of the drawn lines with a line of the terrain near by, precision the share of the terrain's
//! strongest lines with a drawn one near by. Real ground is so full of ridges that a line laid anywhere finds one, so
//! the same recall is taken for turned, mirrored and shifted copies of the terrain: only what exceeds that is due to
//! the drawing. Two more tests need no search for lines: whether the ground stands above both sides along the drawn
//! lines, and for how long each is followed without a break.

mod copies;
mod strongest;

use orograph_core::{Column, Polyline, Unit, prelude::*};

use self::{
    copies::{Copy, standing_share},
    strongest::{strongest, topology},
};
use super::{
    chains::resample,
    nearest::Nearest,
    network::Network,
    ppa::find,
    profiles::normal,
    settings::{Shaping, Steps},
};
use crate::PatchSize;

/// Measures how well the ridges or valleys of a terrain follow drawn ones.
#[derive(Params, Clone, Debug)]
pub struct Adherence {
    /// Distance within which a line counts as followed.
    #[param(default = 5, range = 0.5..=256.0, slider = 1.0..=20.0, unit = "cells")]
    pub reach: f64,
    /// Distance on both sides at which the ground is compared with that on the drawn line.
    #[param(default = 5, range = 1.0..=256.0, slider = 1.0..=20.0, unit = "cells")]
    pub flank: f64,
    /// The patches that the terrain was made of; the curve goes up to a quarter of one.
    #[param(flatten)]
    pub patches: PatchSize,
}

/// Inputs of [`Adherence`].
#[derive(Inputs)]
pub struct AdherenceIn<'a> {
    /// The lines drawn.
    pub drawn: &'a Features,
    /// The terrain made from them, on the same grid.
    pub terrain: &'a Heightfield,
    /// Its lines; without them `feature.ppa` looks for them with its defaults for the patch size.
    pub found: Option<&'a Features>,
}

/// Outputs of [`Adherence`].
#[derive(Outputs)]
pub struct AdherenceOut {
    /// All figures in one row.
    pub report: Table,
    /// Recall, precision and F1 for every distance up to a quarter of a patch.
    pub curve: Table,
    /// For each drawn line its length, the share that is followed, and the longest stretch without a break.
    pub lines: Table,
}

impl Node for Adherence {
    const ID: &'static str = "feature.adherence";
    const VERSION: u32 = 2; // 2 looks for lines as `feature.ppa` 2 does
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = AdherenceIn<'a>;
    type Outputs = AdherenceOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn run(&self, inputs: AdherenceIn<'_>, job: &Job) -> Result<AdherenceOut> {
        let AdherenceIn { drawn, terrain, found } = inputs;
        job.check()?;
        let own;
        let found = match found {
            Some(found) => found,
            None => {
                let steps = Steps::for_patch(drawn.kind, self.patches.side());
                let shaping = Shaping::for_patch(self.patches.side(), steps.reduction.parallel_radius);
                own = find(terrain, &steps, &shaping, job)?.features;
                &own
            }
        };
        let measured = Measured::new(drawn, found, terrain, self, job)?;
        if measured.drawn.is_empty() {
            job.warn("nothing was drawn, so there is nothing to follow");
        }
        Ok(AdherenceOut { report: measured.report()?, curve: measured.curve()?, lines: measured.lines()? })
    }
}

/// A place of a drawn line: row and column, and the unit vector across the line.
type Sample = ([f64; 2], [f64; 2]);

/// Distances between drawn and found lines, and what follows from them.
#[derive(Clone, Debug)]
pub struct Measured {
    settings: Adherence,
    /// For each drawn line the distances of its samples, a cell apart, to the lines found.
    drawn: Vec<Vec<f64>>,
    /// Whether each drawn line is a ring, so that a run may pass its ends.
    closed: Vec<bool>,
    /// Lengths of the drawn lines in cells.
    lengths: Vec<f64>,
    /// Distances of the samples of the strongest lines found to the drawn ones.
    strongest: Vec<f64>,
    /// For each copy of the terrain the distances of all drawn samples.
    copies: Vec<Vec<f64>>,
    /// Share of the drawn samples that stand out from both sides, in the terrain and in each copy.
    standing: (f64, Vec<f64>),
    /// Branch points and components of the drawn and of the strongest lines.
    topology: [[usize; 2]; 2],
}

impl Measured {
    /// Compares drawn lines with those found in a terrain.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`] unless all three have a grid of one size; [`Error::Invalid`] for damaged features
    /// or a ridge against a valley; [`Error::Cancelled`].
    pub fn new(
        drawn: &Features,
        found: &Features,
        terrain: &Heightfield,
        settings: &Adherence,
        job: &Job,
    ) -> Result<Self> {
        drawn.grid.match_size("drawn", terrain.grid(), "terrain")?;
        found.grid.match_size("found", terrain.grid(), "terrain")?;
        if drawn.kind != found.kind {
            return Err(Error::invalid(
                "ridges are compared with valleys",
                "give `feature.ppa` the kind of the drawn lines",
            ));
        }
        let (drawn_network, found_network) = (Network::new(drawn)?, Network::new(found)?);
        let (rows, cols) = terrain.grid().size();
        let samples: Vec<Vec<Sample>> = drawn.lines.iter().map(|line| samples(&line.vertices)).collect();
        let all: Vec<Sample> = samples.concat();
        let lengths = lengths(&drawn_network);
        let chosen = strongest(&found_network, terrain, lengths.iter().sum());
        let places = |lines: &mut dyn Iterator<Item = usize>| -> Vec<[f64; 2]> {
            lines.flat_map(|line| resample(&found.lines[line].vertices, 1.0)).collect()
        };
        job.check()?;
        let mut all_found = places(&mut (0..found.lines.len()));
        // What makes a network a tree opens its rings; there a ring goes on all the same.
        all_found.extend(
            found
                .rings
                .iter()
                .flat_map(|ends| resample(&ends.map(|end| found_network.place(end as usize)), 1.0)),
        );
        let to_found = Nearest::new(all_found, rows, cols);
        let to_drawn = Nearest::new(all.iter().map(|sample| sample.0).collect(), rows, cols);
        let mut copies = Vec::new();
        let mut standing = Vec::new();
        for copy in Copy::all() {
            job.check()?;
            let moved = |at: [f64; 2]| copy.find(at, rows, cols);
            copies.push(all.iter().map(|sample| to_found.distance(moved(sample.0))).collect());
            standing.push(standing_share(&all, terrain, drawn.kind, settings.flank, moved));
        }
        let own = standing_share(&all, terrain, drawn.kind, settings.flank, |at| at);
        let merge = f64::from(settings.patches.patch) / 8.0;
        let every: Vec<usize> = (0..drawn.lines.len()).collect();
        Ok(Self {
            settings: settings.clone(),
            drawn: samples
                .iter()
                .map(|line| line.iter().map(|sample| to_found.distance(sample.0)).collect())
                .collect(),
            closed: drawn.lines.iter().map(|line| is_closed(drawn, line)).collect(),
            lengths,
            strongest: places(&mut chosen.iter().copied()).iter().map(|&at| to_drawn.distance(at)).collect(),
            copies,
            standing: (own, standing),
            topology: [topology(&drawn_network, &every, merge), topology(&found_network, &chosen, merge)],
        })
    }

    /// Share of the drawn lines with a line found within `reach` cells; NaN when nothing was drawn.
    #[must_use]
    pub fn recall(&self, reach: f64) -> f64 {
        share(self.drawn.iter().flatten(), reach)
    }

    /// Share of the strongest lines found with a drawn one within `reach` cells; NaN when none was found.
    #[must_use]
    pub fn precision(&self, reach: f64) -> f64 {
        share(self.strongest.iter(), reach)
    }

    /// The recall of a line that knows nothing of the terrain: the median over turned, mirrored and shifted copies.
    #[must_use]
    pub fn chance(&self, reach: f64) -> f64 {
        median(self.copies.iter().map(|copy| share(copy.iter(), reach)))
    }

    /// Share of the drawn samples that stand above, or for valleys below, both sides.
    #[must_use]
    pub fn standing(&self) -> f64 {
        self.standing.0
    }

    /// For each drawn line the share of it that its longest stretch within `reach` covers; around a ring a stretch passes
    /// the place where the line happens to begin.
    #[must_use]
    pub fn runs(&self, reach: f64) -> Vec<f64> {
        let run = |(line, &closed): (&Vec<f64>, &bool)| {
            let rounds = if closed { 2 } else { 1 };
            let (mut longest, mut now) = (0_usize, 0_usize);
            for &off in std::iter::repeat_n(line, rounds).flatten() {
                now = if off <= reach { now + 1 } else { 0 };
                longest = longest.max(now);
            }
            longest.min(line.len()) as f64 / line.len() as f64
        };
        self.drawn.iter().zip(&self.closed).map(run).collect()
    }

    fn report(&self) -> Result<Table> {
        let reach = self.settings.reach;
        let (recall, precision, chance) = (self.recall(reach), self.precision(reach), self.chance(reach));
        let runs = self.runs(reach);
        let whole: f64 = self.lengths.iter().sum();
        let mean_run = runs.iter().zip(&self.lengths).map(|(run, length)| run * length).sum::<f64>() / whole;
        let mean = |offs: &mut dyn Iterator<Item = &f64>| {
            let (n, sum) = offs.fold((0.0, 0.0), |(n, sum), off| (n + 1.0, sum + off));
            sum / n
        };
        let chamfer = (mean(&mut self.drawn.iter().flatten()) + mean(&mut self.strongest.iter())) / 2.0;
        let copies = |range: std::ops::Range<usize>| {
            median(self.copies[range].iter().map(|copy| share(copy.iter(), reach)))
        };
        let [drawn, found] = self.topology;
        let apart = |i: usize| drawn[i].abs_diff(found[i]) as f64;
        let least = runs.iter().copied().fold(f64::NAN, f64::min);
        Table::metrics([
            ("recall", Unit::One, recall),
            ("precision", Unit::One, precision),
            ("f1", Unit::One, f1(recall, precision)),
            ("recall_by_chance", Unit::One, chance),
            ("lift", Unit::One, (recall - chance) / (1.0 - chance)),
            ("recall_turned", Unit::One, copies(0..1)),
            ("recall_mirrored", Unit::One, copies(1..3)),
            ("recall_shifted", Unit::One, copies(3..self.copies.len())),
            ("standing_out", Unit::One, self.standing.0),
            ("standing_out_by_chance", Unit::One, median(self.standing.1.iter().copied())),
            ("longest_run_mean", Unit::One, mean_run),
            ("longest_run_least", Unit::One, least),
            ("mean_distance", Unit::Cell, chamfer),
            ("branch_points_apart", Unit::One, apart(0)),
            ("components_apart", Unit::One, apart(1)),
        ])
    }

    fn curve(&self) -> Result<Table> {
        let reaches: Vec<f64> = (1..=self.settings.patches.patch / 4).map(f64::from).collect();
        let column = |name: &str, unit, of: &dyn Fn(f64) -> f64| Column {
            name: name.into(),
            unit,
            cells: Cells::Numbers(reaches.iter().map(|&reach| of(reach)).collect()),
        };
        Table::new(vec![
            column("distance", Unit::Cell, &|reach| reach),
            column("recall", Unit::One, &|reach| self.recall(reach)),
            column("precision", Unit::One, &|reach| self.precision(reach)),
            column("f1", Unit::One, &|reach| f1(self.recall(reach), self.precision(reach))),
            column("recall_by_chance", Unit::One, &|reach| self.chance(reach)),
        ])
    }

    fn lines(&self) -> Result<Table> {
        let reach = self.settings.reach;
        let column = |name: &str, unit, cells: Vec<f64>| Column {
            name: name.into(),
            unit,
            cells: Cells::Numbers(cells),
        };
        Table::new(vec![
            column("line", Unit::One, (0..self.drawn.len()).map(|i| i as f64).collect()),
            column("length", Unit::Cell, self.lengths.clone()),
            column("recall", Unit::One, self.drawn.iter().map(|line| share(line.iter(), reach)).collect()),
            column("longest_run", Unit::One, self.runs(reach)),
        ])
    }
}

/// Whether a line ends where it begins, or was opened there.
fn is_closed(features: &Features, line: &Polyline) -> bool {
    let ends = [line.from, line.to];
    let opened = |ring: &[u32; 2]| *ring == ends || *ring == [ends[1], ends[0]];
    ends[0] == ends[1] || features.rings.iter().any(opened)
}

fn lengths(network: &Network<'_>) -> Vec<f64> {
    (0..network.features().lines.len()).map(|line| network.length(line)).collect()
}

/// Places a cell apart along a path, and what is across there.
fn samples(path: &[[f64; 2]]) -> Vec<Sample> {
    let path = resample(path, 1.0);
    (0..path.len()).map(|i| (path[i], normal(&path, i))).collect()
}

fn share<'a>(offs: impl Iterator<Item = &'a f64>, reach: f64) -> f64 {
    let (n, near) =
        offs.fold((0.0, 0.0), |(n, near), off| (n + 1.0, near + f64::from(u8::from(*off <= reach))));
    near / n
}

fn f1(recall: f64, precision: f64) -> f64 {
    if recall + precision > 0.0 { 2.0 * recall * precision / (recall + precision) } else { 0.0 }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
