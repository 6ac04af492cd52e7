//! Values that cross, and views that must not.

use std::{ptr, sync::Arc};

use orograph_core::{
    CellSize, Column, FeatureKind, FeaturePoint, Features, Georef, Grid, Heightfield, Mask, Mesh, ParamValue,
    Patch, Placement, PointKind, Points, Polyline, Slot, Table, Texture, Unit, Value,
};

use crate::*;

fn grid() -> Grid {
    let mut grid = Grid::new(2, 3, CellSize { x: 23.7, y: 30.9 }).unwrap();
    (grid.row0, grid.col0) = (-4, 7);
    grid.origin = glam::DVec2::new(1234.5, -6789.25);
    let transform = [600_000.0, 23.7, 0.0, 5_100_000.0, 0.0, -30.9];
    grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632, Zürich".into() }));
    grid
}

/// One value of each type, with every field set.
fn values() -> Vec<Value> {
    let point = |row, kind| FeaturePoint { row, col: 1.5, height: 900.0, kind };
    let features = Features {
        grid: grid(),
        kind: FeatureKind::Valley,
        points: vec![point(0.0, PointKind::Branch), point(0.5, PointKind::End), point(1.0, PointKind::Path)],
        lines: vec![
            Polyline { from: 0, to: 1, vertices: vec![[0.0, 1.5], [0.5, 1.5]], profiles: vec![1.0; 6] },
            Polyline { from: 1, to: 2, vertices: vec![[0.5, 1.5], [1.0, 1.5]], profiles: Vec::new() },
        ],
        rings: vec![[0, 2]],
        scale: 2.5,
        profile_len: 3,
        profile_step: 1.25,
    };
    let placement = Placement {
        grid: grid(),
        scales: vec![[1.0, 1.5]],
        patches: vec![Patch {
            exemplar: 1,
            source_center: [3.0, 4.0],
            target_center: [5.0, 6.0],
            size: 80,
            mirrored: true,
            controls: vec![[0.0, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0]],
            offset: -12.5,
        }],
        labels: vec![0, 1, 1, 0, 1, 0],
        sources: vec![[0.5, 1.5]; 6],
        seams: vec![[0, 1], [3, 4]],
    };
    let column = |name: &str, unit, cells| Column { name: name.into(), unit, cells };
    let table = Table::new(vec![
        column("rmse", Unit::Metre, orograph_core::Cells::Numbers(vec![1.5, f64::NAN])),
        column("of", Unit::One, orograph_core::Cells::Texts(vec!["größer".into(), String::new()])),
    ]);
    let mesh = Mesh {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        uvs: vec![[0.25, 0.75]; 3],
    };
    let heights = vec![1.0, f32::NAN, -0.0, 4.0, 5.0, 6.0];
    vec![
        Value::Heightfield(Arc::new(Heightfield::new(grid(), heights).unwrap())),
        Value::Mask(Arc::new(Mask::new(grid(), vec![0.0, 0.25, 0.5, 0.75, 1.0, 0.1]).unwrap())),
        Value::Texture(Arc::new(Texture::new(grid(), (0..6).map(|i| [i, 2, 3, 255]).collect()).unwrap())),
        Value::Features(Arc::new(features)),
        Value::Points(Arc::new(Points::new(vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0]).unwrap())),
        Value::Placement(Arc::new(placement)),
        Value::Table(Arc::new(table.unwrap())),
        Value::Mesh(Arc::new(mesh)),
        Value::Number(0.1),
        Value::Integer(-7),
        Value::Boolean(true),
        Value::Text("Grüß Gott".into()),
    ]
}

#[test]
fn every_value_crosses_to_the_bit() {
    for value in values() {
        let mut lender = Lender::new();
        let view = lender.value(&value);
        for cells in [Cells::Copied, Cells::Lent] {
            // SAFETY: the view was lent from a value that is still here.
            let back = unsafe { read_value(&view, cells) }.unwrap();
            assert_eq!(back.value_type(), value.value_type());
            assert_eq!(back.digest(), value.digest(), "{value:?}");
        }
    }
}

#[test]
fn empty_values_cross() {
    let none = Grid::new(0, 5, CellSize::square(1.0)).unwrap();
    let values = [
        Value::Heightfield(Arc::new(Heightfield::new(none, Vec::new()).unwrap())),
        Value::Points(Arc::default()),
        Value::Table(Arc::default()),
        Value::Mesh(Arc::default()),
        Value::Text("".into()),
    ];
    for value in values {
        let mut lender = Lender::new();
        let view = lender.value(&value);
        // SAFETY: as above.
        assert_eq!(unsafe { read_value(&view, Cells::Copied) }.unwrap().digest(), value.digest());
    }
}

#[test]
fn lent_cells_are_the_lender_s_own() {
    let field = Heightfield::new(grid(), vec![1.0; 6]).unwrap();
    let place = field.cells().as_ptr();
    let value = Value::Heightfield(Arc::new(field));
    let mut lender = Lender::new();
    let ports = lender.inputs(&[Slot::Empty, Slot::One(value.clone()), Slot::Many(vec![value.clone(); 2])]);
    assert_eq!(ports.iter().map(|port| port.count).collect::<Vec<_>>(), [0, 1, 2]);
    // SAFETY: as above.
    let back = unsafe { read_value(ports[1].values, Cells::Lent) }.unwrap();
    let Value::Heightfield(back) = back else { panic!("another type") };
    assert_eq!(back.cells().as_ptr(), place);
}

#[test]
fn every_parameter_crosses() {
    let params = [
        ParamValue::Number(0.5),
        ParamValue::Integer(-3),
        ParamValue::Boolean(true),
        ParamValue::Text("näher".into()),
        ParamValue::Curve(vec![[0.0, 1.0], [1.0, 2.0]]),
        ParamValue::Lines(vec![vec![[0.0, 1.0, 2.0]], Vec::new()]),
    ];
    let mut lender = Lender::new();
    let views = lender.params(&params);
    for (view, param) in views.iter().zip(&params) {
        // SAFETY: as above.
        assert_eq!(unsafe { read_param(view) }.as_ref(), Ok(param));
    }
}

/// What is said of the view of `value` after `spoil`.
fn refusal(value: &Value, spoil: impl FnOnce(&mut OrographValue)) -> String {
    let mut lender = Lender::new();
    let mut view = lender.value(value);
    spoil(&mut view);
    // SAFETY: what `spoil` changes is null, or checked before it is followed.
    unsafe { read_value(&view, Cells::Copied) }.unwrap_err().0
}

#[test]
fn malformed_views_are_refused_with_the_reason() {
    let all = values();
    // SAFETY (all below): each member read or written is the one that the value's kind says.
    let with_grid = |change: fn(&mut OrographGrid)| {
        refusal(&all[0], |view| unsafe {
            let raster = view.data.raster.cast_mut();
            let mut grid = *(*raster).grid;
            change(&mut grid);
            (*raster).grid = Box::leak(Box::new(grid));
        })
    };
    assert!(with_grid(|grid| grid.cell_x = f64::NAN).contains("has no area"));
    assert!(with_grid(|grid| grid.rows = u64::MAX).contains("grid of"));
    assert!(with_grid(|grid| grid.origin_y = f64::INFINITY).contains("lies nowhere"));
    assert!(with_grid(|grid| grid.row0 = i64::MIN).contains("lies nowhere"));
    assert!(with_grid(|grid| grid.size = 8).contains("says that it has 8 bytes"));
    assert!(with_grid(|grid| grid.transform[0] = f64::NAN).contains("transform"));
    assert!(refusal(&all[0], |view| view.kind = 99).contains("number 99"));
    assert!(refusal(&all[0], |view| view.data.raster = ptr::null()).contains("null pointer"));
    let null_cells = refusal(&all[1], |view| unsafe { (*view.data.raster.cast_mut()).cells = ptr::null() });
    assert!(null_cells.contains("6 items at a null pointer"), "{null_cells}");
    let unaligned = refusal(&all[1], |view| unsafe {
        let cells = &mut (*view.data.raster.cast_mut()).cells;
        *cells = (*cells).byte_add(1);
    });
    assert!(unaligned.contains("not aligned"), "{unaligned}");
    let points = refusal(&all[4], |view| unsafe { (*view.data.points.cast_mut()).count = usize::MAX });
    assert!(points.contains("fit no memory"), "{points}");
    let dangling = refusal(&all[3], |view| unsafe { (*view.data.features.cast_mut()).point_count = 1 });
    assert!(dangling.contains("that there are not"), "{dangling}");
    let vertices = refusal(&all[7], |view| unsafe { (*view.data.mesh.cast_mut()).vertex_count = 2 });
    assert!(vertices.contains("a triangle names"), "{vertices}");
    let bytes = [0xffu8, 0xfe];
    let text = OrographText { data: bytes.as_ptr().cast(), len: 2 };
    assert!(refusal(&all[11], |view| view.data.text = text).contains("no UTF-8"));
    // SAFETY: a null pointer is not followed.
    assert!(unsafe { read_value(ptr::null(), Cells::Copied) }.is_err());
}

#[test]
fn cells_that_no_value_has_are_refused() {
    let infinite = Heightfield::new(grid(), vec![1.0, 2.0, 3.0, 4.0, f32::INFINITY, 6.0]).unwrap();
    let said = refusal(&Value::Heightfield(Arc::new(infinite)), |_| {});
    assert!(said.contains("row 1, column 1"), "{said}");
    for wrong in [1.5, -0.1, f32::NAN] {
        let mask = Mask::new(grid(), vec![0.0, 0.0, wrong, 0.0, 0.0, 0.0]).unwrap();
        let said = refusal(&Value::Mask(Arc::new(mask)), |_| {});
        assert!(said.contains("row 0, column 2"), "{said}");
    }
}
