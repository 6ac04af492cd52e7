//! Painting: strokes in a picture become lines of a parameter, as vectors in the document.

use eframe::egui;
use orograph_core::{ParamKind, ParamValue, Unit, ValueType};
use orograph_edit::{Interface, Port, beside::grid_of, operations, operations::Refused};
use orograph_engine::{
    compile::param_value,
    document::{Link, Literal},
};

use super::{App, Question, dialogs::For};
use crate::{
    inspector::named,
    views::{Asked, Mode, Strokes, Tool},
};

/// How far a picture's node stands from the painting that it lies under.
const BESIDE: f64 = 280.0;

/// What can be painted of a node: parameters that hold lines, one of them under the brush.
pub(super) struct Drawable {
    node: String,
    layers: Vec<Layer>,
    /// The layer under the brush.
    active: usize,
    /// Metres in the world, and not shares of the picture.
    world: bool,
}

struct Layer {
    param: String,
    doc: String,
    /// Of the third number of a point.
    unit: Unit,
    lines: Vec<Vec<[f64; 3]>>,
}

impl Drawable {
    fn layer(&self) -> &Layer {
        &self.layers[self.active]
    }

    fn link(&self) -> Link {
        Link::new(&self.node, &self.layer().param)
    }
}

/// The setting and the option by which nodes with lines say that they are in metres.
const COORDINATES: (&str, &str) = ("coordinates", "world");

impl App {
    /// What can be painted of the selected node, when there is something.
    pub(super) fn drawable(&mut self) -> Option<Drawable> {
        let name = self.canvas.selection.last()?.clone();
        let document = self.editing.document().clone();
        let node = document.nodes.get(&name)?;
        let interface = self.interfaces.of(&name, node, &document);
        let lined =
            interface.params.iter().filter(|param| matches!(param.spec.kind, ParamKind::Lines { .. }));
        let layers: Vec<_> = lined
            .map(|param| Layer {
                param: param.name.clone(),
                doc: param.spec.doc.to_string(),
                unit: param.spec.unit,
                lines: match value_of(node, &interface, &param.name) {
                    Some(ParamValue::Lines(lines)) => lines,
                    _ => Vec::new(),
                },
            })
            .collect();
        let world = value_of(node, &interface, COORDINATES.0)
            .is_some_and(|value| value == ParamValue::Text(COORDINATES.1.into()));
        let active = layers.iter().position(|layer| layer.param == self.layer).unwrap_or(0);
        (!layers.is_empty()).then_some(Drawable { node: name, layers, active, world })
    }

    /// The tools of a painter, above the panes.
    pub(super) fn palette(&mut self, ui: &mut egui::Ui, drawable: Option<&Drawable>) {
        let Some(drawable) = drawable else {
            self.tool = Tool::Look;
            return;
        };
        for (tool, label) in
            [(Tool::Look, "look"), (Tool::Draw, "draw"), (Tool::Point, "point"), (Tool::Erase, "erase")]
        {
            if ui.selectable_value(&mut self.tool, tool, label).clicked() && tool != Tool::Look {
                self.lay_flat(&drawable.node);
            }
        }
        if drawable.layers.len() > 1 {
            ui.separator();
            for (index, layer) in drawable.layers.iter().enumerate() {
                let button = ui.selectable_label(index == drawable.active, layer.param.replace('_', " "));
                if named(button.on_hover_text(&layer.doc), &format!("paint {}", layer.param)).clicked() {
                    self.layer.clone_from(&layer.param);
                }
            }
            ui.separator();
        }
        let (label, suffix) = match drawable.layer().unit {
            Unit::Metre => ("height of what is drawn", " m"),
            Unit::Degree => ("angle of what is drawn", "°"),
            _ => ("number of what is drawn", ""),
        };
        let height = named(ui.add(egui::DragValue::new(&mut self.height).suffix(suffix)), label);
        height.on_hover_text(&drawable.layer().doc);
        ui.label(label).on_hover_text(&drawable.layer().doc);
        if let Some(input) = self.free_picture(&drawable.node) {
            let button = ui.button("picture under it…").on_hover_text("Paint over a picture from a file");
            if button.clicked() {
                self.ask_file(Question::Input, For::Under(input));
            }
        }
    }

    /// Shows what a node gives as a picture, which can be drawn upon, where it is shown as ground.
    fn lay_flat(&mut self, name: &str) {
        for pane in &mut self.panes {
            let shows = pane.output.as_ref().is_some_and(|output| output.node == name);
            if let (true, Mode::Ground(look)) = (shows, &pane.mode) {
                pane.mode = look.clone().map_or(Mode::First, Mode::Look);
            }
        }
    }

    /// An input of a node that takes a picture and has none.
    fn free_picture(&mut self, name: &str) -> Option<Link> {
        let document = self.editing.document().clone();
        let node = document.nodes.get(name)?;
        let interface = self.interfaces.of(name, node, &document);
        let free = |port: &&Port| {
            port.value_type == Some(ValueType::Texture) && !node.inputs.contains_key(&port.name)
        };
        Some(Link::new(name, &interface.inputs.iter().find(free)?.name))
    }

    /// Puts a picture from a file under a painting.
    pub(super) fn put_under(&mut self, input: &Link, file: String) {
        const READER: &str = "io.read_texture";
        let Some(reader) = self.registry.get(READER).cloned() else {
            self.complain(format!("there is no node type `{READER}` here to read the picture with"));
            return;
        };
        let (x, y) = self.canvas.place_of(&input.node).unwrap_or_default();
        let automatic = self.canvas.automatic().clone();
        self.edit("picture under it", |document, interfaces| {
            Self::settle(document, &automatic);
            let name = operations::add(document, &reader, (x - BESIDE, y));
            operations::set_param(document, &name, "file", Some(Literal::Text(file)))?;
            operations::connect(document, interfaces, &Link::new(name, "texture"), input)
        });
    }

    /// What is painted, as shares of what a pane shows.
    pub(super) fn strokes_for(&self, pane: usize, drawable: Option<&Drawable>) -> Strokes {
        let Some(drawable) = drawable else { return Strokes::default() };
        let grid = self.panes[pane].value().and_then(grid_of).filter(|grid| !grid.is_empty());
        let share = |point: &[f64; 3]| match (grid, drawable.world) {
            (Some(grid), _) => {
                let (row, col) = match drawable.world {
                    true => grid.locate((point[0], point[1]).into()),
                    false => (point[1] * (grid.rows - 1) as f64, point[0] * (grid.cols - 1) as f64),
                };
                Some([(col + 0.5) / grid.cols as f64, (row + 0.5) / grid.rows as f64, point[2]])
            }
            (None, false) => Some(*point),
            // Nobody knows where it is.
            (None, true) => None,
        };
        let shares = |layer: &Layer| -> Vec<Vec<[f64; 3]>> {
            layer.lines.iter().map(|line| line.iter().filter_map(share).collect()).collect()
        };
        let others = drawable.layers.iter().enumerate().filter(|(index, _)| *index != drawable.active);
        Strokes {
            lines: shares(drawable.layer()),
            others: others.flat_map(|(_, layer)| shares(layer)).collect(),
        }
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
                        let mut lines = drawable.layer().lines.clone();
                        lines.push(line);
                        self.set(&drawable.link(), &ParamValue::Lines(lines));
                        self.editing.end_gesture();
                    }
                    Err(refused) => self.complain(refused.to_string()),
                }
            }
            Asked::Erase(at, reach) => {
                let Some(drawable) = drawable else { return };
                let shown = self.strokes_for(index, Some(drawable));
                let lines = &drawable.layer().lines;
                let kept: Vec<_> = lines
                    .iter()
                    .zip(&shown.lines)
                    .filter(|(_, shown)| !touches(shown, at, reach))
                    .map(|(line, _)| line.clone())
                    .collect();
                if kept.len() < lines.len() {
                    self.set(&drawable.link(), &ParamValue::Lines(kept));
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
        let grid = self.panes[pane].value().and_then(grid_of);
        if drawable.world {
            let grid = grid.ok_or_else(|| {
                Refused::new(
                    format!(
                        "`{}` is in metres, and what is shown has no place in the world",
                        drawable.link()
                    ),
                    "show terrain, or set `coordinates` to shares of the picture",
                )
            })?;
            let first = grid.position(0, 0);
            let place = |[x, y]: &[f64; 2]| {
                let (col, row) = (x * grid.cols as f64 - 0.5, y * grid.rows as f64 - 0.5);
                [first.x + col * grid.cell.x, first.y - row * grid.cell.y, height]
            };
            return Ok(stroke.iter().map(place).collect());
        }
        // Shares run from the middle of the first cell to that of the last; a picture's from edge to edge.
        let inner = |share: f64, n: usize| (share * n as f64 - 0.5) / (n.max(2) - 1) as f64;
        let place = |[x, y]: &[f64; 2]| match grid {
            Some(grid) => [inner(*x, grid.cols), inner(*y, grid.rows), height],
            None => [*x, *y, height],
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
        [] => false,
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
