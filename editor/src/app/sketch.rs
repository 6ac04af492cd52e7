//! Painting: strokes in a picture become lines of a parameter, as vectors in the document.

use orograph_core::{Grid, ParamKind, ParamValue, Value};
use orograph_edit::{Interface, operations::Refused};
use orograph_engine::{compile::param_value, document::Link};

use super::App;
use crate::views::{Asked, Mode};

/// A parameter that lines can be drawn for, and what its numbers mean.
pub(super) struct Drawable {
    link: Link,
    lines: Vec<Vec<[f64; 3]>>,
    /// Metres in the world, and not shares of the picture.
    world: bool,
}

/// The setting and the option by which nodes with lines say that they are in metres.
const COORDINATES: (&str, &str) = ("coordinates", "world");

impl App {
    /// The lines of the selected node, when it has such a parameter.
    pub(super) fn drawable(&mut self) -> Option<Drawable> {
        let name = self.canvas.selection.last()?.clone();
        let document = self.editing.document().clone();
        let node = document.nodes.get(&name)?;
        let interface = self.interfaces.of(&name, node, &document);
        let param =
            interface.params.iter().find(|param| matches!(param.spec.kind, ParamKind::Lines { .. }))?;
        let lines = match value_of(node, &interface, &param.name) {
            Some(ParamValue::Lines(lines)) => lines,
            _ => Vec::new(),
        };
        let world = value_of(node, &interface, COORDINATES.0)
            .is_some_and(|value| value == ParamValue::Text(COORDINATES.1.into()));
        Some(Drawable { link: Link::new(name, &param.name), lines, world })
    }

    /// The lines as shares of what a pane shows.
    pub(super) fn lines_for(&self, pane: usize, drawable: Option<&Drawable>) -> Vec<Vec<[f64; 3]>> {
        let Some(drawable) = drawable else { return Vec::new() };
        if !drawable.world {
            return drawable.lines.clone();
        }
        let Some(grid) = self.panes[pane].value().and_then(grid_of) else { return Vec::new() };
        let share = |point: &[f64; 3]| {
            let (row, col) = grid.locate((point[0], point[1]).into());
            [(col + 0.5) / grid.cols.max(1) as f64, (row + 0.5) / grid.rows.max(1) as f64, point[2]]
        };
        drawable.lines.iter().map(|line| line.iter().map(share).collect()).collect()
    }

    /// Does what the user asked of a pane.
    pub(super) fn asked_of_pane(&mut self, index: usize, asked: Asked, drawable: Option<&Drawable>) {
        match asked {
            Asked::Mode(mode) => self.pane_mode(index, mode),
            Asked::Output(output) => {
                let Some(pane) = self.panes.get_mut(index) else { return };
                if pane.pinned.is_some() {
                    pane.pinned = Some(output.clone());
                }
                pane.output = Some(output);
                pane.clear();
            }
            Asked::Pin(pin) => {
                let Some(pane) = self.panes.get_mut(index) else { return };
                pane.pinned = if pin { pane.output.clone() } else { None };
            }
            Asked::Lifted => self.editing.end_gesture(),
            Asked::Stroke(stroke) => {
                let Some(drawable) = drawable else { return };
                match self.points(index, drawable, &stroke) {
                    Ok(line) => {
                        let mut lines = drawable.lines.clone();
                        lines.push(line);
                        self.set(&drawable.link, &ParamValue::Lines(lines));
                        self.editing.end_gesture();
                    }
                    Err(refused) => self.complain(refused.to_string()),
                }
            }
            Asked::Erase(at, reach) => {
                let Some(drawable) = drawable else { return };
                let shown = self.lines_for(index, Some(drawable));
                let kept: Vec<_> = drawable
                    .lines
                    .iter()
                    .zip(&shown)
                    .filter(|(_, shown)| !touches(shown, at, reach))
                    .map(|(line, _)| line.clone())
                    .collect();
                if kept.len() < drawable.lines.len() {
                    self.set(&drawable.link, &ParamValue::Lines(kept));
                }
            }
        }
    }

    fn points(
        &self,
        pane: usize,
        drawable: &Drawable,
        stroke: &[[f64; 2]],
    ) -> Result<Vec<[f64; 3]>, Refused> {
        let height = self.height;
        if !drawable.world {
            return Ok(stroke.iter().map(|[x, y]| [*x, *y, height]).collect());
        }
        let grid = self.panes[pane].value().and_then(grid_of).ok_or_else(|| {
            Refused::new(
                format!("`{}` is in metres, and what is shown has no place in the world", drawable.link),
                "show terrain, or set `coordinates` to shares of the picture",
            )
        })?;
        let first = grid.position(0, 0);
        let place = |[x, y]: &[f64; 2]| {
            let (col, row) = (x * grid.cols as f64 - 0.5, y * grid.rows as f64 - 0.5);
            [first.x + col * grid.cell.x, first.y - row * grid.cell.y, height]
        };
        Ok(stroke.iter().map(place).collect())
    }

    /// A look for a pane, from outside.
    pub fn look(&mut self, mode: Mode) {
        self.pane_mode(0, mode);
    }
}

fn value_of(node: &orograph_engine::document::Node, interface: &Interface, name: &str) -> Option<ParamValue> {
    let param = interface.params.iter().find(|param| param.name == name)?;
    match node.params.get(name) {
        Some(literal) => param_value(literal, &param.spec).ok(),
        None => Some(param.spec.default.clone()),
    }
}

fn grid_of(value: &Value) -> Option<&Grid> {
    match value {
        Value::Heightfield(raster) => Some(raster.grid()),
        Value::Mask(raster) => Some(raster.grid()),
        Value::Texture(raster) => Some(raster.grid()),
        Value::Features(features) => Some(&features.grid),
        _ => None,
    }
}

/// Whether a line passes within `reach` of a place.
fn touches(line: &[[f64; 3]], at: [f64; 2], reach: f64) -> bool {
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let (px, py) = (at[0] - a[0], at[1] - a[1]);
        let length = dx * dx + dy * dy;
        let along = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
        let (ex, ey) = (px - along * dx, py - along * dy);
        ex * ex + ey * ey <= reach * reach
    };
    match line {
        [only] => near(only, only),
        line => line.windows(2).any(|pair| near(&pair[0], &pair[1])),
    }
}

#[cfg(test)]
mod tests {
    use super::touches;

    #[test]
    fn an_eraser_touches_what_passes_near_it_and_no_more() {
        let line = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        assert!(touches(&line, [0.5, 0.009], 0.01));
        assert!(!touches(&line, [0.5, 0.011], 0.01));
        assert!(!touches(&line, [1.02, 0.0], 0.01));
        assert!(touches(&[[0.3, 0.3, 0.0]], [0.3, 0.305], 0.01));
    }
}
