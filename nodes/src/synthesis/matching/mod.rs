//! Which candidate goes to a place: warps, costs, and the choice.
//!
//! Zhou 2007 §5.2 and §5.3. Departures of the default rules. A path of three control points never bends, so two anchors
//! beside its centre are added, and points half-way along each arm, which hold the line to what was drawn between its
//! ends. Ends are warped like paths. Costs are in units of what the exemplar itself shows: bending of a few degrees, its
//! own steps, its own profiles. A candidate whose line does not stand out from both sides where it is to lie pays for it.
//! One of the best is drawn, so that seeds make variants.

mod cheapest;
mod controls;
mod draw;
mod frame;
mod ponds;
mod probes;
#[cfg(test)]
mod tests;
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
use crate::adjust::elevation_constraints::Wanted;
use cheapest::cheapest;
use controls::{controls, is_straight, pairings, triangle_images};
use draw::draw;
use frame::{Frame, Warped};
use probes::{JOIN, Probes};

/// Bending that counts as one: a few degrees at each end of a path.
const BEND: f64 = 0.01;
/// Weight of stretching beside bending.
const STRETCH: f64 = 0.05;
/// Share of the exemplar's height range that a patch may lie off a wanted height for a cost of 1.
const OFF: f64 = 0.1;
/// Cost of a line none of which stands out.
const CREST: f64 = 20.0;

/// One arm-by-arm pairing of a candidate with a place, and its warp.
#[derive(Clone, Debug)]
struct Fit<'a> {
    candidate: &'a Candidate,
    /// For each arm of the place the candidate's arm that goes there.
    arms: Vec<usize>,
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
    /// What was given up for it.
    pub fallback: Fallback,
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
    /// Heights that the terrain should have.
    pub wanted: &'a Wanted,
    /// The rules.
    pub rules: &'a Rules,
}

/// What had to be given up so that a place was served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// Nothing.
    None,
    /// One line more leaves the patch's source than the place.
    ArmIgnored,
    /// One line of the place is not in the patch.
    ArmUnmatched,
}

/// The candidate of `pool` for `site`: one of the best, by `chance` in 0..1. Where none with as many lines can be warped
/// to it, one with a line more, of which one is ignored, or else one with a line less. `None` when there is none either,
/// and where the output does not reach.
///
/// A branch of three lines is not served with a path: [`split`] makes several paths of it, and all lines are there.
///
/// # Errors
/// Those of the cut, and cancellation.
pub fn choose(
    site: &Site,
    pool: &Pool,
    scene: &Scene<'_>,
    chance: f64,
    job: &Job<'_>,
) -> Result<Option<Choice>> {
    let degree = site.arms.len();
    for (degree, fallback) in [(degree, Fallback::None), (degree + 1, Fallback::ArmIgnored)] {
        if let Some(choice) = choose_from(site, &of_degree(pool, degree), pool, scene, chance, job)? {
            return Ok(Some(Choice { fallback, ..choice }));
        }
    }
    let mut best: Option<Choice> = None;
    if degree == 2 || degree > 3 {
        let list = of_degree(pool, degree - 1);
        for unmatched in 0..degree {
            let mut fewer = site.clone();
            fewer.arms.remove(unmatched);
            if degree == 2 {
                fewer.role = Role::End;
            }
            let next = choose_from(&fewer, &list, pool, scene, chance, job)?;
            let is_better = |next: &Choice| best.as_ref().is_none_or(|best| next.cost < best.cost);
            if let Some(next) = next.filter(is_better) {
                best = Some(Choice { fallback: Fallback::ArmUnmatched, ..next });
            }
        }
    }
    Ok(best)
}

/// The candidates that as many lines leave.
fn of_degree(pool: &Pool, degree: usize) -> Vec<&Candidate> {
    match degree {
        0 => Vec::new(),
        1 => pool.ends.iter().collect(),
        2 => pool.paths.iter().collect(),
        _ => pool.branches.iter().filter(|candidate| candidate.site.arms.len() == degree).collect(),
    }
}

/// Paths that together follow all lines of a branch: the straightest way through, then for each other line the straightest
/// way from it.
#[must_use]
pub fn split(site: &Site) -> Vec<Site> {
    let n = site.arms.len();
    let bent = |a: usize, b: usize| {
        let apart = (site.arms[a].angle() - site.arms[b].angle()).abs();
        (apart - std::f64::consts::PI).abs()
    };
    let pairs = || (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    let straightest = |pairs: &mut dyn Iterator<Item = [usize; 2]>| {
        pairs.min_by(|&[a, b], &[c, d]| bent(a, b).total_cmp(&bent(c, d)))
    };
    let Some(through) = straightest(&mut pairs()) else { return Vec::new() };
    let mut ways = vec![through];
    for arm in (0..n).filter(|arm| !through.contains(arm)) {
        ways.extend(straightest(&mut pairs().filter(|pair| pair.contains(&arm))));
    }
    let path = |way: [usize; 2]| Site {
        role: Role::Path,
        center: site.center,
        arms: way.map(|arm| site.arms[arm].clone()).into(),
    };
    ways.into_iter().map(path).collect()
}

/// One of the best of `list`, whose lines are as many as the place's or one more.
fn choose_from(
    site: &Site,
    list: &[&Candidate],
    pool: &Pool,
    scene: &Scene<'_>,
    chance: f64,
    job: &Job<'_>,
) -> Result<Option<Choice>> {
    let rules = scene.rules;
    let center = site.center.map(|x| (x + 0.5).floor() as i64);
    let inner = Window::around(center[0], center[1], rules.patch, scene.canvas.size);
    if inner.is_empty() || list.is_empty() {
        return Ok(None);
    }
    let all: Vec<usize> = (0..site.arms.len()).collect();
    let Some(basis) = Basis::new(&controls(site, &all, rules), rules.radius()) else { return Ok(None) };
    let probes = Probes::new(site, &basis, pool, scene);
    let mut fits: Vec<Fit<'_>> =
        list.par_iter().filter_map(|candidate| best_fit(site, &basis, candidate, rules)).collect();
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
        let lift = lift(probes.lift(&heights), probes.wanted_lift(&heights), exemplar, rules);
        base_cost(fit, &basis, &probes, &heights, lift, exemplar, scene) + repeated(fit)
    };
    let whole = |fit: &Fit<'_>| !basis.folds(&fit.spline, site.center, rules.radius(), false);
    let fits = cheapest(fits, n_kept, bound, cost, whole);
    let frame = Frame::new(site, &inner, &basis, scene);
    let mut warped: Vec<Warped> =
        fits.par_iter().map(|fit| frame.warp(fit, &basis, &probes, scene, job)).collect::<Result<_>>()?;
    // The cut decides among those that differ least from what is there.
    let mut ranks: Vec<usize> = (0..fits.len()).collect();
    ranks.sort_by(|&a, &b| warped[a].cost.total_cmp(&warped[b].cost).then(a.cmp(&b)));
    ranks.truncate(rules.n_cut.max(rules.variety));
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
    // The first of equals is the one that was cheaper before the cut.
    let costs: Vec<f64> = judged.iter().map(|(cost, _)| *cost).collect();
    let Some(best) = draw(&costs, rules.variety, chance) else { return Ok(None) };
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
    Ok(Some(Choice { piece, cost, considered, fallback: Fallback::None }))
}

/// The pairing of a candidate's arms that bends least, when it can be used.
fn best_fit<'a>(site: &Site, basis: &Basis, candidate: &'a Candidate, rules: &Rules) -> Option<Fit<'a>> {
    let mut best: Option<Fit<'a>> = None;
    for arms in pairings(candidate.site.arms.len(), site.arms.len()) {
        let mut sources = controls(&candidate.site, &arms, rules);
        if rules.strict() && site.role == Role::Path && candidate.site.role == Role::Path {
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
            best = Some(Fit { candidate, arms, sources, spline, bend });
        }
    }
    best
}

/// What bending and stretching cost.
fn warp_cost(fit: &Fit<'_>, rules: &Rules) -> f64 {
    if rules.strict() { 1000.0 * fit.spline.energy() } else { fit.bend / BEND }
}

/// How far a candidate is lifted: to the heights that are wanted, whatever that takes, or else towards the ground around it
/// as far as the rules allow.
fn lift(to_ground: Option<f64>, to_wanted: Option<f64>, exemplar: &Exemplar, rules: &Rules) -> f64 {
    let Some(share) = rules.lift else { return 0.0 };
    let limit = share * exemplar.range;
    to_wanted.unwrap_or_else(|| to_ground.unwrap_or(0.0).clamp(-limit, limit))
}

/// Every cost but the seam's and that of depressions.
fn base_cost(
    fit: &Fit<'_>,
    basis: &Basis,
    probes: &Probes,
    heights: &[f32],
    lift: f64,
    exemplar: &Exemplar,
    scene: &Scene<'_>,
) -> f64 {
    let (profile, joins) = probes.profile(heights, lift);
    let terms = &scene.rules.terms;
    let mut warp = warp_cost(fit, scene.rules);
    if terms.wanted_heights > 0.0 {
        warp += terms.wanted_heights * probes.off(heights, OFF * exemplar.range);
    }
    if terms.tangents > 0.0 {
        warp += terms.tangents * probes.turns(fit, basis);
    }
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
