//! Placing patches along the lines of a sketch.
//!
//! Zhou 2007 §5.1: breadth first along the feature tree. Places that share no cell with each other, nor with an earlier one
//! that still waits, do not know of each other but for the ground that they take; they are served together, and one that
//! takes what another of the same round took chooses again.

use std::collections::VecDeque;

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    canvas::{Canvas, Window},
    exemplar::Exemplar,
    matching::{Choice, Scene, Uses, choose},
    network::{Network, Role, Site},
    patches::Pool,
    settings::{Order, Rules},
    synthesise::Report,
};

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
        let mut plan = sketch.plan(rules.patch as f64);
        if order == Order::RasterItems {
            let band = |site: &Site| (site.center[0] / (rules.patch as f64 / 2.0)).floor();
            plan.sort_by(|a, b| band(a).total_cmp(&band(b)).then(a.center[1].total_cmp(&b.center[1])));
        }
        let n_planned = plan.len();
        self.report.planned += n_planned;
        let mut waiting: VecDeque<(Site, Window)> = plan
            .into_iter()
            .filter_map(|site| self.window(&site, rules).map(|window| (site, window)))
            .collect();
        let stage = job.stage(n_planned as u64);
        stage.advance((n_planned - waiting.len()) as u64);
        while !waiting.is_empty() {
            job.check()?;
            let round = round(&waiting, |window| window.grown(rules.margin + 1, self.canvas.size));
            let scene = Scene {
                canvas: self.canvas,
                exemplars: sources.exemplars,
                kind: sketch.kind,
                uses: self.uses,
                rules,
            };
            let found: Vec<Option<(Choice, Vec<f64>)>> = round
                .par_iter()
                .map(|&at| {
                    let (site, window) = &waiting[at];
                    let choice = place(site, &sources.styles[style(scene.canvas, window)], &scene, job)?;
                    let fit = |choice: Choice| {
                        scene.canvas.fit(&choice.piece, rules, job).map(|added| (choice, added))
                    };
                    choice.map(fit).transpose()
                })
                .collect::<Result<_>>()?;
            let mut served = Vec::with_capacity(round.len());
            let mut taken = Uses::default();
            for (&at, found) in round.iter().zip(found) {
                let site = &waiting[at].0;
                let Some((Choice { piece, .. }, added)) = found else {
                    self.report.unmatched += 1;
                    served.push(at);
                    continue;
                };
                let (which, center) = (piece.patch.exemplar as usize, piece.patch.source_center);
                if taken.near(which, center, rules.patch as f64 / 2.0) > 0 {
                    // Another of the round has the same ground: this one chooses again, knowing that.
                    break;
                }
                taken.add(which, center);
                self.uses.add(which, center);
                self.report.seam += piece.seam.mean_cost();
                self.report.placed[role_of(site)] += 1;
                self.canvas.paste(piece, &added);
                self.cores.push(site.center);
                served.push(at);
            }
            stage.advance(served.len() as u64);
            for at in served.into_iter().rev() {
                waiting.remove(at);
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
fn round(waiting: &VecDeque<(Site, Window)>, touched: impl Fn(&Window) -> Window) -> Vec<usize> {
    let mut round = Vec::new();
    let mut before: Vec<Window> = Vec::new();
    for (at, (_, window)) in waiting.iter().enumerate().take(AHEAD) {
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

/// What goes to a place: a patch, or a path through a branch that no candidate fits, or nothing.
fn place(site: &Site, style: &Style, scene: &Scene<'_>, job: &Job<'_>) -> Result<Option<Choice>> {
    let Some(pool) = style.pool(scene.kind) else { return Ok(None) };
    if let Some(chosen) = choose(site, pool, scene, job)? {
        return Ok(Some(chosen));
    }
    if site.role == Role::Path || site.arms.len() < 2 {
        return Ok(None);
    }
    // The straightest way through.
    let (mut best, mut pair) = (f64::INFINITY, [0, 1]);
    for a in 0..site.arms.len() {
        for b in a + 1..site.arms.len() {
            let apart = (site.arms[a].angle() - site.arms[b].angle()).abs();
            let bent = (apart - std::f64::consts::PI).abs();
            if bent < best {
                (best, pair) = (bent, [a, b]);
            }
        }
    }
    let through =
        Site { role: Role::Path, center: site.center, arms: pair.map(|arm| site.arms[arm].clone()).into() };
    choose(&through, pool, scene, job)
}
