//! Inputs of every type, built on one analytic terrain, and digests of what comes out.

// They are sound by construction.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use glam::DVec2;
use orograph_core::Cells as Entries;
use orograph_core::{
    Arity, CellSize, Column, Digest, FeatureKind, FeaturePoint, Features, Georef, Grid, Heightfield, Mask,
    Mesh, NodeSpec, Placement, PointKind, Points, Polyline, Slot, Table, Texture, Unit, Value, ValueType,
};

/// What the terrain under all inputs looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cover {
    /// Every height known.
    Whole,
    /// A few voids, one of them at a corner.
    Holes,
    /// No height known.
    Nothing,
}

/// Non-square cells somewhere in a coordinate system.
pub(crate) fn grid(rows: usize, cols: usize) -> Grid {
    let mut grid = Grid::new(rows, cols, CellSize { x: 23.7, y: 30.9 }).unwrap();
    grid.origin = DVec2::new(1234.5, 6789.25);
    let transform = [600_000.0, 23.7, 0.0, 5_100_000.0, 0.0, -30.9];
    grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
    grid
}

/// A hilly terrain.
pub(crate) fn terrain(rows: usize, cols: usize, cover: Cover) -> Heightfield {
    let height = |row: usize, col: usize| {
        let void = match cover {
            Cover::Whole => false,
            Cover::Holes => (row * 7 + col * 5).is_multiple_of(31),
            Cover::Nothing => true,
        };
        let (x, y) = (col as f64 / 7.0, row as f64 / 5.0);
        if void { f32::NAN } else { (900.0 + 200.0 * libm::sin(x) * libm::cos(y) + 9.0 * x + 5.0 * y) as f32 }
    };
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols)).collect();
    Heightfield::new(grid(rows, cols), cells).unwrap()
}

/// A value of the type, over the terrain's grid.
pub(crate) fn value(of: ValueType, terrain: &Heightfield) -> Value {
    let (grid, n) = (terrain.grid().clone(), terrain.cells().len());
    match of {
        ValueType::Heightfield => Value::Heightfield(Arc::new(terrain.clone())),
        ValueType::Mask => {
            let cells = (0..n).map(|i| [0.0, 0.0, 0.25, 1.0, 1.0, 0.75][i % 6]).collect();
            Value::Mask(Arc::new(Mask::new(grid, cells).unwrap()))
        }
        ValueType::Texture => {
            let cells = (0..n).map(|i| [i as u8, (i / 3) as u8, 99, 255]).collect();
            Value::Texture(Arc::new(Texture::new(grid, cells).unwrap()))
        }
        ValueType::Features => Value::Features(Arc::new(star(grid))),
        ValueType::Points => {
            let at: Vec<DVec2> =
                (0..n).step_by(17).map(|i| grid.position(i / grid.cols, i % grid.cols)).collect();
            let (x, y) = (at.iter().map(|p| p.x).collect(), at.iter().map(|p| p.y).collect());
            let heights = (0..at.len()).map(|i| 800.0 + i as f64).collect();
            Value::Points(Arc::new(Points::new(x, y, heights).unwrap()))
        }
        ValueType::Placement => {
            let (labels, sources) = (vec![0; n], vec![[0.0; 2]; n]);
            let (scales, patches, seams) = (Vec::new(), Vec::new(), Vec::new());
            Value::Placement(Arc::new(Placement { grid, scales, patches, labels, sources, seams }))
        }
        ValueType::Table => {
            let column = |name: &str, cells| Column { name: name.into(), unit: Unit::Metre, cells };
            let columns = vec![
                column("rmse", Entries::Numbers(vec![1.5, f64::NAN])),
                column("of", Entries::Texts(vec!["a".into(), "b, \"c\"".into()])),
            ];
            Value::Table(Arc::new(Table::new(columns).unwrap()))
        }
        ValueType::Mesh => Value::Mesh(Arc::new(Mesh {
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        })),
        ValueType::Number => Value::Number(0.5),
        ValueType::Integer => Value::Integer(3),
        ValueType::Boolean => Value::Boolean(true),
        ValueType::Text => Value::Text("text".into()),
        other => unreachable!("every type of wire is made here, but {other} is not"),
    }
}

/// A value of each type, over one small terrain with voids.
#[must_use]
pub fn samples() -> Vec<Value> {
    use ValueType::{
        Boolean, Features, Heightfield, Integer, Mask, Mesh, Number, Placement, Points, Table, Text, Texture,
    };
    let field = terrain(17, 13, Cover::Holes);
    [Heightfield, Mask, Texture, Features, Points, Placement, Table, Mesh, Number, Integer, Boolean, Text]
        .map(|of| value(of, &field))
        .into()
}

/// What a node of this spec takes, every port connected, over one terrain without voids of so many cells.
#[must_use]
pub fn inputs_of(spec: &NodeSpec, rows: usize, cols: usize) -> Vec<Slot> {
    slots(spec, &terrain(rows, cols, Cover::Whole), true)
}

/// Everything connected, optional ports only when `all` is set.
pub(crate) fn slots(spec: &NodeSpec, terrain: &Heightfield, all: bool) -> Vec<Slot> {
    let slot = |port: &orograph_core::PortSpec| match port.arity {
        Arity::One => Slot::One(value(port.value_type, terrain)),
        Arity::Optional if all => Slot::One(value(port.value_type, terrain)),
        Arity::Optional => Slot::Empty,
        Arity::Many => Slot::Many(vec![value(port.value_type, terrain); 2]),
    };
    spec.inputs.iter().map(slot).collect()
}

/// The part of a raster, other values as they are.
pub(crate) fn crop(value: &Value, [row, col, rows, cols]: [usize; 4]) -> Value {
    let job = orograph_core::Job::detached();
    match value {
        Value::Heightfield(raster) => {
            Value::Heightfield(Arc::new(raster.crop(row, col, rows, cols, &job).unwrap()))
        }
        Value::Mask(raster) => Value::Mask(Arc::new(raster.crop(row, col, rows, cols, &job).unwrap())),
        Value::Texture(raster) => Value::Texture(Arc::new(raster.crop(row, col, rows, cols, &job).unwrap())),
        other => other.clone(),
    }
}

/// Digests of all values, bit for bit.
pub(crate) fn digests(values: &[Value]) -> Vec<Digest> {
    values.iter().map(Value::digest).collect()
}

/// Three ridges from the grid's middle to its corners; none on a grid too small for them.
fn star(grid: Grid) -> Features {
    let (row, col) = (grid.rows as f64 - 1.0, grid.cols as f64 - 1.0);
    let places = [[row / 2.0, col / 2.0], [0.0, 0.0], [0.0, col], [row, col / 2.0]];
    let point = |(i, [row, col]): (usize, [f64; 2])| FeaturePoint {
        row,
        col,
        height: 900.0 - i as f32,
        kind: if i == 0 { PointKind::Branch } else { PointKind::End },
    };
    let line = |to: u32| Polyline {
        from: 0,
        to,
        vertices: vec![places[0], places[to as usize]],
        profiles: Vec::new(),
    };
    let fits = grid.rows > 2 && grid.cols > 2;
    Features {
        grid,
        kind: FeatureKind::Ridge,
        points: if fits { places.into_iter().enumerate().map(point).collect() } else { Vec::new() },
        lines: if fits { (1..4).map(line).collect() } else { Vec::new() },
        rings: Vec::new(),
        scale: 1.0,
        profile_len: 0,
        profile_step: 1.0,
    }
}
