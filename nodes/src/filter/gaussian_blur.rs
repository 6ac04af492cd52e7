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

/// Weights of the cells at distances 0, 1, … from the centre; no more of them than there are cells.
fn bell(sigma: f64, cells: usize) -> Vec<f64> {
    let reach = reach(sigma).min(cells.saturating_sub(1));
    (0..=reach)
        .map(|i| {
            let t = if i == 0 { 0.0 } else { i as f64 / sigma };
            libm::exp(-0.5 * t * t)
        })
        .collect()
}

/// Cells whose sums are kept in registers together.
const BLOCK: usize = 32;

/// `terrain` smoothed by a bell of `sigma` metres; linear in `sigma`.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::Cancelled`].
pub fn blur(terrain: &Heightfield, sigma: f64, job: &Job) -> Result<Heightfield> {
    let (grid, arch) = (terrain.grid(), Arch::new());
    let across = bell(sigma / grid.cell.x, grid.cols);
    let down = bell(sigma / grid.cell.y, grid.rows);
    let pass = |weigh: fn(f32) -> f32| {
        Heightfield::build(grid.clone(), job, |row, out| {
            let cells: Vec<f64> = terrain.row(row).iter().map(|&height| f64::from(weigh(height))).collect();
            arch.dispatch(Along { cells: &cells, bell: &across, out });
            Ok(())
        })
    };
    let heights = pass(|height| if height.is_nan() { 0.0 } else { height })?;
    let weights = match terrain.void_count() {
        0 => Weights::even(grid.size(), &across, &down, arch),
        _ => Weights::Each(pass(|height| f32::from(u8::from(!height.is_nan())))?),
    };
    Heightfield::build(grid.clone(), job, |row, out| {
        let sums = |field: &[f32], stride: usize| {
            let mut sums = vec![0.0; grid.cols];
            arch.dispatch(Down { field, stride, rows: grid.rows, bell: &down, row, sums: &mut sums });
            sums
        };
        let height = sums(heights.cells(), grid.cols);
        let weight = match &weights {
            Weights::Even { inner, .. } if row >= down.len() - 1 && row + down.len() <= grid.rows => inner,
            Weights::Even { across, .. } => &sums(across, 0),
            Weights::Each(weights) => &sums(weights.cells(), grid.cols),
        };
        for (((out, &here), height), weight) in out.iter_mut().zip(terrain.row(row)).zip(&height).zip(weight)
        {
            if !here.is_nan() {
                *out = (height / weight) as f32;
            }
        }
        Ok(())
    })
}

/// What the heights around each cell weigh together.
enum Weights {
    /// Without voids every row is alike.
    Even {
        /// The weights along a row.
        across: Vec<f32>,
        /// Those sums down the columns of a row whose neighbours are all there.
        inner: Vec<f64>,
    },
    /// The weights along each row.
    Each(Heightfield),
}

impl Weights {
    fn even((rows, cols): (usize, usize), across: &[f64], down: &[f64], arch: Arch) -> Self {
        let mut weights = vec![0.0; cols];
        arch.dispatch(Along { cells: &vec![1.0; cols], bell: across, out: &mut weights });
        let mut inner = vec![0.0; cols];
        // Any row that is far enough from the borders, in a raster that has one.
        let row = down.len() - 1;
        let rows = rows.max(2 * down.len());
        arch.dispatch(Down { field: &weights, stride: 0, rows, bell: down, row, sums: &mut inner });
        Self::Even { across: weights, inner }
    }
}

/// Weighted sums along a row, each in the order of its columns.
struct Along<'a> {
    cells: &'a [f64],
    bell: &'a [f64],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Along<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cells, bell, out } = self;
        let (n, reach) = (cells.len(), bell.len() - 1);
        for (block, out) in out.chunks_mut(BLOCK).enumerate() {
            let start = block * BLOCK;
            if start >= reach && start + BLOCK + reach <= n {
                let mut sums = [0.0_f64; BLOCK];
                for offset in 0..=2 * reach {
                    let weight = bell[offset.abs_diff(reach)];
                    let window = &cells[start + offset - reach..][..BLOCK];
                    for (sum, cell) in sums.iter_mut().zip(window) {
                        *sum += weight * cell;
                    }
                }
                for (out, sum) in out.iter_mut().zip(sums) {
                    *out = sum as f32;
                }
                continue;
            }
            for (i, out) in out.iter_mut().enumerate() {
                let col = start + i;
                let others = col.saturating_sub(reach)..(col + reach + 1).min(n);
                *out = others.fold(0.0, |sum, other| sum + bell[other.abs_diff(col)] * cells[other]) as f32;
            }
        }
    }
}

/// Weighted sums down the columns of a row, each in the order of its rows.
struct Down<'a> {
    field: &'a [f32],
    /// From one row to the next; 0 where all rows are the same one.
    stride: usize,
    rows: usize,
    bell: &'a [f64],
    row: usize,
    sums: &'a mut [f64],
}

impl NullaryFnOnce for Down<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { field, stride, rows, bell, row, sums } = self;
        let reach = bell.len() - 1;
        let others = row.saturating_sub(reach)..(row + reach + 1).min(rows);
        for (block, out) in sums.chunks_mut(BLOCK).enumerate() {
            let start = block * BLOCK;
            let mut sums = [0.0_f64; BLOCK];
            for other in others.clone() {
                let weight = bell[other.abs_diff(row)];
                let cells = &field[other * stride + start..][..out.len()];
                if cells.len() == BLOCK {
                    for (sum, &cell) in sums.iter_mut().zip(&cells[..BLOCK]) {
                        *sum += weight * f64::from(cell);
                    }
                } else {
                    for (sum, &cell) in sums.iter_mut().zip(cells) {
                        *sum += weight * f64::from(cell);
                    }
                }
            }
            out.copy_from_slice(&sums[..out.len()]);
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
