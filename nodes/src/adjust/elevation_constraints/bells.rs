//! A smooth change through heights wanted at some cells: a sum of bells, wide ones first.
//!
//! Floater, M. S. and Iske, A. (1996), "Multistep scattered data interpolation using compactly supported radial basis
//! functions", Journal of Computational and Applied Mathematics 73, with Wendland's (1995) function of smoothness C².
//! At each step sites are thinned to centres no nearer to each other than a fixed share of the bells' radius, which
//! keeps the equations well conditioned; a centre stands for the mean of the sites nearest to it, a departure that
//! leaves the roughness along dense lines to narrow bells. What is left goes to bells half as wide.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{EXACT, Site};

/// Least distance of centres, as a share of the radius.
const SPACING: f64 = 0.4;
/// Centres from which on what is left is so fine that it is left to the membrane.
const MOST: usize = 100_000;
const TOLERANCE: f64 = 1e-10;
const MAX_STEPS: usize = 400;

/// The change at every cell, and what is left of it at each site. Sites come in the order of their cells; beyond
/// `reach` metres from them nothing changes.
pub(super) fn bells(grid: &Grid, sites: &[Site], reach: f64, job: &Job<'_>) -> Result<(Vec<f64>, Vec<f64>)> {
    let CellSize { x, y } = grid.cell;
    job.admit((grid.len() + 5 * sites.len()) as u64 * 8, || format!("the change of {} cells", grid.len()))?;
    let place = |site: &Site| [(site.cell % grid.cols) as f64 * x, (site.cell / grid.cols) as f64 * y];
    let places: Vec<[f64; 2]> = sites.iter().map(place).collect();
    let mut left: Vec<f64> = sites.iter().map(|site| site.change).collect();
    let mut change = vec![0.0; grid.len()];
    let mut radius = reach;
    while SPACING * radius > 0.5 * x.min(y) && left.iter().any(|left| left.abs() > EXACT) {
        job.check()?;
        let (seeds, nearest) = thin(&places, SPACING * radius, job)?;
        if seeds.len() > MOST {
            break;
        }
        let mut wanted = vec![0.0; seeds.len()];
        let mut counts = vec![0.0; seeds.len()];
        for (&seed, left) in nearest.iter().zip(&left) {
            wanted[seed as usize] += left;
            counts[seed as usize] += 1.0;
        }
        wanted.iter_mut().zip(counts).for_each(|(wanted, count)| *wanted /= count);
        let centres: Vec<[f64; 2]> = seeds.iter().map(|&seed| places[seed as usize]).collect();
        let weights = weights(&centres, radius, &wanted, job)?;
        let sum = Sum { centres: &centres, weights: &weights, radius };
        change.par_chunks_mut(grid.cols).enumerate().try_for_each(|(row, change)| {
            job.check()?;
            sum.add_to_row(row as f64 * y, x, change);
            Ok(())
        })?;
        left.par_iter_mut().zip(&places).with_min_len(256).try_for_each(|(left, &place)| {
            job.check()?;
            *left -= sum.at(place);
            Ok(())
        })?;
        radius /= 2.0;
    }
    Ok((change, left))
}

/// Indices of places no nearer to each other than `spacing`, ascending, and for each place which of them is nearest.
fn thin(places: &[[f64; 2]], spacing: f64, job: &Job<'_>) -> Result<(Vec<u32>, Vec<u32>)> {
    const NONE: u32 = u32::MAX;
    let bin = |at: f64| (at / spacing) as usize;
    let far = |k: usize| places.iter().map(|place| bin(place[k])).max().unwrap_or(0);
    let (cols, rows) = (far(0) + 1, far(1) + 1);
    job.admit((rows as u64).saturating_mul(cols as u64).saturating_mul(4), || "bins of sites".into())?;
    // Seeds by the square that they lie in: a list for each, by its first seed and each seed's next.
    let mut first = vec![NONE; rows * cols];
    let (mut next, mut seeds): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    let closest = |first: &[u32], next: &[u32], seeds: &[u32], [x, y]: [f64; 2]| {
        let (col, row) = (bin(x), bin(y));
        let mut best = (f64::INFINITY, NONE);
        for row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
            for col in col.saturating_sub(1)..=(col + 1).min(cols - 1) {
                let mut seed = first[row * cols + col];
                while seed != NONE {
                    let place = places[seeds[seed as usize] as usize];
                    let far = (place[0] - x) * (place[0] - x) + (place[1] - y) * (place[1] - y);
                    if far < best.0 || far == best.0 && seed < best.1 {
                        best = (far, seed);
                    }
                    seed = next[seed as usize];
                }
            }
        }
        best
    };
    for (i, &place) in places.iter().enumerate() {
        if i.is_multiple_of(1 << 12) {
            job.check()?;
        }
        if closest(&first, &next, &seeds, place).0 >= spacing * spacing {
            let bin = bin(place[1]) * cols + bin(place[0]);
            next.push(std::mem::replace(&mut first[bin], seeds.len() as u32));
            seeds.push(i as u32);
        }
    }
    let nearest = places.par_iter().map(|&place| closest(&first, &next, &seeds, place).1).collect();
    Ok((seeds, nearest))
}

/// Wendland's function of the squared distance over the squared radius, 1 at 0 and 0 from 1 on.
fn bell(square: f64) -> f64 {
    let far = square.sqrt();
    let rest = (1.0 - far).max(0.0);
    (rest * rest) * (rest * rest) * (4.0 * far + 1.0)
}

/// The weights with which bells at the centres add up to what is wanted there, by conjugate gradients.
fn weights(centres: &[[f64; 2]], radius: f64, wanted: &[f64], job: &Job<'_>) -> Result<Vec<f64>> {
    let unit = vec![1.0; centres.len()];
    let all = Sum { centres, weights: &unit, radius };
    // As no two centres are near, each meets few others, however many there are.
    let rows: Vec<Vec<(u32, f64)>> = centres
        .par_iter()
        .map(|&[x, y]| {
            job.check()?;
            let near = all.band(y).filter_map(|other| {
                let [ox, oy] = centres[other];
                let square = ((ox - x) * (ox - x) + (oy - y) * (oy - y)) / (radius * radius);
                (square < 1.0).then(|| (other as u32, bell(square)))
            });
            Ok(near.collect())
        })
        .collect::<Result<_>>()?;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut weights = vec![0.0; centres.len()];
    let mut rest = wanted.to_vec();
    let mut along = rest.clone();
    let mut energy = dot(&rest, &rest);
    let target = energy * TOLERANCE * TOLERANCE;
    for _ in 0..MAX_STEPS {
        if energy <= target {
            break;
        }
        job.check()?;
        let times = |row: &Vec<(u32, f64)>| row.iter().map(|&(i, value)| value * along[i as usize]).sum();
        let image: Vec<f64> = rows.par_iter().with_min_len(256).map(times).collect();
        let length = energy / dot(&along, &image);
        for (i, image) in image.into_iter().enumerate() {
            weights[i] += length * along[i];
            rest[i] -= length * image;
        }
        let before = std::mem::replace(&mut energy, dot(&rest, &rest));
        along.iter_mut().zip(&rest).for_each(|(along, rest)| *along = rest + energy / before * *along);
    }
    Ok(weights)
}

/// Bells of one radius; centres ascend in y.
struct Sum<'a> {
    centres: &'a [[f64; 2]],
    weights: &'a [f64],
    radius: f64,
}

impl Sum<'_> {
    /// The centres whose bells reach a line of constant y.
    fn band(&self, y: f64) -> std::ops::Range<usize> {
        let start = self.centres.partition_point(|centre| centre[1] < y - self.radius);
        let end = self.centres.partition_point(|centre| centre[1] <= y + self.radius);
        start..end
    }

    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let scale = 1.0 / (self.radius * self.radius);
        let part = |i: usize| {
            let [cx, cy] = self.centres[i];
            self.weights[i] * bell(((cx - x) * (cx - x) + (cy - y) * (cy - y)) * scale)
        };
        self.band(y).map(part).sum()
    }

    fn add_to_row(&self, y: f64, step: f64, row: &mut [f64]) {
        let scale = 1.0 / (self.radius * self.radius);
        for i in self.band(y) {
            let ([cx, cy], weight) = (self.centres[i], self.weights[i]);
            let half = (self.radius * self.radius - (cy - y) * (cy - y)).max(0.0).sqrt();
            let first = ((cx - half) / step).ceil().max(0.0) as usize;
            let end = (((cx + half) / step).floor() as usize + 1).min(row.len());
            for (col, out) in row.iter_mut().enumerate().take(end).skip(first) {
                let across = col as f64 * step - cx;
                *out += weight * bell((across * across + (cy - y) * (cy - y)) * scale);
            }
        }
    }
}
