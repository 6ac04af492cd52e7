//! Beyond the paper: details from wherever the ground around is most like that around the void, turned as it fits best.
//!
//! Boxes on a lattice about the void are compared with it in all orientations: by the mean square difference of heights
//! along the rim, offset left out, and by how rough, how steep and how fine-grained the ground is. Each counts in units of
//! what the void's own surroundings show.

use orograph_core::prelude::*;

use super::{
    frame::Frame,
    source::{Source, Turn},
    texture::Texture,
};

/// Steps along each side of the lattice, and samples of rim and ground that are compared.
const STEPS: u32 = 8;
const SAMPLES: usize = 96;

/// Boxes with more voids than this share are no sources while better ones are to be had.
const MOST_MISSING: f64 = 0.02;

/// The source that fits best within `reach` cells down and across; `None` where no box lies inside the raster.
pub(super) fn search(
    terrain: &Heightfield,
    frame: &Frame,
    reach: [f64; 2],
    around: &Texture,
    job: &Job<'_>,
) -> Result<Option<Source>> {
    let known: Vec<usize> = (0..frame.len())
        .filter(|&i| {
            let [row, col] = frame.cell(i);
            !terrain.at(row, col).is_nan()
        })
        .collect();
    let rim: Vec<usize> = thinned(&known).collect();
    let spread = spread(terrain, frame, &rim);
    let mut best: Option<(f64, Source)> = None;
    let mut least_void: Option<(usize, Source)> = None;
    for turn in Turn::all(terrain.grid().cell) {
        let size = turn.size(frame.size);
        let raster = [terrain.rows(), terrain.cols()];
        let offset = |axis: usize, k: u32| {
            frame.offset(axis, size[axis], reach[axis], raster[axis], f64::from(k) / f64::from(STEPS))
        };
        for down in 0..=STEPS {
            job.check()?;
            for across in 0..=STEPS {
                let by = [offset(0, down), offset(1, across)];
                if by.iter().zip(frame.size).all(|(by, size)| by.unsigned_abs() < size as u64) {
                    // The void itself, in part.
                    continue;
                }
                let Some(source) = Source::beside(frame, by, turn, terrain.grid().size()) else { continue };
                let missing = source.missing(terrain, frame);
                if missing as f64 > MOST_MISSING * frame.len() as f64 {
                    if least_void.is_none_or(|(least, _)| missing < least) {
                        least_void = Some((missing, source));
                    }
                    continue;
                }
                let cost = rim_cost(terrain, frame, &source, &rim, spread)
                    + Texture::of_box(terrain, source.first, size, SAMPLES).apart(around);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, source));
                }
            }
        }
    }
    Ok(best.map(|(_, source)| source).or(least_void.map(|(_, source)| source)))
}

/// At most so many of the cells, evenly spread.
fn thinned(cells: &[usize]) -> impl Iterator<Item = usize> + '_ {
    let step = cells.len().div_ceil(SAMPLES).max(1);
    cells.iter().copied().step_by(step)
}

/// Standard deviation of the known heights of a box.
fn spread(terrain: &Heightfield, frame: &Frame, rim: &[usize]) -> f64 {
    let heights = rim.iter().map(|&i| {
        let [row, col] = frame.cell(i);
        f64::from(terrain.at(row, col))
    });
    deviation(heights)
}

/// How far the box lies from the rim, offset left out, in units of the rim's own relief.
fn rim_cost(terrain: &Heightfield, frame: &Frame, source: &Source, rim: &[usize], spread: f64) -> f64 {
    let differences = rim.iter().map(|&i| {
        let ([row, col], [from_row, from_col]) = (frame.cell(i), source.over(i, frame));
        f64::from(terrain.at(row, col)) - f64::from(terrain.at(from_row, from_col))
    });
    if spread > 0.0 { deviation(differences.filter(|difference| !difference.is_nan())) / spread } else { 0.0 }
}

/// Standard deviation; 0 of nothing.
fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count();
    if n == 0 {
        return 0.0;
    }
    let mean = values.clone().sum::<f64>() / n as f64;
    libm::sqrt(values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{repair::voids::Void, test_fields::field};
    use orograph_core::gaussian;

    #[test]
    fn the_same_ground_is_found_again_whichever_way_it_lies() {
        // A block of ground stands in the terrain twice, the second time turned; its middle is lost once.
        let block = |row: usize, col: usize| 20.0 * gaussian(1, 1, row as i64, col as i64);
        let void = Void { cells: Vec::new(), first: [54, 54], last: [61, 61], cols: 120 };
        let frame = Frame::around(&void, 4, 1, (120, 120)).unwrap();
        assert_eq!((frame.first, frame.size), ([50, 50], [16, 16]));
        for turn in Turn::all(CellSize::square(10.0)) {
            let copy = Source { first: [70, 50], turn };
            let mut terrain = field(120, 120, |row, col| 15.0 * gaussian(2, 2, row as i64, col as i64));
            for i in 0..frame.len() {
                let ([row, col], [to_row, to_col]) = (frame.cell(i), copy.over(i, &frame));
                let height = block(row, col) as f32;
                let lost = (54..62).contains(&row) && (54..62).contains(&col);
                terrain.cells_mut()[row * 120 + col] = if lost { f32::NAN } else { height };
                terrain.cells_mut()[to_row * 120 + to_col] = 100.0 + height;
            }
            let around = Texture::of_box(&terrain, [50, 50], [16, 16], 256);
            let found = search(&terrain, &frame, [40.0, 40.0], &around, &Job::detached()).unwrap();
            assert_eq!(found, Some(copy));
        }
    }

    #[test]
    fn a_raster_without_room_has_no_source() {
        let terrain = field(16, 16, |row, col| (row * col) as f64);
        let frame = Frame { first: [0, 0], size: [16, 16], levels: 1 };
        let around = Texture::of_box(&terrain, [0, 0], [16, 16], 256);
        assert_eq!(search(&terrain, &frame, [50.0; 2], &around, &Job::detached()).unwrap(), None);
    }
}
