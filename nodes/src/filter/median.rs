//! Median filter: each height becomes the middle one of its neighbourhood.
//!
//! Belhadj (2007) runs it over the terrain of figure 13. Here the raster is cut into square tiles. Each tile ranks the
//! heights that it sees once; a sliding window is then a set of ranks, one bit each, and the middle of the set is found
//! by walking a few words from where it was. A step costs O(radius) bit flips, whatever the heights are.

mod nine;

use orograph_core::prelude::*;
use rayon::prelude::*;

/// Replaces each height by the median of the square around it.
///
/// Edges stay sharp while single spikes and pits vanish. Voids stay voids and do not count; beyond the border there is
/// nothing. Between two middle heights the median is their mean.
#[derive(Params, Clone, Debug)]
pub struct Median {
    /// How far the square reaches on every side of its cell; 0 changes nothing.
    #[param(default = 1u32, range = 0..=128, slider = 1..=16, unit = "cells")]
    pub radius: u32,
}

/// Inputs of [`Median`].
#[derive(Inputs)]
pub struct MedianIn<'a> {
    /// Terrain to filter.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Median`].
#[derive(Outputs)]
pub struct MedianOut {
    /// Filtered terrain.
    pub terrain: Heightfield,
}

impl Node for Median {
    const ID: &'static str = "filter.median";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = MedianIn<'a>;
    type Outputs = MedianOut;

    fn halo(&self, _cell: CellSize) -> usize {
        self.radius as usize
    }

    fn cost(&self) -> f64 {
        20.0 + 6.0 * f64::from(self.radius)
    }

    fn run(&self, inputs: MedianIn<'_>, job: &Job) -> Result<MedianOut> {
        Ok(MedianOut { terrain: median(inputs.terrain, self.radius as usize, job)? })
    }
}

/// Shortest side of a tile: long enough to share the ranking, short enough to keep it in fast memory.
const TILE: usize = 64;

/// The median of the measured cells within `radius` of each measured cell; voids stay voids.
///
/// # Errors
/// [`Error::TooLarge`] when the result does not fit, or cancellation.
pub fn median(terrain: &Heightfield, radius: usize, job: &Job<'_>) -> Result<Heightfield> {
    let (rows, cols) = terrain.grid().size();
    if radius == 1 {
        return nine::median(terrain, job);
    }
    let mut out = Heightfield::filled(terrain.grid().clone(), f32::NAN, job)?;
    if terrain.grid().is_empty() {
        return Ok(out);
    }
    let side = TILE.max(2 * radius);
    let done = job.stage(rows as u64);
    out.cells_mut().par_chunks_mut(side * cols).enumerate().try_for_each(|(band, out)| {
        let row0 = band * side;
        let tile_rows = out.len() / cols;
        for col0 in (0..cols).step_by(side) {
            job.check()?;
            let tile_cols = side.min(cols - col0);
            let mut tile = Tile::new(terrain, (row0, tile_rows), (col0, tile_cols), radius);
            tile.run(job, |row, col, height| out[(row - row0) * cols + col] = height)?;
        }
        done.advance(tile_rows as u64);
        Ok(())
    })?;
    Ok(out)
}

/// No rank: a void.
const VOID: u32 = u32::MAX;

/// A tile's surroundings, ranked, and the window that slides over them.
struct Tile {
    /// Rows and columns to write.
    rows: (usize, usize),
    cols: (usize, usize),
    /// Rows and columns that are ranked: those to write and `radius` more, as far as there are any.
    seen_rows: (usize, usize),
    seen_cols: (usize, usize),
    radius: usize,
    ranks: Vec<u32>,
    heights: Vec<f32>,
    /// Ranks in the window, one bit each.
    window: Vec<u64>,
    /// Number of ranks in the window.
    size: usize,
    /// A word near the middle, and how many ranks lie in the words before it.
    word: usize,
    before: usize,
}

impl Tile {
    fn new(terrain: &Heightfield, rows: (usize, usize), cols: (usize, usize), radius: usize) -> Self {
        let around = |(start, n): (usize, usize), all: usize| {
            let first = start.saturating_sub(radius);
            (first, (start + n + radius).min(all) - first)
        };
        let (seen_rows, seen_cols) = (around(rows, terrain.rows()), around(cols, terrain.cols()));
        let mut order = Vec::with_capacity(seen_rows.1 * seen_cols.1);
        for row in 0..seen_rows.1 {
            let heights = &terrain.row(seen_rows.0 + row)[seen_cols.0..seen_cols.0 + seen_cols.1];
            for (col, height) in heights.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
                order.push((u64::from(ordered(*height)) << 32) | (row * seen_cols.1 + col) as u64);
            }
        }
        order.sort_unstable();
        let mut ranks = vec![VOID; seen_rows.1 * seen_cols.1];
        for (rank, &packed) in order.iter().enumerate() {
            ranks[packed as u32 as usize] = rank as u32;
        }
        let heights: Vec<f32> = order.iter().map(|&packed| unordered((packed >> 32) as u32)).collect();
        let window = vec![0; heights.len().div_ceil(64) + 1];
        Self { rows, cols, seen_rows, seen_cols, radius, ranks, heights, window, size: 0, word: 0, before: 0 }
    }

    /// Walks the tile in a serpentine, so that the window only ever moves by one cell.
    fn run(&mut self, job: &Job<'_>, mut write: impl FnMut(usize, usize, f32)) -> Result<()> {
        let (first_col, last_col) = (self.cols.0, self.cols.0 + self.cols.1 - 1);
        let (mut row, mut col) = (self.rows.0, first_col);
        for seen_row in self.reach(row, self.seen_rows) {
            self.flip_row(seen_row, col, true);
        }
        loop {
            write(row, col, self.at(row, col));
            let right = (row - self.rows.0).is_multiple_of(2);
            if col != if right { last_col } else { first_col } {
                let next = if right { col + 1 } else { col - 1 };
                let (gone, come) = if right {
                    (col.checked_sub(self.radius), col + self.radius + 1)
                } else {
                    (Some(col + self.radius), next.wrapping_sub(self.radius))
                };
                if let Some(gone) = gone {
                    self.flip_col(gone, row, false);
                }
                self.flip_col(come, row, true);
                col = next;
            } else if row + 1 < self.rows.0 + self.rows.1 {
                job.check()?;
                if let Some(gone) = row.checked_sub(self.radius) {
                    self.flip_row(gone, col, false);
                }
                self.flip_row(row + self.radius + 1, col, true);
                row += 1;
            } else {
                return Ok(());
            }
        }
    }

    /// What is seen of the stretch of `radius` on both sides of `centre`.
    fn reach(&self, centre: usize, seen: (usize, usize)) -> std::ops::Range<usize> {
        centre.saturating_sub(self.radius).max(seen.0)..(centre + self.radius + 1).min(seen.0 + seen.1)
    }

    fn flip_row(&mut self, row: usize, centre_col: usize, into: bool) {
        if !(self.seen_rows.0..self.seen_rows.0 + self.seen_rows.1).contains(&row) {
            return;
        }
        for col in self.reach(centre_col, self.seen_cols) {
            self.flip(row, col, into);
        }
    }

    fn flip_col(&mut self, col: usize, centre_row: usize, into: bool) {
        if !(self.seen_cols.0..self.seen_cols.0 + self.seen_cols.1).contains(&col) {
            return;
        }
        for row in self.reach(centre_row, self.seen_rows) {
            self.flip(row, col, into);
        }
    }

    #[inline]
    fn flip(&mut self, row: usize, col: usize, into: bool) {
        let rank = self.ranks[(row - self.seen_rows.0) * self.seen_cols.1 + (col - self.seen_cols.0)];
        if rank == VOID {
            return;
        }
        let word = (rank / 64) as usize;
        self.window[word] ^= 1 << (rank % 64);
        let before = usize::from(word < self.word);
        if into {
            self.size += 1;
            self.before += before;
        } else {
            self.size -= 1;
            self.before -= before;
        }
    }

    fn at(&mut self, row: usize, col: usize) -> f32 {
        let centre = (row - self.seen_rows.0) * self.seen_cols.1 + (col - self.seen_cols.0);
        if self.ranks[centre] == VOID {
            return f32::NAN;
        }
        let lower = self.nth((self.size - 1) / 2);
        if self.size % 2 == 1 {
            return lower;
        }
        let upper = self.nth(self.size / 2);
        if lower == upper { lower } else { ((f64::from(lower) + f64::from(upper)) / 2.0) as f32 }
    }

    /// The window's height number `n`, counted from the lowest.
    fn nth(&mut self, n: usize) -> f32 {
        while self.before > n {
            self.word -= 1;
            self.before -= self.window[self.word].count_ones() as usize;
        }
        loop {
            let here = self.window[self.word].count_ones() as usize;
            if self.before + here > n {
                break;
            }
            self.before += here;
            self.word += 1;
        }
        let mut bits = self.window[self.word];
        for _ in self.before..n {
            bits &= bits - 1;
        }
        self.heights[self.word * 64 + bits.trailing_zeros() as usize]
    }
}

/// Bits whose order as integers is that of the heights.
#[inline(always)]
fn ordered(height: f32) -> u32 {
    let bits = height.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The height of [`ordered`] bits.
#[inline(always)]
fn unordered(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & !(1 << 31) } else { !bits })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};
    use orograph_core::{key, unit};

    fn brute_force(terrain: &Heightfield, radius: usize) -> Vec<u32> {
        let (rows, cols) = terrain.grid().size();
        let at = |i: usize| {
            let (row, col) = (i / cols, i % cols);
            if terrain.at(row, col).is_nan() {
                return f32::NAN.to_bits();
            }
            let mut seen: Vec<f32> = (row.saturating_sub(radius)..=(row + radius).min(rows - 1))
                .flat_map(|r| {
                    (col.saturating_sub(radius)..=(col + radius).min(cols - 1)).map(move |c| (r, c))
                })
                .map(|(r, c)| terrain.at(r, c))
                .filter(|height| !height.is_nan())
                .collect();
            seen.sort_by(f32::total_cmp);
            let (low, high) = (seen[(seen.len() - 1) / 2], seen[seen.len() / 2]);
            (if low == high { low } else { ((f64::from(low) + f64::from(high)) / 2.0) as f32 }).to_bits()
        };
        (0..rows * cols).map(at).collect()
    }

    #[test]
    fn it_equals_sorting_every_window() {
        for (rows, cols, radius) in [
            (1, 1, 3),
            (1, 200, 2),
            (90, 70, 1),
            (70, 150, 5),
            (40, 40, 60),
            (3, 5, 0),
            (1, 9, 1),
            (9, 1, 1),
            (2, 2, 1),
        ] {
            for voids in [0.0, 0.01, 0.2] {
                let terrain = field(rows, cols, |row, col| {
                    let u = unit(key(4, 4, row as i64, col as i64));
                    let sign = if row % 2 == 0 { -1.0 } else { 1.0 };
                    if u < voids { f64::NAN } else { (u * 50.0).floor() * sign }
                });
                let out = median(&terrain, radius, &Job::detached()).unwrap();
                let bits: Vec<u32> = out.cells().iter().map(|height| height.to_bits()).collect();
                assert_eq!(bits, brute_force(&terrain, radius), "{rows} × {cols}, radius {radius}, {voids}");
            }
        }
    }

    #[test]
    fn a_spike_vanishes_and_a_step_stays() {
        let spike = row(&[1.0, 1.0, 90.0, 1.0, 1.0, 5.0, 5.0, 5.0]);
        let out = median(&spike, 1, &Job::detached()).unwrap();
        assert_eq!(out.cells(), [1.0, 1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn voids_and_emptiness_pass() {
        assert!(median(&field(0, 4, |_, _| 0.0), 2, &Job::detached()).unwrap().grid().is_empty());
        let out = median(&field(3, 3, |_, _| f64::NAN), 2, &Job::detached()).unwrap();
        assert_eq!(out.void_count(), 9);
    }

    #[test]
    fn a_crop_with_halo_equals_the_whole() {
        let job = Job::detached();
        let terrain = field(100, 120, |row, col| unit(key(1, 1, row as i64, col as i64)) * 100.0);
        let whole = median(&terrain, 4, &job).unwrap().crop(30, 40, 20, 30, &job).unwrap();
        let part = median(&terrain.crop(26, 36, 28, 38, &job).unwrap(), 4, &job).unwrap();
        assert_eq!(part.crop(4, 4, 20, 30, &job).unwrap().cells(), whole.cells());
    }
}
