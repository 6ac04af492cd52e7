//! Curves through voids: cubic Hermite segments along rows, columns and diagonals.
//!
//! Wecker, Samavati and Gavrilova (2007): each run of voids along a line is bridged by one cubic whose slopes at both ends
//! are taken over as many measured samples as the run is long, as far as there are that many. Departure: those slopes
//! are scaled to the parameter of the cubic, so that a steady slope is continued exactly.

use orograph_core::prelude::*;

use crate::filter::chaikin::{Boundary, compose, decompose, whole_len};

/// The direction of a family of parallel curves.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along rows.
    U,
    /// Down columns.
    V,
    /// Down to the right.
    W,
    /// Down to the left.
    T,
}

impl Direction {
    /// All four.
    pub const ALL: [Self; 4] = [Self::U, Self::V, Self::W, Self::T];

    /// Rows and columns from one sample to the next.
    #[must_use]
    pub fn step(self) -> [i64; 2] {
        match self {
            Self::U => [0, 1],
            Self::V => [1, 0],
            Self::W => [1, 1],
            Self::T => [1, -1],
        }
    }

    /// Metres from one sample to the next.
    #[must_use]
    pub fn length(self, cell: CellSize) -> f64 {
        let [down, across] = self.step();
        libm::hypot(down as f64 * cell.y, across as f64 * cell.x)
    }
}

/// How curves get the details that a cubic lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveDetails {
    /// Times that curves are halved.
    pub levels: u32,
    /// How the ends of windows are treated.
    pub boundary: Boundary,
    /// What details are multiplied by.
    pub gain: f64,
}

/// A filled sample: its cell, its height, and its distance in metres from the nearer end of its run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filled {
    /// Row-major index.
    pub cell: usize,
    /// Height in metres.
    pub height: f64,
    /// Distance in metres along the curve.
    pub distance: f64,
}

/// The curves of one direction over a terrain.
#[derive(Clone, Copy, Debug)]
pub struct Curves<'a> {
    terrain: &'a Heightfield,
    direction: Direction,
}

impl<'a> Curves<'a> {
    /// Curves in a direction.
    #[must_use]
    pub fn new(terrain: &'a Heightfield, direction: Direction) -> Self {
        Self { terrain, direction }
    }

    /// Bridges the runs of voids that start among `cells`; runs that reach the border have one end alone and are left out.
    #[must_use]
    pub fn bridge(&self, cells: &[usize], details: Option<CurveDetails>) -> Vec<Filled> {
        let mut out = Vec::new();
        let step = self.direction.length(self.terrain.grid().cell);
        for &cell in cells {
            // A run starts where the sample before is known; at the border it has no such end.
            let Some(before) = self.next(cell, -1).filter(|&before| self.is_known(before)) else { continue };
            let mut run = vec![cell];
            let after = loop {
                match self.next(run[run.len() - 1], 1) {
                    Some(next) if !self.is_known(next) => run.push(next),
                    next => break next,
                }
            };
            let Some(after) = after else { continue };
            let most = run.len() + details.map_or(1, |details| 2 + (1 << details.levels));
            let [before, after] =
                [(before, -1), (after, 1)].map(|(end, steps)| self.known_from(end, steps, most));
            let bridge = Bridge { before, after, n: run.len() };
            let heights = details.map_or_else(|| bridge.cubic(), |details| bridge.detailed(details));
            out.extend(run.iter().zip(heights).enumerate().map(|(i, (&cell, height))| Filled {
                cell,
                height,
                distance: step * (i + 1).min(run.len() - i) as f64,
            }));
        }
        out
    }

    fn next(&self, cell: usize, steps: i64) -> Option<usize> {
        let (rows, cols) = self.terrain.grid().size();
        let [down, across] = self.direction.step().map(|step| step * steps);
        let row = (cell / cols).checked_add_signed(down as isize).filter(|&row| row < rows)?;
        let col = (cell % cols).checked_add_signed(across as isize).filter(|&col| col < cols)?;
        Some(row * cols + col)
    }

    fn is_known(&self, cell: usize) -> bool {
        !self.terrain.cells()[cell].is_nan()
    }

    /// At most `most` known heights in a row from a known cell on, itself first.
    fn known_from(&self, cell: usize, steps: i64, most: usize) -> Vec<f64> {
        let cells = std::iter::successors(Some(cell), |&cell| self.next(cell, steps));
        let known = cells.take_while(|&cell| self.is_known(cell)).take(most);
        known.map(|cell| f64::from(self.terrain.cells()[cell])).collect()
    }
}

/// A run of voids and the known samples on both sides, nearest first.
struct Bridge {
    before: Vec<f64>,
    after: Vec<f64>,
    n: usize,
}

impl Bridge {
    /// The cubic through the run.
    fn cubic(&self) -> Vec<f64> {
        let n = self.n;
        let rise = |known: &[f64]| {
            let k = n.min(known.len() - 1);
            if k == 0 { 0.0 } else { (known[k] - known[0]) * (n + 1) as f64 / k as f64 }
        };
        let (p0, p1) = (self.before[0], self.after[0]);
        let (m0, m1) = (-rise(&self.before), rise(&self.after));
        (1..=n)
            .map(|i| {
                let t = i as f64 / (n + 1) as f64;
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * p0
                    + (t3 - 2.0 * t2 + t) * m0
                    + (3.0 * t2 - 2.0 * t3) * p1
                    + (t3 - t2) * m1
            })
            .collect()
    }

    /// The cubic with details of the ground on both sides, mirrored and mixed by nearness (equation 1 of the paper).
    fn detailed(&self, CurveDetails { levels, boundary, gain }: CurveDetails) -> Vec<f64> {
        let cubic = self.cubic();
        let enough = |levels: &u32| {
            let wanted = whole_len(self.n, *levels);
            self.before.len().min(self.after.len()) >= wanted
        };
        let Some(levels) = (1..=levels).rev().find(enough) else { return cubic };
        let whole = whole_len(self.n, levels);
        let left = (whole - self.n) / 2;
        let right = whole - self.n - left;
        let window: Vec<f64> = self.before[..left]
            .iter()
            .rev()
            .copied()
            .chain(cubic)
            .chain(self.after[..right].iter().copied())
            .collect();
        let before: Vec<f64> = self.before[..whole].iter().rev().copied().collect();
        let smooth = Pyramid::new(window, levels, boundary);
        let sides = [before, self.after[..whole].to_vec()].map(|side| Pyramid::new(side, levels, boundary));
        let details = sides[0].details.iter().zip(&sides[1].details).map(|(before, after)| {
            let mut mixed = mirrored(before, after);
            mixed.iter_mut().for_each(|detail| *detail *= gain);
            mixed
        });
        let curve = Pyramid { details: details.collect(), ..smooth }.compose(boundary);
        curve[left..left + self.n].to_vec()
    }
}

/// Details of both sides, reflected at the middle: near an end those that lie near it outside.
fn mirrored(before: &[f64], after: &[f64]) -> Vec<f64> {
    let m = before.len();
    let share = |j: usize| (j + 1) as f64 / (m + 1) as f64;
    (0..m).map(|j| (1.0 - share(j)) * before[m - 1 - j] + share(j) * after[m - 1 - j]).collect()
}

/// A curve halved several times.
struct Pyramid {
    coarse: Vec<f64>,
    /// Details of each level, finest first.
    details: Vec<Vec<f64>>,
    lengths: Vec<usize>,
}

impl Pyramid {
    fn new(curve: Vec<f64>, levels: u32, boundary: Boundary) -> Self {
        let mut out = Self { coarse: curve, details: Vec::new(), lengths: Vec::new() };
        for _ in 0..levels {
            let (mut coarse, mut details) = Default::default();
            decompose(&out.coarse, boundary, &mut coarse, &mut details);
            out.lengths.push(out.coarse.len());
            out.details.push(details);
            out.coarse = coarse;
        }
        out
    }

    fn compose(self, boundary: Boundary) -> Vec<f64> {
        let mut curve = self.coarse;
        for (details, len) in self.details.iter().zip(self.lengths).rev() {
            let mut fine = Vec::new();
            compose(&curve, details, boundary, len, &mut fine);
            curve = fine;
        }
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::{field, row};

    const DETAILS: CurveDetails = CurveDetails { levels: 3, boundary: Boundary::Natural, gain: 1.0 };

    fn voids(terrain: &Heightfield) -> Vec<usize> {
        (0..terrain.cells().len()).filter(|&i| terrain.cells()[i].is_nan()).collect()
    }

    #[test]
    fn planes_are_continued_in_every_direction() {
        let plane = |row: usize, col: usize| 100.0 + 7.0 * row as f64 - 2.0 * col as f64;
        let hole = |row: usize, col: usize| (20..31).contains(&row) && (25..44).contains(&col);
        let terrain = field(60, 80, |row, col| if hole(row, col) { f64::NAN } else { plane(row, col) });
        for direction in Direction::ALL {
            for details in [None, Some(DETAILS)] {
                let filled = Curves::new(&terrain, direction).bridge(&voids(&terrain), details);
                assert_eq!(filled.len(), 11 * 19);
                for Filled { cell, height, .. } in filled {
                    assert!((height - plane(cell / 80, cell % 80)).abs() < 1e-4, "{direction:?} {details:?}");
                }
            }
        }
    }

    #[test]
    fn distances_and_single_samples_are_as_in_the_paper() {
        // One void, slopes over one sample on each side.
        let n = f32::NAN;
        let terrain = row(&[0.0, 4.0, n, 10.0, 10.0]);
        let filled = Curves::new(&terrain, Direction::U).bridge(&[2], None);
        // Half-way: the mean of the ends and an eighth of the difference of slopes, 2 · 4 and 2 · 0.
        assert_eq!(filled, [Filled { cell: 2, height: 7.0 + 8.0 / 8.0, distance: 10.0 }]);
        // No sample beyond the end: level there. Runs at the border have one end alone.
        let terrain = row(&[0.0, n, n, 6.0]);
        let filled = Curves::new(&terrain, Direction::U).bridge(&[1, 2], None);
        let third = 6.0 * (3.0 / 9.0 - 2.0 / 27.0);
        assert!((filled[0].height - third).abs() < 1e-12);
        assert!(Curves::new(&row(&[n, 1.0, 2.0, n]), Direction::U).bridge(&[0, 3], None).is_empty());
        let square = field(3, 3, |row, col| if row == 1 && col == 1 { f64::NAN } else { 5.0 });
        let diagonal = Curves::new(&square, Direction::T).bridge(&[4], None);
        assert!((diagonal[0].distance - 10.0 * 2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn details_are_mirrored_and_mixed_as_in_the_papers_equation() {
        let mixed = mirrored(&[1.0, 2.0, 3.0, 4.0, 5.0], &[10.0, 20.0, 30.0, 40.0, 50.0]);
        let expected = [12.5, 16.0, 16.5, 14.0, 8.5];
        assert!(mixed.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{mixed:?}");
    }

    #[test]
    fn details_bring_the_roughness_of_the_sides() {
        let rough = |i: usize| 100.0 + 10.0 * orograph_core::gaussian(1, 1, i as i64, 0);
        let heights: Vec<f32> =
            (0..200).map(|i| if (90..108).contains(&i) { f32::NAN } else { rough(i) as f32 }).collect();
        let terrain = row(&heights);
        let bend = |details| {
            let filled = Curves::new(&terrain, Direction::U).bridge(&voids(&terrain), details);
            let bends = filled.windows(3).map(|w| w[0].height - 2.0 * w[1].height + w[2].height);
            bends.map(|bend| bend * bend).sum::<f64>()
        };
        assert!(bend(Some(DETAILS)) > 20.0 * bend(None));
        // Where the sides are too short for one level, the cubic stays.
        let short = row(&heights[86..112]);
        let curves = Curves::new(&short, Direction::U);
        assert_eq!(curves.bridge(&voids(&short), Some(DETAILS)), curves.bridge(&voids(&short), None));
    }
}
