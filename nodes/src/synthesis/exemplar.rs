//! An exemplar made ready: square cells, and the numbers that costs are measured in.

use orograph_core::prelude::*;
use orograph_core::{key, unit};

use super::patches::VoidSums;

/// Draws of the cells at which typical steps are taken.
const STREAM: u64 = 0x7374_6570;
const N_SAMPLES: usize = 20_001;

/// A terrain to take from.
#[derive(Clone, Debug)]
pub struct Exemplar {
    /// Its heights on square cells.
    pub terrain: Heightfield,
    /// Where voids are.
    pub voids: VoidSums,
    /// Highest less lowest.
    pub range: f64,
    /// Twice the median step between neighbouring cells, in metres: the mismatch of a cut edge that nobody sees.
    pub step: f64,
    /// How much larger its rows and columns are than those of the terrain given.
    pub scale: [f64; 2],
}

impl Exemplar {
    /// Prepares `terrain`. Cells that are not square are made so, at the finer of their sides, with a remark.
    ///
    /// # Errors
    /// [`Error::EmptyInput`], [`Error::AllVoid`], [`Error::NonFinite`], [`Error::TooLarge`], or cancellation.
    pub fn new(terrain: &Heightfield, job: &Job<'_>) -> Result<Self> {
        let (low, high) = terrain.known_range("the exemplar")?;
        if low.is_infinite() || high.is_infinite() {
            let at = terrain.cells().iter().position(|height| height.is_infinite()).unwrap_or(0);
            let cols = terrain.cols();
            return Err(Error::NonFinite { what: "the exemplar".into(), row: at / cols, col: at % cols });
        }
        let squared = square(terrain, job)?;
        let scale =
            [squared.rows() as f64 / terrain.rows() as f64, squared.cols() as f64 / terrain.cols() as f64];
        let range = f64::from(high) - f64::from(low);
        let step = 2.0 * median_step(&squared);
        Ok(Self { voids: VoidSums::new(&squared), range, step, scale, terrain: squared })
    }
}

/// The same ground in square cells with the finer side; a copy of what is square already, to a thousandth.
fn square(terrain: &Heightfield, job: &Job<'_>) -> Result<Heightfield> {
    let grid = terrain.grid();
    let side = grid.cell.x.min(grid.cell.y);
    let (rows, cols) = (grid.rows as f64 * grid.cell.y / side, grid.cols as f64 * grid.cell.x / side);
    let (rows, cols) = (rows.round() as usize, cols.round() as usize);
    let is_square = (grid.cell.x / grid.cell.y - 1.0).abs() < 1e-3;
    if is_square || (rows, cols) == grid.size() {
        return terrain.map(job, |height| height);
    }
    job.warn(format!(
        "the exemplar's cells of {:.1} × {:.1} m are resampled to squares of {side:.1} m",
        grid.cell.x, grid.cell.y
    ));
    crate::transform::resize::resize(terrain, rows, cols, crate::transform::resize::Method::Cubic, job)
}

/// Median of the steps to the right and down at cells drawn at random; 0 where none is known.
fn median_step(terrain: &Heightfield) -> f64 {
    let (rows, cols) = terrain.grid().size();
    let mut steps = Vec::with_capacity(2 * N_SAMPLES);
    for i in 0..N_SAMPLES {
        let draw = |axis: i64, n: usize| (unit(key(0, STREAM, i as i64, axis)) * n as f64) as usize;
        let (row, col) = (draw(0, rows), draw(1, cols));
        let height = terrain.at(row, col);
        if col + 1 < cols {
            steps.push(f64::from((terrain.at(row, col + 1) - height).abs()));
        }
        if row + 1 < rows {
            steps.push(f64::from((terrain.at(row + 1, col) - height).abs()));
        }
    }
    steps.retain(|step| !step.is_nan());
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}
