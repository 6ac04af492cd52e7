//! Distance: how far each cell lies from the nearest selected one, exactly.
//!
//! P. Felzenszwalb, D. Huttenlocher, "Distance Transforms of Sampled Functions" (2012): squared distances
//! along the columns, then, along each row, the lower envelope of one parabola per column. Linear in the
//! number of cells. Departure: true metres on both axes.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::ramp::smooth;

/// Which cells are measured.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Cells outside the mask, to the nearest cell inside.
    Outside,
    /// Cells inside the mask, to the nearest cell outside.
    Inside,
}

/// Measures the distance from each cell to the nearest cell of a mask.
///
/// Distances go from cell centre to cell centre. Where there is no cell to measure to, the distance is a void.
#[derive(Params, Clone, Debug)]
pub struct Distance {
    /// Cells whose mask is at least this belong to it.
    #[param(default = 0.5, range = 0.001..=1.0, unit = "1")]
    pub threshold: f64,
    /// Which cells are measured; the others have distance 0.
    #[param(default = Side::Outside)]
    pub side: Side,
    /// Distance at which the falloff reaches 0.
    #[param(default = 500, range = 0.001..=10_000_000.0, slider = 1.0..=5000.0, unit = "m")]
    pub reach: f64,
}

/// Inputs of [`Distance`].
#[derive(Inputs)]
pub struct DistanceIn<'a> {
    /// Mask to measure from.
    pub mask: &'a Mask,
}

/// Outputs of [`Distance`].
#[derive(Outputs)]
pub struct DistanceOut {
    /// Distance in metres.
    pub distance: Heightfield,
    /// 1 at distance 0, falling smoothly to 0 at the reach.
    pub falloff: Mask,
}

impl Node for Distance {
    const ID: &'static str = "mask.distance";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = DistanceIn<'a>;
    type Outputs = DistanceOut;

    fn run(&self, inputs: DistanceIn<'_>, job: &Job) -> Result<DistanceOut> {
        let threshold = self.threshold as f32;
        let outside = self.side == Side::Outside;
        let distance = distances(inputs.mask, |share| (share >= threshold) == outside, job)?;
        let falloff = distance.map(job, |distance| {
            // `max` takes a void, which is out of every reach, to 0.
            smooth((1.0 - f64::from(distance) / self.reach).max(0.0)) as f32
        })?;
        Ok(DistanceOut { distance, falloff })
    }

    fn cost(&self) -> f64 {
        20.0
    }
}

/// Distance in metres from each cell to the nearest one whose share `is_target`; a void where there is none.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::Cancelled`].
pub fn distances(mask: &Mask, is_target: impl Fn(f32) -> bool + Sync, job: &Job) -> Result<Heightfield> {
    let grid = mask.grid();
    let cell = grid.cell;
    let rows = rows_to_target(mask, is_target, job)?;
    Heightfield::build(grid.clone(), job, |row, out| {
        let rises: Vec<f64> = rows[row * grid.cols..][..grid.cols]
            .iter()
            .map(|&n| if n == NONE { f64::INFINITY } else { f64::from(n) * cell.y })
            .collect();
        envelope(&rises, cell.x, out);
        Ok(())
    })
}

/// No target in the column.
const NONE: u32 = u32::MAX;

/// Rows between each cell and the nearest target of its column.
fn rows_to_target(mask: &Mask, is_target: impl Fn(f32) -> bool + Sync, job: &Job) -> Result<Vec<u32>> {
    let (n_rows, n_cols) = mask.grid().size();
    job.admit((mask.grid().len() as u64).saturating_mul(4), || "distances along columns".into())?;
    let mut rows = vec![NONE; mask.grid().len()];
    if rows.is_empty() {
        return Ok(rows);
    }
    for row in 0..n_rows {
        job.check()?;
        let (above, here) = rows[..(row + 1) * n_cols].split_at_mut(row * n_cols);
        let above = if row > 0 { &above[(row - 1) * n_cols..] } else { &[] };
        here.par_iter_mut().with_min_len(8192).zip(mask.row(row)).enumerate().for_each(
            |(col, (n, &share))| {
                *n = if is_target(share) { 0 } else { above.get(col).map_or(NONE, |n| n.saturating_add(1)) };
            },
        );
    }
    for row in (0..n_rows - 1).rev() {
        job.check()?;
        let (here, below) = rows[row * n_cols..].split_at_mut(n_cols);
        here.par_iter_mut().with_min_len(8192).zip(below).for_each(|(n, below)| {
            *n = (*n).min(below.saturating_add(1));
        });
    }
    Ok(rows)
}

/// Roots of the lowest of the parabolas `rises[q]² + (x − q·step)²` at each column.
fn envelope(rises: &[f64], step: f64, out: &mut [f32]) {
    // Columns whose parabola is lowest somewhere, each with the x at which it begins to be.
    let mut lowest: Vec<(usize, f64)> = Vec::with_capacity(rises.len());
    for (q, &rise) in rises.iter().enumerate() {
        if rise.is_infinite() {
            continue;
        }
        let x = q as f64 * step;
        let mut from = f64::NEG_INFINITY;
        while let Some(&(p, start)) = lowest.last() {
            let (px, p_rise) = (p as f64 * step, rises[p]);
            from = ((rise * rise - p_rise * p_rise) / (x - px) + (x + px)) / 2.0;
            if from > start {
                break;
            }
            lowest.pop();
            from = f64::NEG_INFINITY;
        }
        lowest.push((q, from));
    }
    if lowest.is_empty() {
        return; // the row is blank, and blank heights are voids
    }
    let mut k = 0;
    for (col, out) in out.iter_mut().enumerate() {
        let x = col as f64 * step;
        while lowest.get(k + 1).is_some_and(|next| next.1 < x) {
            k += 1;
        }
        let (q, _) = lowest[k];
        let dx = x - q as f64 * step;
        *out = (dx * dx + rises[q] * rises[q]).sqrt() as f32;
    }
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, unit};

    use super::*;

    #[test]
    fn distances_are_those_of_brute_force() {
        for (seed, share) in [(1, 0.01), (2, 0.1), (3, 0.7)] {
            let (n_rows, n_cols) = (37, 53);
            let grid = Grid::new(n_rows, n_cols, CellSize { x: 3.1, y: 7.7 }).unwrap();
            let cells: Vec<f32> = (0..grid.len() as i64)
                .map(|i| f32::from(u8::from(unit(key(seed, 0, i, 0)) < share)))
                .collect();
            let mask = Mask::new(grid.clone(), cells).unwrap();
            let node = Distance { reach: 20.0, ..Distance::default() };
            let out = node.run(DistanceIn { mask: &mask }, &Job::detached()).unwrap();
            for row in 0..n_rows {
                for col in 0..n_cols {
                    let mut nearest = f64::INFINITY;
                    for i in 0..grid.len() {
                        if mask.cells()[i] > 0.5 {
                            let dy = (row as f64 - (i / n_cols) as f64) * 7.7;
                            let dx = (col as f64 - (i % n_cols) as f64) * 3.1;
                            nearest = nearest.min((dx * dx + dy * dy).sqrt());
                        }
                    }
                    assert!((f64::from(out.distance.at(row, col)) - nearest).abs() < 1e-4);
                    let falloff = smooth((1.0 - nearest / 20.0).max(0.0));
                    assert!((f64::from(out.falloff.at(row, col)) - falloff).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn an_empty_mask_is_out_of_reach_and_has_a_full_inside() {
        let grid = Grid::new(3, 4, CellSize::square(1.0)).unwrap();
        let mask = Mask::new(grid, vec![0.0; 12]).unwrap();
        let run = |side| {
            let node = Distance { side, ..Distance::default() };
            node.run(DistanceIn { mask: &mask }, &Job::detached()).unwrap()
        };
        let outside = run(Side::Outside);
        assert_eq!(outside.distance.void_count(), 12);
        assert_eq!(outside.falloff.cells(), [0.0; 12]);
        assert_eq!(run(Side::Inside).distance.cells(), [0.0; 12]);
    }
}
