//! The search itself.

use orograph_core::prelude::*;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    fourier::{Plane, smooth_size},
    roughness::Roughness,
};
use crate::synthesis::{exemplar::Exemplar, network::Network, tps::Point};

/// Cells of an exemplar that are searched at once at most; larger ones are searched coarser.
const COARSE_CELLS: usize = 180_000;

/// Places that are compared together.
const LANES: usize = 5;

/// An exemplar ready to be searched for windows of up to a certain size.
pub struct Searcher<'a> {
    exemplar: &'a Exemplar,
    /// Cells along the side of a coarse cell.
    factor: usize,
    rows: usize,
    cols: usize,
    plane: Plane,
    mean: f64,
    heights: Vec<Complex64>,
    squares: Vec<Complex64>,
    /// Length of line in each coarse cell, in cells.
    lines: Vec<f32>,
    /// Mean of that for a cell.
    density: f64,
    roughness: Roughness,
}

/// What to look for.
#[derive(Clone, Copy, Debug)]
pub struct Query<'a> {
    /// Number of columns of the window.
    pub cols: usize,
    /// Heights to compare with; NaN where nothing is known or it does not count.
    pub heights: &'a [f32],
    /// Cells that would be filled.
    pub open: &'a [bool],
    /// Most metres that the exemplar may be lifted or lowered to fit; `None` for as it is.
    pub lift: Option<f64>,
    /// Most length of line, in cells, in what would be filled; doubled until something is found.
    pub most_lines: f64,
    /// The same as a share of what the exemplar has in as much ground on the average; the larger of both holds.
    pub usual_lines: f64,
    /// Whether places smoother than the exemplar usually is count as worse: unlike ground differs the less the smoother it
    /// is, so that otherwise the plains of an exemplar serve everywhere.
    pub balanced: bool,
    /// How many places to return at most.
    pub n: usize,
}

/// A place that fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Row of the window's first row in the exemplar.
    pub row: usize,
    /// Column of its first column.
    pub col: usize,
    /// Mean squared difference of the cells compared after the lift, in square metres.
    pub mismatch: f64,
    /// Metres to add.
    pub lift: f64,
    /// How many times as much the mismatch counts, of a place smoother than usual.
    pub weight: f64,
}

impl Found {
    /// The mismatch as it counts.
    #[must_use]
    pub fn weighed(&self) -> f64 {
        self.mismatch * self.weight
    }
}

/// Sums over the known cells of a difference: how well it fits at its best lift, and that lift.
fn judge(n: f64, sum: f64, squares: f64, lift: Option<f64>) -> (f64, f64) {
    let Some(limit) = lift else { return ((squares / n).max(0.0), 0.0) };
    let best = sum / n;
    let used = best.clamp(-limit, limit);
    let rest = (squares / n - best * best).max(0.0);
    (rest + (best - used) * (best - used), used)
}

impl<'a> Searcher<'a> {
    /// Prepares `exemplar`; `networks` are the features on it that fills should keep clear of.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the memory is refused, and cancellation.
    pub fn new(exemplar: &'a Exemplar, networks: &[&Network], job: &Job<'_>) -> Result<Self> {
        let (rows, cols) = exemplar.terrain.grid().size();
        let mut factor = 1;
        while (rows / factor) * (cols / factor) > COARSE_CELLS && factor < 8 {
            factor += 1;
        }
        Self::at(exemplar, networks, factor, job)
    }

    fn at(exemplar: &'a Exemplar, networks: &[&Network], factor: usize, job: &Job<'_>) -> Result<Self> {
        job.check()?;
        let terrain = &exemplar.terrain;
        let (rows, cols) = (terrain.rows() / factor, terrain.cols() / factor);
        let plane = Plane::new(smooth_size(rows), smooth_size(cols));
        let n = plane.rows * plane.cols;
        job.admit(n as u64 * 52, || format!("the spectra of {rows} × {cols} cells"))?;
        let coarse = block_means(terrain, factor, rows, cols);
        let (sum, known) =
            coarse.iter().filter(|h| !h.is_nan()).fold((0.0, 0.0), |(s, n), h| (s + h, n + 1.0));
        let mean = if known > 0.0 { sum / known } else { 0.0 };
        let mut field = vec![Complex64::new(0.0, 0.0); rows * plane.cols];
        for row in 0..rows {
            for col in 0..cols {
                let height = coarse[row * cols + col] - mean;
                if !height.is_nan() {
                    field[row * plane.cols + col] = Complex64::new(height, height * height);
                }
            }
        }
        let (heights, squares) = part(&plane.forward(field), &plane);
        let mut lines = vec![0.0; rows * cols];
        for network in networks {
            draw(network, factor, rows, cols, &mut lines);
        }
        let density = lines.iter().map(|&line| f64::from(line)).sum::<f64>() / (lines.len() as f64).max(1.0);
        let roughness = Roughness::new(terrain, factor, rows, cols);
        Ok(Self { exemplar, factor, rows, cols, plane, mean, heights, squares, lines, density, roughness })
    }

    /// The best places for `query`, best first; none when the exemplar is too small or nothing whole is left.
    ///
    /// `uses` tells how often the ground around a centre has served. Places are taken from those that served less often
    /// than the first of `most`; where there is none, than the next, and so on.
    ///
    /// # Errors
    /// Cancellation.
    pub fn search(
        &self,
        query: &Query<'_>,
        most: &[usize],
        uses: impl Fn(Point) -> usize,
        job: &Job<'_>,
    ) -> Result<Vec<Found>> {
        let (cols, rows) = (query.cols, query.heights.len().checked_div(query.cols).unwrap_or(0));
        let (all_rows, all_cols) = self.exemplar.terrain.grid().size();
        if rows == 0 || rows > all_rows || cols > all_cols {
            return Ok(Vec::new());
        }
        let spots = self.coarse_spots(query, (rows, cols), most, uses, job)?;
        let samples = |stride: usize| -> Vec<(usize, f64)> {
            let picked = |i: &usize| (i / cols).is_multiple_of(stride) && (i % cols).is_multiple_of(stride);
            (0..query.heights.len())
                .filter(picked)
                .filter(|&i| !query.heights[i].is_nan())
                .map(|i| ((i / cols) * all_cols + i % cols, f64::from(query.heights[i])))
                .collect()
        };
        let sparse = samples(if rows * cols > 4000 { 2 } else { 1 });
        let reach = self.factor.max(4);
        let fits = |row: i64, col: i64| self.exemplar.voids.is_whole(row, col, rows, cols);
        let refine = |samples: &[(usize, f64)], from: Found, reach: i64, step: usize| -> Found {
            let mut best = Found { mismatch: f64::INFINITY, ..from };
            // A place is moved by little, so its weight stays.
            for down in (-reach..=reach).step_by(step) {
                let row = from.row as i64 + down;
                let cols: Vec<usize> = (-reach..=reach)
                    .step_by(step)
                    .map(|across| from.col as i64 + across)
                    .filter(|&col| fits(row, col))
                    .map(|col| col as usize)
                    .collect();
                for cols in cols.chunks(LANES) {
                    for found in self.compare(samples, row as usize, cols, query.lift) {
                        if found.mismatch < best.mismatch {
                            best = Found { weight: from.weight, ..found };
                        }
                    }
                }
            }
            best
        };
        let mut found: Vec<Found> =
            spots.par_iter().map(|&spot| refine(&sparse, spot, reach as i64, 2)).collect();
        let order = |a: &Found, b: &Found| {
            a.weighed().total_cmp(&b.weighed()).then(a.row.cmp(&b.row)).then(a.col.cmp(&b.col))
        };
        found.sort_by(order);
        found.retain(|found| found.mismatch.is_finite());
        found.truncate(2 * query.n.max(1));
        job.check()?;
        let all = samples(1);
        let mut found: Vec<Found> = found.par_iter().map(|&spot| refine(&all, spot, 1, 1)).collect();
        found.retain(|found| found.mismatch.is_finite());
        found.sort_by(order);
        found.dedup_by_key(|found| (found.row, found.col));
        found.truncate(query.n);
        Ok(found)
    }

    /// Compares cell by cell, at up to [`LANES`] columns together: one sum alone would wait for each of its additions.
    fn compare<'b>(
        &self,
        samples: &[(usize, f64)],
        row: usize,
        cols: &'b [usize],
        lift: Option<f64>,
    ) -> impl Iterator<Item = Found> + 'b {
        let terrain = &self.exemplar.terrain;
        let cells = &terrain.cells()[row * terrain.cols()..];
        // Lanes without a column repeat the first.
        let lanes: [&[f32]; LANES] =
            std::array::from_fn(|lane| &cells[cols.get(lane).copied().unwrap_or(cols[0])..]);
        let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
        for &(at, height) in samples {
            for lane in 0..LANES {
                let difference = height - f64::from(lanes[lane][at]);
                sums[lane] += difference;
                squares[lane] += difference * difference;
            }
        }
        let n = samples.len() as f64;
        cols.iter().zip(sums.into_iter().zip(squares)).map(move |(&col, (sum, squares))| {
            let (mismatch, lift) = if n > 0.0 { judge(n, sum, squares, lift) } else { (0.0, 0.0) };
            Found { row, col, mismatch, lift, weight: 1.0 }
        })
    }

    /// Places worth a closer look: the best of each neighbourhood, as rows and columns of full resolution.
    fn coarse_spots(
        &self,
        query: &Query<'_>,
        (rows, cols): (usize, usize),
        most: &[usize],
        uses: impl Fn(Point) -> usize,
        job: &Job<'_>,
    ) -> Result<Vec<Found>> {
        let factor = self.factor;
        let (h, w) = ((rows / factor).max(1), (cols / factor).max(1));
        if h > self.rows || w > self.cols {
            return Ok(Vec::new());
        }
        let (mut field, mut open) = (vec![Complex64::new(0.0, 0.0); h * self.plane.cols], vec![false; h * w]);
        let (mut n, mut sum, mut square) = (0.0, 0.0, 0.0);
        for row in 0..h {
            for col in 0..w {
                let cells = (0..factor * factor)
                    .map(|k| (row * factor + k / factor) * cols + col * factor + k % factor);
                let (mut total, mut known, mut to_fill) = (0.0, 0, 0);
                for i in cells {
                    if !query.heights[i].is_nan() {
                        total += f64::from(query.heights[i]);
                        known += 1;
                    }
                    to_fill += usize::from(query.open[i]);
                }
                open[row * w + col] = 2 * to_fill >= factor * factor;
                if 2 * known >= factor * factor {
                    let height = total / known as f64 - self.mean;
                    field[row * self.plane.cols + col] = Complex64::new(height, 1.0);
                    n += 1.0;
                    sum += height;
                    square += height * height;
                }
            }
        }
        let (last_row, last_col) = (self.rows - h, self.cols - w);
        let mut spots: Vec<(f64, usize, usize)> = Vec::new();
        let weight = |row: usize, col: usize| {
            if query.balanced { self.roughness.weight(row, col, h, w) } else { 1.0 }
        };
        let block = ((h.min(w)) / 8).max(1);
        let correlated = if n > 0.0 { Some(self.correlate(field, last_row + 1)) } else { None };
        job.check()?;
        for block_row in (0..=last_row).step_by(block) {
            for block_col in (0..=last_col).step_by(block) {
                let mut best = (f64::INFINITY, block_row, block_col);
                if let Some(correlated) = &correlated {
                    for row in block_row..(block_row + block).min(last_row + 1) {
                        for col in block_col..(block_col + block).min(last_col + 1) {
                            let value = correlated[row * self.plane.cols + col];
                            let (mismatch, _) = judge(n, sum - value.im, square + value.re, query.lift);
                            let mismatch = mismatch * weight(row, col);
                            if mismatch < best.0 {
                                best = (mismatch, row, col);
                            }
                        }
                    }
                } else {
                    best.0 = 0.0;
                }
                spots.push(best);
            }
        }
        spots.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let wanted = (8 * query.n).max(16);
        let n_open = open.iter().filter(|&&open| open).count() as f64;
        let least = query.most_lines.max(query.usual_lines * self.density * n_open);
        // Each is counted once, and only if it is come by.
        let (mut served, mut lines) = (vec![None; spots.len()], vec![None; spots.len()]);
        for &most in most {
            let mut limit = least;
            loop {
                job.check()?;
                let mut out = Vec::new();
                for (spot, &(mismatch, row, col)) in spots.iter().enumerate() {
                    let (top, left) = (row * factor, col * factor);
                    let center = [top as f64 + rows as f64 / 2.0, left as f64 + cols as f64 / 2.0];
                    let usable = mismatch.is_finite()
                        && self.exemplar.voids.is_whole(top as i64, left as i64, rows, cols)
                        && *served[spot].get_or_insert_with(|| uses(center)) < most
                        && *lines[spot].get_or_insert_with(|| self.lines_in(row, col, h, w, &open)) <= limit;
                    if usable {
                        let weight = weight(row, col);
                        out.push(Found { row: top, col: left, mismatch, lift: 0.0, weight });
                        if out.len() == wanted {
                            break;
                        }
                    }
                }
                if !out.is_empty() {
                    return Ok(out);
                }
                if limit > 4.0 * (rows * cols) as f64 {
                    break;
                }
                limit = (2.0 * limit).max(1.0);
            }
        }
        Ok(Vec::new())
    }

    /// Length of line in the cells that would be filled from (`row`, `col`).
    fn lines_in(&self, row: usize, col: usize, h: usize, w: usize, open: &[bool]) -> f64 {
        let mut total = 0.0;
        for i in 0..h {
            let lines = &self.lines[(row + i) * self.cols + col..][..w];
            for (line, open) in lines.iter().zip(&open[i * w..]) {
                total += if *open { f64::from(*line) } else { 0.0 };
            }
        }
        total
    }

    /// `-2 (S ⋆ mT) + S² ⋆ m` and, as imaginary part, `S ⋆ m`, of a field mT + i m.
    fn correlate(&self, field: Vec<Complex64>, wanted: usize) -> Vec<Complex64> {
        let spectrum = self.plane.forward(field);
        let mut product = vec![Complex64::new(0.0, 0.0); spectrum.len()];
        let cols = self.plane.rows;
        product.par_chunks_mut(cols).enumerate().for_each(|(row, product)| {
            let (heights, squares) =
                (&self.heights[row * cols..][..cols], &self.squares[row * cols..][..cols]);
            parts(&spectrum, &self.plane, row, |col, template, mask| {
                let (t, m) = (template.conj(), mask.conj());
                let squares = heights[col] * t * -2.0 + squares[col] * m;
                let sums = heights[col] * m;
                // Both are spectra of real fields: one transform brings both back.
                product[col] = Complex64::new(squares.re - sums.im, squares.im + sums.re);
            });
        });
        self.plane.inverse(product, wanted)
    }
}

/// The spectra of the real and of the imaginary part of a field.
fn part(spectrum: &[Complex64], plane: &Plane) -> (Vec<Complex64>, Vec<Complex64>) {
    let mut real = vec![Complex64::new(0.0, 0.0); spectrum.len()];
    let mut imaginary = real.clone();
    let rows = real.par_chunks_mut(plane.rows).zip(imaginary.par_chunks_mut(plane.rows));
    rows.enumerate().for_each(|(row, (real, imaginary))| {
        parts(spectrum, plane, row, |col, own, other| (real[col], imaginary[col]) = (own, other));
    });
    (real, imaginary)
}

/// Gives `take` each column of a row of both, with what the real and the imaginary part of the field have there.
fn parts(
    spectrum: &[Complex64],
    plane: &Plane,
    row: usize,
    mut take: impl FnMut(usize, Complex64, Complex64),
) {
    // Spectra lie transposed: rows here are wave numbers along a row of the field.
    let (rows, cols) = (plane.cols, plane.rows);
    let opposite = &spectrum[(rows - row) % rows * cols..][..cols];
    for (col, &a) in spectrum[row * cols..][..cols].iter().enumerate() {
        let b = opposite[if col == 0 { 0 } else { cols - col }].conj();
        let odd = (a - b) * 0.5;
        take(col, (a + b) * 0.5, Complex64::new(odd.im, -odd.re));
    }
}

/// Means of square blocks; NaN for a block with a void.
fn block_means(terrain: &Heightfield, factor: usize, rows: usize, cols: usize) -> Vec<f64> {
    let mut out = vec![0.0; rows * cols];
    out.par_chunks_mut(cols.max(1)).enumerate().for_each(|(row, out)| {
        for i in 0..factor {
            for (out, cells) in out.iter_mut().zip(terrain.row(row * factor + i).chunks(factor)) {
                *out += cells.iter().map(|&height| f64::from(height)).sum::<f64>();
            }
        }
        out.iter_mut().for_each(|out| *out /= (factor * factor) as f64);
    });
    out
}

/// Adds the length of each line to the coarse cells that it passes.
fn draw(network: &Network, factor: usize, rows: usize, cols: usize, out: &mut [f32]) {
    for chain in &network.chains {
        let n = chain.length().ceil().max(1.0);
        let step = chain.length() / n;
        for i in 0..n as usize {
            let [row, col] = chain.position((i as f64 + 0.5) * step);
            let (row, col) = (((row + 0.5) / factor as f64).floor(), ((col + 0.5) / factor as f64).floor());
            if row >= 0.0 && col >= 0.0 && (row as usize) < rows && (col as usize) < cols {
                out[row as usize * cols + col as usize] += step as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests;
