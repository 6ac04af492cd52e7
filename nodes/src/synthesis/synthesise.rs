//! Synthesis: terrain that looks like an exemplar and has the ridges or valleys of a sketch.
//!
//! Zhou, Sun, Turk, Rehg, "Terrain Synthesis from Digital Elevation Models" (2007). Patches of the exemplar are placed
//! along the sketch's feature tree, each chosen, warped, cut and blended into what is there; what features leave open is
//! filled with windows of the exemplar. The departures are told where the steps are.

use orograph_core::prelude::*;
use orograph_core::{Placement, mix64};

use super::{
    canvas::{Canvas, Window},
    crests,
    cut::SeamWeight,
    exemplar::Exemplar,
    fill_windows::{self, Layout},
    gradient_merge::merge,
    labels::{label, main_style, waver},
    matching::Uses,
    network::Network,
    outlets::{self, usual_depth},
    patches::extract,
    placing::{Placing, Sources, Style},
    report::{Off, Report},
    settings::{Manner, Order, Rules, UserTerms, VARIETY, seed_of},
    ssd::Searcher,
};
use crate::{Chance, adjust::elevation_constraints::Wanted};

/// Noise that moves borders between styles.
const STREAM: u64 = 0x626F_7264_6572_7300;

/// Makes terrain from a sketch of its ridges or valleys and an exemplar whose ground it takes.
///
/// The output has the sketch's rows and columns and the exemplar's cells; a georeferenced sketch keeps its own. Several exemplars are styles: a label map says
/// which goes where. Each seed gives another variant, unless `variety` is 1. Without any line in the sketch the exemplar's ground is continued everywhere.
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
    #[param(default = 0.9, range = 0.0..=4.0, slider = 0.0..=1.5, unit = "1")]
    pub crest: f64,
    /// Closed depressions deeper than nearly all of the exemplar's, times this, get an outlet; 0 leaves all. They silt up a
    /// little, too. What drawn ridges enclose stays closed.
    #[param(default = 1, range = 0.0..=1000.0, slider = 0.0..=4.0, unit = "1")]
    pub outlets: f64,
    /// How the mismatch along a seam is weighed.
    #[param(default = SeamWeight::Slope)]
    pub seam_weight: SeamWeight,
    /// Cells beyond the overlap of two patches over which their step is spread.
    #[param(default = 0u32, range = 0..=256, slider = 0..=20, unit = "cells")]
    pub spread: u32,
    /// Patches may be mirrored.
    #[param(default = true)]
    pub mirror: bool,
    /// Weight of each earlier use of the same ground.
    #[param(default = 1, range = 0.0..=100.0, slider = 0.0..=2.0, unit = "1")]
    pub repetition: f64,
    /// What candidates are judged by beside the paper's costs.
    #[param(flatten)]
    pub terms: UserTerms,
    /// Of how many of the best candidates for a place one is drawn by the seed; 1 always takes the best. The worse a
    /// candidate, the less often it is drawn, and never if it costs a fifth more than the best.
    #[param(default = VARIETY, range = 1..=64, slider = 1..=12, unit = "1")]
    pub variety: u32,
    /// How far borders between styles waver, where 1 is a quarter of a patch; 0 leaves them as the label map has them.
    #[param(default = 0.0, range = 0.0..=4.0, slider = 0.0..=1.0, unit = "1")]
    pub transition: f64,
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
    /// Wanted heights, on the sketch's grid, void where the terrain is free. Patches along lines are chosen and lifted for
    /// them; `adjust.elevation_constraints` then bends the terrain to meet them.
    pub constraints: Option<&'a Heightfield>,
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
    // 2 draws among the best patches, and falls back in more ways; 3 fills with ground as rough as the exemplar and lets
    // drawn lines rival nothing beside them
    // 4 solves seams by another multigrid, within a tenth of a millimetre
    const VERSION: u32 = 5; // 5 cuts seams where slopes agree, and gives depressions an outlet
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
        rules.grow = self.spread as usize;
        if !rules.strict() {
            rules.n_path = self.candidates as usize;
            rules.seam_weight = self.seam_weight;
            rules.lift = Some(self.lift);
            rules.crest = self.crest;
            rules.outlets = self.outlets;
            rules.repetition = self.repetition;
            rules.variety = self.variety as usize;
            rules.terms = self.terms;
        }
        rules.transition = self.transition;
        let (terrain, placement, counts) = synthesise(&inputs, &rules, self.order, job)?;
        let report = counts.table()?;
        Ok(SynthesiseOut { terrain, placement, report })
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
    let wavering = match inputs.styles {
        Some(labels) if rules.transition > 0.0 => {
            let patch = rules.patch as f64;
            let seed = mix64(rules.seed ^ STREAM);
            Some(waver(labels, &grid, rules.transition * patch / 4.0, patch, seed, job)?)
        }
        _ => None,
    };
    let labels = wavering.as_ref().or(inputs.styles);
    let wanted = Wanted::of(&grid, inputs.constraints, None, job)?;
    let style_of = |canvas: &Canvas, window: &Window| match labels {
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
        let mut placing = Placing {
            canvas: &mut canvas,
            uses: &mut uses,
            report: &mut report,
            wanted: &wanted,
            sketches: 0,
            cores: Vec::new(),
        };
        for sketch in &networks {
            placing.follow(sketch, &ground, &style_of, order, rules, job)?;
        }
        report.tell(job);
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
    if rules.outlets > 0.0 {
        let mut usual = 0.0_f64;
        for exemplar in &exemplars {
            usual = usual.max(usual_depth(&exemplar.terrain, job)?).max(exemplar.step / 4.0);
        }
        let limit = rules.outlets * usual;
        report.opened = outlets::open(&mut canvas, &networks, limit, rules.patch as f64 / 2.0, job)?;
    }
    if rules.crest > 0.0 && order != Order::Raster {
        for sketch in &networks {
            let style = |[row, col]: [f64; 2]| {
                let at = (row as usize).min(size.0 - 1) * size.1 + (col as usize).min(size.1 - 1);
                labels.map_or(0, |labels| label(labels.cells()[at], exemplars.len()))
            };
            let wanted =
                |at| styles[style(at)].pool(sketch.kind).map_or(0.0, |pool| rules.crest * pool.prominence);
            let raised = crests::raise(&mut canvas, sketch, wanted, rules.patch, job)?;
            report.raised.cells += raised.cells;
            report.raised.most = report.raised.most.max(raised.most);
        }
    }
    report.off = Off::of(&canvas.heights, &wanted);
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
        return Layout { side: rules.patch, step, raster: true, most_lines: f64::INFINITY, balanced: false };
    }
    let side = rules.fill_window().min(most);
    let step = rules.fill_step().min((side * 2 / 3).max(1));
    let most_lines = if drawn { side as f64 / 4.0 } else { f64::INFINITY };
    Layout { side, step, raster: false, most_lines, balanced: drawn && !rules.strict() }
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
