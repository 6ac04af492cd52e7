//! Views of values and parameters.
//!
//! Every view is borrowed: what a view of an input or parameter points to stays in place and unchanged until
//! `run` returns, and may be read by any thread of the plugin until then. What a view of an output points to
//! is copied before `output` returns.

use std::ffi::{c_char, c_void};

/// The major version: a host refuses a plugin of another one.
pub const OROGRAPH_ABI_MAJOR: u32 = 1;
/// The minor version: rises with every addition.
pub const OROGRAPH_ABI_MINOR: u32 = 0;

/// Heights in metres on a grid, `float`; NaN is a void. See `OrographData.raster`.
pub const OROGRAPH_HEIGHTFIELD: i32 = 0;
/// Shares from 0 to 1 on a grid, `float`. See `OrographData.raster`.
pub const OROGRAPH_MASK: i32 = 1;
/// Colours on a grid: red, green, blue and alpha, a byte each, sRGB. See `OrographData.raster`.
pub const OROGRAPH_TEXTURE: i32 = 2;
/// Ridges or valleys. See `OrographData.features`.
pub const OROGRAPH_FEATURES: i32 = 3;
/// Scattered heights. See `OrographData.points`.
pub const OROGRAPH_POINTS: i32 = 4;
/// Provenance of a synthesis. See `OrographData.placement`.
pub const OROGRAPH_PLACEMENT: i32 = 5;
/// Named metrics. See `OrographData.table`.
pub const OROGRAPH_TABLE: i32 = 6;
/// Triangles. See `OrographData.mesh`.
pub const OROGRAPH_MESH: i32 = 7;
/// A number. See `OrographData.number`.
pub const OROGRAPH_NUMBER: i32 = 8;
/// An integer. See `OrographData.integer`.
pub const OROGRAPH_INTEGER: i32 = 9;
/// True or false. See `OrographData.boolean`.
pub const OROGRAPH_BOOLEAN: i32 = 10;
/// Text; also how a choice travels. See `OrographData.text`.
pub const OROGRAPH_TEXT: i32 = 11;

/// A parameter that is a number. See `OrographSetting.number`.
pub const OROGRAPH_PARAM_NUMBER: i32 = 0;
/// A parameter that is an integer. See `OrographSetting.integer`.
pub const OROGRAPH_PARAM_INTEGER: i32 = 1;
/// A parameter that is true or false. See `OrographSetting.boolean`.
pub const OROGRAPH_PARAM_BOOLEAN: i32 = 2;
/// A parameter that is text: free text, the name of a choice's option, or a file's name as the graph writes it.
/// See `OrographSetting.text`.
pub const OROGRAPH_PARAM_TEXT: i32 = 3;
/// A parameter that is a curve through points. See `OrographSetting.curve`.
pub const OROGRAPH_PARAM_CURVE: i32 = 4;
/// A parameter that is a set of polylines. See `OrographSetting.lines`.
pub const OROGRAPH_PARAM_LINES: i32 = 5;

/// The features are crests.
pub const OROGRAPH_RIDGES: i32 = 0;
/// The features are talwegs.
pub const OROGRAPH_VALLEYS: i32 = 1;

/// Three or more lines meet at the point.
pub const OROGRAPH_BRANCH: i32 = 0;
/// One line ends at the point.
pub const OROGRAPH_END: i32 = 1;
/// The point lies along a line.
pub const OROGRAPH_PATH: i32 = 2;

/// UTF-8 text of `len` bytes. It is not terminated, and `data` may be null where `len` is 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographText {
    /// Its first byte.
    pub data: *const c_char,
    /// Its bytes.
    pub len: usize,
}

/// The cells of a raster and their place in the world. Rows run from north to south, columns from west to east.
///
/// To give a raster on the grid of an input, hand back that input's own `grid` pointer.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographGrid {
    /// `sizeof(OrographGrid)`.
    pub size: u32,
    /// 1 when `transform` and `crs` hold a georeference, 0 when there is none.
    pub georeferenced: u32,
    /// Number of rows.
    pub rows: u64,
    /// Number of columns.
    pub cols: u64,
    /// Row of the base grid that is this grid's row 0: a crop keeps its base grid.
    pub row0: i64,
    /// Column of the base grid that is this grid's column 0.
    pub col0: i64,
    /// Metres from one column to the next.
    pub cell_x: f64,
    /// Metres from one row to the next; cells need not be square.
    pub cell_y: f64,
    /// World x (east) of the centre of the base grid's first cell, in metres.
    pub origin_x: f64,
    /// World y (north) of the centre of the base grid's first cell, in metres.
    pub origin_y: f64,
    /// Affine transform from (column, row) of the base grid's cell corners to the coordinate system:
    /// `x = t[0] + t[1] col + t[2] row`, `y = t[3] + t[4] col + t[5] row`.
    pub transform: [f64; 6],
    /// The coordinate reference system: `EPSG:n`, or the source's own text.
    pub crs: OrographText,
}

/// One value for each cell of a grid, row by row, without gaps.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographRaster {
    /// `sizeof(OrographRaster)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Where the cells lie.
    pub grid: *const OrographGrid,
    /// `rows * cols` cells: `float` in a heightfield or a mask, 4 bytes in a texture. Null when there is none.
    pub cells: *const c_void,
}

/// A point of a network of features.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographFeaturePoint {
    /// Fractional row.
    pub row: f64,
    /// Fractional column.
    pub col: f64,
    /// Height in metres.
    pub height: f32,
    /// `OROGRAPH_BRANCH`, `OROGRAPH_END` or `OROGRAPH_PATH`.
    pub kind: i32,
}

/// A line between two points of a network.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographLine {
    /// Index of the point where it starts.
    pub from: u32,
    /// Index of the point where it ends.
    pub to: u32,
    /// Number of vertices, both ends included.
    pub vertex_count: usize,
    /// Fractional (row, column) of the vertices.
    pub vertices: *const [f64; 2],
    /// Number of profile samples: `vertex_count * profile_len`, or 0 when there are none.
    pub profile_count: usize,
    /// Heights across the line, `profile_len` for each vertex.
    pub profiles: *const f32,
}

/// A forest of ridges or valleys on a grid.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographFeatures {
    /// `sizeof(OrographFeatures)`.
    pub size: u32,
    /// `OROGRAPH_RIDGES` or `OROGRAPH_VALLEYS`.
    pub kind: i32,
    /// The grid that rows and columns refer to.
    pub grid: *const OrographGrid,
    /// Number of points.
    pub point_count: usize,
    /// The points.
    pub points: *const OrographFeaturePoint,
    /// Number of lines.
    pub line_count: usize,
    /// The lines between the points.
    pub lines: *const OrographLine,
    /// Number of rings.
    pub ring_count: usize,
    /// Pairs of end points that face each other where a closed ring was opened.
    pub rings: *const [u32; 2],
    /// Side, in cells of the grid, of the working cells that the lines were found on.
    pub scale: f64,
    /// Distance in cells between samples of a profile.
    pub profile_step: f64,
    /// Samples in each profile.
    pub profile_len: u32,
    /// 0.
    pub reserved: u32,
}

/// Scattered heights.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographPoints {
    /// `sizeof(OrographPoints)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Number of points.
    pub count: usize,
    /// World x of each, in metres.
    pub x: *const f64,
    /// World y of each, in metres.
    pub y: *const f64,
    /// Height of each, in metres.
    pub heights: *const f64,
}

/// One pasted patch of a synthesis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographPatch {
    /// Which exemplar it came from.
    pub exemplar: u32,
    /// Side of its square window, in cells.
    pub window: u32,
    /// 1 when the source is reflected in x, else 0.
    pub mirrored: u32,
    /// 0.
    pub reserved: u32,
    /// Row and column of its centre in the exemplar.
    pub source_center: [f64; 2],
    /// Row and column of its centre in the output.
    pub target_center: [f64; 2],
    /// Added to the source's heights, in metres.
    pub offset: f64,
    /// Number of control points.
    pub control_count: usize,
    /// Control points (target row, target column, source row, source column) of its warp.
    pub controls: *const [f64; 4],
}

/// Which patch went where.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographPlacement {
    /// `sizeof(OrographPlacement)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The grid of the output.
    pub grid: *const OrographGrid,
    /// Number of exemplars.
    pub scale_count: usize,
    /// For each exemplar how many rows and columns synthesis made of one of its own.
    pub scales: *const [f64; 2],
    /// Number of patches.
    pub patch_count: usize,
    /// The patches in the order in which they were pasted.
    pub patches: *const OrographPatch,
    /// Per cell: index of its patch plus one, 0 for none.
    pub labels: *const u32,
    /// Per cell: row and column in the exemplar.
    pub sources: *const [f32; 2],
    /// Number of cut edges.
    pub seam_count: usize,
    /// Cut edges: indices of the two adjacent cells.
    pub seams: *const [u32; 2],
}

/// A column of a table: numbers or texts, the other pointer being null.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographColumn {
    /// Its name, in snake case.
    pub name: OrographText,
    /// The unit of its numbers: `1`, `m`, `deg`, `cells`, `px`, `%`, `seed`, `m/m`, `1/m`, `m2`, `B` or `s`.
    pub unit: OrographText,
    /// One number for each row, NaN for none; or null.
    pub numbers: *const f64,
    /// One text for each row; or null.
    pub texts: *const OrographText,
}

/// Named columns of equal length.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographTable {
    /// `sizeof(OrographTable)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Number of columns.
    pub column_count: usize,
    /// Number of rows.
    pub row_count: usize,
    /// The columns.
    pub columns: *const OrographColumn,
}

/// A triangle mesh in metres, x east, y north, z up.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographMesh {
    /// `sizeof(OrographMesh)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Positions.
    pub vertices: *const [f32; 3],
    /// Unit normals, one for each vertex, or null.
    pub normals: *const [f32; 3],
    /// Texture coordinates from 0 to 1, one for each vertex, or null.
    pub uvs: *const [f32; 2],
    /// Number of triangles.
    pub triangle_count: usize,
    /// Vertex indices, counter-clockwise seen from above.
    pub triangles: *const [u32; 3],
}

/// What a value is: the member that goes with its kind.
#[repr(C)]
#[derive(Clone, Copy)]
pub union OrographData {
    /// Of a heightfield, a mask or a texture.
    pub raster: *const OrographRaster,
    /// Of features.
    pub features: *const OrographFeatures,
    /// Of points.
    pub points: *const OrographPoints,
    /// Of a placement.
    pub placement: *const OrographPlacement,
    /// Of a table.
    pub table: *const OrographTable,
    /// Of a mesh.
    pub mesh: *const OrographMesh,
    /// Of a number.
    pub number: f64,
    /// Of an integer.
    pub integer: i64,
    /// Of a boolean: 0 is false, everything else true.
    pub boolean: i32,
    /// Of text.
    pub text: OrographText,
}

/// A value on a wire.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OrographValue {
    /// `OROGRAPH_HEIGHTFIELD` to `OROGRAPH_TEXT`.
    pub kind: i32,
    /// 0.
    pub reserved: u32,
    /// The value.
    pub data: OrographData,
}

/// What is connected to an input port.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographInput {
    /// Number of wires: 1, 0 where an optional port is not connected, any number at a port that takes many.
    pub count: usize,
    /// The values on them.
    pub values: *const OrographValue,
}

/// Points of a curve.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographCurve {
    /// Number of points, at least one.
    pub count: usize,
    /// The points (x, y), x ascending.
    pub points: *const [f64; 2],
}

/// A polyline.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographPolyline {
    /// Number of vertices.
    pub count: usize,
    /// Vertices (x, y, height).
    pub vertices: *const [f64; 3],
}

/// A set of polylines.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographLines {
    /// Number of polylines.
    pub count: usize,
    /// The polylines.
    pub lines: *const OrographPolyline,
}

/// What a parameter is set to: the member that goes with its kind.
#[repr(C)]
#[derive(Clone, Copy)]
pub union OrographSetting {
    /// Of a number, within its hard range.
    pub number: f64,
    /// Of an integer, within its hard range.
    pub integer: i64,
    /// Of a boolean: 0 or 1.
    pub boolean: i32,
    /// Of text, an option or a file's name.
    pub text: OrographText,
    /// Of a curve.
    pub curve: OrographCurve,
    /// Of lines.
    pub lines: OrographLines,
}

/// A parameter's value.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OrographParam {
    /// `OROGRAPH_PARAM_NUMBER` to `OROGRAPH_PARAM_LINES`, as the spec says.
    pub kind: i32,
    /// 0.
    pub reserved: u32,
    /// The value.
    pub value: OrographSetting,
}
