//! Closed depressions that a patch would make together with the ground around it.

use orograph_core::prelude::*;

use crate::measure::drainage::flood::flood;

/// The share of a window's cells that lie more than `limit` metres below the level at which water would leave their
/// depression. Water leaves over the window's border and into what is not known yet.
///
/// # Errors
/// Refusal of the memory.
pub(super) fn ponded(heights: Vec<f32>, cols: usize, limit: f64) -> Result<f64> {
    let n = heights.len();
    if n == 0 || cols == 0 {
        return Ok(0.0);
    }
    let window = Heightfield::new(Grid::new(n / cols, cols, CellSize::square(1.0))?, heights)?;
    // A window is flooded within a millisecond: its progress is not to show, and whoever calls it looks for cancellation.
    let filled = flood(&window, &Job::detached())?.filled;
    let deep = |(filled, ground): (&f32, &f32)| f64::from(filled - ground) > limit;
    Ok(filled.cells().iter().zip(window.cells()).filter(|&pair| deep(pair)).count() as f64 / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_below_their_spill_level_count_and_what_drains_does_not() {
        // A slope with a pit of 3 × 3 cells, 10 m below a spill level that lies on the slope's lower side.
        let slope = |row: usize, col: usize| 2.0 * col as f32 + row as f32 * 1e-3;
        let pit = |row: usize, col: usize| (8..11).contains(&row) && (8..11).contains(&col);
        let ground = |deep: f32| -> Vec<f32> {
            let cell = |i: usize| {
                let (row, col) = (i / 20, i % 20);
                if pit(row, col) { 14.0 - deep } else { slope(row, col) }
            };
            (0..400).map(cell).collect()
        };
        assert_eq!(ponded(ground(10.0), 20, 5.0).unwrap(), 9.0 / 400.0);
        assert_eq!(ponded(ground(3.0), 20, 5.0).unwrap(), 0.0);
        assert_eq!(ponded((0..400).map(|i| slope(i / 20, i % 20)).collect(), 20, 0.0).unwrap(), 0.0);
        // What is not known may be an outlet.
        let mut opened = ground(10.0);
        opened[9 * 20 + 9] = f32::NAN;
        assert_eq!(ponded(opened, 20, 5.0).unwrap(), 0.0);
        assert_eq!(ponded(Vec::new(), 0, 5.0).unwrap(), 0.0);
    }
}
