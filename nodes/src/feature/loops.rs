//! Drawn loops closed again.
//!
//! Polygon breaking opens a loop at its lowest place. Where that lies beside a junction, what is left of the loop
//! there is a short branch and goes, and the end of the rest looks at the side of another line instead of at a second
//! end. Such an end is led on to that line as long as it stays inside the stroke, and the loop is opened anew where
//! it is furthest from any junction: there two ends face each other, and a ring can be told.

use orograph_core::{PointKind, prelude::*};

use super::{
    chains::distance,
    from_curves,
    network::{between, unit},
    rings::headings,
    settings::Shaping,
};
use crate::transform::sample::{Interpolation, sample};

/// The cosine of the angle by which a bridge may turn from where its end points, 60°.
const AHEAD: f64 = 0.5;
/// Features with more vertices than this are left as they are.
const MOST: usize = 20_000;

/// Closes the loops of a traced sketch that were opened beside a junction.
///
/// `edges` is the distance in cells to the edge of the strokes, negative outside, and `width` that of the widest.
///
/// # Errors
/// As [`from_curves::trace`].
pub(crate) fn close(
    features: &mut Features,
    edges: &Heightfield,
    width: f64,
    shaping: &Shaping,
    job: &Job,
) -> Result<()> {
    let vertices: usize = features.lines.iter().map(|line| line.vertices.len()).sum();
    let bridges = bridges(features, edges, width, shaping, job)?;
    if bridges.is_empty() || vertices > MOST {
        return Ok(());
    }
    let level = |at: [f64; 2]| [at[0], at[1], 0.0];
    let place = |point: u32| {
        let point = &features.points[point as usize];
        [point.row, point.col]
    };
    let mut curves: Vec<Vec<[f64; 3]>> =
        features.lines.iter().map(|line| line.vertices.iter().copied().map(level).collect()).collect();
    curves.extend(features.rings.iter().map(|ring| ring.map(|point| level(place(point))).to_vec()));
    curves.extend(bridges.iter().map(|bridge| bridge.map(level).to_vec()));
    let scale = features.scale;
    *features = from_curves::trace(
        &curves,
        features.grid.clone(),
        features.kind,
        0.0,
        shaping.joining.smooth_passes,
        job,
    )?;
    features.scale = scale;
    Ok(())
}

/// For each end that looks at the side of a line the way to it.
fn bridges(
    features: &Features,
    edges: &Heightfield,
    width: f64,
    shaping: &Shaping,
    job: &Job,
) -> Result<Vec<[[f64; 2]; 2]>> {
    let reach = 1.5 * width;
    let inside = |a: [f64; 2], b: [f64; 2]| {
        let n = distance(a, b).ceil().max(1.0) as usize;
        (0..=n).all(|i| {
            let [row, col] = between(a, b, i as f64 / n as f64);
            sample(edges, row, col, Interpolation::Bilinear) > 0.0
        })
    };
    let mut bridges = Vec::new();
    for (id, heading) in headings(features, shaping.heading).into_iter().enumerate() {
        job.check()?;
        let point = &features.points[id];
        let Some(inward) =
            heading.filter(|_| !features.rings.iter().flatten().any(|&end| end as usize == id))
        else {
            continue;
        };
        let at = [point.row, point.col];
        let ahead = |to: [f64; 2]| {
            unit(at, to).is_some_and(|towards| towards[0] * inward[0] + towards[1] * inward[1] <= -AHEAD)
        };
        let facing = |to: &[f64; 2]| distance(at, *to) <= reach && ahead(*to) && inside(at, *to);
        let nearest = |places: &mut dyn Iterator<Item = [f64; 2]>| {
            places.min_by(|a, b| distance(at, *a).total_cmp(&distance(at, *b)))
        };
        let branches = features.points.iter().filter(|point| point.kind == PointKind::Branch);
        let mut branches = branches.map(|point| [point.row, point.col]).filter(facing);
        // A line's own end lies at its feet; only what comes back from afar is another line.
        let mut others = features.lines.iter().flat_map(|line| {
            let own = |i: usize| {
                let along = |range: std::ops::Range<usize>| -> f64 {
                    line.vertices[range].windows(2).map(|pair| distance(pair[0], pair[1])).sum()
                };
                (line.from as usize == id && along(0..i + 1) <= 2.0 * reach)
                    || (line.to as usize == id && along(i..line.vertices.len()) <= 2.0 * reach)
            };
            (0..line.vertices.len())
                .filter(move |&i| facing(&line.vertices[i]) && !own(i))
                .map(|i| line.vertices[i])
        });
        if let Some(to) = nearest(&mut branches).or_else(|| nearest(&mut others)) {
            bridges.push([at, to]);
        }
    }
    Ok(bridges)
}
