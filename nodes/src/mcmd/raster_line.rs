//! Straight 8-connected lines of cells.

/// A cell that need not lie on the grid: (row, column).
pub(crate) type Place = (i64, i64);

/// Places further out than this count as this far.
const FAR: i64 = 1 << 50;

/// Calls `visit` with row, column and share of the way for each cell of the line from `a` to `b` that lies on a grid of
/// `rows` × `cols`. Takes time for the part on the grid alone, however far the ends are.
pub(crate) fn line(
    a: Place,
    b: Place,
    (rows, cols): (usize, usize),
    mut visit: impl FnMut(usize, usize, f64),
) {
    // Far beyond any grid, yet near enough that differences stay exact.
    let near = |place: Place| (place.0.clamp(-FAR, FAR), place.1.clamp(-FAR, FAR));
    let (a, b) = (near(a), near(b));
    let (down, along) = (b.0 - a.0, b.1 - a.1);
    let steps = down.abs().max(along.abs());
    // The longer side advances by one cell a step, so the steps on the grid are an interval.
    let (start, sign, n) = if down.abs() >= along.abs() {
        (a.0, down.signum(), rows as i64)
    } else {
        (a.1, along.signum(), cols as i64)
    };
    let (first, last) = match sign {
        0 => (0, 0),
        1 => (-start, n - 1 - start),
        _ => (start - (n - 1), start),
    };
    for step in first.max(0)..=last.min(steps) {
        let share = if steps == 0 { 0.0 } else { step as f64 / steps as f64 };
        let row = a.0 + (down as f64 * share).round() as i64;
        let col = a.1 + (along as f64 * share).round() as i64;
        if (0..rows as i64).contains(&row) && (0..cols as i64).contains(&col) {
            visit(row as usize, col as usize, share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(a: Place, b: Place) -> Vec<(usize, usize)> {
        let mut cells = Vec::new();
        line(a, b, (10, 20), |row, col, _| cells.push((row, col)));
        cells
    }

    #[test]
    fn lines_are_8_connected_and_reach_both_ends() {
        for b in [(0, 0), (9, 19), (9, 0), (0, 19), (3, 4), (5, 6)] {
            let line = cells((4, 5), b);
            assert_eq!(line[0], (4, 5));
            assert_eq!(line[line.len() - 1], (b.0 as usize, b.1 as usize));
            for pair in line.windows(2) {
                assert_eq!(pair[0].0.abs_diff(pair[1].0).max(pair[0].1.abs_diff(pair[1].1)), 1);
            }
        }
    }

    #[test]
    fn far_ends_cost_nothing_and_points_are_cells() {
        assert_eq!(cells((5, -1_000_000_000_000), (5, 1_000_000_000_000)).len(), 20);
        assert_eq!(cells((5, 1_000_000_000_000), (5, -1_000_000_000_000)).len(), 20);
        assert_eq!(cells((-9, 3), (-2, 3)), []);
        assert_eq!(cells((2, 3), (2, 3)), [(2, 3)]);
        assert!(cells((i64::MIN, i64::MAX), (i64::MAX, i64::MIN)).len() < 20);
    }
}
