//! Copies: how much of the exemplar a synthesis uses, how often it uses the same ground, and whether that shows.
//!
//! What the eye notices is a pattern that comes again: the largest autocorrelation of the output beyond half a
//! patch. Departure: the output less its mean over a square of one patch, and not less a plane alone, is
//! correlated: long mountains would otherwise pass for repetition. The terrain counts as going on at its own other
//! side, voids as level.

use orograph_core::{Placement, Unit, prelude::*};
use rustfft::{FftDirection, num_complex::Complex};

use super::{fourier, seams::checked_labels, sums::per_row};

/// Measures how a synthesis uses its exemplars, and how much its output repeats itself.
///
/// Ground that belongs to no patch is left out. An autocorrelation above 0.6 is worth a look.
#[derive(Params, Clone, Debug)]
pub struct Copies {}

/// Inputs of [`Copies`].
#[derive(Inputs)]
pub struct CopiesIn<'a> {
    /// The synthesised terrain.
    pub terrain: &'a Heightfield,
    /// Which patch each of its cells came from.
    pub placement: &'a Placement,
    /// The exemplars, in the order in which the placement counts them, for the share of them that is used.
    pub exemplars: Vec<&'a Heightfield>,
}

/// Outputs of [`Copies`].
#[derive(Outputs)]
pub struct CopiesOut {
    /// One row of metrics.
    pub metrics: Table,
}

impl Node for Copies {
    const ID: &'static str = "measure.copies";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CopiesIn<'a>;
    type Outputs = CopiesOut;

    fn cost(&self) -> f64 {
        120.0
    }

    fn run(&self, inputs: CopiesIn<'_>, job: &Job) -> Result<CopiesOut> {
        let CopiesIn { terrain, placement, exemplars } = inputs;
        let uses = Uses::of(terrain.grid(), placement, job)?;
        let whole: usize = exemplars.iter().map(|exemplar| exemplar.grid().len()).sum();
        let repetition = repetition(terrain, uses.patch_size, job)?;
        let metrics = Table::metrics([
            ("patches", Unit::One, placement.patches.len() as f64),
            ("patch_cells", Unit::Percent, 100.0 * uses.labelled),
            (
                "coverage",
                Unit::Percent,
                if whole == 0 { f64::NAN } else { 100.0 * uses.cells as f64 / whole as f64 },
            ),
            ("cell_reuse_max", Unit::One, uses.cell_reuse as f64),
            ("window_reuse_max", Unit::One, uses.window_reuse as f64),
            ("patch_kept_mean", Unit::Cell, uses.kept_cells),
            ("patch_kept_share", Unit::Percent, 100.0 * uses.kept_share),
            ("autocorrelation_peak", Unit::One, repetition.peak),
            ("autocorrelation_rows", Unit::Cell, repetition.rows),
            ("autocorrelation_cols", Unit::Cell, repetition.cols),
        ])?;
        Ok(CopiesOut { metrics })
    }
}

/// How a synthesis uses its exemplars.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uses {
    /// Share, 0 to 1, of the output that belongs to a patch.
    pub labelled: f64,
    /// Different cells of the exemplars in the output.
    pub cells: usize,
    /// Most often that one cell of an exemplar comes in the output.
    pub cell_reuse: usize,
    /// Most patches from the same place of the same exemplar, mirrored or not.
    pub window_reuse: usize,
    /// Mean over the patches of the cells that are left of them after cuts; NaN without patches.
    pub kept_cells: f64,
    /// Mean over the patches of the share of their window that is left, 0 to 1; NaN without patches.
    pub kept_share: f64,
    /// Side of the middle one of the patches by size, in cells; 1 without patches.
    pub patch_size: usize,
}

impl Uses {
    /// Counts what a placement takes from where.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`] and [`Error::Invalid`] for a placement that does not fit the grid or itself,
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(grid: &Grid, placement: &Placement, job: &Job) -> Result<Self> {
        job.check()?;
        let labels = checked_labels(grid, placement)?;
        if placement.sources.len() != labels.len() {
            return Err(Error::invalid(
                "the placement does not say for every cell where it came from",
                "connect the placement that the synthesis of this terrain gave",
            ));
        }
        let patches = &placement.patches;
        job.admit(labels.len() as u64 * 12, || "the source of every cell".into())?;
        let mut kept = vec![0u64; patches.len()];
        let mut sources = Vec::with_capacity(labels.len());
        for (i, (&label, source)) in labels.iter().zip(&placement.sources).enumerate() {
            if i.is_multiple_of(1 << 16) {
                job.check()?;
            }
            if let Some(patch) = (label as usize).checked_sub(1) {
                kept[patch] += 1;
                sources.push((patches[patch].exemplar, source.map(|at| at.round() as i32)));
            }
        }
        let labelled = sources.len() as f64 / labels.len() as f64;
        let (cells, cell_reuse) = runs(&mut sources);
        job.check()?;
        let place = |at: [f64; 2]| at.map(|at| at.round() as i64);
        let mut windows: Vec<_> =
            patches.iter().map(|patch| (patch.exemplar, place(patch.source_center))).collect();
        let (_, window_reuse) = runs(&mut windows);
        let mut sizes: Vec<_> = patches.iter().map(|patch| patch.size).collect();
        sizes.sort_unstable();
        let count = patches.len() as f64;
        let share = |(cells, size): (&u64, u32)| *cells as f64 / (f64::from(size) * f64::from(size)).max(1.0);
        let kept_share =
            kept.iter().zip(patches.iter().map(|patch| patch.size)).map(share).sum::<f64>() / count;
        Ok(Self {
            labelled,
            cells,
            cell_reuse,
            window_reuse,
            kept_cells: kept.iter().sum::<u64>() as f64 / count,
            kept_share,
            patch_size: sizes.get(sizes.len() / 2).map_or(1, |&size| size.max(1) as usize),
        })
    }
}

/// How many different items there are, and how many there are of the most frequent one.
fn runs<T: Ord + Copy>(items: &mut [T]) -> (usize, usize) {
    items.sort_unstable();
    let equal = items.chunk_by(|a, b| a == b);
    equal.fold((0, 0), |(count, most), run| (count + 1, most.max(run.len())))
}

/// Where a terrain is most like itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repetition {
    /// The normalised autocorrelation there, up to 1; NaN where no lag is long enough.
    pub peak: f64,
    /// How many rows further on.
    pub rows: f64,
    /// How many columns further on, negative to the west.
    pub cols: f64,
}

/// The largest autocorrelation of a terrain's detail at lags of more than half of `patch` cells.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub fn repetition(terrain: &Heightfield, patch: usize, job: &Job) -> Result<Repetition> {
    job.check()?;
    let none = Repetition { peak: f64::NAN, rows: f64::NAN, cols: f64::NAN };
    let (rows, cols) = terrain.grid().size();
    if terrain.grid().is_empty() {
        return Ok(none);
    }
    job.admit(terrain.grid().len() as u64 * 32, || format!("a Fourier transform of {rows} × {cols} cells"))?;
    let detail = detail(terrain, patch / 2, job)?;
    let mut waves = fourier::transform(detail, (rows, cols), FftDirection::Forward, job)?;
    waves.iter_mut().for_each(|wave| *wave = Complex::new(wave.norm_sqr(), 0.0));
    let products = fourier::transform(waves, (cols, rows), FftDirection::Inverse, job)?;
    let all = products.first().map_or(0.0, |product| product.re);
    if all <= 0.0 {
        return Ok(none);
    }
    let near = patch as f64 / 2.0;
    // A lag and its opposite are alike: half of the rows say everything.
    let best = per_row(rows / 2 + 1, job, |row| {
        let signed = |col: usize| if 2 * col > cols { col as f64 - cols as f64 } else { col as f64 };
        let far = |col: &usize| (row * row) as f64 + signed(*col) * signed(*col) > near * near;
        let correlation = |col: usize| (products[row * cols + col].re / all, signed(col));
        Ok((0..cols).filter(far).map(correlation).reduce(|a, b| if b.0 > a.0 { b } else { a }))
    })?;
    let found = best.into_iter().enumerate().filter_map(|(row, best)| best.map(|best| (row, best)));
    Ok(found.reduce(|a, b| if b.1.0 > a.1.0 { b } else { a }).map_or(none, |(row, (peak, col))| Repetition {
        peak,
        rows: row as f64,
        cols: col,
    }))
}

/// Heights less their mean over a square of `reach` cells to each side, 0 in voids.
fn detail(terrain: &Heightfield, reach: usize, job: &Job) -> Result<Vec<Complex<f64>>> {
    let (rows, cols) = terrain.grid().size();
    let finite = terrain.cells().iter().find(|height| height.is_finite());
    // Counted from one of the heights, sums over large terrains stay exact enough.
    let zero = finite.map_or(0.0, |&height| f64::from(height));
    let rise = |height: f32| if height.is_finite() { f64::from(height) - zero } else { 0.0 };
    // Sums along the rows, then down the columns.
    let across = per_row(rows, job, |row| {
        let line = terrain.row(row);
        let mut until = Vec::with_capacity(cols + 1);
        until.push((0.0, 0.0));
        let mut sum = (0.0, 0.0);
        for &height in line {
            sum = (sum.0 + rise(height), sum.1 + f64::from(u8::from(height.is_finite())));
            until.push(sum);
        }
        let of = |col: usize| {
            let (a, b) = (until[col.saturating_sub(reach)], until[(col + reach + 1).min(cols)]);
            [(b.0 - a.0) as f32, (b.1 - a.1) as f32]
        };
        Ok((0..cols).map(of).collect::<Vec<_>>())
    })?;
    let lines = per_row(rows, job, |row| {
        let mut sums = vec![[0.0f64; 2]; cols];
        for line in &across[row.saturating_sub(reach)..(row + reach + 1).min(rows)] {
            for (sum, part) in sums.iter_mut().zip(line) {
                *sum = [sum[0] + f64::from(part[0]), sum[1] + f64::from(part[1])];
            }
        }
        let over = |(&height, [sum, count]): (&f32, [f64; 2])| {
            Complex::new(if height.is_finite() { rise(height) - sum / count } else { 0.0 }, 0.0)
        };
        Ok(terrain.row(row).iter().zip(sums).map(over).collect::<Vec<_>>())
    })?;
    Ok(lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;
    use orograph_core::Patch;

    fn noise(row: usize, col: usize) -> f64 {
        orograph_core::gaussian(6, 1, row as i64, col as i64)
    }

    fn patch(row: f64, col: f64) -> Patch {
        Patch {
            exemplar: 0,
            source_center: [row, col],
            target_center: [0.0; 2],
            size: 4,
            mirrored: false,
            controls: Vec::new(),
            offset: 0.0,
        }
    }

    #[test]
    fn uses_are_those_of_a_hand_count() {
        // Four rows of eight: two patches from the same sixteen cells, the second one cut by a row.
        let terrain = field(4, 8, noise);
        let labels: Vec<u32> = (0..32).map(|i| if i % 8 < 4 { 1 } else { 2 * u32::from(i >= 8) }).collect();
        let sources = (0..32).map(|i| [(i / 8) as f32, (i % 4) as f32]).collect();
        let placement = Placement {
            scales: Vec::new(),
            grid: terrain.grid().clone(),
            patches: vec![patch(1.5, 1.5), patch(1.5, 1.5)],
            labels,
            sources,
            seams: Vec::new(),
        };
        let exemplar = field(8, 8, noise);
        let inputs = CopiesIn { terrain: &terrain, placement: &placement, exemplars: vec![&exemplar] };
        let metrics = Copies::default().run(inputs, &Job::detached()).unwrap().metrics;
        let metric = |name: &str| metrics.metric(name).unwrap();
        assert_eq!(
            (metric("coverage"), metric("cell_reuse_max"), metric("window_reuse_max")),
            (25.0, 2.0, 2.0)
        );
        assert_eq!((metric("patch_kept_mean"), metric("patch_kept_share")), (14.0, 87.5));
        assert_eq!(metric("patch_cells"), 87.5);
        let broken = Placement { sources: Vec::new(), ..placement };
        let inputs = CopiesIn { terrain: &terrain, placement: &broken, exemplars: Vec::new() };
        assert!(Copies::default().run(inputs, &Job::detached()).is_err());
    }

    #[test]
    fn tiles_repeat_at_their_period_and_noise_does_not() {
        let job = Job::detached();
        let tiled = field(96, 96, |row, col| noise(row % 96, (col + 5 * (row / 96)) % 32) + row as f64);
        let found = repetition(&tiled, 16, &job).unwrap();
        assert!(found.peak > 0.9, "{found:?}");
        assert_eq!((found.rows, found.cols.abs()), (0.0, 32.0));
        assert!(repetition(&field(96, 96, noise), 16, &job).unwrap().peak < 0.1);
        assert!(repetition(&field(9, 9, |_, _| 2.0), 4, &job).unwrap().peak.is_nan());
        assert!(repetition(&field(3, 3, noise), 64, &job).unwrap().peak.is_nan());
    }

    #[test]
    fn long_mountains_are_no_repetition() {
        let hills = field(128, 128, |row, col| {
            300.0 * libm::sin(row as f64 / 40.0) * libm::cos(col as f64 / 50.0) + 20.0 * noise(row, col)
        });
        assert!(repetition(&hills, 40, &Job::detached()).unwrap().peak < 0.6);
    }
}
