//! A few heights of each candidate, enough to rank them all before any is warped whole.

use libm::hypot;
use orograph_core::{FeatureKind, Heightfield};

use super::{
    Fit,
    controls::{offset, unit_vector},
};
use crate::synthesis::{
    canvas::Canvas,
    network::Site,
    patches::{ACROSS, Pool, fall},
    resample::cubic,
    settings::Rules,
    tps::{Basis, Point},
};

/// Share of the exemplar's usual prominence that a line should have.
const CRISP: f64 = 0.8;

/// Points of the output at which candidates are compared before any is warped whole.
pub(super) struct Probes {
    /// Terms of the spline at each point.
    pub(super) terms: Vec<f64>,
    /// Heights there now; NaN where unknown.
    pub(super) old: Vec<f32>,
    pub(super) n_joins: usize,
    pub(super) n_stations: usize,
    /// How far the ground should fall on both sides of the line, in metres.
    pub(super) prominence: f64,
}

/// Samples of a profile across a join, and at a station of a line.
pub(super) const JOIN: usize = 7;
pub(super) const STATION: usize = ACROSS.len();
impl Probes {
    pub(super) fn new(site: &Site, basis: &Basis, pool: &Pool, canvas: &Canvas, rules: &Rules) -> Self {
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
    pub(super) fn heights(&self, fit: &Fit<'_>, basis: &Basis, terrain: &Heightfield) -> Vec<f32> {
        let n = basis.n_terms();
        self.terms
            .chunks(n)
            .map(|terms| cubic(terrain, fit.candidate.source(fit.spline.map_terms(terms))))
            .collect()
    }

    /// Mean by which the ground lies above the candidate at the joins.
    pub(super) fn lift(&self, heights: &[f32]) -> Option<f64> {
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
    pub(super) fn profile(&self, heights: &[f32], lift: f64) -> (f64, f64) {
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
    pub(super) fn flatness(&self, heights: &[f32], kind: FeatureKind) -> f64 {
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
pub(in crate::synthesis) fn height_at(canvas: &Canvas, [row, col]: Point) -> f32 {
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
