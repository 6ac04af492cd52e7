//! Nearest of many places.

use super::chains::distance;

/// Side of a bucket in cells.
const SIDE: f64 = 16.0;
/// Fewer places than this are looked through one by one.
const FEW: usize = 64;

/// Places sorted into square buckets.
#[derive(Clone, Debug)]
pub(crate) struct Nearest {
    all: Vec<[f64; 2]>,
    rows: usize,
    cols: usize,
    buckets: Vec<Vec<[f64; 2]>>,
}

impl Nearest {
    /// Places on a grid of `rows` × `cols` cells; those beside it count for its border.
    pub(crate) fn new(places: Vec<[f64; 2]>, rows: usize, cols: usize) -> Self {
        let along = |n: usize| (n as f64 / SIDE) as usize + 1;
        let (rows, cols) = (along(rows), along(cols));
        let mut nearest = Self { all: Vec::new(), rows, cols, buckets: vec![Vec::new(); rows * cols] };
        for &place in &places {
            let (row, col) = nearest.bucket(place);
            nearest.buckets[row * cols + col].push(place);
        }
        nearest.all = places;
        nearest
    }

    fn bucket(&self, [row, col]: [f64; 2]) -> (usize, usize) {
        // The conversion holds negative numbers at zero.
        let along = |at: f64, n: usize| ((at / SIDE) as usize).min(n - 1);
        (along(row, self.rows), along(col, self.cols))
    }

    /// Distance to the nearest place; infinite without any.
    pub(crate) fn distance(&self, at: [f64; 2]) -> f64 {
        let least = |places: &[[f64; 2]]| {
            places.iter().map(|&place| distance(place, at)).fold(f64::INFINITY, f64::min)
        };
        if self.all.len() < FEW {
            return least(&self.all);
        }
        let (row, col) = self.bucket(at);
        let mut best = f64::INFINITY;
        for ring in 0..self.rows.max(self.cols) {
            // Everything further out than this ring is at least so many buckets away, less the one that `at` is in.
            if best <= (ring as f64 - 1.0) * SIDE {
                break;
            }
            for r in row.saturating_sub(ring)..=(row + ring).min(self.rows - 1) {
                let edge = r.abs_diff(row) == ring;
                let step = if edge || ring == 0 { 1 } else { 2 * ring };
                let first = col as i64 - ring as i64;
                for c in (first..=first + 2 * ring as i64).step_by(step) {
                    if (0..self.cols as i64).contains(&c) {
                        best = best.min(least(&self.buckets[r * self.cols + c as usize]));
                    }
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::{key, unit};

    #[test]
    fn the_nearest_is_that_of_brute_force() {
        let place = |i: i64, stream: u64| {
            [unit(key(1, stream, i, 0)) * 130.0 - 5.0, unit(key(1, stream, i, 1)) * 90.0]
        };
        for n in [0, 1, 40, 70, 300] {
            let places: Vec<_> = (0..n).map(|i| place(i, 2)).collect();
            let nearest = Nearest::new(places.clone(), 120, 90);
            for i in 0..200 {
                let at = place(i, 3);
                let expected = places.iter().map(|&p| distance(p, at)).fold(f64::INFINITY, f64::min);
                assert_eq!(nearest.distance(at), expected);
            }
        }
    }
}
