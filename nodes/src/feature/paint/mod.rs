//! Painting: everything that a hand draws over a map, as what synthesis takes it for.
//!
//! Zhou 2007 §6 draws ridges and valleys, assigns styles to regions and sets a mountain of one's own into the sketch
//! before the rest is made. All of it is kept as vectors here, so that a painting is the same at every resolution.

mod regions;

use glam::DVec2;
use orograph_core::{FeatureKind, Features, prelude::*};

use super::from_curves::trace;
use crate::{
    Ground,
    look::{
        canvas::Canvas,
        colour::{PAPER, Tint, blend},
        placement::tint,
    },
    mcmd::{
        extent::extent,
        sketch::{Coordinates, draw},
    },
    synthesis::stamp::{Laid, Stamp},
};

const RIDGE: Tint = [0xc8, 0x32, 0x1e, 0xff];
const VALLEY: Tint = [0x1e, 0x5a, 0xc8, 0xff];
const HEIGHT: Tint = [0x1e, 0x1e, 0x1e, 0xff];
const STAMP: Tint = [0x8c, 0x3c, 0xb4, 0xff];

/// Turns what is painted over a map into ridges, valleys, wanted heights, styles and stamps for
/// `synthesis.synthesise`.
///
/// The grid is that of `like`; unconnected, the settings say how much ground to cover. A picture lies under the painting
/// and changes none of it.
#[derive(Params, Clone, Debug)]
pub struct Paint {
    /// Ridges, as polylines of (x, y, height); heights say where a closed loop is opened.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "m")]
    pub ridges: Lines,
    /// Valleys, likewise.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "m")]
    pub valleys: Lines,
    /// Wanted heights, as polylines of (x, y, height in metres); one point alone is a spot height.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "m")]
    pub heights: Lines,
    /// Regions of a style, as outlines of (x, y, number of the style); later ones lie over earlier ones.
    #[param(default = Vec::new(), range = -1e9..=1e9)]
    pub regions: Lines,
    /// Where the stamp is set, as points of (x, y, degrees that it is turned clockwise); later ones lie over earlier ones.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "deg")]
    pub stamps: Lines,
    /// What x and y mean.
    #[param(default = Coordinates::Extent)]
    pub coordinates: Coordinates,
    /// Number of the style outside of all regions.
    #[param(default = 0u32, range = 0..=255, slider = 0..=8, unit = "1")]
    pub style: u32,
    /// How much larger a stamp becomes, in cells of the painting for one of its own.
    #[param(default = 1, range = 0.01..=100.0, slider = 0.25..=4.0, unit = "1")]
    pub stamp_scale: f64,
    /// Vertices of ridges or valleys nearer than this to each other or to a line become one with it.
    #[param(default = 1.5, range = 0.0..=64.0, slider = 0.0..=10.0, unit = "cells")]
    pub snap: f64,
    /// Smoothing passes over each ridge or valley, whose vertices are a cell apart.
    #[param(default = 2u32, range = 0..=1024, slider = 0..=100, unit = "1")]
    pub smooth_passes: u32,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

/// Inputs of [`Paint`].
#[derive(Inputs)]
pub struct PaintIn<'a> {
    /// Terrain whose grid is taken.
    pub like: Option<&'a Heightfield>,
    /// Picture to paint over, such as a scanned map; it is laid over the grid whatever its own size is.
    pub picture: Option<&'a Texture>,
    /// Piece of terrain that is set in where stamps are painted; its voids let through what is below.
    pub stamp: Option<&'a Heightfield>,
}

/// Outputs of [`Paint`].
#[derive(Outputs)]
pub struct PaintOut {
    /// The painting, over the picture or on white paper.
    pub picture: Texture,
    /// The ridges.
    pub ridges: Features,
    /// The valleys.
    pub valleys: Features,
    /// Wanted heights; all other cells are voids.
    pub constraints: Heightfield,
    /// Number of the style at each cell.
    pub styles: Heightfield,
    /// The stamps; all other cells are voids.
    pub given: Heightfield,
}

impl Node for Paint {
    const ID: &'static str = "feature.paint";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = PaintIn<'a>;
    type Outputs = PaintOut;

    fn run(&self, inputs: PaintIn<'_>, job: &Job) -> Result<PaintOut> {
        job.check()?;
        let grid = match inputs.like {
            Some(like) => like.grid().clone(),
            None => extent(&self.ground, job)?,
        };
        let mut constraints = Heightfield::filled(grid.clone(), f32::NAN, job)?;
        draw(&self.heights, self.coordinates, &mut constraints, job)?;
        let outlines = self.placed(&self.regions, &grid);
        if outlines.iter().any(|outline| outline.len() < 3) {
            job.warn("a region of fewer than three places covers nothing");
        }
        let styles = regions::fill(&outlines, self.style as f32, &grid, job)?;
        let given = self.stamped(inputs.stamp, &grid, job)?;
        let ridges = self.traced(&self.ridges, FeatureKind::Ridge, &grid, job)?;
        let valleys = self.traced(&self.valleys, FeatureKind::Valley, &grid, job)?;
        let picture = self.painted(inputs.picture, &styles, &given, job)?;
        Ok(PaintOut { picture, ridges, valleys, constraints, styles, given })
    }
}

impl Paint {
    /// Lines as (row, column, third number).
    fn placed(&self, lines: &Lines, grid: &Grid) -> Vec<Vec<[f64; 3]>> {
        let place = |point: &[f64; 3]| {
            let (row, col) = self.coordinates.locate(grid, point);
            [row, col, point[2]]
        };
        lines.0.iter().map(|line| line.iter().map(place).collect()).collect()
    }

    fn traced(&self, lines: &Lines, kind: FeatureKind, grid: &Grid, job: &Job) -> Result<Features> {
        trace(&self.placed(lines, grid), grid.clone(), kind, self.snap, self.smooth_passes, job)
    }

    fn stamped(&self, stamp: Option<&Heightfield>, grid: &Grid, job: &Job) -> Result<Heightfield> {
        let places = self.placed(&self.stamps, grid);
        let Some(stamp) = stamp else {
            if !places.is_empty() {
                job.warn("stamps are painted, but no terrain is wired to `stamp`");
            }
            return Heightfield::filled(grid.clone(), f32::NAN, job);
        };
        let (rows, cols) = grid.size();
        let lay = |&[row, col, turn]: &[f64; 3]| {
            let (across, down) = ((col + 0.5) / cols as f64, (row + 0.5) / rows as f64);
            let settings = Stamp { across, down, turn, scale: self.stamp_scale, ..Stamp::default() };
            Laid::new(&settings, grid, stamp, None)
        };
        // The last one lies on top.
        let laid: Vec<_> = places.iter().flatten().rev().map(lay).collect();
        Heightfield::build(grid.clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let shown = laid.iter().map(|stamp| stamp.at(row, col)).find(|(_, share)| *share > 0.0);
                *out = shown.map_or(f32::NAN, |(height, _)| height);
            }
            job.check()
        })
    }

    fn painted(
        &self,
        under: Option<&Texture>,
        styles: &Heightfield,
        given: &Heightfield,
        job: &Job,
    ) -> Result<Texture> {
        let grid = styles.grid();
        let (rows, cols) = grid.size();
        let ground = Texture::build(grid.clone(), job, |row, out| {
            let over = |at: usize, n: usize, all: usize| ((at as f64 + 0.5) * n as f64 / all as f64) as usize;
            for (col, out) in out.iter_mut().enumerate() {
                *out = match under.filter(|picture| !picture.grid().is_empty()) {
                    Some(picture) => picture.at(
                        over(row, picture.rows(), rows).min(picture.rows() - 1),
                        over(col, picture.cols(), cols).min(picture.cols() - 1),
                    ),
                    None => PAPER,
                };
                let style = styles.at(row, col);
                if style != self.style as f32 {
                    *out = blend(*out, tint(style as u32 + 1), 0.45);
                }
                if !given.at(row, col).is_nan() {
                    *out = blend(*out, STAMP, 0.35);
                }
            }
            job.check()
        })?;
        let mut canvas = Canvas::on(grid.clone(), PAPER, job)?;
        canvas.paste(&ground, 0, 0);
        let width = (rows.max(cols) as f64 / 320.0).max(1.5);
        let layers = [
            (&self.regions, HEIGHT, true),
            (&self.valleys, VALLEY, false),
            (&self.ridges, RIDGE, false),
            (&self.heights, HEIGHT, false),
            (&self.stamps, STAMP, false),
        ];
        for (lines, ink, closed) in layers {
            for line in self.placed(lines, grid) {
                job.check()?;
                let spots: Vec<DVec2> = line.iter().map(|point| DVec2::new(point[1], point[0])).collect();
                let end = spots.first().copied().filter(|_| closed);
                for pair in spots.iter().copied().chain(end).collect::<Vec<_>>().windows(2) {
                    canvas.line(pair[0], pair[1], width, ink);
                }
                if let [only] = spots[..] {
                    canvas.disc(only, 1.5 * width, ink);
                }
            }
        }
        Ok(canvas.into_picture())
    }
}

#[cfg(test)]
mod tests;
