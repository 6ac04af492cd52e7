//! Where water goes over filled ground, how much of it and from how far.
//!
//! O'Callaghan, J. F. and Mark, D. M. (1984), "The extraction of drainage networks from digital elevation data",
//! Computer Vision, Graphics, and Image Processing 28 (3): each cell drains to the neighbour with the steepest
//! descent, the first of equals. On level ground water goes back the way the flood came, which is the way out.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::flood::{Flood, OUT, VOID, around, beside};
use crate::measure::distribution::line_slope;

/// Accumulations below this are hillslopes, not streams: too small for exponents.
pub const LEAST_STREAM: u32 = 100;

/// Water over a terrain.
#[derive(Debug)]
pub struct Flow {
    /// Cells that drain through each cell, itself included; 0 for voids.
    pub accumulation: Vec<u32>,
    /// Length in metres of the longest way that water takes to each cell.
    pub longest: Vec<f32>,
    /// Distance in metres to the cell that each one drains to; 0 where water leaves the terrain.
    run: Vec<f32>,
}

impl Flow {
    /// Follows the water of a flooded terrain.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(flood: &Flood, job: &Job) -> Result<Self> {
        let grid = flood.filled.grid();
        let size = grid.size();
        job.admit(grid.len() as u64 * 13, || format!("the flow over {} × {} cells", grid.rows, grid.cols))?;
        let CellSize { x, y } = grid.cell;
        let diagonal = (x * x + y * y).sqrt();
        let apart = [diagonal, y, diagonal, x, diagonal, y, diagonal, x];
        let heights = flood.filled.cells();
        let down = |cell: usize| {
            if flood.came_from[cell] == VOID {
                return VOID;
            }
            let (mut steepest, mut to, mut first) = (0.0, flood.came_from[cell], usize::MAX);
            for (direction, other) in around(size, cell) {
                let fall = (f64::from(heights[cell]) - f64::from(heights[other])) / apart[direction];
                // Beside a void nothing is greater or equal.
                if fall > steepest || (fall == steepest && fall > 0.0 && other < first) {
                    (steepest, to, first) = (fall, direction as u8, other);
                }
            }
            to
        };
        let mut towards = vec![VOID; grid.len()];
        towards.par_chunks_mut(1 << 14).enumerate().try_for_each(|(chunk, towards)| {
            job.check()?;
            towards.iter_mut().enumerate().for_each(|(i, to)| *to = down((chunk << 14) + i));
            Ok(())
        })?;

        let mut accumulation: Vec<u32> = towards.iter().map(|&to| u32::from(to != VOID)).collect();
        let mut longest = vec![0f32; grid.len()];
        let mut run = vec![0f32; grid.len()];
        // Every cell drains to one that the flood reached before it, so backwards all of its water is there.
        for (done, &cell) in flood.order.iter().rev().enumerate() {
            if done.is_multiple_of(1 << 16) {
                job.check()?;
            }
            let cell = cell as usize;
            let to = towards[cell];
            if to >= OUT {
                continue;
            }
            if let Some(other) = beside(size, cell, to.into()) {
                run[cell] = apart[usize::from(to)] as f32;
                accumulation[other] += accumulation[cell];
                longest[other] = longest[other].max(longest[cell] + run[cell]);
            }
        }
        Ok(Self { accumulation, longest, run })
    }

    /// Exponent of the share of cells that at least so much drains through: slope of the logarithms at 24
    /// accumulations from [`LEAST_STREAM`] to a hundredth of the known cells. About −0.43 in natural basins;
    /// NaN on too small a terrain.
    #[must_use]
    pub fn exceedance(&self) -> f64 {
        let known = self.accumulation.iter().filter(|&&cells| cells > 0).count() as f64;
        let mut streams: Vec<u32> =
            self.accumulation.iter().copied().filter(|&cells| cells >= LEAST_STREAM).collect();
        streams.sort_unstable();
        let (low, high) = (f64::from(LEAST_STREAM), known / 100.0);
        if high < 2.0 * low {
            return f64::NAN;
        }
        let points: Vec<_> = (0..24)
            .map(|i| low * libm::pow(high / low, f64::from(i) / 23.0))
            .map(|least| (least, streams.len() - streams.partition_point(|&cells| f64::from(cells) < least)))
            .filter(|(_, count)| *count > 0)
            .map(|(least, count)| (libm::log(least), libm::log(count as f64 / known)))
            .collect();
        line_slope(&points)
    }

    /// Metres of stream for each square metre of known ground, streams being cells that at least `least` cells
    /// drain through; NaN without known ground.
    #[must_use]
    pub fn density(&self, least: u32, cell: CellSize) -> f64 {
        let known = self.accumulation.iter().filter(|&&cells| cells > 0).count() as f64;
        let streams = self.accumulation.iter().zip(&self.run).filter(|(cells, _)| **cells >= least.max(1));
        streams.map(|(_, &run)| f64::from(run)).sum::<f64>() / (known * cell.x * cell.y)
    }

    /// Hack's exponent: slope of the logarithms of the longest way to a cell over the area that drains through
    /// it, over all cells of at least [`LEAST_STREAM`]. About 0.5 to 0.6 in nature; NaN without streams.
    #[must_use]
    pub fn hack(&self) -> f64 {
        let pairs = self.accumulation.iter().zip(&self.longest);
        let streams = pairs.filter(|(cells, long)| **cells >= LEAST_STREAM && **long > 0.0);
        let points: Vec<_> = streams
            .map(|(&cells, &long)| (libm::log(f64::from(cells)), libm::log(f64::from(long))))
            .collect();
        line_slope(&points)
    }

    /// Share, 0 to 1, of the length of lines that lies on cells of at least [`LEAST_STREAM`]; NaN without
    /// lines.
    #[must_use]
    pub fn share_on_streams(&self, lines: &Features) -> f64 {
        let (rows, cols) = lines.grid.size();
        let inside =
            |at: f64, n: usize| (at.round() >= 0.0 && at.round() < n as f64).then_some(at.round() as usize);
        let (mut all, mut on) = (0.0, 0.0);
        for pair in lines.lines.iter().flat_map(|line| line.vertices.windows(2)) {
            let ([r, c], [r1, c1]) = (pair[0], pair[1]);
            let long = ((r1 - r) * (r1 - r) + (c1 - c) * (c1 - c)).sqrt();
            // Lines are drawn from cell to cell; a longer stretch is looked at every half cell.
            let steps = (2.0 * long).ceil().clamp(1.0, 1e6);
            for step in 0..steps as usize {
                let t = (step as f64 + 0.5) / steps;
                let (Some(row), Some(col)) = (inside(r + t * (r1 - r), rows), inside(c + t * (c1 - c), cols))
                else {
                    continue;
                };
                let cells = self.accumulation.get(row * cols + col).copied().unwrap_or(0);
                all += long / steps;
                on += if cells >= LEAST_STREAM { long / steps } else { 0.0 };
            }
        }
        on / all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::drainage::flood::flood;
    use crate::test_fields::field;

    fn flow(terrain: &Heightfield) -> (Flood, Flow) {
        let flood = flood(terrain, &Job::detached()).unwrap();
        let flow = Flow::of(&flood, &Job::detached()).unwrap();
        (flood, flow)
    }

    #[test]
    fn a_tilted_plane_drains_along_its_columns() {
        let (_, flow) = flow(&field(300, 40, |row, _| -(row as f64)));
        for col in 1..39 {
            assert_eq!(flow.accumulation[299 * 40 + col], 300);
            assert_eq!(flow.accumulation[99 * 40 + col], 100);
            assert_eq!(flow.longest[299 * 40 + col], 2990.0);
        }
        // Longest way and area grow together.
        assert!((flow.hack() - 1.0).abs() < 0.01, "{}", flow.hack());
        // From the 200th row on every cell is a stream that runs for ten metres, but for the last.
        let expected = 100.0 / 300.0 / 10.0;
        assert!((flow.density(200, CellSize::square(10.0)) - expected).abs() < 0.02 * expected);
    }

    #[test]
    fn all_water_gets_out_and_none_is_lost() {
        let noise = |row: usize, col: usize| orograph_core::gaussian(2, 1, row as i64, col as i64);
        let terrain = field(90, 120, |row, col| (3.0 * noise(row, col)).round());
        let (flood, flow) = flow(&terrain);
        let out: u32 = (0..90 * 120).filter(|&i| flow.run[i] == 0.0).map(|i| flow.accumulation[i]).sum();
        assert_eq!(out, 90 * 120);
        assert!((0..90 * 120).filter(|&i| flow.run[i] == 0.0).all(|i| flood.came_from[i] == OUT));
    }

    #[test]
    fn a_valley_gathers_the_water_of_both_sides() {
        let terrain = field(60, 41, |row, col| 5.0 * (col as f64 - 20.0).abs() - row as f64 * 0.5);
        let (_, flow) = flow(&terrain);
        let streams = flow.accumulation.iter().filter(|&&cells| cells >= 400).count();
        assert!(streams > 0 && flow.accumulation[59 * 41 + 20] > 1500);
        let line = |col: f64| {
            let vertices = vec![[20.0, col], [58.0, col]];
            let profiles = Vec::new();
            Features {
                grid: terrain.grid().clone(),
                kind: FeatureKind::Valley,
                points: Vec::new(),
                lines: vec![orograph_core::Polyline { from: 0, to: 1, vertices, profiles }],
                rings: Vec::new(),
                scale: 1.0,
                profile_len: 0,
                profile_step: 1.0,
            }
        };
        assert_eq!(flow.share_on_streams(&line(20.0)), 1.0);
        assert_eq!(flow.share_on_streams(&line(12.0)), 0.0);
        assert!(flow.share_on_streams(&line(-50.0)).is_nan());
    }
}
