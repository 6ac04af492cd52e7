//! Pictures of terrain.

pub mod aspect;
pub mod canvas;
pub mod chart;
pub mod colour;
pub mod colour_relief;
pub mod contact_sheet;
pub mod contours;
pub mod difference_map;
pub mod features;
pub mod hillshade;
pub mod histogram;
pub mod legend;
pub mod mark_known;
pub mod mask_overlay;
pub mod mesh;
pub mod perspective;
pub mod placement;
pub mod plot;
pub mod profile;
pub mod slope;
pub mod ticks;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<aspect::Aspect>(),
        NodeType::of::<colour_relief::ColourRelief>(),
        NodeType::of::<contact_sheet::ContactSheet>(),
        NodeType::of::<contours::Contours>(),
        NodeType::of::<difference_map::DifferenceMap>(),
        NodeType::of::<features::Features>(),
        NodeType::of::<hillshade::Hillshade>(),
        NodeType::of::<histogram::Histogram>(),
        NodeType::of::<mark_known::MarkKnown>(),
        NodeType::of::<mask_overlay::MaskOverlay>(),
        NodeType::of::<mesh::Mesh>(),
        NodeType::of::<perspective::Perspective>(),
        NodeType::of::<placement::Placement>(),
        NodeType::of::<plot::Plot>(),
        NodeType::of::<profile::Profile>(),
        NodeType::of::<slope::Slope>(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{measure, test_fields::field};
    use orograph_core::{Arity, Placement, Slot, Unit, ValueType, prelude::*};

    /// Something for every port of a node, all of it on the grid of `terrain`.
    fn slots(node: &NodeType, terrain: &Heightfield) -> Vec<Slot> {
        let job = Job::detached();
        let value = |value_type| match value_type {
            ValueType::Heightfield => Value::Heightfield(terrain.clone().into()),
            ValueType::Mask => Value::Mask(terrain.map(&job, |height| height / 100.0).unwrap().into()),
            ValueType::Texture => {
                let picture: Texture = terrain.map(&job, |height| [height as u8, 90, 200, 255]).unwrap();
                Value::Texture(picture.into())
            }
            ValueType::Table => Value::Table(Table::metrics([("a", Unit::Metre, 1.0)]).unwrap().into()),
            ValueType::Placement => Value::Placement(unplaced(terrain.grid()).into()),
            ValueType::Features => Value::Features(no_lines(terrain.grid()).into()),
            ValueType::Mesh => Value::Mesh(orograph_core::Mesh::default().into()),
            other => panic!("no sample of {other}"),
        };
        let slot = |port: &orograph_core::PortSpec| match port.arity {
            Arity::Many => Slot::Many(vec![value(port.value_type); 3]),
            _ => Slot::One(value(port.value_type)),
        };
        node.spec().inputs.iter().map(slot).collect()
    }

    fn unplaced(grid: &Grid) -> Placement {
        let (labels, sources) = (vec![0; grid.len()], vec![[0.0; 2]; grid.len()]);
        Placement {
            grid: grid.clone(),
            scales: Vec::new(),
            patches: Vec::new(),
            labels,
            sources,
            seams: Vec::new(),
        }
    }

    fn no_lines(grid: &Grid) -> Features {
        Features {
            grid: grid.clone(),
            kind: FeatureKind::Valley,
            points: Vec::new(),
            lines: Vec::new(),
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 1.0,
        }
    }

    fn run(node: &NodeType, terrain: &Heightfield) -> Result<Vec<Value>> {
        let defaults: Vec<_> = node.spec().params.iter().map(|param| param.default.clone()).collect();
        node.instantiate(&defaults).unwrap().run(&slots(node, terrain), &Job::detached())
    }

    fn all() -> impl Iterator<Item = NodeType> {
        nodes().into_iter().chain(measure::nodes())
    }

    /// Hills with voids, all different.
    fn hills(rows: usize, cols: usize) -> Heightfield {
        field(rows, cols, |row, col| {
            let bits = orograph_core::key(5, 6, row as i64, col as i64);
            if bits.is_multiple_of(23) { f64::NAN } else { 60.0 + 40.0 * orograph_core::signed_unit(bits) }
        })
    }

    #[test]
    fn odd_terrain_is_drawn_and_measured_or_refused_in_words() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        let flat = |rows, cols, height| field(rows, cols, |_, _| height);
        for node in all() {
            for terrain in [
                flat(0, 0, 0.0),
                flat(0, 5, 0.0),
                flat(1, 1, 7.0),
                flat(1, 40, 3.0),
                flat(40, 1, -3.0),
                flat(3, 4, nan),
                flat(3, 4, inf),
                field(4, 4, |row, col| [-inf, inf, nan, 1e38][(row + col) % 4]),
                field(2, 2, |row, _| [3e38, -3e38][row]),
            ] {
                if let Err(error) = run(&node, &terrain) {
                    assert!(error.hint().is_some(), "{}: {error}", node.spec().id);
                }
            }
        }
    }

    #[test]
    fn local_nodes_give_tiles_that_equal_the_whole() {
        let job = Job::detached();
        let whole = hills(31, 37);
        let tile = whole.crop(9, 8, 15, 17, &job).unwrap();
        for node in all().filter(|node| node.spec().extent == Extent::Local) {
            let defaults: Vec<_> = node.spec().params.iter().map(|param| param.default.clone()).collect();
            let halo = node.instantiate(&defaults).unwrap().halo(whole.grid().cell);
            let (rows, cols) = (15 - 2 * halo, 17 - 2 * halo);
            let part = |value: &Value, row, col| match value {
                Value::Heightfield(raster) => {
                    Value::Heightfield(raster.crop(row, col, rows, cols, &job).unwrap().into()).digest()
                }
                Value::Texture(raster) => {
                    Value::Texture(raster.crop(row, col, rows, cols, &job).unwrap().into()).digest()
                }
                other => panic!("{other:?} is no raster"),
            };
            let outputs = run(&node, &whole).unwrap().into_iter().zip(run(&node, &tile).unwrap());
            for (of_whole, of_tile) in outputs {
                assert_eq!(
                    part(&of_whole, 9 + halo, 8 + halo),
                    part(&of_tile, halo, halo),
                    "{}",
                    node.spec().id
                );
            }
        }
    }
}
