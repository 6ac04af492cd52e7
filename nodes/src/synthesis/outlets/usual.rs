//! What an exemplar's closed depressions are like, as real ones are the measure of others.

use orograph_core::prelude::*;

use crate::measure::drainage::{flood::flood, pits::each_depression};

/// Side of the windows, and most of them along a side, in which an exemplar's depressions are looked at.
const WINDOW: usize = 256;
const WINDOWS: usize = 3;
/// The share of an exemplar's depressions that are shallower than what is usual.
const USUAL: f64 = 0.97;

/// The depth in metres that few of a terrain's closed depressions exceed; 0 without any.
///
/// # Errors
/// Refusal of the memory, and cancellation.
pub(crate) fn usual_depth(terrain: &Heightfield, job: &Job<'_>) -> Result<f64> {
    let starts = |n: usize| {
        let count = n.div_ceil(WINDOW).clamp(1, WINDOWS);
        let last = n.saturating_sub(WINDOW);
        (0..count).map(move |i| (last * i).checked_div(count - 1).unwrap_or(last / 2))
    };
    let mut depths = Vec::new();
    for top in starts(terrain.rows()) {
        for left in starts(terrain.cols()) {
            let (rows, cols) = (WINDOW.min(terrain.rows()), WINDOW.min(terrain.cols()));
            let window = terrain.crop(top, left, rows, cols, job)?;
            let quiet = Job::detached();
            let filled = flood(&window, &quiet)?.filled;
            each_depression(&window, &filled, &quiet, |found| depths.push(found.depth))?;
        }
    }
    depths.sort_by(f64::total_cmp);
    Ok(depths.get((USUAL * depths.len() as f64) as usize).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn usual_depth_passes_over_the_few_that_are_deepest() {
        // 400 pits of a cell, 3 m deep, and three of 50 m; where ground falls everywhere there is none.
        let pitted = |row: usize, col: usize| {
            let pit = row % 12 == 6 && col % 12 == 6;
            let deep = pit && row == 6 && col < 36;
            1000.0
                - row as f64
                - if deep {
                    50.0
                } else if pit {
                    4.0
                } else {
                    0.0
                }
        };
        let depth = |terrain: &Heightfield| usual_depth(terrain, &Job::detached()).unwrap();
        assert_eq!(depth(&field(240, 240, pitted)), 3.0);
        assert_eq!(depth(&field(900, 300, |row, _| row as f64)), 0.0);
        assert_eq!(depth(&field(3, 3, |_, _| f64::NAN)), 0.0);
    }
}
