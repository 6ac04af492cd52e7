//! Values and parameters as borrowed views.

use std::{any::Any, ffi::c_void, marker::PhantomData, ptr};

use orograph_core::{
    Cells, FeatureKind, Features, Grid, Kind, Mesh, ParamValue, Placement, PointKind, Points, Raster, Slot,
    Table, Value,
};

use crate::types::*;

/// Keeps what views point to. The views are good for as long as it is; the values lent through it outlive it.
///
/// Cells, coordinates and other plain columns are lent in place; only what Rust lays out in its own way is copied.
#[derive(Default)]
pub struct Lender<'a> {
    // Moving a vector does not move what it holds.
    kept: Vec<Box<dyn Any + Send + Sync>>,
    lent: PhantomData<&'a ()>,
}

/// Pointers into boxes that are kept beside them, and read alone.
struct Kept<T>(T);
// SAFETY: what the pointers inside lead to is never written while a lender lives.
unsafe impl<T> Send for Kept<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for Kept<T> {}

impl<'a> Lender<'a> {
    /// A lender that has lent nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn keep<T: 'static>(&mut self, item: T) -> *const T {
        self.keep_all(vec![item])
    }

    fn keep_all<T: 'static>(&mut self, items: Vec<T>) -> *const T {
        let place = items.as_ptr();
        self.kept.push(Box::new(Kept(items)));
        place
    }

    /// Input ports.
    pub fn inputs(&mut self, slots: &'a [Slot]) -> Vec<OrographInput> {
        slots
            .iter()
            .map(|slot| {
                let values: &'a [Value] = match slot {
                    Slot::Empty => &[],
                    Slot::One(value) => std::slice::from_ref(value),
                    Slot::Many(values) => values,
                };
                let views: Vec<_> = values.iter().map(|value| self.value(value)).collect();
                OrographInput { count: views.len(), values: self.keep_all(views) }
            })
            .collect()
    }

    /// A value.
    pub fn value(&mut self, value: &'a Value) -> OrographValue {
        let of = |kind, data| OrographValue { kind, reserved: 0, data };
        match value {
            Value::Heightfield(raster) => of(OROGRAPH_HEIGHTFIELD, self.raster(raster)),
            Value::Mask(raster) => of(OROGRAPH_MASK, self.raster(raster)),
            Value::Texture(raster) => of(OROGRAPH_TEXTURE, self.raster(raster)),
            Value::Features(features) => {
                let features = self.features(features);
                of(OROGRAPH_FEATURES, OrographData { features: self.keep(features) })
            }
            Value::Points(points) => {
                let points = self.points(points);
                of(OROGRAPH_POINTS, OrographData { points: self.keep(points) })
            }
            Value::Placement(placement) => {
                let placement = self.placement(placement);
                of(OROGRAPH_PLACEMENT, OrographData { placement: self.keep(placement) })
            }
            Value::Table(table) => {
                let table = self.table(table);
                of(OROGRAPH_TABLE, OrographData { table: self.keep(table) })
            }
            Value::Mesh(mesh) => of(OROGRAPH_MESH, OrographData { mesh: self.keep(mesh_view(mesh)) }),
            Value::Number(number) => of(OROGRAPH_NUMBER, OrographData { number: *number }),
            Value::Integer(integer) => of(OROGRAPH_INTEGER, OrographData { integer: *integer }),
            Value::Boolean(boolean) => of(OROGRAPH_BOOLEAN, OrographData { boolean: i32::from(*boolean) }),
            Value::Text(text) => of(OROGRAPH_TEXT, OrographData { text: OrographText::of(text) }),
        }
    }

    fn grid(&mut self, grid: &Grid) -> *const OrographGrid {
        // The reference counts of a grid's coordinate system keep its text where it is.
        let georef = grid.georef.clone();
        let view = OrographGrid {
            size: size(size_of::<OrographGrid>()),
            georeferenced: u32::from(georef.is_some()),
            rows: grid.rows as u64,
            cols: grid.cols as u64,
            row0: grid.row0,
            col0: grid.col0,
            cell_x: grid.cell.x,
            cell_y: grid.cell.y,
            origin_x: grid.origin.x,
            origin_y: grid.origin.y,
            transform: georef.as_ref().map_or([0.0; 6], |georef| georef.transform),
            crs: georef.as_ref().map_or(OrographText::EMPTY, |georef| OrographText::of(&georef.crs)),
        };
        self.kept.push(Box::new(georef));
        self.keep(view)
    }

    fn raster<K: Kind>(&mut self, raster: &'a Raster<K>) -> OrographData {
        let grid = self.grid(raster.grid());
        let cells = raster.cells().as_ptr().cast::<c_void>();
        let view = OrographRaster { size: size(size_of::<OrographRaster>()), reserved: 0, grid, cells };
        OrographData { raster: self.keep(view) }
    }

    fn features(&mut self, features: &'a Features) -> OrographFeatures {
        let points = features.points.iter().map(|point| OrographFeaturePoint {
            row: point.row,
            col: point.col,
            height: point.height,
            kind: match point.kind {
                PointKind::Branch => OROGRAPH_BRANCH,
                PointKind::End => OROGRAPH_END,
                PointKind::Path => OROGRAPH_PATH,
            },
        });
        let lines = features.lines.iter().map(|line| OrographLine {
            from: line.from,
            to: line.to,
            vertex_count: line.vertices.len(),
            vertices: line.vertices.as_ptr(),
            profile_count: line.profiles.len(),
            profiles: line.profiles.as_ptr(),
        });
        OrographFeatures {
            size: size(size_of::<OrographFeatures>()),
            kind: match features.kind {
                FeatureKind::Ridge => OROGRAPH_RIDGES,
                FeatureKind::Valley => OROGRAPH_VALLEYS,
            },
            grid: self.grid(&features.grid),
            point_count: features.points.len(),
            points: self.keep_all(points.collect()),
            line_count: features.lines.len(),
            lines: self.keep_all(lines.collect()),
            ring_count: features.rings.len(),
            rings: features.rings.as_ptr(),
            scale: features.scale,
            profile_step: features.profile_step,
            profile_len: features.profile_len,
            reserved: 0,
        }
    }

    fn points(&mut self, points: &'a Points) -> OrographPoints {
        let (x, y, heights) = points.columns();
        OrographPoints {
            size: size(size_of::<OrographPoints>()),
            reserved: 0,
            count: points.len(),
            x: x.as_ptr(),
            y: y.as_ptr(),
            heights: heights.as_ptr(),
        }
    }

    fn placement(&mut self, placement: &'a Placement) -> OrographPlacement {
        let patches = placement.patches.iter().map(|patch| OrographPatch {
            exemplar: patch.exemplar,
            window: patch.size,
            mirrored: u32::from(patch.mirrored),
            reserved: 0,
            source_center: patch.source_center,
            target_center: patch.target_center,
            offset: patch.offset,
            control_count: patch.controls.len(),
            controls: patch.controls.as_ptr(),
        });
        OrographPlacement {
            size: size(size_of::<OrographPlacement>()),
            reserved: 0,
            grid: self.grid(&placement.grid),
            scale_count: placement.scales.len(),
            scales: placement.scales.as_ptr(),
            patch_count: placement.patches.len(),
            patches: self.keep_all(patches.collect()),
            labels: placement.labels.as_ptr(),
            sources: placement.sources.as_ptr(),
            seam_count: placement.seams.len(),
            seams: placement.seams.as_ptr(),
        }
    }

    fn table(&mut self, table: &'a Table) -> OrographTable {
        let columns = table
            .columns()
            .iter()
            .map(|column| {
                let (numbers, texts) = match &column.cells {
                    Cells::Numbers(numbers) => (numbers.as_ptr(), ptr::null()),
                    Cells::Texts(texts) => {
                        let texts = texts.iter().map(|text| OrographText::of(text)).collect();
                        (ptr::null(), self.keep_all(texts))
                    }
                };
                let unit = OrographText::of(column.unit.symbol());
                OrographColumn { name: OrographText::of(&column.name), unit, numbers, texts }
            })
            .collect::<Vec<_>>();
        OrographTable {
            size: size(size_of::<OrographTable>()),
            reserved: 0,
            column_count: columns.len(),
            row_count: table.rows(),
            columns: self.keep_all(columns),
        }
    }

    /// Parameters.
    pub fn params(&mut self, values: &'a [ParamValue]) -> Vec<OrographParam> {
        let of = |kind, value| OrographParam { kind, reserved: 0, value };
        values
            .iter()
            .map(|value| match value {
                ParamValue::Number(number) => of(OROGRAPH_PARAM_NUMBER, OrographSetting { number: *number }),
                ParamValue::Integer(integer) => {
                    of(OROGRAPH_PARAM_INTEGER, OrographSetting { integer: *integer })
                }
                ParamValue::Boolean(boolean) => {
                    of(OROGRAPH_PARAM_BOOLEAN, OrographSetting { boolean: i32::from(*boolean) })
                }
                ParamValue::Text(text) => {
                    of(OROGRAPH_PARAM_TEXT, OrographSetting { text: OrographText::of(text) })
                }
                ParamValue::Curve(points) => {
                    let curve = OrographCurve { count: points.len(), points: points.as_ptr() };
                    of(OROGRAPH_PARAM_CURVE, OrographSetting { curve })
                }
                ParamValue::Lines(lines) => {
                    let lines = lines
                        .iter()
                        .map(|line| OrographPolyline { count: line.len(), vertices: line.as_ptr() })
                        .collect::<Vec<_>>();
                    let lines = OrographLines { count: lines.len(), lines: self.keep_all(lines) };
                    of(OROGRAPH_PARAM_LINES, OrographSetting { lines })
                }
            })
            .collect()
    }
}

fn mesh_view(mesh: &Mesh) -> OrographMesh {
    OrographMesh {
        size: size(size_of::<OrographMesh>()),
        reserved: 0,
        vertex_count: mesh.vertices.len(),
        vertices: mesh.vertices.as_ptr(),
        normals: if mesh.normals.is_empty() { ptr::null() } else { mesh.normals.as_ptr() },
        uvs: if mesh.uvs.is_empty() { ptr::null() } else { mesh.uvs.as_ptr() },
        triangle_count: mesh.triangles.len(),
        triangles: mesh.triangles.as_ptr(),
    }
}

impl OrographText {
    /// No text.
    pub const EMPTY: Self = Self { data: ptr::null(), len: 0 };

    /// A view of `text`, good for as long as it is.
    #[must_use]
    pub const fn of(text: &str) -> Self {
        Self { data: text.as_ptr().cast(), len: text.len() }
    }
}

/// The size of a struct, as its first field says it.
const fn size(bytes: usize) -> u32 {
    // Every struct is far below 4 GiB.
    bytes as u32
}
