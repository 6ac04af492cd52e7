//! Placing patches along the lines of a sketch.
//!
//! Zhou 2007 §5.1: breadth first along the feature tree. Places that share no cell with each other, nor with an earlier one
//! that still waits, do not know of each other but for the ground that they take; they are served together, and one that
//! takes what another of the same round took chooses again.

use std::collections::VecDeque;

use orograph_core::prelude::*;
use orograph_core::{key, unit};
use rayon::prelude::*;

use super::{
    canvas::{Canvas, Window},
    exemplar::Exemplar,
    matching::{Choice, Fallback, Scene, Uses, choose, split},
    network::{Network, Role, Site},
    patches::Pool,
    report::Report,
    settings::{Order, Rules},
};
use crate::adjust::elevation_constraints::Wanted;

/// Draws among the best candidates.
const STREAM: u64 = 0x7661_7269_616E_7473;

/// Most places served together, and how far down the plan they are looked for. Numbers of their own, so that no result
/// depends on that of threads.
const AT_ONCE: usize = 8;
const AHEAD: usize = 32;

/// An exemplar's networks and pools, by kind of feature.
pub(super) struct Style {
    /// One for each kind of feature.
    pub(super) networks: Vec<Network>,
    /// The candidates of each.
    pub(super) pools: Vec<Pool>,
}

impl Style {
    /// The candidates for lines of a kind, when the exemplar was searched for such.
    pub(super) fn pool(&self, kind: FeatureKind) -> Option<&Pool> {
        self.networks.iter().position(|network| network.kind == kind).map(|at| &self.pools[at])
    }
}

/// What ground is taken from.
pub(super) struct Sources<'a> {
    /// The exemplars.
    pub(super) exemplars: &'a [Exemplar],
    /// What was found on each.
    pub(super) styles: &'a [Style],
}

/// Synthesis while patches are placed.
pub(super) struct Placing<'a> {
    /// The ground so far.
    pub(super) canvas: &'a mut Canvas,
    /// Ground used so far.
    pub(super) uses: &'a mut Uses,
    /// What is counted.
    pub(super) report: &'a mut Report,
    /// Heights that the terrain should have.
    pub(super) wanted: &'a Wanted,
    /// Sketches followed so far.
    pub(super) sketches: u32,
    /// Centres of the places served so far.
    pub(super) cores: Vec<[f64; 2]>,
}

impl Placing<'_> {
    /// Places patches along all lines of a sketch, but where an earlier sketch has some.
    pub(super) fn follow(
        &mut self,
        sketch: &Network,
        sources: &Sources<'_>,
        style: &(dyn Fn(&Canvas, &Window) -> usize + Sync),
        order: Order,
        rules: &Rules,
        job: &Job<'_>,
    ) -> Result<()> {
        let mut plan: Vec<(usize, Site)> = sketch.plan(rules.patch as f64).into_iter().enumerate().collect();
        if order == Order::RasterItems {
            let band = |site: &Site| (site.center[0] / (rules.patch as f64 / 2.0)).floor();
            plan.sort_by(|(_, a), (_, b)| {
                band(a).total_cmp(&band(b)).then(a.center[1].total_cmp(&b.center[1]))
            });
        }
        let n_planned = plan.len();
        self.report.planned += n_planned;
        // By its number in the plan along the tree, so that neither the order of placement nor what is served together
        // has a say in what a place draws.
        let sketches = i64::from(self.sketches);
        let chance = |number: usize, part: usize| {
            let parts = sketches << 32 | part as i64;
            unit(key(rules.seed, STREAM, number as i64, parts))
        };
        let mut waiting: VecDeque<Waiting> = plan
            .into_iter()
            .filter_map(|(number, site)| {
                let window = self.window(&site, rules)?;
                Some(Waiting { number, chance: chance(number, 0), window, site })
            })
            .collect();
        self.sketches += 1;
        let stage = job.stage(n_planned as u64);
        stage.advance((n_planned - waiting.len()) as u64);
        while !waiting.is_empty() {
            job.check()?;
            let round = round(waiting.iter().map(|place| &place.window), |window| {
                window.grown(rules.margin + 1, self.canvas.size)
            });
            let scene = Scene {
                canvas: self.canvas,
                exemplars: sources.exemplars,
                kind: sketch.kind,
                uses: self.uses,
                wanted: self.wanted,
                rules,
            };
            let found: Vec<Found> = round
                .par_iter()
                .map(|&at| {
                    let Waiting { window, .. } = &waiting[at];
                    place(&waiting[at], &sources.styles[style(scene.canvas, window)], &scene, job)
                })
                .collect::<Result<_>>()?;
            // Which are done with, and the places that come in their stead.
            let mut served: Vec<(usize, Vec<Waiting>)> = Vec::with_capacity(round.len());
            let mut taken = Uses::default();
            for (&at, found) in round.iter().zip(found) {
                let Waiting { site, number, window, .. } = &waiting[at];
                let (Choice { piece, fallback, .. }, added) = match found {
                    Found::Patch(choice, added) => (*choice, added),
                    Found::Paths(paths) => {
                        self.report.branches_split += 1;
                        self.report.planned += paths.len() - 1;
                        let path = |(part, site)| {
                            let chance = chance(*number, part + 1);
                            Waiting { number: *number, chance, window: *window, site }
                        };
                        served.push((at, paths.into_iter().enumerate().map(path).collect()));
                        continue;
                    }
                    Found::Nothing => {
                        self.report.unmatched += 1;
                        served.push((at, Vec::new()));
                        continue;
                    }
                };
                let (which, center) = (piece.patch.exemplar as usize, piece.patch.source_center);
                if taken.near(which, center, rules.patch as f64 / 2.0) > 0 {
                    // Another of the round has the same ground: this one chooses again, knowing that.
                    break;
                }
                taken.add(which, center);
                self.uses.add(which, center);
                self.report.seam += piece.seam.mean_mismatch();
                self.report.placed[role_of(site)] += 1;
                match fallback {
                    Fallback::None => {}
                    Fallback::ArmIgnored => self.report.arms_ignored += 1,
                    Fallback::ArmUnmatched => self.report.arms_unmatched += 1,
                }
                self.canvas.paste(piece, &added);
                self.cores.push(site.center);
                served.push((at, Vec::new()));
            }
            for (at, instead) in served.into_iter().rev() {
                waiting.remove(at);
                stage.advance(u64::from(instead.is_empty()));
                instead.into_iter().rev().for_each(|place| waiting.insert(at, place));
            }
        }
        Ok(())
    }

    /// The window of a place that is to be served: on the output, not on ground that stays, and not where an earlier
    /// sketch has a patch.
    fn window(&self, site: &Site, rules: &Rules) -> Option<Window> {
        let close = |core: &[f64; 2]| {
            libm::hypot(core[0] - site.center[0], core[1] - site.center[1]) < rules.patch as f64 / 4.0
        };
        let [row, col] = site.center.map(|x| (x + 0.5).floor() as i64);
        let window = Window::around(row, col, rules.patch, self.canvas.size);
        let wanted = !self.cores.iter().any(close) && !is_given(self.canvas, site) && !window.is_empty();
        wanted.then_some(window)
    }
}

/// Which of those that wait are served together: the first, and those that touch none that comes before them.
fn round<'a>(waiting: impl Iterator<Item = &'a Window>, touched: impl Fn(&Window) -> Window) -> Vec<usize> {
    let mut round = Vec::new();
    let mut before: Vec<Window> = Vec::new();
    for (at, window) in waiting.enumerate().take(AHEAD) {
        let window = touched(window);
        if !before.iter().any(|other| other.touches(&window)) {
            round.push(at);
            if round.len() == AT_ONCE {
                break;
            }
        }
        before.push(window);
    }
    round
}

/// Where a site's patch is counted.
fn role_of(site: &Site) -> usize {
    match site.role {
        Role::Branch => 0,
        Role::End => 1,
        Role::Path => 2,
    }
}

/// Whether a place lies on ground that stays.
fn is_given(canvas: &Canvas, site: &Site) -> bool {
    let [row, col] = site.center.map(|x| (x + 0.5).floor());
    let (rows, cols) = canvas.size;
    let inside = row >= 0.0 && col >= 0.0 && row < rows as f64 && col < cols as f64;
    inside && canvas.is_frozen(row as usize * cols + col as usize)
}

/// A place that is still to be served.
struct Waiting {
    /// Its number in the plan.
    number: usize,
    /// What decides among the best candidates.
    chance: f64,
    window: Window,
    site: Site,
}

/// What goes to a place.
enum Found {
    /// A patch, and what spreads its seam.
    Patch(Box<Choice>, Vec<f64>),
    /// Paths in place of a branch that no candidate fits.
    Paths(Vec<Site>),
    Nothing,
}

/// What goes to a place.
fn place(place: &Waiting, style: &Style, scene: &Scene<'_>, job: &Job<'_>) -> Result<Found> {
    let Some(pool) = style.pool(scene.kind) else { return Ok(Found::Nothing) };
    if let Some(choice) = choose(&place.site, pool, scene, place.chance, job)? {
        let added = scene.canvas.fit(&choice.piece, scene.rules, job)?;
        return Ok(Found::Patch(Box::new(choice), added));
    }
    if place.site.role == Role::Branch && !pool.paths.is_empty() {
        return Ok(Found::Paths(split(&place.site)));
    }
    Ok(Found::Nothing)
}
