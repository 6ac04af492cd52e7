//! Sketches as constraints: drawn lines and painted pixels become known cells (Belhadj 2007, figures 5, 6 and 8).

use orograph_core::prelude::*;

use crate::{
    Ground,
    mcmd::{extent::extent, raster_line::line},
};

/// What the coordinates of lines mean.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// Shares of the picture: x from 0 at the first column to 1 at the last, y from 0 at the top to 1 at the bottom.
    Extent,
    /// Metres in the world: x east, y north.
    World,
}

impl Coordinates {
    /// The row and column of a drawn point.
    pub(crate) fn locate(self, grid: &Grid, point: &[f64; 3]) -> (f64, f64) {
        match self {
            Self::Extent => {
                (point[1] * grid.rows.saturating_sub(1) as f64, point[0] * grid.cols.saturating_sub(1) as f64)
            }
            Self::World => grid.locate([point[0], point[1]].into()),
        }
    }
}

/// Draws lines of (x, y, height) one cell wide, later ones over earlier ones; one point alone is a cell.
///
/// # Errors
/// Cancellation.
pub(crate) fn draw(
    lines: &Lines,
    coordinates: Coordinates,
    onto: &mut Heightfield,
    job: &Job<'_>,
) -> Result<()> {
    let grid = onto.grid().clone();
    if grid.is_empty() {
        return Ok(());
    }
    let (rows, cols) = grid.size();
    let place = |point: &[f64; 3]| {
        let (row, col) = coordinates.locate(&grid, point);
        (row.round() as i64, col.round() as i64)
    };
    let heights = onto.cells_mut();
    for points in &lines.0 {
        job.check()?;
        // A line of one point is a segment from it to itself.
        let ends = points.iter().zip(points.iter().skip(1).chain(points.last()));
        for (a, b) in ends.take(points.len().saturating_sub(1).max(1)) {
            line(place(a), place(b), (rows, cols), |row, col, share| {
                heights[row * cols + col] = (a[2] + (b[2] - a[2]) * share) as f32;
            });
        }
    }
    Ok(())
}

/// What becomes of the heights of `like`.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Only its grid counts.
    Ignore,
    /// They are known cells too, and what is drawn replaces them.
    Under,
    /// They are known cells too, and what is drawn does not touch them.
    Over,
}

/// Turns drawn lines and a painted picture into known cells for `mcmd.mcmd`.
///
/// The grid is that of `like`, else of the picture, else it is made from width, height and cells. Lines are drawn one
/// cell wide, later ones over earlier ones and over the picture.
#[derive(Params, Clone, Debug)]
pub struct Sketch {
    /// Polylines of (x, y, height in metres); heights run evenly between a line's points. One point alone is a summit
    /// or a pit.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "m")]
    pub lines: Lines,
    /// What x and y mean.
    #[param(default = Coordinates::Extent)]
    pub coordinates: Coordinates,
    /// Height of the picture's empty parts; pixels of this height and voids give no known cell.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub background: f64,
    /// How far a pixel may be from the background and still be empty.
    #[param(default = 0, range = 0.0..=20_000.0, slider = 0.0..=100.0, unit = "m")]
    pub tolerance: f64,
    /// What becomes of the heights of `like`.
    #[param(default = Base::Ignore)]
    pub base: Base,
    /// The ground to cover.
    #[param(flatten, default = Ground { cells: 513, ..Ground::default() })]
    pub ground: Ground,
}

/// Inputs of [`Sketch`].
#[derive(Inputs)]
pub struct SketchIn<'a> {
    /// Painted heights; it is laid over the grid whatever its own size is.
    pub picture: Option<&'a Heightfield>,
    /// Terrain whose grid is taken, and whose heights are if `base` says so.
    pub like: Option<&'a Heightfield>,
}

/// Outputs of [`Sketch`].
#[derive(Outputs)]
pub struct SketchOut {
    /// Known cells where something is drawn; all others are voids.
    pub constraints: Heightfield,
}

impl Node for Sketch {
    const ID: &'static str = "mcmd.sketch";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = SketchIn<'a>;
    type Outputs = SketchOut;

    fn run(&self, inputs: SketchIn<'_>, job: &Job) -> Result<SketchOut> {
        let grid = match (inputs.like, inputs.picture) {
            (Some(field), _) | (None, Some(field)) => field.grid().clone(),
            (None, None) => extent(&self.ground, job)?,
        };
        let mut constraints = match inputs.like {
            Some(like) if self.base == Base::Under => like.map(job, |height| height)?,
            _ => Heightfield::filled(grid, f32::NAN, job)?,
        };
        if constraints.grid().is_empty() {
            return Ok(SketchOut { constraints });
        }
        if let Some(picture) = inputs.picture {
            self.paint(picture, &mut constraints, job)?;
        }
        draw(&self.lines, self.coordinates, &mut constraints, job)?;
        if let Some(like) = inputs.like.filter(|_| self.base == Base::Over) {
            let base = like.cells().iter();
            for (out, height) in constraints.cells_mut().iter_mut().zip(base).filter(|(_, h)| !h.is_nan()) {
                *out = *height;
            }
        }
        Ok(SketchOut { constraints })
    }
}

impl Sketch {
    /// Sets the cell under each painted pixel; where several lie over one cell, to their mean.
    fn paint(&self, picture: &Heightfield, constraints: &mut Heightfield, job: &Job<'_>) -> Result<()> {
        let (rows, cols) = constraints.grid().size();
        let painted =
            |height: f32| (f64::from(height) - self.background).abs() > self.tolerance && !height.is_nan();
        let under = |i: usize, n: usize, all: usize| ((i as f64 + 0.5) * all as f64 / n as f64) as usize;
        let (mut sums, mut counts) = (vec![0.0_f64; cols], vec![0_u32; cols]);
        for row in 0..picture.rows() {
            job.check()?;
            let to = under(row, picture.rows(), rows).min(rows - 1);
            for (col, &height) in picture.row(row).iter().enumerate().filter(|(_, height)| painted(**height))
            {
                let at = under(col, picture.cols(), cols).min(cols - 1);
                sums[at] += f64::from(height);
                counts[at] += 1;
            }
            // Pixel rows come in order, so a row of cells is complete when the next one begins.
            if row + 1 < picture.rows() && under(row + 1, picture.rows(), rows).min(rows - 1) == to {
                continue;
            }
            let out = &mut constraints.cells_mut()[to * cols..(to + 1) * cols];
            for ((out, sum), count) in out.iter_mut().zip(&mut sums).zip(&mut counts) {
                if *count > 0 {
                    *out = (*sum / f64::from(*count)) as f32;
                }
                (*sum, *count) = (0.0, 0);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn run(node: &Sketch, picture: Option<&Heightfield>, like: Option<&Heightfield>) -> Heightfield {
        node.run(SketchIn { picture, like }, &Job::detached()).unwrap().constraints
    }

    fn known(field: &Heightfield) -> Vec<(usize, usize, f32)> {
        let cells = field.cells().iter().enumerate().filter(|(_, height)| !height.is_nan());
        cells.map(|(i, &height)| (i / field.cols(), i % field.cols(), height)).collect()
    }

    #[test]
    fn heights_run_evenly_along_lines() {
        let lines = vec![vec![[0.0, 0.5, 10.0], [1.0, 0.5, 50.0]], vec![[0.5, 0.0, 7.0]]].into();
        let node =
            Sketch { lines, ground: Ground { width: 50.0, height: 30.0, cells: 5 }, ..Sketch::default() };
        let out = run(&node, None, None);
        assert_eq!(out.grid().size(), (3, 5));
        let expected = [(0, 2, 7.0), (1, 0, 10.0), (1, 1, 20.0), (1, 2, 30.0), (1, 3, 40.0), (1, 4, 50.0)];
        assert_eq!(known(&out), expected);
    }

    #[test]
    fn world_coordinates_are_metres() {
        let like = field(4, 4, |_, _| 1.0);
        let lines = vec![vec![[10.0, -20.0, 5.0]], vec![[1e9, 1e9, 5.0]], vec![]].into();
        let node = Sketch { lines, coordinates: Coordinates::World, ..Sketch::default() };
        assert_eq!(known(&run(&node, None, Some(&like))), [(2, 1, 5.0)]);
    }

    #[test]
    fn the_base_lies_under_or_over_what_is_drawn() {
        let like = field(1, 2, |_, col| if col == 0 { 1.0 } else { f64::NAN });
        let lines: Lines = vec![vec![[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]]].into();
        for (base, expected) in
            [(Base::Under, [5.0, 5.0]), (Base::Over, [1.0, 5.0]), (Base::Ignore, [5.0, 5.0])]
        {
            let node = Sketch { lines: lines.clone(), base, ..Sketch::default() };
            assert_eq!(run(&node, None, Some(&like)).cells(), expected);
        }
        let node = Sketch { base: Base::Under, ..Sketch::default() };
        assert_eq!(known(&run(&node, None, Some(&like))), [(0, 0, 1.0)]);
    }

    #[test]
    fn pixels_other_than_the_background_are_known() {
        let picture = field(4, 4, |row, col| if row == col { 100.0 + row as f64 } else { 0.0 });
        let same = run(&Sketch::default(), Some(&picture), None);
        assert_eq!(known(&same), [(0, 0, 100.0), (1, 1, 101.0), (2, 2, 102.0), (3, 3, 103.0)]);
        let half = run(&Sketch::default(), Some(&picture), Some(&field(2, 2, |_, _| 0.0)));
        assert_eq!(known(&half), [(0, 0, 100.5), (1, 1, 102.5)]);
        let double = run(&Sketch::default(), Some(&picture), Some(&field(8, 8, |_, _| 0.0)));
        assert_eq!(known(&double).len(), 4);
    }
}
