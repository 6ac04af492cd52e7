//! Harmonic fill: the smoothest surface through the rim of each hole.
//!
//! Laplace's equation on the cells of a hole, with the cells around it as boundary values and no flow across the border
//! of the raster. A five-point stencil weighs neighbours by 1 / dx² and 1 / dy², so cells need not be square. Each
//! connected hole is solved by itself in f64, by conjugate gradients with a modified incomplete Cholesky
//! preconditioner, sequentially: the result does not depend on threads or on other holes.

mod system;

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::voids::{self, around};
use system::{NONE, System, check_often};

/// Fills holes with the smoothest surface that meets their rim; every other cell is unchanged.
///
/// A filled height never leaves the range of its hole's rim. A hole without rim keeps the mean of the heights that it
/// had, and stays void, with a remark, when it had none.
#[derive(Params, Clone, Debug)]
pub struct HarmonicFill {}

/// Inputs of [`HarmonicFill`].
#[derive(Inputs)]
pub struct HarmonicFillIn<'a> {
    /// Terrain with holes.
    pub terrain: &'a Heightfield,
    /// Cells to fill, where at least one half; the terrain's own voids when unconnected.
    pub holes: Option<&'a Mask>,
}

/// Outputs of [`HarmonicFill`].
#[derive(Outputs)]
pub struct HarmonicFillOut {
    /// Terrain with its holes filled.
    pub terrain: Heightfield,
}

impl Node for HarmonicFill {
    const ID: &'static str = "repair.harmonic_fill";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = HarmonicFillIn<'a>;
    type Outputs = HarmonicFillOut;

    fn cost(&self) -> f64 {
        30.0
    }

    fn run(&self, inputs: HarmonicFillIn<'_>, job: &Job) -> Result<HarmonicFillOut> {
        if let Some(holes) = inputs.holes {
            inputs.terrain.grid().match_size("terrain", holes.grid(), "holes")?;
        }
        Ok(HarmonicFillOut { terrain: harmonic_fill(inputs.terrain, inputs.holes, job)? })
    }
}

/// Bytes for one unknown: its cell, neighbours, and the vectors of the iteration.
const BYTES: u64 = 96;

/// Fills `holes` (or the voids) of `terrain`.
///
/// # Errors
/// [`Error::NotConverged`], [`Error::TooLarge`], or cancellation.
pub fn harmonic_fill(terrain: &Heightfield, holes: Option<&Mask>, job: &Job<'_>) -> Result<Heightfield> {
    let mut out = terrain.map(job, |height| height)?;
    let (rows, cols) = terrain.grid().size();
    let is_hole = |i: usize| match holes {
        Some(holes) => holes.cells()[i] >= 0.5,
        None => terrain.cells()[i].is_nan(),
    };
    let n = (0..rows * cols).into_par_iter().filter(|&i| is_hole(i)).count() as u64;
    if n == 0 {
        return Ok(out);
    }
    let bytes = n.saturating_mul(BYTES) + (rows * cols) as u64 * 4;
    job.admit(bytes, || format!("the equations of {n} cells to fill"))?;
    if n >= u64::from(NONE) {
        return Err(Error::TooLarge { what: format!("a fill of {n} cells"), bytes, limit: u64::from(NONE) });
    }
    let holes = voids::find((rows, cols), 0, is_hole, job)?;
    let mut local = vec![NONE; rows * cols];
    for hole in &holes {
        for (number, &i) in hole.cells.iter().enumerate() {
            check_often(number, job)?;
            local[i] = number as u32;
        }
    }
    let cell = terrain.grid().cell;
    let widest = cell.x.min(cell.y);
    let weights = ((widest / cell.x) * (widest / cell.x), (widest / cell.y) * (widest / cell.y));
    let done = job.stage(n);
    let solved: Vec<Option<Vec<f32>>> = holes
        .par_iter()
        .map(|hole| {
            let heights = solve(terrain, &hole.cells, &local, weights, job);
            done.advance(hole.cells.len() as u64);
            heights
        })
        .collect::<Result<_>>()?;
    let mut rimless = 0;
    for (hole, heights) in holes.iter().zip(solved) {
        match heights {
            Some(heights) => {
                hole.cells.iter().zip(heights).for_each(|(&i, height)| out.cells_mut()[i] = height);
            }
            None => rimless += 1,
        }
    }
    if rimless > 0 {
        job.warn(format!("{rimless} holes have no measured rim and stay void"));
    }
    Ok(out)
}

/// The heights of one hole; `None` when it has neither rim nor heights of its own.
fn solve(
    terrain: &Heightfield,
    cells: &[usize],
    local: &[u32],
    (weight_x, weight_y): (f64, f64),
    job: &Job<'_>,
) -> Result<Option<Vec<f32>>> {
    let (rows, cols) = terrain.grid().size();
    let heights = terrain.cells();
    let mut rim = Rim::default();
    let mut system =
        System { weight_x, weight_y, near: Vec::with_capacity(cells.len()), diagonal: Vec::new() };
    for (unknown, &i) in cells.iter().enumerate() {
        check_often(unknown, job)?;
        let mut near = [NONE; 4];
        let mut diagonal = 0.0;
        for (side, next) in around(i, (rows, cols)).into_iter().enumerate() {
            let Some(next) = next else { continue };
            near[side] = local[next];
            if local[next] == NONE {
                if heights[next].is_nan() {
                    continue;
                }
                rim.add(heights[next]);
            }
            diagonal += system.weight(side);
        }
        system.near.push(near);
        system.diagonal.push(diagonal);
    }
    if rim.count == 0.0 {
        let mut own = Rim::default();
        cells
            .iter()
            .map(|&i| heights[i])
            .filter(|height| !height.is_nan())
            .for_each(|height| own.add(height));
        return Ok((own.count > 0.0).then(|| vec![(own.sum / own.count) as f32; cells.len()]));
    }
    // Heights above the rim's mean: a flat rim is solved at once, and rounding is relative to the relief.
    let mean = rim.sum / rim.count;
    let right: Vec<f64> = cells
        .iter()
        .enumerate()
        .map(|(unknown, &i)| {
            check_often(unknown, job)?;
            let sides = around(i, (rows, cols)).into_iter().enumerate();
            let known = sides.filter_map(|(side, next)| Some((side, next?)));
            let rim = known.filter(|&(_, next)| local[next] == NONE && !heights[next].is_nan());
            let pull = rim
                .fold(0.0, |sum, (side, next)| sum + system.weight(side) * (f64::from(heights[next]) - mean));
            Ok(pull)
        })
        .collect::<Result<_>>()?;
    let solution = system.solve(right, job)?;
    let clamp = |height: f64| height.clamp(f64::from(rim.lowest), f64::from(rim.highest)) as f32;
    Ok(Some(solution.into_iter().map(|offset| clamp(mean + offset)).collect()))
}

/// Sum and range of the heights around a hole.
struct Rim {
    sum: f64,
    count: f64,
    lowest: f32,
    highest: f32,
}

impl Default for Rim {
    fn default() -> Self {
        Self { sum: 0.0, count: 0.0, lowest: f32::INFINITY, highest: f32::NEG_INFINITY }
    }
}

impl Rim {
    fn add(&mut self, height: f32) {
        self.sum += f64::from(height);
        self.count += 1.0;
        self.lowest = self.lowest.min(height);
        self.highest = self.highest.max(height);
    }
}

#[cfg(test)]
mod tests {
    use std::{
        path::PathBuf,
        sync::atomic::{AtomicU64, Ordering},
    };

    use orograph_core::{Context, Host, OutputStream};

    use super::*;
    use crate::test_fields::field;
    use orograph_core::{key, unit};

    fn with_cell(terrain: Heightfield, x: f64, y: f64) -> Heightfield {
        let (rows, cols) = terrain.grid().size();
        terrain.with_grid(Grid::new(rows, cols, CellSize { x, y }).unwrap()).unwrap()
    }

    fn filled(terrain: &Heightfield) -> Heightfield {
        harmonic_fill(terrain, None, &Job::detached()).unwrap()
    }

    /// A disc, a bar that reaches the border, and specks.
    fn is_void(row: usize, col: usize) -> bool {
        let (dy, dx) = (row as f64 - 30.0, col as f64 - 40.0);
        dx * dx + dy * dy < 400.0
            || (row > 55 && col == 70)
            || key(1, 1, row as i64, col as i64).is_multiple_of(50)
    }

    #[test]
    fn harmonic_functions_are_reproduced_and_known_cells_untouched() {
        for (dx, dy) in [(1.0, 1.0), (0.7, 1.3)] {
            // Inside the raster x² - y² is exact; at its border no function flows, so a hole there is left out.
            let truth = |row: usize, col: usize| {
                let (x, y) = (col as f64 * dx - 20.0, row as f64 * dy - 20.0);
                (x * x - y * y) / 100.0
            };
            let inside = |row: usize, col: usize| is_void(row, col) && row * col > 0 && row < 59 && col < 79;
            let holed = with_cell(
                field(60, 80, |row, col| if inside(row, col) { f64::NAN } else { truth(row, col) }),
                dx,
                dy,
            );
            let out = filled(&holed);
            for row in 0..60 {
                for col in 0..80 {
                    let (height, expected) = (out.at(row, col), truth(row, col) as f32);
                    // The bar is cut off one row above the border and has its rim there.
                    assert!((height - expected).abs() < 2e-5, "{height} {expected} at {row}, {col}");
                    assert!(inside(row, col) || height.to_bits() == expected.to_bits());
                }
            }
        }
    }

    #[test]
    fn no_slope_crosses_the_border() {
        // Heights vary along the hole only, which takes up whole columns down to the border.
        let holed =
            field(30, 40, |row, col| if row > 3 && (5..20).contains(&col) { f64::NAN } else { col as f64 });
        let out = filled(&holed);
        for row in 0..30 {
            for col in 0..40 {
                assert!((out.at(row, col) - col as f32).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn heights_stay_within_the_rim_and_residuals_vanish() {
        let rough = |row: usize, col: usize| 1000.0 * unit(key(3, 3, row as i64, col as i64));
        let holed =
            field(
                64,
                90,
                |row, col| if is_void(row, col) || col > 60 && row < 50 { f64::NAN } else { rough(row, col) },
            );
        let out = filled(&holed);
        assert_eq!(out.void_count(), 0);
        let (low, high) = holed.range().unwrap();
        for row in 1..63 {
            for col in 1..89 {
                let height = out.at(row, col);
                assert!((low..=high).contains(&height));
                if holed.at(row, col).is_nan() {
                    let around = [(row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)];
                    let mean = around.iter().map(|&(r, c)| f64::from(out.at(r, c))).sum::<f64>() / 4.0;
                    assert!((f64::from(height) - mean).abs() < 1e-3, "{height} {mean}");
                }
            }
        }
    }

    #[test]
    fn holes_without_rim_are_met() {
        let out = filled(&field(5, 5, |_, _| f64::NAN));
        assert_eq!(out.void_count(), 25);
        assert!(filled(&field(0, 0, |_, _| 0.0)).grid().is_empty());
        let terrain = field(4, 4, |row, _| row as f64);
        let all = terrain.map(&Job::detached(), |_| 1.0).unwrap();
        let out = harmonic_fill(&terrain, Some(&all), &Job::detached()).unwrap();
        assert!(out.cells().iter().all(|&height| height == 1.5));
    }

    #[test]
    fn a_mask_chooses_the_cells_and_leaves_other_voids() {
        let mut terrain = field(9, 9, |_, col| col as f64);
        terrain.cells_mut()[0] = f32::NAN;
        let spiked = {
            let mut t = terrain.clone();
            t.cells_mut()[40] = 99.0;
            t
        };
        let mut holes: Mask = terrain.map(&Job::detached(), |_| 0.0).unwrap();
        holes.cells_mut()[40] = 1.0;
        let out = harmonic_fill(&spiked, Some(&holes), &Job::detached()).unwrap();
        assert!(out.at(0, 0).is_nan());
        assert_eq!(out.cells()[1..], terrain.cells()[1..]);
    }

    /// Cancels the work when it is asked for the last time that is allowed.
    struct Cancelling {
        asked: AtomicU64,
        most: u64,
    }

    impl Host for Cancelling {
        fn cancelled(&self) -> bool {
            self.asked.fetch_add(1, Ordering::Relaxed) >= self.most
        }
        fn progress(&self, _: f64) {}
        fn warn(&self, _: &str) {}
        fn memory_limit(&self) -> u64 {
            1 << 30
        }
        fn input_path(&self, path: &str) -> Result<PathBuf> {
            Err(Error::reading(path, "there are no files here"))
        }
        fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
            Err(Error::writing(path, "there are no files here"))
        }
    }

    #[test]
    fn one_large_hole_can_be_cancelled_at_every_pass_over_it() {
        // 360,000 unknowns: six pieces, each of which asks in each pass over the hole.
        const SIDE: usize = 602;
        let inside = |at: usize| (1..SIDE - 1).contains(&at);
        let holed = field(
            SIDE,
            SIDE,
            |row, col| {
                if inside(row) && inside(col) { f64::NAN } else { (row * col) as f64 }
            },
        );
        let asked = |most: u64| {
            let host = Cancelling { asked: AtomicU64::new(0), most };
            let ended = harmonic_fill(&holed, None, &Job::new(&host, Context::default()));
            (host.asked.into_inner(), ended)
        };
        // Copy and search ask once a row or two; what is asked from there on is asked within the solution.
        let before = 3 * SIDE as u64;
        for most in [before, before + 30, before + 100] {
            let (asked, ended) = asked(most);
            assert_eq!(ended.err(), Some(Error::Cancelled), "after {most}");
            assert!(asked <= most + 4, "asked {asked} times instead of {most}");
        }
        let cancelled_in_pass = asked(before + 6 * 40);
        assert_eq!(cancelled_in_pass.1.err(), Some(Error::Cancelled));
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let holed =
            field(
                90,
                90,
                |row, col| {
                    if is_void(row, col) { f64::NAN } else { unit(key(3, 3, row as i64, col as i64)) }
                },
            );
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| filled(&holed)).into_cells()
        };
        assert!(on(1) == on(2) && on(1) == on(8));
    }
}
