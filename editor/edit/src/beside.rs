//! What a look can take besides the value itself: another value to compare it with, or the terrain that it lies on.

use std::collections::HashSet;

use orograph_core::{Grid, Value, ValueType};
use orograph_engine::{
    Document,
    document::{GRAPH, Link},
};

use crate::{Interfaces, runner::Fault};

/// Outputs that a look takes besides the one that it shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Beside {
    /// None.
    #[default]
    Nothing,
    /// The value that it is compared with.
    Against(Link),
    /// Terrain to draw it over, the likeliest first; the first on the same grid is taken.
    Over(Vec<Link>),
}

/// More terrains than these are not tried.
const MOST: usize = 4;

/// The terrain that what an output gives lies on: what the node took it from, what it gives together with it, and
/// what stands further up. For terrain it is the terrain itself.
#[must_use]
pub fn ground(document: &Document, interfaces: &mut Interfaces, output: &Link) -> Vec<Link> {
    let terrain = Some(ValueType::Heightfield);
    let own = interfaces.type_of(output, document);
    if own == terrain {
        return vec![output.clone()];
    }
    let together = siblings(document, interfaces, &output.node);
    let mut found = Vec::new();
    // A placement lies on the terrain that was made with it, not on the one that its patches were taken from.
    if own == Some(ValueType::Placement) {
        found.extend(together.iter().cloned());
    }
    let mut seen = HashSet::new();
    let mut layer = vec![output.node.clone()];
    while !layer.is_empty() && found.len() < MOST {
        let mut above = Vec::new();
        for name in layer {
            if !seen.insert(name.clone()) {
                continue;
            }
            let Some(node) = document.nodes.get(&name) else { continue };
            for link in node.inputs.values().flatten().filter(|link| link.node != GRAPH) {
                if interfaces.type_of(link, document) == terrain {
                    found.push(link.clone());
                }
                above.push(link.node.clone());
            }
        }
        layer = above;
    }
    found.truncate(MOST);
    found.extend(together);
    let mut once = HashSet::new();
    found.retain(|link| once.insert(link.to_string()));
    found
}

/// The terrains that a node gives.
fn siblings(document: &Document, interfaces: &mut Interfaces, name: &str) -> Vec<Link> {
    let Some(node) = document.nodes.get(name) else { return Vec::new() };
    let interface = interfaces.of(name, node, document);
    let terrains = interface.outputs.iter().filter(|port| port.value_type == Some(ValueType::Heightfield));
    terrains.map(|port| Link::new(name, &port.name)).collect()
}

/// The grid that a value lies on.
#[must_use]
pub fn grid_of(value: &Value) -> Option<&Grid> {
    match value {
        Value::Features(features) => Some(&features.grid),
        Value::Placement(placement) => Some(&placement.grid),
        other => other.grid(),
    }
}

/// Whether a cell of the one grid covers the same ground as the same cell of the other.
#[must_use]
pub fn same_ground(a: &Grid, b: &Grid) -> bool {
    let near = |x: f64, y: f64, step: f64| (x - y).abs() <= step * 1e-3;
    let alike = |x: f64, y: f64| near(x, y, x.abs().max(y.abs()) * 1e-3);
    let (at, to) = (a.position(0, 0), b.position(0, 0));
    a.size() == b.size()
        && alike(a.cell.x, b.cell.x)
        && alike(a.cell.y, b.cell.y)
        && near(at.x, to.x, a.cell.x)
        && near(at.y, to.y, a.cell.y)
}

/// Why two values cannot be subtracted from each other cell by cell, and the mend; nothing when they can.
#[must_use]
pub(crate) fn unlike(first: (&Link, &Value), second: (&Link, &Value)) -> Option<Fault> {
    let ((a, a_value), (b, b_value)) = (first, second);
    let fault = |message: String, help: &str| {
        Some(Fault { node: Some(a.node.clone()), message, help: Some(help.to_owned()) })
    };
    let (a_type, b_type) = (a_value.value_type(), b_value.value_type());
    if a_type != b_type {
        return fault(
            format!("`{a}` is a {a_type} and `{b}` a {b_type}: they have no difference"),
            "Show two terrains, or two masks",
        );
    }
    let (Some(a_grid), Some(b_grid)) = (grid_of(a_value), grid_of(b_value)) else {
        return fault(format!("Of a {a_type} there is no difference"), "Show two terrains, or two masks");
    };
    if same_ground(a_grid, b_grid) {
        return None;
    }
    let size = |grid: &Grid| format!("{} × {} cells", grid.rows, grid.cols);
    if a_grid.size() != b_grid.size() {
        return fault(
            format!("`{a}` has {} and `{b}` {}", size(a_grid), size(b_grid)),
            "Bring one to the grid of the other with `transform.resize` or `transform.crop`",
        );
    }
    let cell = |grid: &Grid| format!("{} × {} m", grid.cell.x, grid.cell.y);
    if cell(a_grid) != cell(b_grid) {
        return fault(
            format!("A cell of `{a}` is {}, one of `{b}` {}", cell(a_grid), cell(b_grid)),
            "Compare terrains of one cell size, or set it where the file is read",
        );
    }
    let place = |grid: &Grid| format!("x {:.1} m, y {:.1} m", grid.position(0, 0).x, grid.position(0, 0).y);
    fault(
        format!("`{a}` begins at {}, `{b}` at {}: they are of other ground", place(a_grid), place(b_grid)),
        "Cut the same part out of both with `transform.crop`",
    )
}

/// Share of the differences that a scale takes in; the few beyond take its end colours.
const COVERED: f64 = 0.99;

/// A round number that nearly all differences between two values on one grid stay below, and one where there are none.
#[must_use]
pub(crate) fn largest_difference(first: &Value, second: &Value) -> f64 {
    let (a, b) = match (first, second) {
        (Value::Heightfield(a), Value::Heightfield(b)) => (a.cells(), b.cells()),
        (Value::Mask(a), Value::Mask(b)) => (a.cells(), b.cells()),
        _ => return 1.0,
    };
    let difference = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).abs();
    let mut sizes: Vec<f64> = a.iter().zip(b).map(difference).filter(|size| size.is_finite()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let last = sizes.len() - 1;
    let rank = ((sizes.len() as f64 * COVERED).ceil() as usize).saturating_sub(1).min(last);
    let (_, size, _) = sizes.select_nth_unstable_by(rank, f64::total_cmp);
    round_up(*size)
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8 and 10 times a power of ten, within what the look takes.
fn round_up(size: f64) -> f64 {
    /// What is smaller is no difference.
    const LEAST: f64 = 1e-6;
    /// The look takes no more.
    const MOST: f64 = 40_000.0;
    if size < LEAST {
        return 1.0;
    }
    let power = power_below(size);
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
    let factor = steps.into_iter().find(|step| size <= step * power * (1.0 + 1e-9)).unwrap_or(10.0);
    (factor * power).clamp(LEAST, MOST)
}

/// The greatest power of ten that is not greater.
fn power_below(size: f64) -> f64 {
    libm::pow(10.0, libm::floor(libm::log10(size)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::{CellSize, Heightfield};

    use super::*;

    fn field(cell: f64, heights: &[f32]) -> Value {
        let grid = Grid::new(1, heights.len(), CellSize::square(cell)).unwrap();
        Value::Heightfield(Heightfield::new(grid, heights.to_vec()).unwrap().into())
    }

    #[test]
    fn the_scale_takes_in_nearly_all_differences_and_is_round() {
        let errors: Vec<f32> = (1..=1000).map(|i| if i > 995 { 1e6 } else { i as f32 / 100.0 }).collect();
        assert_eq!(largest_difference(&field(1.0, &errors), &field(1.0, &[0.0; 1000])), 10.0);
        assert_eq!(largest_difference(&field(1.0, &[3.0, f32::NAN]), &field(1.0, &[1.7, 5.0])), 1.5);
        assert_eq!(largest_difference(&field(1.0, &[3.0]), &field(1.0, &[3.0])), 1.0, "no difference");
        assert_eq!(largest_difference(&field(1.0, &[f32::NAN]), &field(1.0, &[3.0])), 1.0, "voids alone");
    }

    #[test]
    fn what_lies_elsewhere_is_told_with_the_mend() {
        let (a, b) = (Link::new("a", "terrain"), Link::new("b", "terrain"));
        let why = |first: &Value, second: &Value| unlike((&a, first), (&b, second));
        let two = field(10.0, &[1.0, 2.0]);
        assert_eq!(why(&two, &field(10.0, &[5.0, 5.0])), None);
        let sizes = why(&two, &field(10.0, &[1.0])).unwrap();
        assert!(sizes.message.contains("1 × 2 cells") && sizes.help.unwrap().contains("transform.resize"));
        assert!(why(&two, &field(30.0, &[1.0, 2.0])).unwrap().message.contains("30 × 30 m"));
        assert!(why(&two, &Value::Number(1.0)).unwrap().message.contains("Number"));
    }
}
