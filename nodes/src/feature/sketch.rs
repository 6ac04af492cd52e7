//! Sketch preparation: from pen strokes to heights whose crests are the strokes' middle lines.
//!
//! Zhou et al. (2007) take a sketch for a terrain, bright above dark, and say that the width of strokes does not
//! matter. A stroke is a plateau, though, and shows no crest in a profile; so the distance to its edge is added, and
//! the width that it reveals sets the parameters of the search.

use orograph_core::{Share, Unit, prelude::*};

use super::{
    lattice::Blocks,
    settings::{Drop, Kind, Reduction, Shaping, Steps},
};
use crate::mask::distance::distances;

/// Which pixels are strokes.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strokes {
    /// Bright for ridges, dark for valleys: the sketch is a picture of heights.
    ByKind,
    /// Those brighter than the background.
    Bright,
    /// Those darker than the background.
    Dark,
}

/// Turns a sketch into a field without unit whose crests, or talwegs, run along the middle of its strokes.
///
/// `feature.from_sketch` does this and the search at once. Wire the field to `feature.ppa` and copy the suggested
/// parameters there to have your hands on each.
#[derive(Params, Clone, Debug)]
pub struct Sketch {
    /// Ridges or valleys.
    #[param(default = Kind::Ridge)]
    pub kind: Kind,
    /// Which pixels are strokes.
    #[param(default = Strokes::ByKind)]
    pub strokes: Strokes,
    /// How far from the background towards the strokes' full strength a pixel must be to count as stroke.
    #[param(default = 0.5, range = 0.05..=0.95, unit = "1")]
    pub threshold: f64,
    /// How much the distance to a stroke's edge counts beside its brightness.
    #[param(default = 1, range = 0.0..=4.0, unit = "1")]
    pub edge_weight: f64,
    /// Takes the most frequent brightness for the background.
    #[param(default = true)]
    pub find_background: bool,
    /// Brightness of the background when it is not found, 0 the darkest and 1 the brightest of the sketch.
    #[param(default = 0, range = 0.0..=1.0, unit = "1")]
    pub background: f64,
}

/// Inputs of [`Sketch`].
#[derive(Inputs)]
pub struct SketchIn<'a> {
    /// The sketch; its heights are brightness of any range, voids are background.
    pub sketch: &'a Heightfield,
}

/// Outputs of [`Sketch`].
#[derive(Outputs)]
pub struct SketchOut {
    /// Field without unit on the sketch's grid, for `feature.ppa`.
    pub field: Heightfield,
    /// Width of the strokes in pixels, and parameters of `feature.ppa` that suit it.
    pub suggested: Table,
}

impl Node for Sketch {
    const ID: &'static str = "feature.sketch";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = SketchIn<'a>;
    type Outputs = SketchOut;

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, inputs: SketchIn<'_>, job: &Job) -> Result<SketchOut> {
        let prepared = prepare(inputs.sketch, self, job)?;
        if prepared.is_none() {
            job.warn(NO_STROKE);
        }
        let steps = prepared.as_ref().map_or(Steps { working_cell: 1, ..Steps::default() }, Prepared::steps);
        let width = prepared.as_ref().map_or(0.0, |prepared| prepared.width);
        let merge_radius =
            prepared.as_ref().map_or(4.0, |prepared| prepared.shaping(80).joining.merge_radius);
        let drop = if let Drop::Share(drop) = steps.drop { drop } else { STROKE_DROP };
        let suggested = Table::metrics([
            ("stroke_width", Unit::Pixel, width),
            ("working_cell", Unit::Cell, steps.working_cell as f64),
            ("half_profile", Unit::One, steps.half_profile as f64),
            ("drop", Unit::One, drop),
            ("min_branch", Unit::One, steps.reduction.min_branch as f64),
            ("parallel_radius", Unit::One, steps.reduction.parallel_radius),
            ("merge_radius", Unit::One, merge_radius),
        ])?;
        let sign = if self.kind == Kind::Ridge { 1.0 } else { -1.0 };
        let grid = inputs.sketch.grid().clone();
        let field = Heightfield::build(grid, job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                // Each block holds one value, so that the blocks' means in `feature.ppa` are the values themselves.
                *out = prepared.as_ref().map_or(0.0, |p| sign * p.field.at(row / p.shrink, col / p.shrink));
            }
            Ok(())
        })?;
        Ok(SketchOut { field, suggested })
    }
}

/// What is said of a sketch without strokes.
pub(crate) const NO_STROKE: &str = "the sketch shows no stroke: ridges are drawn bright and valleys dark unless \
                                    `strokes` says otherwise, and must pass `threshold`";

/// Share of the range by which the profile of a stroke falls.
const STROKE_DROP: f64 = 0.02;
/// Half-profiles longer than this make the sketch be shrunk first, to half-profiles of about half of it.
const LONGEST_PROFILE: f64 = 12.0;

/// A sketch ready for the search.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Field without unit on blocks of [`shrink`](Self::shrink) pixels; strokes are crests whatever the kind.
    pub field: Heightfield,
    /// Distance to the edge of the strokes, pixel by pixel, in pixels: positive inside, negative outside.
    pub edges: Heightfield,
    /// Pixels along the side of a block.
    pub shrink: usize,
    /// Width of the widest stroke in pixels.
    pub width: f64,
    /// Its width in blocks.
    pub block_width: f64,
    /// Ridges or valleys.
    pub kind: Kind,
}

impl Prepared {
    /// The numbers of the search on a sketch of this stroke width.
    #[must_use]
    pub fn steps(&self) -> Steps {
        let width = self.block_width;
        Steps {
            kind: self.kind.into(),
            working_cell: self.shrink,
            half_profile: half_profile(width) as usize,
            drop: Drop::Share(STROKE_DROP),
            reduction: Reduction {
                min_branch: width.max(7.0).ceil() as u32,
                parallel_radius: (width / 2.0 + 1.0).max(3.0),
                ..Reduction::default()
            },
            ..Steps::default()
        }
    }

    /// The numbers of classification that go with it, for patches of `patch` cells.
    #[must_use]
    pub fn shaping(&self, patch: usize) -> Shaping {
        let mut shaping = Shaping::for_patch(patch, self.steps().reduction.parallel_radius);
        shaping.joining.merge_radius = self.block_width.max(4.0);
        shaping
    }
}

fn half_profile(width: f64) -> f64 {
    (width / 2.0).ceil().max(3.0)
}

/// Prepares a sketch; `None` where it shows no stroke. Wide strokes make it be shrunk to blocks of pixels first.
///
/// # Errors
/// [`Error::BadSize`] below 3 × 3 pixels; [`Error::NonFinite`]; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn prepare(sketch: &Heightfield, settings: &Sketch, job: &Job) -> Result<Option<Prepared>> {
    let (rows, cols) = sketch.grid().size();
    if rows < 3 || cols < 3 {
        return Err(Error::BadSize { what: "the sketch".into(), rows, cols, min: 3 });
    }
    let Some((low, high)) = sketch.range() else { return Ok(None) };
    if low.is_infinite() || high.is_infinite() {
        let at = sketch.cells().iter().position(|grey| grey.is_infinite()).unwrap_or(0);
        return Err(Error::NonFinite { what: "the sketch".into(), row: at / cols, col: at % cols });
    }
    if low >= high {
        return Ok(None);
    }
    let (low, span) = (f64::from(low), f64::from(high) - f64::from(low));
    let grid = Grid::new(rows, cols, CellSize::square(1.0))?;
    let greys = Heightfield::build(grid, job, |row, out| {
        for (out, &grey) in out.iter_mut().zip(sketch.row(row)) {
            *out = ((f64::from(grey) - low) / span) as f32;
        }
        Ok(())
    })?;
    let Some(Raised { field, edges, half }) = raise(&greys, settings, job)? else { return Ok(None) };
    let (width, kind) = (2.0 * half, settings.kind);
    if half_profile(width) <= LONGEST_PROFILE {
        return Ok(Some(Prepared { field, edges, shrink: 1, width, block_width: width, kind }));
    }
    let shrink = (half_profile(width) / (LONGEST_PROFILE / 2.0)).ceil() as usize;
    let small = shrunk(&greys, shrink, job)?;
    // Blocks may blur fine strokes away; then the sketch is taken as it is.
    Ok(Some(match raise(&small, settings, job)? {
        Some(small) => {
            Prepared { field: small.field, edges, shrink, width, block_width: 2.0 * small.half, kind }
        }
        None => Prepared { field, edges, shrink: 1, width, block_width: width, kind },
    }))
}

/// Mean grey of each block; a block at the border takes what there is of it.
fn shrunk(greys: &Heightfield, shrink: usize, job: &Job) -> Result<Heightfield> {
    let blocks = Blocks { down: shrink, across: shrink };
    let lattice = blocks.lattice(greys.grid());
    let grid = Grid::new(lattice.rows, lattice.cols, CellSize::square(1.0))?;
    let (rows, cols) = greys.grid().size();
    Heightfield::build(grid, job, |row, out| {
        for (col, out) in out.iter_mut().enumerate() {
            let (mut sum, mut known) = (0.0, 0.0);
            for row in row * shrink..rows.min((row + 1) * shrink) {
                for &grey in &greys.row(row)[col * shrink..cols.min((col + 1) * shrink)] {
                    if !grey.is_nan() {
                        sum += f64::from(grey);
                        known += 1.0;
                    }
                }
            }
            *out = (sum / known) as f32;
        }
        Ok(())
    })
}

/// Strokes raised in the middle.
struct Raised {
    /// Brightness with the distance to the edge added.
    field: Heightfield,
    /// That distance, negative outside.
    edges: Heightfield,
    /// The greatest of it: half the width of the widest stroke.
    half: f64,
}

/// Makes strokes bright and adds the distance to their edge; `None` without strokes.
fn raise(greys: &Heightfield, settings: &Sketch, job: &Job) -> Result<Option<Raised>> {
    let dark = match settings.strokes {
        Strokes::ByKind => settings.kind == Kind::Valley,
        Strokes::Bright => false,
        Strokes::Dark => true,
    };
    let mut background = if settings.find_background { most_frequent(greys) } else { settings.background };
    if dark {
        background = 1.0 - background;
    }
    let bright = |grey: f32| {
        let grey = f64::from(grey);
        match (grey.is_nan(), dark) {
            (true, _) => background,
            (false, true) => 1.0 - grey,
            (false, false) => grey,
        }
    };
    let least = settings.threshold * (1.0 - background);
    let strokes = greys.map::<Share>(job, |grey| f32::from(u8::from(bright(grey) - background > least)))?;
    // Pixels beyond the border are no edge, so that strokes may run off the sketch.
    let edges = distances(&strokes, |share| share < 0.5, job)?;
    // A sketch that is stroke all over has no edge anywhere, and no middle line either.
    let Some((_, half)) = edges.range().filter(|(_, half)| *half > 0.0) else { return Ok(None) };
    let half = f64::from(half);
    let field = Heightfield::build(greys.grid().clone(), job, |row, out| {
        for (col, out) in out.iter_mut().enumerate() {
            let edge = f64::from(edges.at(row, col));
            *out = (bright(greys.at(row, col)) + settings.edge_weight * edge / half) as f32;
        }
        Ok(())
    })?;
    let outside = distances(&strokes, |share| share >= 0.5, job)?;
    let mut signed = edges;
    signed.cells_mut().iter_mut().zip(outside.cells()).for_each(|(edge, outside)| *edge -= outside);
    Ok(Some(Raised { field, edges: signed, half }))
}

/// Mean of the greys in the fullest of 256 classes, the darkest of equals.
fn most_frequent(greys: &Heightfield) -> f64 {
    let mut classes = vec![(0_u64, 0.0_f64); 256];
    for &grey in greys.cells().iter().filter(|grey| !grey.is_nan()) {
        let class = &mut classes[((f64::from(grey) * 256.0) as usize).min(255)];
        class.0 += 1;
        class.1 += f64::from(grey);
    }
    let fullest = classes.iter().max_by(|a, b| a.0.cmp(&b.0)).map_or(0, |class| class.0);
    let class = classes.iter().find(|class| class.0 == fullest);
    class.map_or(0.0, |&(n, sum)| if n > 0 { sum / n as f64 } else { 0.0 })
}
