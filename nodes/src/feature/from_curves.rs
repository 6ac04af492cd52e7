//! From curves: ridges or valleys from polylines, without a picture.
//!
//! Curves are drawn by hand, so they miss each other a little: vertices nearer than the snapping distance become one,
//! lines are split where they cross and where a vertex lies on them. Features are a forest; closed loops are opened
//! where they are least important, at the lowest place (for valleys the highest), and of equals at the one furthest
//! from any junction, and the gap, a cell wide, is remembered as a ring.

use orograph_core::{FeaturePoint, PointKind, Polyline, prelude::*};

use super::{
    chains::{resample, smooth},
    curves::Mesh,
    forest::Frame,
    lattice::Blocks,
    rings,
    settings::{Kind, Shaping},
};
use crate::{
    Ground,
    mcmd::{extent::extent, sketch::Coordinates},
};

/// Turns drawn polylines into ridges or valleys.
///
/// The grid is that of `like`; unconnected, the settings say how much ground to cover.
#[derive(Params, Clone, Debug)]
pub struct FromCurves {
    /// Polylines of (x, y, height); heights say where a closed loop is opened.
    #[param(default = Vec::new(), range = -1e9..=1e9, unit = "m")]
    pub lines: Lines,
    /// What x and y mean.
    #[param(default = Coordinates::Extent)]
    pub coordinates: Coordinates,
    /// Ridges or valleys.
    #[param(default = Kind::Ridge)]
    pub kind: Kind,
    /// Vertices nearer than this to each other or to a line become one with it.
    #[param(default = 1.5, range = 0.0..=64.0, slider = 0.0..=10.0, unit = "cells")]
    pub snap: f64,
    /// Smoothing passes over each line, whose vertices are a cell apart.
    #[param(default = 2u32, range = 0..=1024, slider = 0..=100, unit = "1")]
    pub smooth_passes: u32,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

/// Inputs of [`FromCurves`].
#[derive(Inputs)]
pub struct FromCurvesIn<'a> {
    /// Terrain whose grid is taken.
    pub like: Option<&'a Heightfield>,
    /// Places in the world that are joined, in their order, to one more line.
    pub points: Option<&'a Points>,
}

/// Outputs of [`FromCurves`].
#[derive(Outputs)]
pub struct FromCurvesOut {
    /// The ridges or valleys drawn.
    pub features: Features,
}

impl Node for FromCurves {
    const ID: &'static str = "feature.from_curves";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Resolution];
    type Inputs<'a> = FromCurvesIn<'a>;
    type Outputs = FromCurvesOut;

    fn run(&self, inputs: FromCurvesIn<'_>, job: &Job) -> Result<FromCurvesOut> {
        job.check()?;
        let grid = match inputs.like {
            Some(like) => like.grid().clone(),
            None => extent(&self.ground, job)?,
        };
        let mut curves: Vec<Vec<[f64; 3]>> = Vec::new();
        for line in &self.lines.0 {
            let place = |point: &[f64; 3]| {
                let (row, col) = self.coordinates.locate(&grid, point);
                [row, col, point[2]]
            };
            curves.push(line.iter().map(place).collect());
        }
        if let Some(points) = inputs.points {
            let place = |(x, y, height): (f64, f64, f64)| {
                let (row, col) = grid.locate([x, y].into());
                [row, col, height]
            };
            curves.push(points.iter().map(place).collect());
        }
        let features = trace(&curves, grid, self.kind.into(), self.snap, self.smooth_passes, job)?;
        if features.lines.is_empty() {
            job.warn("there is no curve of two places or more");
        }
        Ok(FromCurvesOut { features })
    }
}

/// The features of curves of (row, column, height), vertices a cell apart.
///
/// # Errors
/// [`Error::Invalid`] for a place that is no number; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn trace(
    curves: &[Vec<[f64; 3]>],
    grid: Grid,
    kind: FeatureKind,
    snap: f64,
    smooth_passes: u32,
    job: &Job,
) -> Result<Features> {
    let mut mesh = Mesh::new(curves, snap, job)?;
    mesh.densify(1.0, job)?;
    mesh.break_loops(kind == FeatureKind::Ridge);
    let blocks = Blocks { down: 1, across: 1 };
    let mut features = Frame { grid: &grid, blocks, heights: &[], kind }.features(Vec::new(), Vec::new());
    let degrees = mesh.degrees();
    let mut ids = vec![u32::MAX; degrees.len()];
    for (node, &degree) in degrees.iter().enumerate().filter(|(_, degree)| !matches!(degree, 0 | 2)) {
        ids[node] = features.points.len() as u32;
        let [row, col, height] = mesh.places[node];
        let kind = if degree == 1 { PointKind::End } else { PointKind::Branch };
        features.points.push(FeaturePoint { row, col, height: height as f32, kind });
    }
    for chain in mesh.chains() {
        job.check()?;
        let mut path: Vec<[f64; 2]> =
            chain.iter().map(|&node| [mesh.places[node][0], mesh.places[node][1]]).collect();
        smooth(&mut path, smooth_passes);
        let (from, to) = (ids[chain[0]], ids[chain[chain.len() - 1]]);
        features.lines.push(Polyline { from, to, vertices: resample(&path, 1.0), profiles: Vec::new() });
    }
    features.rings = rings::close(&features, blocks, &Shaping::default());
    Ok(features)
}
