//! A candidate in the window of its place: all its heights, its core, and what its seam costs.

use libm::hypot;
use orograph_core::{Job, Result};
use rayon::prelude::*;

use super::{Fit, Scene, base_cost, lift, ponds::ponded, probes::Probes};
use crate::synthesis::{
    canvas::Window,
    cut::Seam,
    network::{Role, Site},
    resample::cubic,
    settings::Rules,
    tps::{Basis, Point},
};

/// Share of a window in closed depressions that costs 1.
const PONDED: f64 = 0.01;

/// The window of a place, and all that does not depend on the candidate.
pub(super) struct Frame {
    pub(super) window: Window,
    pub(super) old: Vec<f32>,
    /// Terms of the spline at the cells that the patch covers, and which those are.
    pub(super) terms: Vec<f64>,
    pub(super) cells: Vec<usize>,
    pub(super) core: Vec<bool>,
    pub(super) center: Point,
}

/// A candidate in the window.
pub(super) struct Warped {
    pub(super) heights: Vec<f32>,
    pub(super) sources: Vec<Point>,
    pub(super) lift: f64,
    /// All costs, with the mismatch of the whole overlap in place of the seam's.
    pub(super) cost: f64,
    /// All costs but the seam's.
    pub(super) base: f64,
}

impl Frame {
    pub(super) fn new(site: &Site, inner: &Window, basis: &Basis, scene: &Scene<'_>) -> Self {
        let margin = scene.rules.margin;
        let window = inner.grown(margin + 1, scene.canvas.size);
        let old = scene.canvas.part(&window);
        let (_, near) = scene.canvas.reached(&window, inner, &old, margin);
        let covered = |i: usize| near[i] || inner.holds(window.cell(i));
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

    pub(super) fn warp(
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
        let probed = probes.heights(fit, basis, &exemplar.terrain);
        let lift = lift((n > 0.0).then(|| sum / n), probes.wanted_lift(&probed), exemplar, rules);
        heights.iter_mut().for_each(|height| *height += lift as f32);
        let mismatches = self.old.iter().zip(&heights).map(|(old, new)| f64::from((old - new).abs()));
        let mismatch: f64 = mismatches.filter(|mismatch| !mismatch.is_nan()).sum();
        let uses =
            scene.uses.near(fit.candidate.exemplar, fit.candidate.site.center, rules.patch as f64 / 2.0);
        let base =
            base_cost(fit, basis, probes, &probed, lift, exemplar, scene) + rules.repetition * uses as f64;
        let typical = if n > 0.0 && exemplar.step > 0.0 { mismatch / n / exemplar.step } else { 0.0 };
        Ok(Warped { heights, sources, lift, cost: base + typical, base })
    }

    /// The total cost of a candidate, and its seam.
    pub(super) fn judge(
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
        if scene.rules.terms.pits > 0.0 {
            let (ground, cols) = (self.old.iter().zip(&warped.heights).zip(&seam.new), self.window.cols);
            let ground =
                ground.map(|((&old, &new), &is_new)| if is_new && !new.is_nan() { new } else { old });
            cost += scene.rules.terms.pits * ponded(ground.collect(), cols, exemplar.step)? / PONDED;
        }
        Ok((cost, seam))
    }
}

/// Cells of the window that must come from the patch: around its centre, and along its lines half-way to the next.
pub(super) fn core(site: &Site, window: &Window, rules: &Rules) -> Vec<bool> {
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

pub(super) fn to_segment(at: Point, [a, b]: &[Point; 2]) -> f64 {
    let (d, f) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let square = d[0] * d[0] + d[1] * d[1];
    let t = if square > 0.0 { ((d[0] * f[0] + d[1] * f[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    hypot(f[0] - t * d[0], f[1] - t * d[1])
}
