//! MD, the top-down pass: midpoint displacement of every cell that is still unknown, level by level.
//!
//! The cells of one level depend on coarser levels alone (with the diamond-square scheme its edges also on its
//! centres), so rows run in parallel and the order within a level does not matter.

use orograph_core::{Grid, Heightfield, Job, Result, key, signed_unit};
use pulp::Arch;
use rayon::prelude::*;

use crate::mcmd::{
    axis::Axis,
    even_level::{EvenLevel, even_stride},
    settings::{Falloff, Scheme, Settings},
};

/// Stream of the displacement's random numbers.
const STREAM: u64 = 0x6D63_6D64;

/// Random numbers of the pass: a function of seed and base cell.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    seed: u64,
    row0: i64,
    col0: i64,
}

impl Noise {
    #[inline(always)]
    pub(crate) fn at(self, x: usize, y: usize) -> f64 {
        signed_unit(key(self.seed, STREAM, self.col0 + x as i64, self.row0 + y as i64))
    }
}

/// Gives corners that are still unknown the mean of the known cells, displaced when there is displacement.
fn set_corners(heights: &mut [f32], grid: &Grid, settings: &Settings, noise: Noise) {
    let (rows, cols) = grid.size();
    let corners = [(0, 0), (0, cols - 1), (rows - 1, 0), (rows - 1, cols - 1)];
    if corners.iter().all(|(y, x)| !heights[y * cols + x].is_nan()) {
        return;
    }
    // Partial sums by row, combined in row order: the same bits on any number of threads.
    let partials: Vec<(f64, u64)> = heights
        .par_chunks(cols)
        .map(|row| {
            let known = row.iter().filter(|height| !height.is_nan());
            known.fold((0.0, 0), |(sum, n), &height| (sum + f64::from(height), n + 1))
        })
        .collect();
    let (sum, n) = partials.iter().fold((0.0, 0), |(sum, n), part| (sum + part.0, n + part.1));
    let mean = if n == 0 { settings.datum } else { sum / n as f64 };
    for (y, x) in corners {
        let height = &mut heights[y * cols + x];
        if height.is_nan() {
            // A single cell has nothing to be displaced against.
            let displaced = settings.shape.rs > 0.0 && rows * cols > 1;
            let shift =
                if displaced { noise.at(x, y) * settings.shape.rs * settings.relief / 2.0 } else { 0.0 };
            *height = settings.limit(mean + shift) as f32;
        }
    }
}

/// One level of the subdivision.
struct Level<'a> {
    /// Columns of coarser levels.
    lines: &'a [u32],
    /// The column halfway between neighbouring lines.
    mids: &'a [Option<u32>],
    /// Smaller half of this level's intervals along rows, and along columns.
    half: (u32, u32),
    factors: &'a [[f64; 3]; 3],
    falloff: &'a Falloff,
    noise: Noise,
    /// Displacement of edges per random number.
    amplitude: f64,
    /// Displacement of centres per random number.
    center_amplitude: f64,
    settings: &'a Settings,
    /// The quick way, where the level allows it.
    even: Option<EvenLevel<'a>>,
}

/// A row of this level's midpoints with the rows that it halves the space between.
struct Between<'a> {
    y: usize,
    row: &'a mut [f32],
    above: usize,
    /// Steps to the rows above and below.
    steps: (usize, usize),
}

impl Level<'_> {
    #[inline]
    fn put<const NOISY: bool>(&self, out: &mut f32, mean: f64, amplitude: f64, x: usize, y: usize) {
        let shift = if NOISY { (self.noise.at(x, y) + self.settings.shape.rt) * amplitude } else { 0.0 };
        let height = self.settings.limit(mean + shift) as f32;
        *out = if out.is_nan() { height } else { *out };
    }

    #[inline]
    fn step_x(&self, distance: u32) -> usize {
        1 + (distance - self.half.0) as usize
    }

    #[inline]
    fn weigh<const FLAT: bool>(&self, height: f32, factor: f64) -> f64 {
        if FLAT { f64::from(height) } else { self.falloff.apply(height, factor) }
    }

    /// Edges within a row of a coarser level; `above` and `below` hold the centres of this level beside it.
    fn edges<const FLAT: bool, const NOISY: bool>(
        &self,
        y: usize,
        row: &mut [f32],
        beside: [Option<(&[f32], usize)>; 2],
    ) {
        if let Some(even) = self.even {
            return even.edges::<FLAT, NOISY>(y, row);
        }
        for (ends, mid) in self.lines.windows(2).zip(self.mids) {
            let Some(mid) = *mid else { continue };
            let (a, b) = (ends[0] as usize, ends[1] as usize);
            let x = mid as usize;
            let factor = |distance: u32| self.factors[self.step_x(distance)][0];
            let mut sum = self.weigh::<FLAT>(row[a], factor(mid - ends[0]))
                + self.weigh::<FLAT>(row[b], factor(ends[1] - mid));
            let mut count = 2.0;
            for (centres, step) in beside.into_iter().flatten() {
                sum += self.weigh::<FLAT>(centres[x], self.factors[0][step]);
                count += 1.0;
            }
            self.put::<NOISY>(&mut row[x], sum / count, self.amplitude, x, y);
        }
    }

    /// Centres and, when `edges`, the edges of the same row between the rows `above` and `below`.
    fn between<const FLAT: bool, const NOISY: bool>(
        &self,
        at: &mut Between<'_>,
        above: &[f32],
        below: &[f32],
        squares: bool,
    ) {
        let (y, row, (up, down)) = (at.y, &mut *at.row, at.steps);
        if let Some(even) = self.even {
            return even.between::<FLAT, NOISY>(y, row, [above, below], (up, down));
        }
        // One length for all three lets the compiler check indices once.
        let (above, below) = (&above[..row.len()], &below[..row.len()]);
        for (k, &line) in self.lines.iter().enumerate() {
            let x = line as usize;
            if !squares {
                let sum = self.weigh::<FLAT>(above[x], self.factors[0][up])
                    + self.weigh::<FLAT>(below[x], self.factors[0][down]);
                self.put::<NOISY>(&mut row[x], sum / 2.0, self.amplitude, x, y);
            }
            let Some(mid) = self.mids.get(k).copied().flatten() else { continue };
            let right = self.lines[k + 1];
            let (b, m) = (right as usize, mid as usize);
            let (west, east) = (self.step_x(mid - line), self.step_x(right - mid));
            let sum = self.weigh::<FLAT>(above[x], self.factors[west][up])
                + self.weigh::<FLAT>(above[b], self.factors[east][up])
                + self.weigh::<FLAT>(below[x], self.factors[west][down])
                + self.weigh::<FLAT>(below[b], self.factors[east][down]);
            self.put::<NOISY>(&mut row[m], sum / 4.0, self.center_amplitude, m, y);
        }
        if squares {
            self.edges_between::<FLAT, NOISY>(at, above, below);
        }
    }

    /// Diamond-square edges of a row of midpoints, once its centres are known.
    fn edges_between<const FLAT: bool, const NOISY: bool>(
        &self,
        at: &mut Between<'_>,
        above: &[f32],
        below: &[f32],
    ) {
        let (row, (up, down)) = (&mut *at.row, at.steps);
        for (k, &line) in self.lines.iter().enumerate() {
            let x = line as usize;
            let mut sum = self.weigh::<FLAT>(above[x], self.factors[0][up])
                + self.weigh::<FLAT>(below[x], self.factors[0][down]);
            let mut count = 2.0;
            let before = k.checked_sub(1).and_then(|k| self.mids[k]);
            let after = self.mids.get(k).copied().flatten();
            for mid in before.into_iter().chain(after) {
                let factor = self.factors[self.step_x(mid.abs_diff(line))][0];
                sum += self.weigh::<FLAT>(row[mid as usize], factor);
                count += 1.0;
            }
            self.put::<NOISY>(&mut row[x], sum / count, self.amplitude, x, at.y);
        }
    }

    /// All cells of the level. `rows` tells rows of coarser levels from those of this one.
    fn run<const FLAT: bool, const NOISY: bool>(
        &self,
        heights: &mut [f32],
        cols: usize,
        (rows, level): (&Axis, usize),
        job: &Job<'_>,
    ) -> Result<()> {
        let squares = self.settings.scheme == Scheme::DiamondSquare;
        let mut lines: Vec<(usize, &mut [f32])> = Vec::new();
        let mut mids: Vec<Between<'_>> = Vec::new();
        for (y, row) in heights.chunks_mut(cols).enumerate() {
            let own = rows.level[y] as usize;
            if own < level {
                lines.push((y, row));
            } else if own == level {
                let step = |distance: u32| rows.step(level, distance);
                let steps = (step(y as u32 - rows.low[y]), step(rows.high[y] - y as u32));
                mids.push(Between { y, row, above: lines.len() - 1, steps });
            }
        }
        let few = (4096 / self.lines.len().max(1)).max(1);
        if !squares {
            lines.par_iter_mut().with_min_len(few).try_for_each(|(y, row)| {
                job.check()?;
                self.edges::<FLAT, NOISY>(*y, row, [None, None]);
                Ok(())
            })?;
        }
        let shared: Vec<&[f32]> = lines.iter().map(|(_, row)| &**row).collect();
        mids.par_iter_mut().with_min_len(few).try_for_each(|between| {
            job.check()?;
            let (above, below) = (shared[between.above], shared[between.above + 1]);
            self.between::<FLAT, NOISY>(between, above, below, squares);
            Ok(())
        })?;
        if squares {
            // Each coarser row sees the rows of centres right above and below it.
            let mut beside = vec![[None, None]; lines.len()];
            for between in &mids {
                let row = &*between.row;
                beside[between.above][1] = Some((row, between.steps.0));
                beside[between.above + 1][0] = Some((row, between.steps.1));
            }
            lines.par_iter_mut().zip(beside).with_min_len(few).try_for_each(|((y, row), beside)| {
                job.check()?;
                self.edges::<FLAT, NOISY>(*y, row, beside);
                Ok(())
            })?;
        }
        Ok(())
    }
}

/// Makes every cell known; known ones keep their bits.
///
/// # Errors
/// Cancellation.
pub(crate) fn top_down(
    field: &mut Heightfield,
    (cols, rows): (&Axis, &Axis),
    settings: &Settings,
    job: &Job<'_>,
) -> Result<()> {
    let grid = field.grid().clone();
    let n_cols = grid.cols;
    let noise = Noise { seed: settings.seed, row0: grid.row0, col0: grid.col0 };
    let heights = field.cells_mut();
    set_corners(heights, &grid, settings, noise);
    let falloff = Falloff::new(cols, rows, settings.shape.l, settings.datum);
    let mut lines = cols.ends();
    let depth = cols.depth.max(rows.depth);
    let arch = Arch::new();
    for level in 1..=depth {
        let mids = cols.midpoints(&lines);
        let (flat, noisy) = (falloff.is_flat(), settings.shape.rs != 0.0);
        let amplitude = settings.amplitude(level);
        let amplitudes = [amplitude, amplitude * settings.center_gain];
        let triangles = settings.scheme == Scheme::TriangleEdge;
        let stride = if triangles { even_stride(&lines, n_cols) } else { None };
        let even = stride.map(|stride| EvenLevel {
            stride,
            falloff: &falloff,
            factors: falloff.level(level),
            noise,
            rt: settings.shape.rt,
            amplitudes,
            limits: settings.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
            arch,
        });
        let this = Level {
            lines: &lines,
            mids: &mids,
            half: (cols.half[level], rows.half[level]),
            factors: falloff.level(level),
            falloff: &falloff,
            noise,
            amplitude,
            center_amplitude: amplitudes[1],
            settings,
            even,
        };
        let run = match (flat, noisy) {
            (true, true) => Level::run::<true, true>,
            (true, false) => Level::run::<true, false>,
            (false, true) => Level::run::<false, true>,
            (false, false) => Level::run::<false, false>,
        };
        run(&this, heights, n_cols, (rows, level), job)?;
        job.progress(level as f64 / depth as f64);
        lines = Axis::refine(&lines, &mids);
    }
    Ok(())
}
