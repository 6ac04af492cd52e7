//! Gaussian blur: a mean weighted by distance, separable, with voids left out.
//!
//! Normalised convolution (H. Knutsson, C.-F. Westin, 1993): weighted heights and weights are summed along
//! rows and then along columns, and one is divided by the other. A void and what lies beyond the border weigh
//! nothing. The bell is cut at four standard deviations, where it has fallen to a 3000th.

use orograph_core::prelude::*;
use pulp::{Arch, NullaryFnOnce};

/// Smooths terrain by a bell-shaped mean. Voids stay voids and weigh nothing in their neighbours' means.
#[derive(Params, Clone, Debug)]
pub struct GaussianBlur {
    /// Standard deviation of the bell on the ground: forms much smaller than this vanish.
    #[param(default = 100, range = 0.0..=100_000.0, slider = 0.0..=2000.0, unit = "m")]
    pub sigma: f64,
}

/// Inputs of [`GaussianBlur`].
#[derive(Inputs)]
pub struct GaussianBlurIn<'a> {
    /// Terrain to smooth.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`GaussianBlur`].
#[derive(Outputs)]
pub struct GaussianBlurOut {
    /// Smooth terrain.
    pub terrain: Heightfield,
}

impl Node for GaussianBlur {
    const ID: &'static str = "filter.gaussian_blur";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = GaussianBlurIn<'a>;
    type Outputs = GaussianBlurOut;

    fn run(&self, inputs: GaussianBlurIn<'_>, job: &Job) -> Result<GaussianBlurOut> {
        Ok(GaussianBlurOut { terrain: blur(inputs.terrain, self.sigma, job)? })
    }

    fn halo(&self, cell: CellSize) -> usize {
        reach(self.sigma / cell.x).max(reach(self.sigma / cell.y))
    }

    fn cost(&self) -> f64 {
        30.0
    }
}

/// Cells to each side that a bell of `sigma` cells looks at.
fn reach(sigma: f64) -> usize {
    (4.0 * sigma).ceil() as usize
}

/// Cells of a row whose sums are kept in registers together.
const BLOCK: usize = 32;
/// Rows whose sums are kept in registers together, and their columns.
const ROWS: usize = 4;
const COLS: usize = 16;

/// `terrain` smoothed by a bell of `sigma` metres; linear in `sigma`.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::Cancelled`].
pub fn blur(terrain: &Heightfield, sigma: f64, job: &Job) -> Result<Heightfield> {
    let (grid, arch) = (terrain.grid(), Arch::new());
    let across = Bell::new(sigma / grid.cell.x, grid.cols);
    let down = Bell::new(sigma / grid.cell.y, grid.rows);
    let pass = |weigh: Weigh| {
        Heightfield::build_lots(grid.clone(), ROWS, job, |first, out| {
            let mut cells = across.beside_nothing(grid.cols);
            for (row, out) in out.chunks_mut(grid.cols).enumerate() {
                // A wide bell takes its time for each.
                job.check()?;
                let heights = terrain.row(first + row);
                arch.dispatch(Weighed { heights, weigh, cells: &mut cells[across.reach..] });
                arch.dispatch(Along { cells: &cells, bell: across.whole(), out });
            }
            Ok(())
        })
    };
    let heights = pass(Weigh::Height)?;
    let weights = match terrain.void_count() {
        0 => Weights::even(grid.size(), &across, &down, arch),
        _ => Weights::Each(pass(Weigh::Presence)?),
    };
    Heightfield::build_lots(grid.clone(), ROWS, job, |first, out| {
        let n = out.len() / grid.cols;
        let sums = |field: &[f32], stride: usize| {
            let mut sums = vec![0.0; out.len()];
            let (rows, cols) = grid.size();
            arch.dispatch(Down { field, stride, rows, bell: &down, first, cols, sums: &mut sums });
            sums
        };
        let height = sums(heights.cells(), grid.cols);
        let weight = match &weights {
            Weights::Even { inner, .. } if first >= down.reach && first + n + down.reach <= grid.rows => {
                inner
            }
            Weights::Even { across, .. } => &sums(across, 0),
            Weights::Each(weights) => &sums(weights.cells(), grid.cols),
        };
        let here = &terrain.cells()[first * grid.cols..];
        arch.dispatch(Means { here, sums: &height, weights: weight, out });
        Ok(())
    })
}

/// Weights of the cells around one, of those at all distances from `-reach` to `reach`.
struct Bell {
    reach: usize,
    /// Among zeros, [`ROWS`] on either side.
    weights: Vec<f64>,
}

impl Bell {
    /// A bell of `sigma` cells; no wider than there are cells.
    fn new(sigma: f64, cells: usize) -> Self {
        let reach = reach(sigma).min(cells.saturating_sub(1));
        let mut weights = vec![0.0; 2 * (reach + ROWS) + 1];
        for (i, weight) in weights[ROWS..=2 * reach + ROWS].iter_mut().enumerate() {
            let away = i.abs_diff(reach);
            let t = if away == 0 { 0.0 } else { away as f64 / sigma };
            *weight = libm::exp(-0.5 * t * t);
        }
        Self { reach, weights }
    }

    fn whole(&self) -> &[f64] {
        &self.weights[ROWS..=2 * self.reach + ROWS]
    }

    /// Room for a row of `n` cells from `reach` on, among as many zeros as its [`Along`] asks for.
    fn beside_nothing(&self, n: usize) -> Vec<f64> {
        vec![0.0; n.next_multiple_of(BLOCK) + 2 * self.reach]
    }
}

/// What the heights around each cell weigh together.
enum Weights {
    /// Without voids every row is alike.
    Even {
        /// The weights along a row.
        across: Vec<f32>,
        /// Those sums down the columns of rows whose neighbours are all there, as many as are made together.
        inner: Vec<f64>,
    },
    /// The weights along each row.
    Each(Heightfield),
}

impl Weights {
    fn even((rows, cols): (usize, usize), across: &Bell, down: &Bell, arch: Arch) -> Self {
        let mut weights = vec![0.0; cols];
        let mut ones = across.beside_nothing(cols);
        ones[across.reach..][..cols].fill(1.0);
        arch.dispatch(Along { cells: &ones, bell: across.whole(), out: &mut weights });
        let mut inner = vec![0.0; ROWS * cols];
        // Any rows that are far enough from the borders, in a raster that has them.
        let rows = rows.max(2 * down.reach + ROWS);
        arch.dispatch(Down {
            field: &weights,
            stride: 0,
            rows,
            bell: down,
            first: down.reach,
            cols,
            sums: &mut inner,
        });
        Self::Even { across: weights, inner }
    }
}

/// What of a cell is summed.
#[derive(Clone, Copy)]
enum Weigh {
    /// Its height; 0 for a void.
    Height,
    /// 1; 0 for a void.
    Presence,
}

/// A row on its way to being summed.
struct Weighed<'a> {
    heights: &'a [f32],
    weigh: Weigh,
    cells: &'a mut [f64],
}

impl NullaryFnOnce for Weighed<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let pairs = self.cells.iter_mut().zip(self.heights);
        match self.weigh {
            Weigh::Height => pairs.for_each(|(cell, height)| {
                *cell = if height.is_nan() { 0.0 } else { f64::from(*height) };
            }),
            Weigh::Presence => pairs.for_each(|(cell, height)| {
                *cell = if height.is_nan() { 0.0 } else { 1.0 };
            }),
        }
    }
}

/// Sums over weights where there is a height.
struct Means<'a> {
    here: &'a [f32],
    sums: &'a [f64],
    weights: &'a [f64],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Means<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let n = self.out.len();
        let (here, sums, weights) = (&self.here[..n], &self.sums[..n], &self.weights[..n]);
        for (i, out) in self.out.iter_mut().enumerate() {
            *out = if here[i].is_nan() { f32::NAN } else { (sums[i] / weights[i]) as f32 };
        }
    }
}

/// Weighted sums along a row, each in the order of its columns.
struct Along<'a> {
    /// The row among zeros, which add nothing.
    cells: &'a [f64],
    bell: &'a [f64],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Along<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cells, bell, out } = self;
        for (block, out) in out.chunks_mut(BLOCK).enumerate() {
            let mut sums = [0.0_f64; BLOCK];
            for (window, weight) in cells[block * BLOCK..].windows(BLOCK).zip(bell) {
                for (sum, cell) in sums.iter_mut().zip(window) {
                    *sum += weight * cell;
                }
            }
            let sums = sums.map(|sum| sum as f32);
            out.copy_from_slice(&sums[..out.len()]);
        }
    }
}

/// Weighted sums down the columns of at most [`ROWS`] rows, each in the order of its rows.
struct Down<'a> {
    field: &'a [f32],
    /// From one row to the next; 0 where all rows are the same one.
    stride: usize,
    rows: usize,
    bell: &'a Bell,
    first: usize,
    cols: usize,
    sums: &'a mut [f64],
}

impl Down<'_> {
    /// The sums of `n` columns from `start` on, at most [`COLS`].
    #[inline(always)]
    fn block(&self, start: usize, n: usize) -> [[f64; COLS]; ROWS] {
        let reach = self.bell.reach;
        let mut sums = [[0.0_f64; COLS]; ROWS];
        for other in self.first.saturating_sub(reach)..(self.first + ROWS + reach).min(self.rows) {
            let cells = &self.field[other * self.stride + start..][..n];
            // The bell of each row lies one further; beyond a bell are zeros, which add nothing.
            let weights = &self.bell.weights[other + reach + 1 - self.first..][..ROWS];
            for (sums, weight) in sums.iter_mut().zip(weights.iter().rev()) {
                for (sum, &cell) in sums.iter_mut().zip(cells) {
                    *sum += weight * f64::from(cell);
                }
            }
        }
        sums
    }
}

impl NullaryFnOnce for Down<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for start in (0..self.cols).step_by(COLS) {
            let n = COLS.min(self.cols - start);
            // A number that is known beforehand is what keeps the sums in registers.
            let made = if n == COLS { self.block(start, COLS) } else { self.block(start, n) };
            for (sums, made) in self.sums.chunks_mut(self.cols).zip(made) {
                sums[start..start + n].copy_from_slice(&made[..n]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn sums_are_those_of_the_two_dimensional_bell() {
        let void = |row: usize, col: usize| (row * 7 + col * 3).is_multiple_of(11);
        let height = |row: usize, col: usize| ((row * 31 + col * 17) % 23) as f64 * 10.0;
        let mut grid = field(19, 23, |_, _| 0.0).grid().clone();
        grid.cell = CellSize { x: 10.0, y: 16.0 };
        let terrain = field(19, 23, |row, col| if void(row, col) { f64::NAN } else { height(row, col) });
        let terrain = terrain.with_grid(grid).unwrap();
        let out = blur(&terrain, 20.0, &Job::detached()).unwrap();
        for row in 0..19_usize {
            for col in 0..23_usize {
                let (mut sum, mut weights) = (0.0, 0.0);
                for r in 0..19_usize {
                    for c in 0..23_usize {
                        let (dx, dy) = (c.abs_diff(col) as f64 * 10.0, r.abs_diff(row) as f64 * 16.0);
                        if !void(r, c) && dx <= 80.0 && dy <= 80.0 {
                            let weight = libm::exp(-(dx * dx + dy * dy) / 800.0);
                            sum += weight * height(r, c);
                            weights += weight;
                        }
                    }
                }
                let here = f64::from(out.at(row, col));
                assert_eq!(here.is_nan(), void(row, col));
                assert!(here.is_nan() || (here - sum / weights).abs() < 1e-3, "{row} {col}");
            }
        }
    }

    #[test]
    fn a_plane_stays_a_plane_away_from_the_border() {
        let plane = field(60, 60, |row, col| 2.0 * row as f64 - 3.0 * col as f64);
        let out = blur(&plane, 50.0, &Job::detached()).unwrap();
        for i in 20..40 {
            assert!((out.at(i, 25) - plane.at(i, 25)).abs() < 1e-3);
        }
    }

    #[test]
    fn no_width_changes_nothing_and_any_width_is_taken() {
        let terrain = field(3, 4, |row, col| (row * col) as f64);
        assert_eq!(blur(&terrain, 0.0, &Job::detached()).unwrap().cells(), terrain.cells());
        let mean = blur(&terrain, 1e5, &Job::detached()).unwrap().at(0, 0);
        assert!((mean - 1.5).abs() < 1e-3, "{mean}");
    }
}
