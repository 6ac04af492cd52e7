//! Synthesis: terrain that looks like an exemplar and has the ridges or valleys of a sketch.
//!
//! Zhou, Sun, Turk, Rehg, "Terrain Synthesis from Digital Elevation Models" (2007). Patches of the exemplar are placed
//! along the sketch's feature tree, each chosen, warped, cut and blended into what is there; what features leave open is
//! filled with windows of the exemplar. The departures are told where the steps are.

use orograph_core::prelude::*;
use orograph_core::{Placement, Unit};

use super::{
    canvas::{Canvas, Window},
    crests::{self, Raised},
    cut::SeamWeight,
    exemplar::Exemplar,
    fill_windows::{self, Counts, Layout},
    gradient_merge::merge,
    matching::Uses,
    network::Network,
    patches::extract,
    placing::{Placing, Sources, Style},
    settings::{Manner, Order, Rules, seed_of},
    ssd::Searcher,
};
use crate::Chance;

/// Makes terrain from a sketch of its ridges or valleys and an exemplar whose ground it takes.
///
/// The output has the sketch's rows and columns and the exemplar's cells; a georeferenced sketch keeps its own. Several exemplars are styles: a label map says
/// which goes where. Without any line in the sketch the exemplar's ground is continued everywhere.
#[derive(Params, Clone, Debug)]
pub struct Synthesise {
    /// Whose rules are followed, and on what scale.
    #[param(flatten)]
    pub manner: Manner,
    /// The order in which patches are placed.
    #[param(default = Order::Tree)]
    pub order: Order,
    /// Candidates for a path or an end whose seams are compared.
    #[param(default = 10u32, range = 1..=1000, slider = 1..=64, unit = "1")]
    pub candidates: u32,
    /// Most that a patch is raised or lowered to meet the ground around it, as a share of the exemplar's height range.
    #[param(default = 0.1, range = 0.0..=10.0, slider = 0.0..=1.0, unit = "1")]
    pub lift: f64,
    /// What drawn lines stand out by from both sides at least, as a share of what lines of the exemplar usually do. Where
    /// patches do not, the ground is raised, or lowered along valleys; 0 leaves it.
    #[param(default = 0.6, range = 0.0..=4.0, slider = 0.0..=1.5, unit = "1")]
    pub crest: f64,
    /// How the mismatch along a seam is weighed.
    #[param(default = SeamWeight::Plain)]
    pub seam_weight: SeamWeight,
    /// Cells beyond the overlap of two patches over which their step is spread.
    #[param(default = 0u32, range = 0..=256, slider = 0..=20, unit = "cells")]
    pub spread: u32,
    /// Patches may be mirrored.
    #[param(default = true)]
    pub mirror: bool,
    /// Weight of each earlier use of the same ground.
    #[param(default = 0.25, range = 0.0..=100.0, slider = 0.0..=2.0, unit = "1")]
    pub repetition: f64,
    /// What is left to chance.
    #[param(flatten)]
    pub chance: Chance,
}

/// Inputs of [`Synthesise`].
#[derive(Inputs)]
pub struct SynthesiseIn<'a> {
    /// Lines to follow, such as those of a sketch; of several networks, as ridges and valleys, the first comes first.
    pub sketches: Vec<&'a Features>,
    /// Terrain to take ground from; several are styles, numbered from 0.
    pub exemplars: Vec<&'a Heightfield>,
    /// Lines found on the exemplars, on the grids of these.
    pub features: Vec<&'a Features>,
    /// Number of the style at each cell, on the sketch's grid; style 0 everywhere when unconnected.
    pub styles: Option<&'a Heightfield>,
    /// Ground that is there already and stays, on the sketch's grid; voids are to be made.
    pub given: Option<&'a Heightfield>,
}

/// Outputs of [`Synthesise`].
#[derive(Outputs)]
pub struct SynthesiseOut {
    /// The terrain.
    pub terrain: Heightfield,
    /// Which patch went where.
    pub placement: Placement,
    /// Counts of what was placed and what was not.
    pub report: Table,
}

impl Node for Synthesise {
    const ID: &'static str = "synthesis.synthesise";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = SynthesiseIn<'a>;
    type Outputs = SynthesiseOut;

    fn cost(&self) -> f64 {
        2000.0
    }

    fn run(&self, inputs: SynthesiseIn<'_>, job: &Job) -> Result<SynthesiseOut> {
        let mut rules = self.manner.rules(usize::MAX);
        rules.seed = seed_of(self.chance, job);
        rules.mirror = self.mirror;
        rules.seam_weight = self.seam_weight;
        rules.grow = self.spread as usize;
        if !rules.strict() {
            rules.n_path = self.candidates as usize;
            rules.lift = Some(self.lift);
            rules.crest = self.crest;
            rules.repetition = self.repetition;
        }
        let (terrain, placement, counts) = synthesise(&inputs, &rules, self.order, job)?;
        let report = counts.table()?;
        Ok(SynthesiseOut { terrain, placement, report })
    }
}

/// What was placed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Places planned.
    pub planned: usize,
    /// Patches placed, by role: branches, ends, paths.
    pub placed: [usize; 3],
    /// Places that no candidate fitted.
    pub unmatched: usize,
    /// Candidates left out at the exemplar's rim or beside voids.
    pub left_out: usize,
    /// Mean mismatch along the features' seams before they were removed, in metres.
    pub seam: f64,
    /// What was filled.
    pub fill: Counts,
    /// What was raised so that lines stand out.
    pub raised: Raised,
}

impl Report {
    fn table(&self) -> Result<Table> {
        let n = |n: usize| n as f64;
        Table::metrics([
            ("planned", Unit::One, n(self.planned)),
            ("branches", Unit::One, n(self.placed[0])),
            ("ends", Unit::One, n(self.placed[1])),
            ("paths", Unit::One, n(self.placed[2])),
            ("unmatched", Unit::One, n(self.unmatched)),
            ("candidates_left_out", Unit::One, n(self.left_out)),
            ("seam_mismatch", Unit::Metre, self.seam),
            ("fill_windows", Unit::One, n(self.fill.pasted)),
            ("smoothed_cells", Unit::Cell, n(self.fill.smoothed)),
            ("raised_cells", Unit::Cell, n(self.raised.cells)),
            ("most_raised", Unit::Metre, self.raised.most),
        ])
    }
}

/// The terrain, where it came from, and what was placed.
///
/// # Errors
/// [`Error::EmptyInput`], [`Error::AllVoid`] and [`Error::NonFinite`] for the exemplars, [`Error::DimensionMismatch`],
/// [`Error::TooLarge`], those of the steps, and cancellation.
pub fn synthesise(
    inputs: &SynthesiseIn<'_>,
    rules: &Rules,
    order: Order,
    job: &Job<'_>,
) -> Result<(Heightfield, Placement, Report)> {
    let sketch =
        inputs.sketches.first().ok_or_else(|| Error::EmptyInput { what: "the list of sketches".into() })?;
    let size = sketch.grid.size();
    for other in &inputs.sketches {
        sketch.grid.match_size("the first sketch", &other.grid, "another sketch")?;
    }
    let exemplars: Vec<Exemplar> =
        inputs.exemplars.iter().map(|terrain| Exemplar::new(terrain, job)).collect::<Result<_>>()?;
    let Some(first) = exemplars.first() else {
        return Err(Error::EmptyInput { what: "the list of exemplars".into() });
    };
    let grid = output_grid(&sketch.grid, first, job);
    let rules = &fitting(rules, &exemplars, job);
    let mut canvas = Canvas::new(size, job)?;
    if let Some(given) = inputs.given {
        sketch.grid.match_size("sketch", given.grid(), "given")?;
        canvas.freeze(given);
    }
    if let Some(styles) = inputs.styles {
        sketch.grid.match_size("sketch", styles.grid(), "styles")?;
    }
    let mut report = Report::default();
    let styles = styles(inputs, &exemplars, rules, &mut report, job)?;
    let style_of = |canvas: &Canvas, window: &Window| match inputs.styles {
        Some(labels) => main_style(canvas, window, labels, exemplars.len()),
        None => 0,
    };
    let mut uses = Uses::default();
    let drawn = inputs.sketches.iter().any(|sketch| !sketch.lines.is_empty());
    if !drawn {
        job.warn("the sketch has no lines: the exemplar's ground is continued everywhere");
    }
    let networks: Vec<Network> =
        inputs.sketches.iter().map(|sketch| Network::new(sketch, [1.0; 2])).collect();
    if order != Order::Raster {
        let ground = Sources { exemplars: &exemplars, styles: &styles };
        let mut placing =
            Placing { canvas: &mut canvas, uses: &mut uses, report: &mut report, cores: Vec::new() };
        for sketch in &networks {
            placing.follow(sketch, &ground, &style_of, order, rules, job)?;
        }
        if report.unmatched > 0 {
            job.warn(format!("{} places of the sketch found no patch that fits", report.unmatched));
        }
    }
    report.seam /= (report.placed.iter().sum::<usize>() as f64).max(1.0);
    let searchers: Vec<Searcher<'_>> = exemplars
        .iter()
        .zip(&styles)
        .map(|(exemplar, style)| Searcher::new(exemplar, &style.networks.iter().collect::<Vec<_>>(), job))
        .collect::<Result<_>>()?;
    let sources = fill_windows::Sources { exemplars: &exemplars, searchers: &searchers };
    let layout = layout(rules, order, drawn, &exemplars);
    report.fill = fill_windows::fill(&mut canvas, &sources, &layout, &style_of, &mut uses, rules, job)?;
    if report.fill.smoothed > 0 {
        job.warn(format!("{} cells found nothing that fits and are filled smoothly", report.fill.smoothed));
    }
    if let Some(reach) = rules.merge {
        merge(&mut canvas, reach, job)?;
    }
    if rules.crest > 0.0 && order != Order::Raster {
        for sketch in &networks {
            let style = |[row, col]: [f64; 2]| {
                let at = (row as usize).min(size.0 - 1) * size.1 + (col as usize).min(size.1 - 1);
                inputs.styles.map_or(0, |labels| label(labels.cells()[at], exemplars.len()))
            };
            let wanted =
                |at| styles[style(at)].pool(sketch.kind).map_or(0.0, |pool| rules.crest * pool.prominence);
            let raised = crests::raise(&mut canvas, sketch, wanted, rules.patch, job)?;
            report.raised.cells += raised.cells;
            report.raised.most = report.raised.most.max(raised.most);
        }
    }
    let (terrain, placement) = canvas.finish(grid, &exemplars)?;
    Ok((terrain, placement, report))
}

/// The grid of what is made for a sketch: a drawing takes on the exemplar's cells, a map keeps its own and its place.
pub(super) fn output_grid(sketch: &Grid, exemplar: &Exemplar, job: &Job<'_>) -> Grid {
    let mut grid = sketch.clone();
    let cell = exemplar.terrain.grid().cell;
    if grid.georef.is_none() {
        grid.cell = cell;
    } else if (grid.cell.x / cell.x - 1.0).abs() > 0.01 || (grid.cell.y / cell.y - 1.0).abs() > 0.01 {
        job.warn(format!(
            "the sketch's cells of {:.1} × {:.1} m take ground from cells of {:.1} m: slopes change accordingly",
            grid.cell.x, grid.cell.y, cell.x
        ));
    }
    grid
}

/// The rules with a patch that fits into the smallest exemplar.
fn fitting(rules: &Rules, exemplars: &[Exemplar], job: &Job<'_>) -> Rules {
    let sides = exemplars.iter().map(|exemplar| exemplar.terrain.rows().min(exemplar.terrain.cols()));
    let most = sides.min().unwrap_or(1).max(1);
    let patch = rules.patch.min(most);
    if patch < rules.patch {
        job.warn(format!(
            "an exemplar is smaller than a patch of {} cells: {patch} cells are used",
            rules.patch
        ));
    }
    Rules { patch, ..*rules }
}

fn layout(rules: &Rules, order: Order, drawn: bool, exemplars: &[Exemplar]) -> Layout {
    let sides = exemplars.iter().map(|exemplar| exemplar.terrain.rows().min(exemplar.terrain.cols()));
    let most = sides.min().unwrap_or(1).max(1);
    if order == Order::Raster {
        let step = (rules.patch * 2 / 3).max(1);
        return Layout { side: rules.patch, step, raster: true, most_lines: f64::INFINITY };
    }
    let side = rules.fill_window().min(most);
    let step = rules.fill_step().min((side * 2 / 3).max(1));
    let most_lines = if drawn { side as f64 / 4.0 } else { f64::INFINITY };
    Layout { side, step, raster: false, most_lines }
}

/// The style of most of a window's unknown cells; of equals the least.
fn main_style(canvas: &Canvas, window: &Window, labels: &Heightfield, n: usize) -> usize {
    let mut counts = vec![0_usize; n];
    for i in 0..window.len() {
        let at = canvas.index(window, i);
        let number = labels.cells()[at];
        if canvas.heights[at].is_nan() && number >= 0.0 {
            counts[label(number, n)] += 1;
        }
    }
    let most = counts.iter().copied().max().unwrap_or(0);
    counts.iter().position(|&count| count == most).unwrap_or(0)
}

/// The style that a cell of the label map names; the last for numbers beyond, the first for none.
fn label(number: f32, n: usize) -> usize {
    ((number + 0.5).max(0.0) as usize).min(n - 1)
}

/// Networks and pools of each exemplar. A network belongs to the first exemplar of its grid that has none of its kind.
fn styles(
    inputs: &SynthesiseIn<'_>,
    exemplars: &[Exemplar],
    rules: &Rules,
    report: &mut Report,
    job: &Job<'_>,
) -> Result<Vec<Style>> {
    let mut styles: Vec<Style> =
        exemplars.iter().map(|_| Style { networks: Vec::new(), pools: Vec::new() }).collect();
    for features in &inputs.features {
        let takes = |(i, style): &(usize, &Style)| {
            inputs.exemplars[*i].grid() == &features.grid
                && style.networks.iter().all(|network| network.kind != features.kind)
        };
        let Some((owner, _)) = styles.iter().enumerate().find(takes) else {
            return Err(Error::invalid(
                "features were given that lie on no exemplar's grid, or twice",
                "connect to `features` what `feature.ppa` finds on each exemplar, once for each kind",
            ));
        };
        let network = Network::new(features, exemplars[owner].scale);
        let pool = extract(&network, owner, &exemplars[owner].terrain, &exemplars[owner].voids, rules, job)?;
        report.left_out += pool.left_out;
        styles[owner].networks.push(network);
        styles[owner].pools.push(pool);
    }
    Ok(styles)
}
