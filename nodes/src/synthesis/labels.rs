//! Which style goes where, by a map of labels.
//!
//! Zhou 2007 §6 lets the user assign a style to each region. A window takes the style of most of what it is to fill, so
//! borders that are drawn with a ruler show; the map may be warped by noise before it is read.

use orograph_core::prelude::*;

use super::canvas::{Canvas, Window};
use crate::generate::noise::{Noise, gains};

/// Octaves of the noise that moves borders, and the share of each in the one before.
const OCTAVES: u32 = 3;
const GAIN: f64 = 0.5;

/// `labels` with borders that waver by up to `reach` cells in waves of `wave` cells, on a grid of its size. The noise lies
/// still in the world, so that a part of the map wavers as the whole does.
///
/// # Errors
/// [`Error::TooLarge`], or cancellation.
pub(super) fn waver(
    labels: &Heightfield,
    grid: &Grid,
    reach: f64,
    wave: f64,
    seed: u64,
    job: &Job<'_>,
) -> Result<Heightfield> {
    let (rows, cols) = grid.size();
    let side = grid.cell.x.min(grid.cell.y);
    let noises = [0, 1].map(|axis| Noise::new(seed.wrapping_add(axis), wave * side, 2.0, OCTAVES));
    let gains = gains(GAIN, OCTAVES);
    Heightfield::build(labels.grid().clone(), job, |row, out| {
        let x: Vec<f64> = (0..cols).map(|col| grid.position(row, col).x).collect();
        let y = grid.position(row, 0).y;
        let moves = noises.each_ref().map(|noise| {
            let (mut sum, mut layer) = (vec![0.0_f32; cols], vec![0.0_f32; cols]);
            for (k, gain) in gains.iter().enumerate() {
                noise.row(k, &x, y, &mut layer);
                sum.iter_mut().zip(&layer).for_each(|(sum, layer)| *sum += gain * layer);
            }
            sum
        });
        let there = |at: usize, by: f32, n: usize| {
            (at as f64 + f64::from(by) * reach).round().clamp(0.0, n as f64 - 1.0) as usize
        };
        for (col, out) in out.iter_mut().enumerate() {
            *out = labels.at(there(row, moves[0][col], rows), there(col, moves[1][col], cols));
        }
        job.check()
    })
}

/// The style of most of a window's unknown cells; of equals the least.
pub(super) fn main_style(canvas: &Canvas, window: &Window, labels: &Heightfield, n: usize) -> usize {
    let mut counts = vec![0_usize; n];
    for i in 0..window.len() {
        let at = canvas.index(window, i);
        let number = labels.cells()[at];
        if canvas.heights[at].is_nan() && number >= 0.0 {
            counts[label(number, n)] += 1;
        }
    }
    let most = counts.iter().copied().max().unwrap_or(0);
    counts.iter().position(|&count| count == most).unwrap_or(0)
}

/// The style that a cell of the label map names; the last for numbers beyond, the first for none.
pub(super) fn label(number: f32, n: usize) -> usize {
    ((number + 0.5).max(0.0) as usize).min(n - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn borders_waver_no_further_than_told_and_labels_stay_whole() {
        let labels = field(120, 160, |_, col| if col < 80 { 1.0 } else { 3.0 });
        let of = |reach: f64, seed: u64| {
            waver(&labels, labels.grid(), reach, 40.0, seed, &Job::detached()).unwrap()
        };
        assert_eq!(of(0.0, 5).cells(), labels.cells());
        let out = of(20.0, 5);
        assert!(out.cells().iter().all(|&label| label == 1.0 || label == 3.0));
        let border =
            |out: &Heightfield, row: usize| out.row(row).iter().filter(|&&label| label == 1.0).count();
        let borders: Vec<usize> = (0..120).map(|row| border(&out, row)).collect();
        assert!(borders.iter().all(|at| at.abs_diff(80) <= 20));
        let (least, most) = (borders.iter().min().unwrap(), borders.iter().max().unwrap());
        assert!(most - least > 5, "{borders:?}");
        assert_ne!(out.cells(), of(20.0, 6).cells());
    }
}
