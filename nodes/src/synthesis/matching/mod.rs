//! Which candidate goes to a place: warps, costs, and the choice.
//!
//! Zhou 2007 §5.2 and §5.3. Departures of the default rules. A path of three control points never bends, so two anchors
//! beside its centre are added, and points half-way along each arm, which hold the line to what was drawn between its
//! ends. Ends are warped like paths. Costs are in units of what the exemplar itself shows: bending of a few degrees, its
//! own steps, its own profiles. A candidate whose line does not stand out from both sides where it is to lie pays for it.

mod cheapest;
mod controls;
mod frame;
mod probes;
mod uses;

use orograph_core::{FeatureKind, Job, Patch, Result};
use rayon::prelude::*;

pub(super) use probes::height_at;
pub use uses::Uses;

use super::{
    canvas::{Canvas, Piece, Sheet, Window},
    cut::Seam,
    exemplar::Exemplar,
    network::{Role, Site},
    patches::{Candidate, Pool},
    settings::Rules,
    tps::{Basis, Point, Spline},
};
use cheapest::cheapest;
use controls::{controls, is_straight, pairings, triangle_images};
use frame::{Frame, Warped};
use probes::{JOIN, Probes};

/// Bending that counts as one: a few degrees at each end of a path.
const BEND: f64 = 0.01;
/// Weight of stretching beside bending.
const STRETCH: f64 = 0.05;
/// Cost of a line none of which stands out.
const CREST: f64 = 20.0;

/// One arm-by-arm pairing of a candidate with a place, and its warp.
#[derive(Clone, Debug)]
struct Fit<'a> {
    candidate: &'a Candidate,
    sources: Vec<Point>,
    spline: Spline,
    bend: f64,
}

/// The chosen patch, ready to be pasted.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The patch, cut.
    pub piece: Piece,
    /// Its cost, by the rules' own measure.
    pub cost: f64,
    /// Its rank's runners-up: exemplar, centre, mirrored, cost without the seam.
    pub considered: Vec<Ranked>,
}

/// A candidate as it was judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// Which exemplar.
    pub exemplar: usize,
    /// Centre in the exemplar.
    pub center: Point,
    /// Whether it is reflected.
    pub mirrored: bool,
    /// Bending and stretching.
    pub bend: f64,
    /// Mean mismatch along its seam in metres.
    pub seam: f64,
    /// The total.
    pub cost: f64,
}

/// What candidates are judged by, besides themselves.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The ground so far.
    pub canvas: &'a Canvas,
    /// What patches are taken from.
    pub exemplars: &'a [Exemplar],
    /// Crests or talwegs.
    pub kind: FeatureKind,
    /// Windows used already.
    pub uses: &'a Uses,
    /// The rules.
    pub rules: &'a Rules,
}

/// The best candidate of `pool` for `site`; `None` when none can be warped to it or the output does not reach it.
///
/// # Errors
/// Those of the cut, and cancellation.
pub fn choose(site: &Site, pool: &Pool, scene: &Scene<'_>, job: &Job<'_>) -> Result<Option<Choice>> {
    let rules = scene.rules;
    let list = match site.role {
        Role::Branch => &pool.branches,
        Role::End => &pool.ends,
        Role::Path => &pool.paths,
    };
    let all: Vec<usize> = (0..site.arms.len()).collect();
    let Some(basis) = Basis::new(&controls(site, &all, rules), rules.radius()) else { return Ok(None) };
    let probes = Probes::new(site, &basis, pool, scene.canvas, rules);
    let exact =
        site.role != Role::Branch || list.iter().any(|candidate| candidate.site.arms.len() == all.len());
    let mut fits: Vec<Fit<'_>> = list
        .par_iter()
        .filter(|candidate| !exact || site.role != Role::Branch || candidate.site.arms.len() == all.len())
        .filter_map(|candidate| best_fit(site, &basis, candidate, rules))
        .collect();
    // Windows that served often enough wait until nothing else is left.
    let reach = rules.patch as f64 / 2.0;
    let uses = |fit: &Fit<'_>| scene.uses.near(fit.candidate.exemplar, fit.candidate.site.center, reach);
    if fits.iter().any(|fit| uses(fit) < rules.max_uses) {
        fits.retain(|fit| uses(fit) < rules.max_uses);
    }
    let n_kept = if site.role == Role::Branch { rules.n_branch } else { rules.n_path };
    let repeated = |fit: &Fit<'_>| rules.repetition * uses(fit) as f64;
    let bound = |fit: &Fit<'_>| warp_cost(fit, rules) + repeated(fit);
    let cost = |fit: &Fit<'_>| {
        let exemplar = &scene.exemplars[fit.candidate.exemplar];
        let heights = probes.heights(fit, &basis, &exemplar.terrain);
        let limit = rules.lift.map_or(0.0, |share| share * exemplar.range);
        let lift = probes.lift(&heights).unwrap_or(0.0).clamp(-limit, limit);
        base_cost(fit, &probes, &heights, lift, exemplar, scene) + repeated(fit)
    };
    let whole = |fit: &Fit<'_>| !basis.folds(&fit.spline, site.center, rules.radius(), false);
    let fits = cheapest(fits, n_kept, bound, cost, whole);
    let center = site.center.map(|x| (x + 0.5).floor() as i64);
    let inner = Window::around(center[0], center[1], rules.patch, scene.canvas.size);
    if inner.is_empty() || fits.is_empty() {
        return Ok(None);
    }
    let frame = Frame::new(site, &inner, &basis, scene);
    let mut warped: Vec<Warped> =
        fits.par_iter().map(|fit| frame.warp(fit, &basis, &probes, scene, job)).collect::<Result<_>>()?;
    // The cut decides among those that differ least from what is there.
    let mut ranks: Vec<usize> = (0..fits.len()).collect();
    ranks.sort_by(|&a, &b| warped[a].cost.total_cmp(&warped[b].cost).then(a.cmp(&b)));
    ranks.truncate(rules.n_cut);
    let judged: Vec<(f64, Seam)> = ranks
        .par_iter()
        .map(|&rank| frame.judge(&fits[rank], &warped[rank], &basis, &probes, scene, job))
        .collect::<Result<_>>()?;
    let considered = ranks
        .iter()
        .zip(&judged)
        .map(|(&rank, (cost, seam))| Ranked {
            exemplar: fits[rank].candidate.exemplar,
            center: fits[rank].candidate.site.center,
            mirrored: fits[rank].candidate.mirrored,
            bend: fits[rank].bend,
            seam: seam.mean_cost(),
            cost: *cost,
        })
        .collect();
    // The first of equals, which is the one that was cheaper before the cut.
    let Some(best) = (0..judged.len()).min_by(|&a, &b| judged[a].0.total_cmp(&judged[b].0)) else {
        return Ok(None);
    };
    let fit = &fits[ranks[best]];
    let warped = warped.swap_remove(ranks[best]);
    let Some((cost, seam)) = judged.into_iter().nth(best) else { return Ok(None) };
    let pairs = controls(site, &all, rules);
    let patch = Patch {
        exemplar: fit.candidate.exemplar as u32,
        source_center: fit.candidate.site.center,
        target_center: site.center,
        size: rules.patch as u32,
        mirrored: fit.candidate.mirrored,
        controls: pairs
            .iter()
            .zip(&fit.sources)
            .map(|(to, from)| {
                let from = fit.candidate.source(*from);
                [to[0], to[1], from[0], from[1]]
            })
            .collect(),
        offset: warped.lift,
    };
    let sheet = Sheet { window: frame.window, heights: warped.heights, core: frame.core };
    let piece = Piece { sheet, old: frame.old, seam, patch, sources: warped.sources };
    Ok(Some(Choice { piece, cost, considered }))
}

/// The pairing of a candidate's arms that bends least, when it can be used.
fn best_fit<'a>(site: &Site, basis: &Basis, candidate: &'a Candidate, rules: &Rules) -> Option<Fit<'a>> {
    let mut best: Option<Fit<'a>> = None;
    for arms in pairings(candidate.site.arms.len(), site.arms.len(), site.role) {
        let mut sources = controls(&candidate.site, &arms, rules);
        if rules.strict() && site.role == Role::Path {
            // The paper's three points, unless they are in line on either side.
            if !is_straight(site, rules) && !is_straight(&candidate.site, rules) {
                sources = triangle_images(site, &candidate.site, basis).unwrap_or(sources);
            }
        }
        let Some(spline) = basis.fit(&sources) else { continue };
        let stretch = spline.stretch(basis);
        if !stretch.is_usable() || stretch.determinant < 0.0 {
            continue;
        }
        let bend = spline.energy() + STRETCH * stretch.distortion();
        if best.as_ref().is_none_or(|best| bend < best.bend) {
            best = Some(Fit { candidate, sources, spline, bend });
        }
    }
    best
}

/// What bending and stretching cost.
fn warp_cost(fit: &Fit<'_>, rules: &Rules) -> f64 {
    if rules.strict() { 1000.0 * fit.spline.energy() } else { fit.bend / BEND }
}

/// Every cost but the seam's.
fn base_cost(
    fit: &Fit<'_>,
    probes: &Probes,
    heights: &[f32],
    lift: f64,
    exemplar: &Exemplar,
    scene: &Scene<'_>,
) -> f64 {
    let (profile, joins) = probes.profile(heights, lift);
    let warp = warp_cost(fit, scene.rules);
    if scene.rules.strict() {
        return if fit.candidate.site.role == Role::Branch { warp } else { warp + 3.0 * profile };
    }
    let mut cost = warp + CREST * probes.flatness(heights, scene.kind);
    if joins > 0.0 && exemplar.step > 0.0 {
        // Profiles five times as far apart as cells: their differences in units of five steps.
        cost += (profile / (JOIN as f64 * joins)).sqrt() / (2.5 * exemplar.step);
    }
    cost
}
