//! Which candidate goes to a place: warps, costs, and the choice.
//!
//! Zhou 2007 §5.2 and §5.3. Departures of the default rules. A path of three control points never bends, so two anchors
//! beside its centre are added, and points half-way along each arm, which hold the line to what was drawn between its
//! ends. Ends are warped like paths. Costs are in units of what the exemplar itself shows: bending of a few degrees, its
//! own steps, its own profiles. A candidate whose line does not stand out from both sides where it is to lie pays for it.

use libm::hypot;
use orograph_core::{FeatureKind, Heightfield, Job, Patch, Result};
use rayon::prelude::*;

use super::{
    canvas::{Canvas, Sheet, Window},
    cut::Seam,
    exemplar::Exemplar,
    network::{Role, Site},
    patches::{ACROSS, Candidate, Pool, fall},
    resample::cubic,
    settings::Rules,
    tps::{Basis, Point, Spline},
};

/// Bending that counts as one: a few degrees at each end of a path.
const BEND: f64 = 0.01;
/// Weight of stretching beside bending.
const STRETCH: f64 = 0.05;
/// Cost of a line none of which stands out.
const CREST: f64 = 20.0;
/// Share of the exemplar's usual prominence that a line should have.
const CRISP: f64 = 0.8;

/// One arm-by-arm pairing of a candidate with a place, and its warp.
#[derive(Clone, Debug)]
struct Fit<'a> {
    candidate: &'a Candidate,
    number: usize,
    shift: usize,
    sources: Vec<Point>,
    spline: Spline,
    bend: f64,
    /// All but the seam.
    cheap: f64,
}

/// The chosen patch, ready to be pasted.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The patch in its window.
    pub sheet: Sheet,
    /// What is there now.
    pub old: Vec<f32>,
    /// The seam between.
    pub seam: Seam,
    /// Where it came from.
    pub patch: Patch,
    /// Where each of its cells came from.
    pub sources: Vec<Point>,
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

/// Earlier uses of an exemplar's windows.
#[derive(Clone, Debug, Default)]
pub struct Uses {
    centers: Vec<(usize, Point)>,
}

impl Uses {
    /// Earlier uses whose centres lie within `reach` cells.
    #[must_use]
    pub fn near(&self, exemplar: usize, center: Point, reach: f64) -> usize {
        let close = |at: &Point| {
            let (down, across) = (at[0] - center[0], at[1] - center[1]);
            down * down + across * across <= reach * reach
        };
        self.centers.iter().filter(|(which, at)| *which == exemplar && close(at)).count()
    }

    /// Counts a use.
    pub fn add(&mut self, exemplar: usize, center: Point) {
        self.centers.push((exemplar, center));
    }
}

fn unit_vector(from: Point, to: Point) -> Point {
    let (down, across) = (to[0] - from[0], to[1] - from[1]);
    let length = hypot(down, across);
    if length > 0.0 { [down / length, across / length] } else { [0.0, 1.0] }
}

fn offset(at: Point, along: Point, by: f64) -> Point {
    [at[0] + along[0] * by, at[1] + along[1] * by]
}

/// The control points of a place with these arms, in order.
fn controls(site: &Site, arms: &[usize], rules: &Rules) -> Vec<Point> {
    let (center, radius) = (site.center, rules.radius());
    let tips: Vec<Point> = arms.iter().map(|&arm| site.arms[arm].tip()).collect();
    let mut out = vec![center];
    if rules.strict() && arms.len() < 3 {
        return affine_controls(center, &tips, radius);
    }
    out.extend(&tips);
    if rules.strict() {
        return out;
    }
    for (&arm, tip) in arms.iter().zip(&tips) {
        let reach = hypot(tip[0] - center[0], tip[1] - center[1]);
        out.push(site.arms[arm].crossing(reach / 2.0));
    }
    if let [first, rest @ ..] = &tips[..]
        && rest.len() < 2
    {
        let along =
            rest.first().map_or_else(|| unit_vector(center, *first), |second| unit_vector(*second, *first));
        let normal = [along[1], -along[0]];
        out.push(offset(center, normal, radius));
        out.push(offset(center, normal, -radius));
        if rest.is_empty() {
            out.push(offset(center, along, -radius));
        }
    }
    out
}

/// Three points whose images determine the paper's map of a path or an end: its own three where they span a triangle,
/// otherwise a right-angled frame along the line.
fn affine_controls(center: Point, tips: &[Point], radius: f64) -> Vec<Point> {
    let along = match tips {
        [tip] => unit_vector(center, *tip),
        [first, second, ..] => unit_vector(*second, *first),
        [] => [0.0, 1.0],
    };
    vec![center, offset(center, along, radius), offset(center, [along[1], -along[0]], radius)]
}

/// Whether the two arms of a path leave its centre in one line, near enough.
fn is_straight(site: &Site, rules: &Rules) -> bool {
    let [a, b] = [0, 1].map(|arm| site.arms[arm].tip());
    let c = site.center;
    let cross = (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
    cross.abs() < 0.02 * rules.radius() * rules.radius()
}

/// The ways to pair `n` arms with `wanted` arms: cyclic shifts, of all choices of arms when there is one too many.
fn pairings(n: usize, wanted: usize, role: Role) -> Vec<Vec<usize>> {
    if role != Role::Branch {
        return if n >= wanted { vec![(0..wanted).collect()] } else { Vec::new() };
    }
    let shifts = |arms: Vec<usize>| {
        (0..arms.len()).map(move |shift| {
            let mut turned = arms.clone();
            turned.rotate_left(shift);
            turned
        })
    };
    if n == wanted {
        shifts((0..n).collect()).collect()
    } else if n == wanted + 1 {
        (0..n).flat_map(|omitted| shifts((0..n).filter(|&arm| arm != omitted).collect())).collect()
    } else {
        Vec::new()
    }
}

/// Points of the output at which candidates are compared before any is warped whole.
struct Probes {
    /// Terms of the spline at each point.
    terms: Vec<f64>,
    /// Heights there now; NaN where unknown.
    old: Vec<f32>,
    n_joins: usize,
    n_stations: usize,
    /// How far the ground should fall on both sides of the line, in metres.
    prominence: f64,
}

/// Samples of a profile across a join, and at a station of a line.
const JOIN: usize = 7;
const STATION: usize = ACROSS.len();
impl Probes {
    fn new(site: &Site, basis: &Basis, pool: &Pool, canvas: &Canvas, rules: &Rules) -> Self {
        let patch = rules.patch as f64;
        let mut points = Vec::new();
        let mut n_joins = 0;
        for arm in &site.arms {
            let at = arm.crossing(patch / 4.0);
            let known = height_at(canvas, at);
            if known.is_nan() {
                continue;
            }
            n_joins += 1;
            let before = arm.crossing(patch / 4.0 - patch / 16.0);
            let normal = unit_vector(before, at);
            let normal = [normal[1], -normal[0]];
            points.extend((0..JOIN).map(|i| offset(at, normal, (i as f64 - 3.0) * patch / 16.0)));
        }
        let n_join_points = points.len();
        let mut n_stations = 0;
        for arm in &site.arms {
            let reach = hypot(arm.tip()[0] - site.center[0], arm.tip()[1] - site.center[1]);
            for share in [0.12, 0.3, 0.48, 0.66, 0.84] {
                let (before, at) = (arm.crossing((share - 0.1) * reach), arm.crossing(share * reach));
                let after = arm.crossing((share + 0.1) * reach);
                let along = unit_vector(before, after);
                let normal = [along[1], -along[0]];
                points.extend(ACROSS.iter().map(|by| offset(at, normal, by * patch / 16.0)));
                n_stations += 1;
            }
        }
        let mut terms = Vec::with_capacity(points.len() * basis.n_terms());
        points.iter().for_each(|&at| basis.terms(at, &mut terms));
        let old = points[..n_join_points].iter().map(|&at| height_at(canvas, at)).collect();
        Self { terms, old, n_joins, n_stations, prominence: CRISP * pool.prominence }
    }

    /// Heights of a candidate at all points.
    fn heights(&self, fit: &Fit<'_>, basis: &Basis, terrain: &Heightfield) -> Vec<f32> {
        let n = basis.n_terms();
        self.terms
            .chunks(n)
            .map(|terms| cubic(terrain, fit.candidate.source(fit.spline.map_terms(terms))))
            .collect()
    }

    /// Mean by which the ground lies above the candidate at the joins.
    fn lift(&self, heights: &[f32]) -> Option<f64> {
        let (mut sum, mut n) = (0.0, 0.0);
        for (old, new) in self.old.iter().zip(heights) {
            let difference = f64::from(*old) - f64::from(*new);
            if !difference.is_nan() {
                sum += difference;
                n += 1.0;
            }
        }
        (n > 0.0).then(|| sum / n)
    }

    /// Sum over joins of squared differences, scaled to seven samples each, and the joins that have any.
    fn profile(&self, heights: &[f32], lift: f64) -> (f64, f64) {
        let (mut total, mut joins) = (0.0, 0.0);
        for (old, new) in self.old.chunks(JOIN).zip(heights.chunks(JOIN)).take(self.n_joins) {
            let (mut sum, mut n) = (0.0, 0.0);
            for (old, new) in old.iter().zip(new) {
                let difference = f64::from(*old) - f64::from(*new) - lift;
                if !difference.is_nan() {
                    sum += difference * difference;
                    n += 1.0;
                }
            }
            if n > 0.0 {
                total += sum * JOIN as f64 / n;
                joins += 1.0;
            }
        }
        (total, joins)
    }

    /// How much the line fails to stand out from both sides by what is wanted: 0 where it does, 1 where not at all.
    fn flatness(&self, heights: &[f32], kind: FeatureKind) -> f64 {
        if self.n_stations == 0 || self.prominence <= 0.0 {
            return 0.0;
        }
        let sign = if kind == FeatureKind::Ridge { 1.0 } else { -1.0 };
        let stations = heights[self.n_joins * JOIN..].chunks(STATION);
        let flat =
            stations.map(|across| 1.0 - (fall(|i| sign * across[i]) / self.prominence).clamp(0.0, 1.0));
        flat.sum::<f64>() / self.n_stations as f64
    }
}

/// The canvas's height at a fractional place, bilinear; NaN where a cell around is unknown.
fn height_at(canvas: &Canvas, [row, col]: Point) -> f32 {
    let (rows, cols) = canvas.size;
    if !(row >= 0.0 && col >= 0.0 && row <= rows as f64 - 1.0 && col <= cols as f64 - 1.0)
        || rows < 2
        || cols < 2
    {
        return f32::NAN;
    }
    let (r, c) = ((row as usize).min(rows - 2), (col as usize).min(cols - 2));
    let (down, across) = ((row - r as f64) as f32, (col - c as f64) as f32);
    let at = |i: usize, j: usize| canvas.heights[(r + i) * cols + c + j];
    let top = at(0, 0) + (at(0, 1) - at(0, 0)) * across;
    let bottom = at(1, 0) + (at(1, 1) - at(1, 0)) * across;
    top + (bottom - top) * down
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
        .enumerate()
        .filter(|(_, candidate)| {
            !exact || site.role != Role::Branch || candidate.site.arms.len() == all.len()
        })
        .flat_map_iter(|(number, candidate)| best_fit(site, &basis, &probes, candidate, number, scene))
        .collect();
    // Windows that served often enough wait until nothing else is left.
    let reach = rules.patch as f64 / 2.0;
    let uses = |fit: &Fit<'_>| scene.uses.near(fit.candidate.exemplar, fit.candidate.site.center, reach);
    if fits.iter().any(|fit| uses(fit) < rules.max_uses) {
        fits.retain(|fit| uses(fit) < rules.max_uses);
    }
    for fit in &mut fits {
        fit.cheap += rules.repetition * uses(fit) as f64;
    }
    fits.sort_by(|a, b| {
        a.cheap.total_cmp(&b.cheap).then(a.number.cmp(&b.number)).then(a.shift.cmp(&b.shift))
    });
    let n_kept = if site.role == Role::Branch { rules.n_branch } else { rules.n_path };
    // Whether a warp folds is dear to tell, so only those that would be kept are asked.
    let whole = |fit: &Fit<'_>| !basis.folds(&fit.spline, site.center, rules.radius(), false);
    let fits: Vec<Fit<'_>> = fits.into_iter().filter(whole).take(n_kept).collect();
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
    Ok(Some(Choice { sheet, old: frame.old, seam, patch, sources: warped.sources, cost, considered }))
}

/// The pairing of a candidate's arms that bends least, when it can be used.
fn best_fit<'a>(
    site: &Site,
    basis: &Basis,
    probes: &Probes,
    candidate: &'a Candidate,
    number: usize,
    scene: &Scene<'_>,
) -> Option<Fit<'a>> {
    let rules = scene.rules;
    let exemplar = &scene.exemplars[candidate.exemplar];
    let mut best: Option<Fit<'a>> = None;
    for (shift, arms) in
        pairings(candidate.site.arms.len(), site.arms.len(), site.role).into_iter().enumerate()
    {
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
            best = Some(Fit { candidate, number, shift, sources, spline, bend, cheap: bend });
        }
    }
    let mut fit = best?;
    let heights = probes.heights(&fit, basis, &exemplar.terrain);
    let limit = rules.lift.map_or(0.0, |share| share * exemplar.range);
    let lift = probes.lift(&heights).unwrap_or(0.0).clamp(-limit, limit);
    fit.cheap = base_cost(&fit, probes, &heights, lift, exemplar, scene);
    Some(fit)
}

/// Images of a straight frame's three points under the affine map that takes one path's three points to another's.
fn triangle_images(site: &Site, other: &Site, _basis: &Basis) -> Option<Vec<Point>> {
    let triangle = |site: &Site| [site.center, site.arms[0].tip(), site.arms[1].tip()];
    let (from, to) = (triangle(site), triangle(other));
    let affine = Basis::new(&from, 1.0)?;
    let spline = affine.fit(&to)?;
    let radius = hypot(from[1][0] - from[0][0], from[1][1] - from[0][1]);
    let tips = [from[1], from[2]];
    Some(affine_controls(from[0], &tips, radius).into_iter().map(|at| affine.map(&spline, at)).collect())
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
    if scene.rules.strict() {
        return if fit.candidate.site.role == Role::Branch {
            1000.0 * fit.spline.energy()
        } else {
            1000.0 * fit.spline.energy() + 3.0 * profile
        };
    }
    let mut cost = fit.bend / BEND + CREST * probes.flatness(heights, scene.kind);
    if joins > 0.0 && exemplar.step > 0.0 {
        // Profiles five times as far apart as cells: their differences in units of five steps.
        cost += (profile / (JOIN as f64 * joins)).sqrt() / (2.5 * exemplar.step);
    }
    cost
}

/// The window of a place, and all that does not depend on the candidate.
struct Frame {
    window: Window,
    old: Vec<f32>,
    /// Terms of the spline at the cells that the patch covers, and which those are.
    terms: Vec<f64>,
    cells: Vec<usize>,
    core: Vec<bool>,
    center: Point,
}

/// A candidate in the window.
struct Warped {
    heights: Vec<f32>,
    sources: Vec<Point>,
    lift: f64,
    /// All costs, with the mismatch of the whole overlap in place of the seam's.
    cost: f64,
    /// All costs but the seam's.
    base: f64,
}

impl Frame {
    fn new(site: &Site, inner: &Window, basis: &Basis, scene: &Scene<'_>) -> Self {
        let window = inner.framed(scene.canvas.size);
        let old = scene.canvas.part(&window);
        let covered = |i: usize| {
            let (row, col) = window.cell(i);
            row >= inner.top
                && col >= inner.left
                && row < inner.top + inner.rows
                && col < inner.left + inner.cols
        };
        let cells: Vec<usize> = (0..window.len()).filter(|&i| covered(i)).collect();
        let n = basis.n_terms();
        let mut terms = vec![0.0; cells.len() * n];
        terms.par_chunks_mut(n * 256).zip(cells.par_chunks(256)).for_each(|(terms, cells)| {
            let mut buffer = Vec::with_capacity(n);
            for (terms, &i) in terms.chunks_mut(n).zip(cells) {
                let (row, col) = window.cell(i);
                buffer.clear();
                basis.terms([row as f64, col as f64], &mut buffer);
                terms.copy_from_slice(&buffer);
            }
        });
        let core = core(site, &window, scene.rules);
        Self { window, old, terms, cells, core, center: site.center }
    }

    fn warp(
        &self,
        fit: &Fit<'_>,
        basis: &Basis,
        probes: &Probes,
        scene: &Scene<'_>,
        job: &Job<'_>,
    ) -> Result<Warped> {
        job.check()?;
        let rules = scene.rules;
        let exemplar = &scene.exemplars[fit.candidate.exemplar];
        let mut heights = vec![f32::NAN; self.window.len()];
        let mut sources = vec![[f64::NAN; 2]; self.window.len()];
        let (mut sum, mut n) = (0.0, 0.0);
        for (terms, &i) in self.terms.chunks(basis.n_terms()).zip(&self.cells) {
            let source = fit.candidate.source(fit.spline.map_terms(terms));
            let height = cubic(&exemplar.terrain, source);
            (heights[i], sources[i]) = (height, source);
            let difference = f64::from(self.old[i]) - f64::from(height);
            if !difference.is_nan() {
                sum += difference;
                n += 1.0;
            }
        }
        let limit = rules.lift.map_or(0.0, |share| share * exemplar.range);
        let lift = if n > 0.0 { (sum / n).clamp(-limit, limit) } else { 0.0 };
        heights.iter_mut().for_each(|height| *height += lift as f32);
        let mismatches = self.old.iter().zip(&heights).map(|(old, new)| f64::from((old - new).abs()));
        let mismatch: f64 = mismatches.filter(|mismatch| !mismatch.is_nan()).sum();
        let probed = probes.heights(fit, basis, &exemplar.terrain);
        let uses =
            scene.uses.near(fit.candidate.exemplar, fit.candidate.site.center, rules.patch as f64 / 2.0);
        let base = base_cost(fit, probes, &probed, lift, exemplar, scene) + rules.repetition * uses as f64;
        let typical = if n > 0.0 && exemplar.step > 0.0 { mismatch / n / exemplar.step } else { 0.0 };
        Ok(Warped { heights, sources, lift, cost: base + typical, base })
    }

    /// The total cost of a candidate, and its seam.
    fn judge(
        &self,
        fit: &Fit<'_>,
        warped: &Warped,
        basis: &Basis,
        probes: &Probes,
        scene: &Scene<'_>,
        job: &Job<'_>,
    ) -> Result<(f64, Seam)> {
        let exemplar = &scene.exemplars[fit.candidate.exemplar];
        let seam = scene.canvas.seam(
            &self.window,
            &warped.heights,
            &self.core,
            &self.old,
            self.center,
            scene.rules,
            job,
        )?;
        let mut cost = warped.base;
        if scene.rules.strict() {
            cost += seam.cost;
            if fit.candidate.site.role == Role::Branch {
                let probed = probes.heights(fit, basis, &exemplar.terrain);
                cost += 3.0 * probes.profile(&probed, warped.lift).0;
            }
        } else if exemplar.step > 0.0 {
            cost += seam.mean_cost() / exemplar.step;
        }
        Ok((cost, seam))
    }
}

/// Cells of the window that must come from the patch: around its centre, and along its lines half-way to the next.
fn core(site: &Site, window: &Window, rules: &Rules) -> Vec<bool> {
    let patch = rules.patch as f64;
    let disc = if site.role == Role::Path { 0.0 } else { patch / 8.0 };
    let corridor = match (rules.strict(), site.role) {
        (true, Role::Path) => patch / 16.0,
        (true, _) => -1.0,
        (false, _) => patch / 10.0,
    };
    let reach = patch / 4.0;
    let mut segments: Vec<[Point; 2]> = Vec::new();
    for arm in &site.arms {
        let end = arm.crossing(reach);
        for pair in arm.track.windows(2) {
            let is_last = hypot(pair[1][0] - site.center[0], pair[1][1] - site.center[1]) >= reach;
            segments.push([pair[0], if is_last { end } else { pair[1] }]);
            if is_last {
                break;
            }
        }
    }
    let from_center = |at: Point| hypot(at[0] - site.center[0], at[1] - site.center[1]);
    (0..window.len())
        .map(|i| {
            let (row, col) = window.cell(i);
            let at = [row as f64, col as f64];
            let away = from_center(at);
            away <= disc
                || away <= reach && segments.iter().any(|segment| to_segment(at, segment) <= corridor)
        })
        .collect()
}

fn to_segment(at: Point, [a, b]: &[Point; 2]) -> f64 {
    let (d, f) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let square = d[0] * d[0] + d[1] * d[1];
    let t = if square > 0.0 { ((d[0] * f[0] + d[1] * f[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    hypot(f[0] - t * d[0], f[1] - t * d[1])
}
