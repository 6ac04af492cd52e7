//! How often windows of the exemplars were used.

use std::collections::BTreeMap;

use crate::synthesis::tps::Point;

/// Side of the squares that centres are kept by, in cells: about half a patch, as far as is mostly asked for.
const SQUARE: f64 = 40.0;

/// Earlier uses of an exemplar's windows.
#[derive(Clone, Debug, Default)]
pub struct Uses {
    /// Centres by exemplar and square, so that what asks for some looks at few.
    centers: BTreeMap<(usize, i64, i64), Vec<Point>>,
}

impl Uses {
    /// Earlier uses whose centres lie within `reach` cells.
    #[must_use]
    pub fn near(&self, exemplar: usize, center: Point, reach: f64) -> usize {
        let close = |at: &&Point| {
            let (down, across) = (at[0] - center[0], at[1] - center[1]);
            down * down + across * across <= reach * reach
        };
        let [first, last] = [square(center.map(|x| x - reach)), square(center.map(|x| x + reach))];
        (first[0]..=last[0])
            .flat_map(|row| self.centers.range((exemplar, row, first[1])..=(exemplar, row, last[1])))
            .map(|(_, centers)| centers.iter().filter(close).count())
            .sum()
    }

    /// Counts a use.
    pub fn add(&mut self, exemplar: usize, center: Point) {
        let [row, col] = square(center);
        self.centers.entry((exemplar, row, col)).or_default().push(center);
    }
}

fn square(center: Point) -> [i64; 2] {
    center.map(|x| (x / SQUARE).floor() as i64)
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, unit};

    use super::*;

    #[test]
    fn as_many_are_near_as_there_are() {
        let draw = |i: i64, axis: i64| 700.0 * unit(key(3, 5, i, axis)) - 20.0;
        let centers: Vec<(usize, Point)> =
            (0..800).map(|i| (usize::from(i % 3 == 0), [draw(i, 0), draw(i, 1)])).collect();
        let mut uses = Uses::default();
        centers.iter().for_each(|&(exemplar, center)| uses.add(exemplar, center));
        for (i, reach) in [0.0, 12.0, 40.0, 80.0, 333.0, 5000.0].into_iter().enumerate() {
            for exemplar in 0..3 {
                let at = if reach == 0.0 { centers[0].1 } else { [draw(i as i64, 2), draw(i as i64, 3)] };
                let apart = |a: Point| [a[0] - at[0], a[1] - at[1]];
                let near = |&&(which, center): &&(usize, Point)| {
                    let [down, across] = apart(center);
                    which == exemplar && down * down + across * across <= reach * reach
                };
                assert_eq!(uses.near(exemplar, at, reach), centers.iter().filter(near).count());
            }
        }
    }
}
