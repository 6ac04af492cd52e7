//! From sketch: what a drawing says about ridges or valleys, in one node.

use orograph_core::prelude::*;

use super::{
    chains::shape,
    forest::Frame,
    lattice::Blocks,
    loops, medial,
    ppa::{Found, forest},
    settings::{Kind, Steps, crest},
    sketch::{NO_STROKE, Prepared, Sketch, Strokes, prepare},
};
use crate::{
    PatchSize,
    transform::resize::{Method, resize},
};

/// Finds the ridges or valleys that a sketch shows: the middle lines of its strokes, whatever their width.
///
/// `feature.sketch` and `feature.ppa` in one, with parameters that suit the strokes, and lines moved onto the middle. A sketch without strokes gives no
/// lines and a remark.
#[derive(Params, Clone, Debug)]
pub struct FromSketch {
    /// Ridges or valleys.
    #[param(default = Kind::Ridge)]
    pub kind: Kind,
    /// Which pixels are strokes.
    #[param(default = Strokes::ByKind)]
    pub strokes: Strokes,
    /// Cells along the longer side of the result; 0 takes a cell for each pixel.
    #[param(default = 0u32, range = 0..=65_536, slider = 0..=4096, unit = "cells")]
    pub cells: u32,
    /// How far from the background towards the strokes' full strength a pixel must be to count as stroke.
    #[param(default = 0.5, range = 0.05..=0.95, unit = "1")]
    pub threshold: f64,
    /// The patches that the lines are for: they set over what length a line's end points somewhere.
    #[param(flatten)]
    pub patches: PatchSize,
    /// Smoothing passes over each line.
    #[param(default = 2u32, range = 0..=32, slider = 0..=10, unit = "1")]
    pub smooth_passes: u32,
}

/// Inputs of [`FromSketch`].
#[derive(Inputs)]
pub struct FromSketchIn<'a> {
    /// The sketch; its heights are brightness of any range, voids are background.
    pub sketch: &'a Heightfield,
}

/// Outputs of [`FromSketch`].
#[derive(Outputs)]
pub struct FromSketchOut {
    /// The ridges or valleys drawn.
    pub features: Features,
}

impl Node for FromSketch {
    const ID: &'static str = "feature.from_sketch";
    const VERSION: u32 = 2; // 2 keeps rings whole, and lines where they are when junctions become one
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FromSketchIn<'a>;
    type Outputs = FromSketchOut;

    fn cost(&self) -> f64 {
        25.0
    }

    fn run(&self, inputs: FromSketchIn<'_>, job: &Job) -> Result<FromSketchOut> {
        let resized;
        let mut sketch = inputs.sketch;
        let (rows, cols) = sketch.grid().size();
        let longer = rows.max(cols);
        if self.cells > 0 && longer > 0 && longer != self.cells as usize {
            let side =
                |n: usize| ((n as f64 * f64::from(self.cells) / longer as f64).round() as usize).max(1);
            resized = resize(sketch, side(rows), side(cols), Method::Bilinear, job)?;
            sketch = &resized;
        }
        let preparation =
            Sketch { kind: self.kind, strokes: self.strokes, threshold: self.threshold, ..Sketch::default() };
        let Some(prepared) = prepare(sketch, &preparation, job)? else {
            job.warn(NO_STROKE);
            let blocks = Blocks { down: 1, across: 1 };
            let frame = Frame { grid: sketch.grid(), blocks, heights: &[], kind: self.kind.into() };
            return Ok(FromSketchOut { features: frame.features(Vec::new(), Vec::new()) });
        };
        let found = trace(&prepared, sketch.grid(), self.patches.side(), self.smooth_passes, job)?;
        if found.features.lines.is_empty() {
            job.warn("the strokes are too short to show a line");
        }
        Ok(FromSketchOut { features: found.features })
    }
}

/// The lines of a prepared sketch on its grid of pixels. Heights are those of the prepared field,
/// negative for valleys.
///
/// # Errors
/// [`Error::BadSize`] for a sketch that shrinking leaves less than 3 × 3 blocks; [`Error::TooLarge`];
/// [`Error::Cancelled`].
pub fn trace(prepared: &Prepared, grid: &Grid, patch: usize, smooth_passes: u32, job: &Job) -> Result<Found> {
    let steps = prepared.steps();
    // The prepared field has strokes as crests whatever they stand for.
    let upright = Steps { kind: FeatureKind::Ridge, ..steps };
    let raw = forest(&prepared.field, Blocks { down: 1, across: 1 }, &upright, job)?;
    let blocks = Blocks { down: prepared.shrink, across: prepared.shrink };
    let heights: Vec<f32> = raw.heights.iter().map(|&height| crest(height, steps.kind)).collect();
    let frame = Frame { grid, blocks, heights: &heights, kind: steps.kind };
    let mut shaping = prepared.shaping(patch);
    shaping.joining.smooth_passes = smooth_passes;
    let mut features = shape(&raw.forest, &frame, &shaping, job)?;
    medial::centre(&mut features, &prepared.edges, blocks, &shaping, job)?;
    loops::close(&mut features, &prepared.edges, prepared.width, &shaping, job)?;
    Ok(Found { features, drop: raw.drop, share: raw.share })
}
