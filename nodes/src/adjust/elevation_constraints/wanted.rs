//! What heights are wanted where.

use orograph_core::prelude::*;

/// Cells, ascending, and the height wanted at each, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted(Vec<(usize, f32)>);

impl Wanted {
    /// Heights at cells in any order; of several at one cell the mean.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a height that is no finite number.
    pub fn new(mut heights: Vec<(usize, f64)>) -> Result<Self> {
        if !heights.iter().all(|(_, height)| (*height as f32).is_finite()) {
            return Err(Error::invalid("a wanted height is no finite number", "give it in metres"));
        }
        heights.sort_by_key(|&(cell, _)| cell);
        let mean = |run: &[(usize, f64)]| {
            let sum: f64 = run.iter().map(|(_, height)| height).sum();
            (run[0].0, (sum / run.len() as f64) as f32)
        };
        Ok(Self(heights.chunk_by(|a, b| a.0 == b.0).map(mean).collect()))
    }

    /// The heights of a raster that is void where nothing is wanted, and of points, which win over it. Points off the
    /// grid are passed over with a remark.
    ///
    /// # Errors
    /// [`Error::DimensionMismatch`], [`Error::NonFinite`], [`Error::Invalid`], or cancellation.
    pub fn of(
        grid: &Grid,
        raster: Option<&Heightfield>,
        points: Option<&Points>,
        job: &Job<'_>,
    ) -> Result<Self> {
        let mut heights = Vec::new();
        let mut outside = 0;
        for (x, y, height) in points.into_iter().flat_map(Points::iter) {
            let (row, col) = grid.locate([x, y].into());
            let inside =
                |at: f64, n: usize| (at >= -0.5 && at < n as f64 - 0.5).then_some((at + 0.5) as usize);
            match (inside(row, grid.rows), inside(col, grid.cols)) {
                (Some(row), Some(col)) => heights.push((row * grid.cols + col, height)),
                _ => outside += 1,
            }
        }
        if outside > 0 {
            job.warn(format!("{outside} points lie off the terrain and are passed over"));
        }
        let Self(points) = Self::new(heights)?;
        let Some(raster) = raster else { return Ok(Self(points)) };
        grid.match_size("terrain", raster.grid(), "constraints")?;
        let mut all = Vec::new();
        let mut of_points = points.into_iter().peekable();
        for (cell, &height) in raster.cells().iter().enumerate() {
            if cell.is_multiple_of(1 << 16) {
                job.check()?;
            }
            if height.is_infinite() {
                let (row, col) = (cell / grid.cols, cell % grid.cols);
                return Err(Error::NonFinite { what: "constraints".into(), row, col });
            }
            match of_points.next_if(|point| point.0 == cell) {
                Some(point) => all.push(point),
                None if !height.is_nan() => all.push((cell, height)),
                None => {}
            }
        }
        Ok(Self(all))
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those of a run of cells.
    pub(crate) fn within(&self, cells: std::ops::Range<usize>) -> impl Iterator<Item = (usize, f32)> + '_ {
        let at = |cell: usize| self.0.partition_point(|&(own, _)| own < cell);
        self.0[at(cells.start)..at(cells.end.max(cells.start))].iter().copied()
    }

    /// Each cell and its height.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.0.iter().copied()
    }
}
