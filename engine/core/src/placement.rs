//! Which patch went where: enough to replay a synthesis on another layer of the exemplar.

use serde::{Deserialize, Serialize};

use crate::Grid;

/// One pasted patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// Which exemplar it came from.
    pub exemplar: u32,
    /// Row and column of its centre in the exemplar.
    pub source_center: [f64; 2],
    /// Row and column of its centre in the output.
    pub target_center: [f64; 2],
    /// Side of its square window, in cells.
    pub size: u32,
    /// Whether the source is reflected in x.
    pub mirrored: bool,
    /// Control points (target row, target column, source row, source column) of its warp.
    pub controls: Vec<[f64; 4]>,
    /// Added to the source's heights, in metres.
    pub offset: f64,
}

/// The provenance of a synthesised raster.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// The grid of the output.
    pub grid: Grid,
    /// For each exemplar how many rows and columns synthesis made of one of its own, when it made its cells square.
    pub scales: Vec<[f64; 2]>,
    /// The patches in the order in which they were pasted.
    pub patches: Vec<Patch>,
    /// Per cell, row-major: index of its patch plus one, 0 for none.
    pub labels: Vec<u32>,
    /// Per cell, row-major: row and column in the exemplar, in the cells that synthesis made of it.
    pub sources: Vec<[f32; 2]>,
    /// Cut edges: indices of the two adjacent cells.
    pub seams: Vec<[u32; 2]>,
}
