//! How often windows of the exemplars were used.

use crate::synthesis::tps::Point;

/// Earlier uses of an exemplar's windows.
#[derive(Clone, Debug, Default)]
pub struct Uses {
    centers: Vec<(usize, Point)>,
}

impl Uses {
    /// Earlier uses whose centres lie within `reach` cells.
    #[must_use]
    pub fn near(&self, exemplar: usize, center: Point, reach: f64) -> usize {
        let close = |at: &Point| {
            let (down, across) = (at[0] - center[0], at[1] - center[1]);
            down * down + across * across <= reach * reach
        };
        self.centers.iter().filter(|(which, at)| *which == exemplar && close(at)).count()
    }

    /// Counts a use.
    pub fn add(&mut self, exemplar: usize, center: Point) {
        self.centers.push((exemplar, center));
    }
}
