//! What stands under the pointer, in words.

use orograph_core::{FeatureKind, Features, Grid, PointKind, Value};
use orograph_edit::beside::grid_of;

/// Values that are asked for what they say at a place.
#[derive(Clone, Copy)]
pub(super) struct Probe<'a> {
    /// The value.
    pub(super) value: &'a Value,
    /// What it is compared with, or the terrain that it lies on.
    pub(super) beside: Option<&'a Value>,
    /// Whether the two are compared.
    pub(super) compared: bool,
}

impl Probe<'_> {
    pub(super) fn grid(&self) -> Option<&Grid> {
        grid_of(self.value)
    }

    /// What stands at a share of the picture; lines are found within `reach` cells.
    pub(super) fn tell(&self, share: [f64; 2], reach: f64) -> Option<String> {
        let grid = self.grid()?;
        let (row, col) = cell(grid, share)?;
        let position = grid.position(row, col);
        let place = format!("row {row}, col {col}   x {:.1} m, y {:.1} m", position.x, position.y);
        Some(format!("{place}   {}", self.what(share, reach)?))
    }

    /// The value alone.
    pub(super) fn what(&self, share: [f64; 2], reach: f64) -> Option<String> {
        let grid = self.grid()?;
        let (row, col) = cell(grid, share)?;
        let own = match self.value {
            Value::Features(features) => {
                let at = [share[1] * grid.rows as f64 - 0.5, share[0] * grid.cols as f64 - 0.5];
                feature(features, at, reach)
            }
            Value::Placement(placement) => match placement.labels.get(row * grid.cols + col) {
                Some(0) | None => "no patch".to_owned(),
                Some(label) => format!("patch {label} of {}", placement.patches.len()),
            },
            Value::Texture(texture) => {
                let [r, g, b, _] = texture.at(row, col);
                format!("#{r:02x}{g:02x}{b:02x}")
            }
            value => number(value, row, col).map_or_else(String::new, |number| written(value, number)),
        };
        let beside = self.beside.filter(|beside| grid_of(beside).is_some_and(|b| b.size() == grid.size()));
        let Some(other) = beside.and_then(|beside| number(beside, row, col).map(|at| (beside, at))) else {
            return Some(own);
        };
        let (beside, at) = other;
        Some(match (self.compared, number(self.value, row, col)) {
            (true, Some(value)) => {
                let difference = value - at;
                let words = match difference.is_nan() {
                    true => "void".to_owned(),
                    false => {
                        format!("{}{}", if difference > 0.0 { "+" } else { "" }, written(beside, difference))
                    }
                };
                format!("{own} against {}: {words}", written(beside, at))
            }
            (true, None) => own,
            // Terrain over its own heights says nothing new.
            (false, _) if matches!(self.value, Value::Heightfield(_)) => own,
            (false, _) => format!("{own}   at {}", written(beside, at)),
        })
    }
}

/// The cell at a share of a picture.
fn cell(grid: &Grid, share: [f64; 2]) -> Option<(usize, usize)> {
    let inside = |share: f64, n: usize| {
        let at = (share * n as f64).floor();
        (at >= 0.0 && at < n as f64).then_some(at as usize)
    };
    Some((inside(share[1], grid.rows)?, inside(share[0], grid.cols)?))
}

fn number(value: &Value, row: usize, col: usize) -> Option<f64> {
    match value {
        Value::Heightfield(terrain) => Some(f64::from(terrain.at(row, col))),
        Value::Mask(mask) => Some(f64::from(mask.at(row, col))),
        _ => None,
    }
}

fn written(value: &Value, number: f64) -> String {
    match value {
        _ if number.is_nan() => "void".to_owned(),
        Value::Heightfield(_) => format!("{number:.2} m"),
        _ => format!("{number:.3}"),
    }
}

/// The point or line that lies nearest to a place (row, column), within `reach` cells.
fn feature(features: &Features, at: [f64; 2], reach: f64) -> String {
    let far = |a: [f64; 2]| (a[0] - at[0]) * (a[0] - at[0]) + (a[1] - at[1]) * (a[1] - at[1]);
    let name = match features.kind {
        FeatureKind::Ridge => "ridge",
        FeatureKind::Valley => "valley",
    };
    let points = features.points.iter().filter(|point| point.kind != PointKind::Path);
    let point = points.map(|point| (far([point.row, point.col]), point)).min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((distance, point)) = point
        && distance <= reach * reach
    {
        let what = if point.kind == PointKind::Branch { "branch point" } else { "end" };
        return format!("{what} of a {name}, {}", height(point.height));
    }
    let along = |line: &orograph_core::Polyline| {
        line.vertices.windows(2).any(|pair| from_segment(at, pair[0], pair[1]) <= reach * reach)
    };
    match features.lines.iter().position(along) {
        Some(index) => format!("{name} {} of {}", index + 1, features.lines.len()),
        None => format!("no {name}"),
    }
}

fn height(metres: f32) -> String {
    if metres.is_nan() { "void".to_owned() } else { format!("{metres:.2} m") }
}

/// The square of the distance from a place to a segment.
fn from_segment(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (along, from) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = match square > 0.0 {
        true => ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0),
        false => 0.0,
    };
    let off = [from[0] - share * along[0], from[1] - share * along[1]];
    off[0] * off[0] + off[1] * off[1]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::{CellSize, FeaturePoint, Heightfield, Mask, Placement, Polyline};

    use super::*;

    fn grid() -> Grid {
        Grid::new(10, 20, CellSize::square(5.0)).unwrap()
    }

    fn alone(value: &Value) -> Probe<'_> {
        Probe { value, beside: None, compared: false }
    }

    #[test]
    fn voids_and_heights_and_what_lies_between_two_of_them_are_told() {
        let mut cells = vec![7.5; 200];
        cells[0] = f32::NAN;
        let a = Value::Heightfield(Heightfield::new(grid(), cells).unwrap().into());
        let b = Value::Heightfield(Heightfield::new(grid(), vec![5.0; 200]).unwrap().into());
        let probe = Probe { value: &a, beside: Some(&b), compared: true };
        assert_eq!(probe.what([0.5, 0.5], 1.0).unwrap(), "7.50 m against 5.00 m: +2.50 m");
        assert_eq!(probe.what([0.01, 0.01], 1.0).unwrap(), "void against 5.00 m: void");
        let told = alone(&a).tell([0.999, 0.0], 1.0).unwrap();
        assert_eq!(told, "row 0, col 19   x 95.0 m, y 0.0 m   7.50 m");
        assert_eq!(alone(&a).tell([1.0, 0.0], 1.0), None, "outside");
        assert_eq!(alone(&a).tell([-0.001, 0.0], 1.0), None, "outside");
    }

    #[test]
    fn a_void_of_a_mask_is_told_as_one() {
        let mask = Value::Mask(Mask::new(grid(), vec![f32::NAN; 200]).unwrap().into());
        assert_eq!(alone(&mask).what([0.5, 0.5], 1.0).unwrap(), "void");
    }

    #[test]
    fn the_patch_under_the_pointer_is_told_by_its_number() {
        let patch = orograph_core::Patch {
            exemplar: 0,
            source_center: [0.0; 2],
            target_center: [0.0; 2],
            size: 3,
            mirrored: false,
            controls: Vec::new(),
            offset: 0.0,
        };
        let mut labels = vec![0; 200];
        labels[25] = 2;
        let placement = Placement {
            grid: grid(),
            scales: Vec::new(),
            patches: vec![patch.clone(), patch],
            labels,
            sources: Vec::new(),
            seams: Vec::new(),
        };
        let value = Value::Placement(placement.into());
        assert_eq!(alone(&value).what([5.5 / 20.0, 1.5 / 10.0], 1.0).unwrap(), "patch 2 of 2");
        assert_eq!(alone(&value).what([0.9, 0.9], 1.0).unwrap(), "no patch");
    }

    #[test]
    fn the_line_or_point_under_the_pointer_is_told_with_the_ground_below() {
        let point = |row: f64, col: f64, kind| FeaturePoint { row, col, height: 3.0, kind };
        let features = Features {
            grid: grid(),
            kind: FeatureKind::Valley,
            points: vec![point(5.0, 2.0, PointKind::Branch), point(5.0, 15.0, PointKind::End)],
            lines: vec![Polyline {
                from: 0,
                to: 1,
                vertices: vec![[5.0, 2.0], [5.0, 15.0]],
                profiles: Vec::new(),
            }],
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 0.0,
        };
        let value = Value::Features(features.into());
        let at = |row: f64, col: f64| [(col + 0.5) / 20.0, (row + 0.5) / 10.0];
        assert_eq!(alone(&value).what(at(5.3, 2.2), 1.0).unwrap(), "branch point of a valley, 3.00 m");
        assert_eq!(alone(&value).what(at(5.9, 8.0), 1.0).unwrap(), "valley 1 of 1");
        assert_eq!(alone(&value).what(at(6.2, 8.0), 1.0).unwrap(), "no valley");
        let ground = Value::Heightfield(Heightfield::new(grid(), vec![8.0; 200]).unwrap().into());
        let over = Probe { value: &value, beside: Some(&ground), compared: false };
        assert_eq!(over.what(at(8.0, 8.0), 1.0).unwrap(), "no valley   at 8.00 m");
    }
}
