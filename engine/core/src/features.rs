//! Ridge and valley networks: a forest of points joined by polylines, with height profiles across them.

use serde::{Deserialize, Serialize};

use crate::Grid;

/// Whether the lines are crests or talwegs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FeatureKind {
    /// Crests.
    Ridge,
    /// Talwegs.
    Valley,
}

/// The role of a point in the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PointKind {
    /// Three or more lines meet.
    Branch,
    /// One line ends.
    End,
    /// A point along a line.
    Path,
}

/// A node of the network.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeaturePoint {
    /// Fractional row.
    pub row: f64,
    /// Fractional column.
    pub col: f64,
    /// Height in metres.
    pub height: f32,
    /// Its role.
    pub kind: PointKind,
}

/// A line between two points of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polyline {
    /// Index of the point where it starts.
    pub from: u32,
    /// Index of the point where it ends.
    pub to: u32,
    /// Fractional (row, column) of its vertices, both ends included.
    pub vertices: Vec<[f64; 2]>,
    /// Heights across the line at each vertex, [`Features::profile_len`] apiece; empty when not taken.
    pub profiles: Vec<f32>,
}

/// A forest of ridges or valleys on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Features {
    /// The grid that rows and columns refer to.
    pub grid: Grid,
    /// Crests or talwegs.
    pub kind: FeatureKind,
    /// The points.
    pub points: Vec<FeaturePoint>,
    /// The lines between them.
    pub lines: Vec<Polyline>,
    /// Pairs of end points that face each other where a closed ring was opened to make the network a forest.
    pub rings: Vec<[u32; 2]>,
    /// Side, in cells of the grid, of the working cells that the lines were found on.
    pub scale: f64,
    /// Samples in each profile.
    pub profile_len: u32,
    /// Distance in cells between samples of a profile.
    pub profile_step: f64,
}
