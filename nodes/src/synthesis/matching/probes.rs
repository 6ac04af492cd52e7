//! A few heights of each candidate, enough to rank them all before any is warped whole.

use libm::hypot;
use orograph_core::{FeatureKind, Heightfield};

use super::{
    Fit, Scene,
    controls::{offset, unit_vector},
};
use crate::synthesis::{
    canvas::Canvas,
    network::Site,
    patches::{ACROSS, Pool, fall},
    resample::cubic,
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
    joins: Vec<Join>,
    /// Heights that are wanted at the last points.
    wanted: Vec<f32>,
    /// How far the ground should fall on both sides of the line, in metres.
    pub(super) prominence: f64,
}

/// Where the line of a place meets a line that is there.
struct Join {
    arm: usize,
    at: Point,
    along: Point,
    /// How far before and behind it directions are taken, in cells.
    step: f64,
}

/// Most wanted heights that are looked at.
const MOST_WANTED: usize = 16;

/// Samples of a profile across a join, and at a station of a line.
pub(super) const JOIN: usize = 7;
pub(super) const STATION: usize = ACROSS.len();
impl Probes {
    pub(super) fn new(site: &Site, basis: &Basis, pool: &Pool, scene: &Scene<'_>) -> Self {
        let Scene { canvas, rules, .. } = *scene;
        let patch = rules.patch as f64;
        let mut points = Vec::new();
        let mut joins = Vec::new();
        for (number, arm) in site.arms.iter().enumerate() {
            let at = arm.crossing(patch / 4.0);
            let known = height_at(canvas, at);
            if known.is_nan() {
                continue;
            }
            let step = patch / 16.0;
            let before = arm.crossing(patch / 4.0 - step);
            let along = unit_vector(before, arm.crossing(patch / 4.0 + step));
            joins.push(Join { arm: number, at, along, step });
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
        let (places, wanted): (Vec<Point>, Vec<f32>) = wanted_near(site, scene).into_iter().unzip();
        points.extend(places);
        let n_joins = joins.len();
        let mut terms = Vec::with_capacity(points.len() * basis.n_terms());
        points.iter().for_each(|&at| basis.terms(at, &mut terms));
        let old = points[..n_join_points].iter().map(|&at| height_at(canvas, at)).collect();
        Self { terms, old, n_joins, n_stations, joins, wanted, prominence: CRISP * pool.prominence }
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

    /// How far the candidate lies below each height that is wanted, where it has ground.
    fn lacks(&self, heights: &[f32]) -> impl Iterator<Item = f64> {
        let at = self.n_joins * JOIN + self.n_stations * STATION;
        let lacks = self.wanted.iter().zip(&heights[at..]).map(|(wanted, own)| f64::from(wanted - own));
        lacks.filter(|lack| !lack.is_nan())
    }

    /// Mean by which the candidate is to be lifted to have the heights that are wanted; `None` when none are.
    pub(super) fn wanted_lift(&self, heights: &[f32]) -> Option<f64> {
        let (sum, n) = self.lacks(heights).fold((0.0, 0.0), |(sum, n), lack| (sum + lack, n + 1.0));
        (n > 0.0).then(|| sum / n)
    }

    /// Mean square of how far the candidate lies off the heights that are wanted, in units of `range` metres.
    pub(super) fn off(&self, heights: &[f32], range: f64) -> f64 {
        let square = |lack: f64| (lack / range) * (lack / range);
        let (sum, n) = self.lacks(heights).fold((0.0, 0.0), |(sum, n), lack| (sum + square(lack), n + 1.0));
        if n > 0.0 && range > 0.0 { sum / n } else { 0.0 }
    }

    /// Sum over joins of 1 less the cosine of the angle between the drawn line, which the ground there follows, and the
    /// candidate's own line as it is warped.
    pub(super) fn turns(&self, fit: &Fit<'_>, basis: &Basis) -> f64 {
        let turn = |join: &Join| {
            let source = basis.map(&fit.spline, join.at);
            let [down, across] = basis.jacobian(&fit.spline, join.at);
            let drawn = [down, across].map(|row| row[0] * join.along[0] + row[1] * join.along[1]);
            let site = &fit.candidate.site;
            let arm = &site.arms[fit.arms[join.arm]];
            let away = hypot(source[0] - site.center[0], source[1] - site.center[1]);
            let (before, after) = (arm.crossing(away - join.step), arm.crossing(away + join.step));
            let own = [after[0] - before[0], after[1] - before[1]];
            let lengths = hypot(drawn[0], drawn[1]) * hypot(own[0], own[1]);
            // An arm that ends before has no direction there, and is not to blame for one.
            if lengths > 0.0 { 1.0 - (drawn[0] * own[0] + drawn[1] * own[1]) / lengths } else { 0.0 }
        };
        self.joins.iter().map(turn).sum()
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
        let stations = heights[self.n_joins * JOIN..].chunks(STATION).take(self.n_stations);
        let flat =
            stations.map(|across| 1.0 - (fall(|i| sign * across[i]) / self.prominence).clamp(0.0, 1.0));
        flat.sum::<f64>() / self.n_stations as f64
    }
}

/// Places within a quarter of a patch from the centre of `site` where heights are wanted, and these; of many every k-th.
fn wanted_near(site: &Site, scene: &Scene<'_>) -> Vec<(Point, f32)> {
    let (rows, cols) = scene.canvas.size;
    let reach = scene.rules.patch as f64 / 4.0;
    let span = |at: f64, n: usize| {
        let (from, to) = ((at - reach).ceil().max(0.0), (at + reach).floor().min(n as f64 - 1.0));
        from as usize..(to + 1.0).max(0.0) as usize
    };
    if scene.wanted.is_empty() {
        return Vec::new();
    }
    let [row, col] = site.center;
    let columns = span(col, cols);
    let mut near = Vec::new();
    for r in span(row, rows) {
        for (cell, height) in scene.wanted.within(r * cols + columns.start..r * cols + columns.end) {
            let at = [r as f64, (cell - r * cols) as f64];
            if hypot(at[0] - row, at[1] - col) <= reach {
                near.push((at, height));
            }
        }
    }
    let keep = near.len().div_ceil(MOST_WANTED).max(1);
    near.into_iter().step_by(keep).collect()
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
