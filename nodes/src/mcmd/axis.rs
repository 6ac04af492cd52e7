//! The subdivision of one axis, for any number of samples.
//!
//! The interval from the first to the last sample is halved again and again: `(a, b)` with `b - a > 1` has the
//! midpoint `a + (b - a) / 2`, one level deeper than the interval. The two ends have level 0. With 2^n + 1
//! samples these are the paper's levels; other sizes need no padding. Intervals of one level differ by one
//! sample at most, so the distance from a midpoint to an end takes two values a level.

use orograph_core::{Error, Result};

/// Levels that an axis can have: one for each bit of its length, and the ends.
pub(crate) const MAX_LEVELS: usize = 33;

/// Levels and parent intervals of the samples of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    /// Level of each sample.
    pub(crate) level: Vec<u8>,
    /// Lower end of the interval that the sample halves.
    pub(crate) low: Vec<u32>,
    /// Upper end of that interval.
    pub(crate) high: Vec<u32>,
    /// For each level, the smaller of the two distances from a midpoint to an end.
    pub(crate) half: [u32; MAX_LEVELS],
    /// The deepest level.
    pub(crate) depth: usize,
}

impl Axis {
    /// # Errors
    /// [`Error::TooLarge`] beyond 2^32 - 1 samples.
    pub(crate) fn new(samples: usize) -> Result<Self> {
        if u32::try_from(samples).is_err() {
            return Err(Error::TooLarge {
                what: format!("a side of {samples} cells"),
                bytes: samples as u64 * 4,
                limit: u64::from(u32::MAX) * 4,
            });
        }
        let mut axis = Self {
            level: vec![0; samples],
            low: vec![0; samples],
            high: vec![0; samples],
            half: [0; MAX_LEVELS],
            depth: 0,
        };
        let mut lines = axis.ends();
        loop {
            let mids = axis.midpoints(&lines);
            if mids.iter().all(Option::is_none) {
                return Ok(axis);
            }
            axis.depth += 1;
            let mut half = u32::MAX;
            for (ends, &mid) in lines.windows(2).zip(&mids) {
                if let Some(mid) = mid {
                    let i = mid as usize;
                    axis.level[i] = axis.depth as u8;
                    (axis.low[i], axis.high[i]) = (ends[0], ends[1]);
                    half = half.min(mid - ends[0]);
                }
            }
            axis.half[axis.depth] = half;
            lines = Self::refine(&lines, &mids);
        }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.level.len()
    }

    /// The samples of level 0: both ends, or the only sample.
    pub(crate) fn ends(&self) -> Vec<u32> {
        match self.len() {
            0 => vec![],
            1 => vec![0],
            n => vec![0, n as u32 - 1],
        }
    }

    /// The midpoint of each interval between neighbouring `lines`, where it is long enough to have one.
    pub(crate) fn midpoints(&self, lines: &[u32]) -> Vec<Option<u32>> {
        lines.windows(2).map(|ends| midpoint(ends[0], ends[1])).collect()
    }

    /// Lines and midpoints of one level together: the lines of the next.
    pub(crate) fn refine(lines: &[u32], mids: &[Option<u32>]) -> Vec<u32> {
        let mut finer = Vec::with_capacity(lines.len() + mids.len());
        for (i, &line) in lines.iter().enumerate() {
            finer.push(line);
            finer.extend(mids.get(i).copied().flatten());
        }
        finer
    }

    /// Midpoints of level `level` next to line `at` of a lower level, before and after it.
    pub(crate) fn neighbours(&self, at: u32, level: usize) -> (Option<u32>, Option<u32>) {
        let last = self.len() as u32 - 1;
        let own = self.level[at as usize] as usize;
        let (low, high) = match own {
            0 => (0, last),
            _ => (self.low[at as usize], self.high[at as usize]),
        };
        // Halving the interval on one side once per level in between narrows it to that of `level - 1`.
        let (mut before, mut after) = (low, high);
        for _ in own + 1..level {
            before = midpoint(before, at).unwrap_or(before);
            after = midpoint(at, after).unwrap_or(after);
        }
        (midpoint(before, at), midpoint(at, after))
    }

    /// Which of the distances of `level` this is: 0 for none, 1 for the smaller half, 2 for the larger.
    pub(crate) fn step(&self, level: usize, distance: u32) -> usize {
        if distance == 0 { 0 } else { 1 + (distance - self.half[level]) as usize }
    }
}

/// The sample halfway from `a` to `b`, if any lies between.
fn midpoint(a: u32, b: u32) -> Option<u32> {
    (b.saturating_sub(a) > 1).then(|| a + (b - a) / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_samples_have_the_papers_levels() {
        let axis = Axis::new(5).unwrap();
        assert_eq!(axis.level, [0, 2, 1, 2, 0]);
        assert_eq!((axis.low[1], axis.high[1]), (0, 2));
        assert_eq!(axis.depth, 2);
    }

    #[test]
    fn every_sample_is_reached_and_halves_take_two_values() {
        for n in 0..600 {
            let axis = Axis::new(n).unwrap();
            for i in 1..n.saturating_sub(1) {
                let level = axis.level[i] as usize;
                assert!(level > 0, "sample {i} of {n}");
                let (low, high) = (axis.low[i], axis.high[i]);
                assert_eq!(i as u32, low + (high - low) / 2);
                let half = axis.half[level];
                for distance in [i as u32 - low, high - i as u32] {
                    assert!(distance == half || distance == half + 1, "{distance} at {i} of {n}");
                }
            }
        }
    }

    #[test]
    fn neighbours_are_those_of_the_sorted_lines() {
        for n in [2, 3, 7, 20, 31, 33, 64] {
            let axis = Axis::new(n).unwrap();
            for level in 1..=axis.depth {
                let lines: Vec<u32> =
                    (0..n as u32).filter(|&i| (axis.level[i as usize] as usize) < level).collect();
                let mids = axis.midpoints(&lines);
                for (k, &line) in lines.iter().enumerate() {
                    let before = k.checked_sub(1).and_then(|k| mids[k]);
                    let after = mids.get(k).copied().flatten();
                    assert_eq!(axis.neighbours(line, level), (before, after), "{line} of {n} at {level}");
                }
            }
        }
    }
}
