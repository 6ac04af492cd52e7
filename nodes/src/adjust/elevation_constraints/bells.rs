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
        left.iter_mut().zip(sites).for_each(|(left, site)| *left = site.change - change[site.cell]);
        radius /= 2.0;
    }
    Ok((change, left))
}

/// Indices of places no nearer to each other than `spacing`, ascending, and for each place which of them is nearest.
fn thin(places: &[[f64; 2]], spacing: f64, job: &Job<'_>) -> Result<(Vec<u32>, Vec<u32>)> {
    let mut seeds = Seeds::none(places, spacing, job)?;
    for (i, &place) in places.iter().enumerate() {
        if i.is_multiple_of(1 << 12) {
            job.check()?;
        }
        if !seeds.around(place).any(|(far, _)| far < spacing * spacing) {
            seeds.plant(i as u32);
        }
    }
    let nearest = |&place: &[f64; 2]| {
        let least = |best: (f64, u32), seed: (f64, u32)| {
            if seed.0 < best.0 || seed.0 == best.0 && seed.1 < best.1 { seed } else { best }
        };
        seeds.around(place).fold((f64::INFINITY, Seeds::NONE), least).1
    };
    let nearest = places.par_iter().with_min_len(1024).map(nearest).collect();
    Ok((seeds.planted, nearest))
}

/// Some of the places, by the square of the plane that they lie in: a list for each square, by its first seed and each
/// seed's next.
struct Seeds<'a> {
    places: &'a [[f64; 2]],
    spacing: f64,
    rows: usize,
    cols: usize,
    first: Vec<u32>,
    next: Vec<u32>,
    planted: Vec<u32>,
}

impl<'a> Seeds<'a> {
    const NONE: u32 = u32::MAX;

    fn none(places: &'a [[f64; 2]], spacing: f64, job: &Job<'_>) -> Result<Self> {
        let far = |k: usize| places.iter().map(|place| place[k]).fold(0.0, f64::max);
        let [cols, rows] = [0, 1].map(|k| (far(k) / spacing) as usize + 1);
        job.admit((rows as u64).saturating_mul(cols as u64).saturating_mul(4), || "bins of sites".into())?;
        let first = vec![Self::NONE; rows * cols];
        Ok(Self { places, spacing, rows, cols, first, next: Vec::new(), planted: Vec::new() })
    }

    fn square(&self, [x, y]: [f64; 2]) -> [usize; 2] {
        [(y / self.spacing) as usize, (x / self.spacing) as usize]
    }

    fn plant(&mut self, place: u32) {
        let [row, col] = self.square(self.places[place as usize]);
        let head = &mut self.first[row * self.cols + col];
        self.next.push(std::mem::replace(head, self.planted.len() as u32));
        self.planted.push(place);
    }

    /// The squared distance and number of each seed in the nine squares around a place.
    fn around(&self, place: [f64; 2]) -> impl Iterator<Item = (f64, u32)> + '_ {
        let [row, col] = self.square(place);
        let cols = col.saturating_sub(1)..(col + 2).min(self.cols);
        let squares = (row.saturating_sub(1)..(row + 2).min(self.rows))
            .flat_map(move |row| cols.clone().map(move |col| row * self.cols + col));
        let seed = |head: u32| (head != Self::NONE).then_some(head);
        let lists = squares.flat_map(move |square| {
            std::iter::successors(seed(self.first[square]), move |&last| seed(self.next[last as usize]))
        });
        lists.map(move |seed| {
            let [x, y] = self.places[self.planted[seed as usize] as usize];
            ((x - place[0]) * (x - place[0]) + (y - place[1]) * (y - place[1]), seed)
        })
    }
}

/// Wendland's function of the squared distance over the squared radius, 1 at 0 and 0 from 1 on.
fn bell(square: f64) -> f64 {
    let far = square.sqrt();
    let rest = (1.0 - far).max(0.0);
    (rest * rest) * (rest * rest) * (4.0 * far + 1.0)
}

/// The weights with which bells at the centres add up to what is wanted there, by conjugate gradients.
fn weights(centres: &[[f64; 2]], radius: f64, wanted: &[f64], job: &Job<'_>) -> Result<Vec<f64>> {
    // As no two centres are near, each meets few others, however many there are.
    let squares = Squares::of(centres, radius);
    let rows: Vec<Vec<(u32, f64)>> = centres
        .par_iter()
        .map(|&[x, y]| {
            job.check()?;
            let near = squares.around([x, y]).filter_map(|other| {
                let [ox, oy] = centres[other as usize];
                let square = ((ox - x) * (ox - x) + (oy - y) * (oy - y)) / (radius * radius);
                (square < 1.0).then(|| (other, bell(square)))
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

/// Places by the square of the plane that they lie in.
struct Squares {
    side: f64,
    rows: usize,
    cols: usize,
    /// Where each square's places begin in `members`; one more than there are squares.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Squares {
    /// Squares of the given side, or wider ones where they would be more than places.
    fn of(places: &[[f64; 2]], side: f64) -> Self {
        let far = |axis: usize| places.iter().map(|place| place[axis]).fold(0.0, f64::max);
        let (width, height) = (far(0), far(1));
        let most = (places.len() as f64).sqrt().ceil();
        let side = side.max(width.max(height) / most);
        let at = |along: f64| (along / side) as usize;
        let (rows, cols) = (at(height) + 1, at(width) + 1);
        let square = |[x, y]: [f64; 2]| at(y) * cols + at(x);
        let mut starts = vec![0; rows * cols + 1];
        places.iter().for_each(|&place| starts[square(place) + 1] += 1);
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let mut free = starts.clone();
        let mut members = vec![0; places.len()];
        for (i, &place) in (0..).zip(places) {
            let slot = &mut free[square(place)];
            members[*slot as usize] = i;
            *slot += 1;
        }
        Self { side, rows, cols, starts, members }
    }

    /// All places in the nine squares around one, so at least those within a square's side of it.
    fn around(&self, [x, y]: [f64; 2]) -> impl Iterator<Item = u32> + '_ {
        let near = |along: f64, count: usize| {
            let at = (along / self.side) as usize;
            at.saturating_sub(1)..(at + 2).min(count)
        };
        let cols = near(x, self.cols);
        near(y, self.rows).flat_map(move |row| {
            let first = self.starts[row * self.cols + cols.start] as usize;
            let end = self.starts[row * self.cols + cols.end] as usize;
            self.members[first..end].iter().copied()
        })
    }
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
