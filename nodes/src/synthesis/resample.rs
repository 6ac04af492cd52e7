//! Heights between cells by Catmull–Rom splines, without the border handling of whole-raster resampling.

use orograph_core::Heightfield;

use crate::transform::sample::catmull_rom;

/// The height at a fractional (row, column); a void outside, and where one of the four cells around is a void.
///
/// With a void or the border among the sixteen cells around but not among the four, the height is bilinear.
#[must_use]
pub fn cubic(terrain: &Heightfield, [row, col]: [f64; 2]) -> f32 {
    let (rows, cols) = terrain.grid().size();
    // Written so that NaN is outside.
    let inside = |at: f64, n: usize| at >= 0.0 && at <= n as f64 - 1.0;
    if rows < 2 || cols < 2 || !inside(row, rows) || !inside(col, cols) {
        return f32::NAN;
    }
    // The last cell's own centre is the end of the last stretch.
    let (r, c) = ((row as usize).min(rows - 2), (col as usize).min(cols - 2));
    let (down, across) = (row - r as f64, col - c as f64);
    if r >= 1 && c >= 1 && r + 2 < rows && c + 2 < cols {
        let (wr, wc) = (catmull_rom(down), catmull_rom(across));
        let mut sum = 0.0;
        for (i, wr) in wr.into_iter().enumerate() {
            let cells = &terrain.row(r + i - 1)[c - 1..c + 3];
            let along = wc[0] * f64::from(cells[0])
                + wc[1] * f64::from(cells[1])
                + wc[2] * f64::from(cells[2])
                + wc[3] * f64::from(cells[3]);
            sum += wr * along;
        }
        if !sum.is_nan() {
            return sum as f32;
        }
    }
    let at = |i: usize, j: usize| f64::from(terrain.at(r + i, c + j));
    let top = at(0, 0) + (at(0, 1) - at(0, 0)) * across;
    let bottom = at(1, 0) + (at(1, 1) - at(1, 0)) * across;
    (top + (bottom - top) * down) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn parabolas_are_met_inside_and_planes_up_to_the_border() {
        let parabola = field(9, 9, |row, col| (row * row) as f64 - 3.0 * (col * col) as f64);
        let plane = field(9, 9, |row, col| 2.0 * row as f64 + 5.0 * col as f64);
        for at in [[2.25, 3.75], [1.0, 1.0], [5.5, 6.99], [4.0, 3.5]] {
            let truth = at[0] * at[0] - 3.0 * at[1] * at[1];
            assert!((f64::from(cubic(&parabola, at)) - truth).abs() < 1e-4);
        }
        for at in [[0.0, 0.0], [0.5, 7.5], [8.0, 8.0], [3.3, 8.0], [7.25, 0.25]] {
            assert!((f64::from(cubic(&plane, at)) - 2.0 * at[0] - 5.0 * at[1]).abs() < 1e-5, "{at:?}");
        }
        assert!(cubic(&plane, [-0.01, 3.0]).is_nan() && cubic(&plane, [3.0, f64::NAN]).is_nan());
        assert!(cubic(&plane, [3.0, 8.01]).is_nan());
    }

    #[test]
    fn a_void_reaches_the_squares_that_it_is_a_corner_of() {
        let holed = field(9, 9, |row, col| if (row, col) == (4, 4) { f64::NAN } else { 7.0 });
        assert!(cubic(&holed, [3.5, 4.5]).is_nan() && cubic(&holed, [4.9, 3.1]).is_nan());
        assert_eq!(cubic(&holed, [2.9, 4.5]), 7.0);
        assert_eq!(cubic(&holed, [5.1, 3.5]), 7.0);
    }
}
