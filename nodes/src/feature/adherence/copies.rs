//! The terrain seen otherwise: what lines that know nothing of it would find.

use orograph_core::{FeatureKind, Heightfield};

use super::Sample;
use crate::transform::sample::{Interpolation, sample};

/// The terrain seen otherwise.
#[derive(Clone, Copy, Debug)]
pub(super) enum Copy {
    Turned,
    MirroredAcross,
    MirroredDown,
    /// Shifted by so many thirds of its rows and columns; what leaves on one side comes in on the other.
    Shifted(u8, u8),
}

impl Copy {
    /// Every copy: the turned one, the two mirrored ones, the shifted ones.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let thirds = (0..3).flat_map(|down| (0..3).map(move |across| Self::Shifted(down, across)));
        [Self::Turned, Self::MirroredAcross, Self::MirroredDown].into_iter().chain(thirds.skip(1))
    }

    /// Where in the terrain a place of the copy lies.
    pub(super) fn find(self, [row, col]: [f64; 2], rows: usize, cols: usize) -> [f64; 2] {
        let back = |at: f64, n: usize| n as f64 - 1.0 - at;
        let shift = |at: f64, n: usize, thirds: u8| {
            let n = n as f64;
            let to = at + f64::from(thirds) * n / 3.0;
            if to > n - 0.5 { to - n } else { to }
        };
        match self {
            Self::Turned => [back(row, rows), back(col, cols)],
            Self::MirroredAcross => [row, back(col, cols)],
            Self::MirroredDown => [back(row, rows), col],
            Self::Shifted(down, across) => [shift(row, rows, down), shift(col, cols, across)],
        }
    }
}

/// Share of the samples that stand out from the ground `flank` cells to either side; those beside unknown ground do
/// not count.
pub(super) fn standing_share(
    all: &[Sample],
    terrain: &Heightfield,
    kind: FeatureKind,
    flank: f64,
    moved: impl Fn([f64; 2]) -> [f64; 2],
) -> f64 {
    let height = |at: [f64; 2]| {
        let [row, col] = moved(at);
        sample(terrain, row, col, Interpolation::Bilinear)
    };
    let (mut n, mut standing) = (0.0, 0.0);
    for &(at, across) in all {
        let side = |sign: f64| height([0, 1].map(|k| at[k] + sign * flank * across[k]));
        let (middle, sides) = (height(at), [side(1.0), side(-1.0)]);
        if middle.is_nan() || sides[0].is_nan() || sides[1].is_nan() {
            continue;
        }
        n += 1.0;
        let out = match kind {
            FeatureKind::Ridge => sides.iter().all(|side| middle > *side),
            FeatureKind::Valley => sides.iter().all(|side| middle < *side),
        };
        standing += f64::from(u8::from(out));
    }
    standing / n
}
