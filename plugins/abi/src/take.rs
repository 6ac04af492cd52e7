//! Values and parameters from views, with everything checked that can be.
//!
//! What cannot be checked is whether a pointer that is not null leads to as many items as its view says.

use std::{slice, sync::Arc};

use glam::DVec2;
use orograph_core::{
    CellSize, Column, FeatureKind, FeaturePoint, Features, Georef, Grid, Kind, Mesh, ParamValue, Patch,
    Placement, PointKind, Points, Polyline, Raster, Rgba, Table, Unit, Value,
};

use crate::types::*;

/// What is wrong with a view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Malformed(pub String);

type Result<T, E = Malformed> = std::result::Result<T, E>;

fn malformed<T>(what: impl Into<String>) -> Result<T> {
    Err(Malformed(what.into()))
}

/// What becomes of a raster's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// They are copied.
    Copied,
    /// They are read where they are: they must stay there for as long as the value and every clone of it lives.
    /// They are not looked through for contents that no value has, which [`check_cells`] does.
    Lent,
}

/// `count` items at `place`.
///
/// # Safety
/// Where `place` is not null, so many items must lie there for `'a`.
unsafe fn items<'a, T>(place: *const T, count: usize, what: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if place.is_null() {
        return malformed(format!("{what}: {count} items at a null pointer"));
    }
    if !place.is_aligned() {
        return malformed(format!("{what}: the pointer is not aligned"));
    }
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return malformed(format!("{what}: {count} items fit no memory"));
    }
    // SAFETY: not null, aligned, of a possible size; the caller vouches for the rest.
    Ok(unsafe { slice::from_raw_parts(place, count) })
}

/// The item at `place`.
///
/// # Safety
/// As [`items`] with a count of 1.
unsafe fn item<'a, T>(place: *const T, what: &str) -> Result<&'a T> {
    if place.is_null() {
        return malformed(format!("{what} is a null pointer"));
    }
    // SAFETY: as the caller vouches.
    match unsafe { items(place, 1, what) }? {
        [item, ..] => Ok(item),
        [] => malformed(format!("{what} is not there")),
    }
}

/// A struct that begins with its size.
///
/// # Safety
/// As [`item`], for as many bytes as the struct says that it has.
unsafe fn sized<'a, T>(place: *const T, what: &str) -> Result<&'a T> {
    // SAFETY: every sized struct begins with a `u32`.
    let said = *unsafe { item(place.cast::<u32>(), what) }? as usize;
    if said < size_of::<T>() {
        return malformed(format!("{what} says that it has {said} bytes, but needs {}", size_of::<T>()));
    }
    // SAFETY: as the caller vouches.
    unsafe { item(place, what) }
}

/// The text of a view.
///
/// # Errors
/// [`Malformed`] for a null pointer, an impossible length or bytes that are no UTF-8.
///
/// # Safety
/// Where the pointer is not null, `len` bytes must lie there for `'a`.
pub unsafe fn read_text<'a>(text: OrographText) -> Result<&'a str> {
    // SAFETY: as the caller vouches.
    let bytes = unsafe { items(text.data.cast::<u8>(), text.len, "a text") }?;
    std::str::from_utf8(bytes).map_err(|error| Malformed(format!("a text is no UTF-8: {error}")))
}

/// The parameter of a view, copied.
///
/// # Errors
/// [`Malformed`] for null pointers, impossible lengths and unknown kinds.
///
/// # Safety
/// The view's pointers, where they are not null, must lead to as many items as it says.
pub unsafe fn read_param(param: &OrographParam) -> Result<ParamValue> {
    // SAFETY: the kind says which member is set; the caller vouches for what it points to.
    unsafe {
        Ok(match param.kind {
            OROGRAPH_PARAM_NUMBER => ParamValue::Number(param.value.number),
            OROGRAPH_PARAM_INTEGER => ParamValue::Integer(param.value.integer),
            OROGRAPH_PARAM_BOOLEAN => ParamValue::Boolean(param.value.boolean != 0),
            OROGRAPH_PARAM_TEXT => ParamValue::Text(read_text(param.value.text)?.to_owned()),
            OROGRAPH_PARAM_CURVE => {
                let curve = param.value.curve;
                ParamValue::Curve(items(curve.points, curve.count, "a curve")?.to_vec())
            }
            OROGRAPH_PARAM_LINES => {
                let lines = param.value.lines;
                let lines = items(lines.lines, lines.count, "lines")?.iter();
                let vertices = lines.map(|line| Ok(items(line.vertices, line.count, "a line")?.to_vec()));
                ParamValue::Lines(vertices.collect::<Result<_>>()?)
            }
            other => return malformed(format!("no kind of parameter has the number {other}")),
        })
    }
}

/// The value of a view; everything but a raster's cells is copied.
///
/// # Errors
/// [`Malformed`] for null pointers, impossible lengths and sizes, and, in what is copied, contents that no value of
/// its type has.
///
/// # Safety
/// The view's pointers, where they are not null, must lead to as many items as it says; with [`Cells::Lent`] the
/// cells must stay for as long as the value and its clones live.
pub unsafe fn read_value(value: *const OrographValue, cells: Cells) -> Result<Value> {
    // SAFETY: the kind says which member is set; the caller vouches for what it points to.
    unsafe {
        let OrographValue { kind, data, .. } = item(value, "a value")?;
        let value = match *kind {
            OROGRAPH_HEIGHTFIELD => Value::Heightfield(Arc::new(raster(data.raster, cells)?)),
            OROGRAPH_MASK => Value::Mask(Arc::new(raster(data.raster, cells)?)),
            OROGRAPH_TEXTURE => Value::Texture(Arc::new(raster::<Rgba>(data.raster, cells)?)),
            OROGRAPH_FEATURES => Value::Features(Arc::new(features(data.features)?)),
            OROGRAPH_POINTS => Value::Points(Arc::new(points(data.points)?)),
            OROGRAPH_PLACEMENT => Value::Placement(Arc::new(placement(data.placement)?)),
            OROGRAPH_TABLE => Value::Table(Arc::new(table(data.table)?)),
            OROGRAPH_MESH => Value::Mesh(Arc::new(mesh(data.mesh)?)),
            OROGRAPH_NUMBER => Value::Number(data.number),
            OROGRAPH_INTEGER => Value::Integer(data.integer),
            OROGRAPH_BOOLEAN => Value::Boolean(data.boolean != 0),
            OROGRAPH_TEXT => Value::Text(read_text(data.text)?.into()),
            other => return malformed(format!("no kind of value has the number {other}")),
        };
        if cells == Cells::Copied {
            check_cells(&value)?;
        }
        Ok(value)
    }
}

unsafe fn grid(view: *const OrographGrid) -> Result<Grid> {
    // SAFETY: as the caller of `read_value` vouches.
    let view = unsafe { sized(view, "a grid") }?;
    let count = |n: u64| usize::try_from(n).map_err(|_| Malformed(format!("a grid of {n} rows or columns")));
    let cell = CellSize { x: view.cell_x, y: view.cell_y };
    let grid = Grid::new(count(view.rows)?, count(view.cols)?, cell);
    let mut grid = grid.map_err(|error| Malformed(error.to_string()))?;
    // So far from its base grid no position would be exact.
    const FAR: u64 = 1 << 40;
    if !(view.origin_x.is_finite() && view.origin_y.is_finite())
        || view.row0.unsigned_abs() > FAR
        || view.col0.unsigned_abs() > FAR
    {
        return malformed("a grid lies nowhere: its origin is not finite, or its base grid too far away");
    }
    (grid.row0, grid.col0) = (view.row0, view.col0);
    grid.origin = DVec2::new(view.origin_x, view.origin_y);
    if view.georeferenced != 0 {
        if !view.transform.iter().all(|x| x.is_finite()) {
            return malformed("a georeference's transform is not finite");
        }
        // SAFETY: as above.
        let crs = unsafe { read_text(view.crs) }?.to_owned();
        grid.georef = Some(Arc::new(Georef { transform: view.transform, crs }));
    }
    Ok(grid)
}

unsafe fn raster<K: Kind>(view: *const OrographRaster, keep: Cells) -> Result<Raster<K>> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "a raster")?;
        let grid = grid(view.grid)?;
        let cells: &'static [K::Cell] = items(view.cells.cast(), grid.len(), "a raster's cells")?;
        match keep {
            Cells::Lent => Raster::lent(grid, cells).map_err(|error| Malformed(error.to_string())),
            Cells::Copied => {
                let bytes = slice::from_raw_parts(cells.as_ptr().cast::<u8>(), size_of_val(cells));
                let (rows, cols) = grid.size();
                Raster::of_bytes(grid, bytes)
                    .ok_or_else(|| Malformed(format!("there is no memory for {rows} × {cols} cells")))
            }
        }
    }
}

/// Whether the cells of a raster are such as its type has.
///
/// # Errors
/// [`Malformed`] for an infinite height, or a share outside 0 to 1.
pub fn check_cells(value: &Value) -> Result<()> {
    match value {
        Value::Heightfield(raster) => match first(raster, f32::is_infinite) {
            Some((row, col, _)) => {
                malformed(format!("a height is infinite at row {row}, column {col}; a void is NaN"))
            }
            None => Ok(()),
        },
        Value::Mask(raster) => match first(raster, |share| !(0.0..=1.0).contains(&share)) {
            Some((row, col, share)) => {
                malformed(format!("a mask holds {share} at row {row}, column {col}, outside 0 to 1"))
            }
            None => Ok(()),
        },
        _ => Ok(()),
    }
}

/// The first cell that is `bad`: its row, column and content.
fn first<K: Kind<Cell = f32>>(raster: &Raster<K>, bad: impl Fn(f32) -> bool) -> Option<(usize, usize, f32)> {
    // Whole runs are looked at without stopping, which a compiler turns into wide instructions.
    const RUN: usize = 4096;
    let any = |run: &[f32]| run.iter().fold(false, |any, &cell| any | bad(cell));
    let run = raster.cells().chunks(RUN).position(any)?;
    let at = run * RUN + raster.cells()[run * RUN..].iter().position(|&cell| bad(cell))?;
    Some((at / raster.cols(), at % raster.cols(), raster.cells()[at]))
}

unsafe fn features(view: *const OrographFeatures) -> Result<Features> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "features")?;
        let point = |point: &OrographFeaturePoint| {
            let kind = match point.kind {
                OROGRAPH_BRANCH => PointKind::Branch,
                OROGRAPH_END => PointKind::End,
                OROGRAPH_PATH => PointKind::Path,
                other => return malformed(format!("no kind of point has the number {other}")),
            };
            Ok(FeaturePoint { row: point.row, col: point.col, height: point.height, kind })
        };
        let known = |index: u32| (index as usize) < view.point_count;
        let line = |line: &OrographLine| {
            if !known(line.from) || !known(line.to) {
                return malformed("a line joins points that there are not");
            }
            let wanted = line.vertex_count.checked_mul(view.profile_len as usize);
            if line.profile_count != 0 && wanted != Some(line.profile_count) {
                return malformed("a line has profiles of another length than `profile_len`");
            }
            Ok(Polyline {
                from: line.from,
                to: line.to,
                vertices: items(line.vertices, line.vertex_count, "a line's vertices")?.to_vec(),
                profiles: items(line.profiles, line.profile_count, "a line's profiles")?.to_vec(),
            })
        };
        let rings = items(view.rings, view.ring_count, "rings")?;
        if !rings.iter().flatten().all(|&index| known(index)) {
            return malformed("a ring joins points that there are not");
        }
        Ok(Features {
            grid: grid(view.grid)?,
            kind: match view.kind {
                OROGRAPH_RIDGES => FeatureKind::Ridge,
                OROGRAPH_VALLEYS => FeatureKind::Valley,
                other => return malformed(format!("no kind of features has the number {other}")),
            },
            points: items(view.points, view.point_count, "points")?
                .iter()
                .map(point)
                .collect::<Result<_>>()?,
            lines: items(view.lines, view.line_count, "lines")?.iter().map(line).collect::<Result<_>>()?,
            rings: rings.to_vec(),
            scale: view.scale,
            profile_len: view.profile_len,
            profile_step: view.profile_step,
        })
    }
}

unsafe fn points(view: *const OrographPoints) -> Result<Points> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "points")?;
        let column = |place, what| Ok(items(place, view.count, what)?.to_vec());
        Points::new(column(view.x, "x")?, column(view.y, "y")?, column(view.heights, "heights")?)
            .map_err(|error| Malformed(error.to_string()))
    }
}

unsafe fn placement(view: *const OrographPlacement) -> Result<Placement> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "a placement")?;
        let grid = grid(view.grid)?;
        let patch = |patch: &OrographPatch| {
            Ok(Patch {
                exemplar: patch.exemplar,
                source_center: patch.source_center,
                target_center: patch.target_center,
                size: patch.window,
                mirrored: patch.mirrored != 0,
                controls: items(patch.controls, patch.control_count, "a patch's controls")?.to_vec(),
                offset: patch.offset,
            })
        };
        let patches = items(view.patches, view.patch_count, "patches")?;
        let labels = items(view.labels, grid.len(), "a placement's labels")?;
        if labels.iter().any(|&label| label as usize > patches.len()) {
            return malformed("a placement's label names a patch that there is not");
        }
        let seams = items(view.seams, view.seam_count, "seams")?;
        if seams.iter().flatten().any(|&cell| cell as usize >= grid.len()) {
            return malformed("a seam names a cell that there is not");
        }
        Ok(Placement {
            scales: items(view.scales, view.scale_count, "scales")?.to_vec(),
            patches: patches.iter().map(patch).collect::<Result<_>>()?,
            labels: labels.to_vec(),
            sources: items(view.sources, grid.len(), "a placement's sources")?.to_vec(),
            seams: seams.to_vec(),
            grid,
        })
    }
}

unsafe fn table(view: *const OrographTable) -> Result<Table> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "a table")?;
        let column = |column: &OrographColumn| {
            let unit = read_text(column.unit)?;
            let Some(unit) = Unit::of_symbol(unit) else {
                return malformed(format!("no unit is written `{}`", unit.escape_debug()));
            };
            let cells = if column.texts.is_null() {
                orograph_core::Cells::Numbers(items(column.numbers, view.row_count, "a column")?.to_vec())
            } else {
                let texts = items(column.texts, view.row_count, "a column")?.iter();
                let texts = texts.map(|&text| Ok(read_text(text)?.to_owned()));
                orograph_core::Cells::Texts(texts.collect::<Result<_>>()?)
            };
            Ok(Column { name: read_text(column.name)?.to_owned(), unit, cells })
        };
        let columns = items(view.columns, view.column_count, "columns")?;
        Table::new(columns.iter().map(column).collect::<Result<_>>()?)
            .map_err(|error| Malformed(error.to_string()))
    }
}

unsafe fn mesh(view: *const OrographMesh) -> Result<Mesh> {
    // SAFETY: as the caller of `read_value` vouches.
    unsafe {
        let view = sized(view, "a mesh")?;
        let vertices = view.vertex_count;
        let present = |missing: bool| if missing { 0 } else { vertices };
        let triangles = items(view.triangles, view.triangle_count, "triangles")?;
        if triangles.iter().flatten().any(|&vertex| vertex as usize >= vertices) {
            return malformed("a triangle names a vertex that there is not");
        }
        Ok(Mesh {
            vertices: items(view.vertices, vertices, "vertices")?.to_vec(),
            triangles: triangles.to_vec(),
            normals: items(view.normals, present(view.normals.is_null()), "normals")?.to_vec(),
            uvs: items(view.uvs, present(view.uvs.is_null()), "texture coordinates")?.to_vec(),
        })
    }
}
