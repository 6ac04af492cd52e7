//! The points that a place and a candidate are warped by, and how their arms are paired.

use libm::hypot;

use crate::synthesis::{
    network::Site,
    settings::Rules,
    tps::{Basis, Point},
};

pub(super) fn unit_vector(from: Point, to: Point) -> Point {
    let (down, across) = (to[0] - from[0], to[1] - from[1]);
    let length = hypot(down, across);
    if length > 0.0 { [down / length, across / length] } else { [0.0, 1.0] }
}

pub(super) fn offset(at: Point, along: Point, by: f64) -> Point {
    [at[0] + along[0] * by, at[1] + along[1] * by]
}

/// The control points of a place with these arms, in order.
pub(super) fn controls(site: &Site, arms: &[usize], rules: &Rules) -> Vec<Point> {
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
pub(super) fn affine_controls(center: Point, tips: &[Point], radius: f64) -> Vec<Point> {
    let along = match tips {
        [tip] => unit_vector(center, *tip),
        [first, second, ..] => unit_vector(*second, *first),
        [] => [0.0, 1.0],
    };
    vec![center, offset(center, along, radius), offset(center, [along[1], -along[0]], radius)]
}

/// Whether the two arms of a path leave its centre in one line, near enough.
pub(super) fn is_straight(site: &Site, rules: &Rules) -> bool {
    let [a, b] = [0, 1].map(|arm| site.arms[arm].tip());
    let c = site.center;
    let cross = (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
    cross.abs() < 0.02 * rules.radius() * rules.radius()
}

/// The ways to pair `n` arms with `wanted` arms: cyclic shifts, of all choices of arms when there is one too many. Paths
/// are in their pool in both directions, so as they are.
pub(super) fn pairings(n: usize, wanted: usize) -> Vec<Vec<usize>> {
    if n == wanted && n < 3 {
        return vec![(0..n).collect()];
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

/// Images of a straight frame's three points under the affine map that takes one path's three points to another's.
pub(super) fn triangle_images(site: &Site, other: &Site, _basis: &Basis) -> Option<Vec<Point>> {
    let triangle = |site: &Site| [site.center, site.arms[0].tip(), site.arms[1].tip()];
    let (from, to) = (triangle(site), triangle(other));
    let affine = Basis::new(&from, 1.0)?;
    let spline = affine.fit(&to)?;
    let radius = hypot(from[1][0] - from[0][0], from[1][1] - from[0][1]);
    let tips = [from[1], from[2]];
    Some(affine_controls(from[0], &tips, radius).into_iter().map(|at| affine.map(&spline, at)).collect())
}
