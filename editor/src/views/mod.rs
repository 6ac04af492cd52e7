//! Panes that show values: as pictures, as ground in three dimensions, as tables.

mod ground;
mod picture;
mod table;

use eframe::egui;
use orograph_core::{Texture, Value, ValueType};
use orograph_edit::{Fault, Shown, Wish, looks};
use orograph_engine::{Registry, document::Link};

pub use ground::Ground;
pub use picture::{Picture, Probe};

/// How a pane shows its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mode {
    /// As the first look at its type.
    First,
    /// As the picture that a node type makes of it.
    Look(String),
    /// As ground to walk around, with the look on it.
    Ground(Option<String>),
}

/// A pane.
pub struct Pane {
    /// Its name; wishes carry it.
    pub name: String,
    /// The output that it stays with; none to follow the selection.
    pub pinned: Option<Link>,
    /// How it shows.
    pub mode: Mode,
    /// What it shows now.
    pub output: Option<Link>,
    picture: Picture,
    ground: Ground,
    content: Content,
}

enum Content {
    Nothing,
    Faults(Vec<Fault>),
    Value(Value),
}

/// What the user asked of a pane.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Show it in another way.
    Mode(Mode),
    /// Stay with the output, or follow the selection again.
    Pin(bool),
    /// A stroke was drawn, in shares of the picture, x to the right and y down.
    Stroke(Vec<[f64; 2]>),
    /// Strokes near this place are to go; within this share of the picture.
    Erase([f64; 2], f64),
    /// A gesture with the brush ended.
    Lifted,
}

/// What the pointer does in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Moves the picture.
    #[default]
    Look,
    /// Draws lines.
    Draw,
    /// Sets single points.
    Point,
    /// Takes lines away.
    Erase,
}

impl Pane {
    /// A pane that follows the selection.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            pinned: None,
            mode: Mode::First,
            output: None,
            picture: Picture::default(),
            ground: Ground::default(),
            content: Content::Nothing,
        }
    }

    /// What is to be computed for it.
    #[must_use]
    pub fn wish(&self, registry: &Registry, value_type: Option<ValueType>) -> Option<Wish> {
        let output = self.output.clone()?;
        let look = self.look(registry, value_type?);
        Some(Wish { name: self.name.clone(), output, look, overrides: Vec::new() })
    }

    fn look(&self, registry: &Registry, value_type: ValueType) -> Option<String> {
        let looks = looks::of(registry, value_type);
        match &self.mode {
            Mode::Look(id) | Mode::Ground(Some(id)) if looks.iter().any(|spec| *spec.id == **id) => {
                Some(id.clone())
            }
            _ => looks.first().map(|spec| spec.id.to_string()),
        }
    }

    /// Takes the answer to its wish.
    pub fn take(&mut self, ctx: &egui::Context, result: Result<Shown, Vec<Fault>>) {
        match result {
            Ok(Shown { value, picture }) => {
                let texture = match (&picture, &value) {
                    (Some(Value::Texture(texture)), _) | (None, Value::Texture(texture)) => {
                        Some(texture.clone())
                    }
                    _ => None,
                };
                self.picture.show(ctx, &self.name, texture.as_deref());
                self.ground.show(match &value {
                    Value::Heightfield(terrain) => Some(terrain),
                    _ => None,
                });
                self.content = Content::Value(value);
            }
            Err(faults) => self.content = Content::Faults(faults),
        }
    }

    /// Shows nothing.
    pub fn clear(&mut self) {
        self.content = Content::Nothing;
    }

    /// The value that is shown.
    #[must_use]
    pub fn value(&self) -> Option<&Value> {
        match &self.content {
            Content::Value(value) => Some(value),
            _ => None,
        }
    }

    /// Draws the pane; `lines` are drawn over a picture while a tool edits them.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        registry: &Registry,
        value_type: Option<ValueType>,
        tool: Tool,
        lines: &[Vec<[f64; 3]>],
    ) -> Vec<Asked> {
        let mut asked = Vec::new();
        ui.horizontal(|ui| self.bar(ui, registry, value_type, &mut asked));
        match &self.content {
            Content::Nothing => {
                ui.centered_and_justified(|ui| ui.weak("Choose a node to look at what it gives."));
            }
            Content::Faults(faults) => {
                egui::ScrollArea::vertical().id_salt(&self.name).show(ui, |ui| {
                    for fault in faults {
                        ui.colored_label(crate::theme::FAULT, &fault.message);
                        if let Some(help) = &fault.help {
                            ui.label(help);
                        }
                    }
                });
            }
            Content::Value(value) => match (value, &self.mode) {
                (Value::Table(values), _) => table::show(ui, &self.name, values),
                (Value::Heightfield(_), Mode::Ground(_)) => {
                    let texture = self.picture.texture();
                    self.ground.ui(ui, &self.name, texture);
                }
                _ if self.picture.texture().is_some() => {
                    let probe = Probe { value };
                    asked.extend(self.picture.ui(ui, &self.name, &probe, tool, lines));
                }
                (value, _) => {
                    ui.label(words(value));
                }
            },
        }
        asked
    }

    fn bar(
        &self,
        ui: &mut egui::Ui,
        registry: &Registry,
        value_type: Option<ValueType>,
        asked: &mut Vec<Asked>,
    ) {
        let title = self.output.as_ref().map_or_else(|| "nothing".to_owned(), ToString::to_string);
        ui.strong(title);
        let mut pinned = self.pinned.is_some();
        if ui.checkbox(&mut pinned, "pin").on_hover_text("Stay with this output").changed() {
            asked.push(Asked::Pin(pinned));
        }
        let Some(value_type) = value_type else { return };
        let looks = looks::of(registry, value_type);
        if looks.is_empty() {
            return;
        }
        let now = self.look(registry, value_type).unwrap_or_default();
        let short = |id: &str| id.rsplit('.').next().unwrap_or(id).replace('_', " ");
        egui::ComboBox::from_id_salt((&self.name, "look")).selected_text(short(&now)).show_ui(ui, |ui| {
            for spec in &looks {
                let response =
                    ui.selectable_label(*spec.id == *now, short(&spec.id)).on_hover_text(spec.summary());
                if response.clicked() {
                    let id = spec.id.to_string();
                    asked.push(Asked::Mode(match &self.mode {
                        Mode::Ground(_) => Mode::Ground(Some(id)),
                        _ => Mode::Look(id),
                    }));
                }
            }
        });
        if value_type == ValueType::Heightfield {
            let solid = matches!(self.mode, Mode::Ground(_));
            if ui.selectable_label(!solid, "2D").clicked() {
                asked.push(Asked::Mode(Mode::Look(now.clone())));
            }
            if ui.selectable_label(solid, "3D").clicked() {
                asked.push(Asked::Mode(Mode::Ground(Some(now))));
            }
        }
    }
}

/// A value that has no picture.
fn words(value: &Value) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Integer(integer) => integer.to_string(),
        Value::Boolean(value) => value.to_string(),
        Value::Text(text) => text.to_string(),
        Value::Points(points) => format!("{} points", points.len()),
        Value::Mesh(mesh) => format!("a mesh of {} triangles", mesh.triangles.len()),
        other => format!("a {}", other.value_type()),
    }
}

/// A texture as the window takes it, made smaller where the window's limit asks for that.
fn image_of(texture: &Texture, most: usize) -> egui::ColorImage {
    let (rows, cols) = (texture.rows(), texture.cols());
    let step = rows.max(cols).div_ceil(most.max(1)).max(1);
    let (height, width) = (rows.div_ceil(step), cols.div_ceil(step));
    let mut pixels = Vec::with_capacity(height * width);
    for row in (0..rows).step_by(step) {
        let cells = texture.row(row);
        for cell in cells.iter().step_by(step) {
            let [r, g, b, a] = *cell;
            pixels.push(egui::Color32::from_rgba_unmultiplied(r, g, b, a));
        }
    }
    egui::ColorImage::new([width, height], pixels)
}

/// A small picture for a node.
#[must_use]
pub fn thumbnail(ctx: &egui::Context, name: &str, shown: &Shown) -> Option<egui::TextureHandle> {
    const SIZE: usize = 96;
    let texture = match (&shown.picture, &shown.value) {
        (Some(Value::Texture(texture)), _) | (None, Value::Texture(texture)) => texture,
        _ => return None,
    };
    let image = image_of(texture, SIZE);
    // Square, so that all nodes are alike: the picture stands in the middle.
    let side = image.size[0].max(image.size[1]).max(1);
    let mut square = egui::ColorImage::filled([side, side], egui::Color32::TRANSPARENT);
    let (left, top) = ((side - image.size[0]) / 2, (side - image.size[1]) / 2);
    for row in 0..image.size[1] {
        for col in 0..image.size[0] {
            square[(left + col, top + row)] = image[(col, row)];
        }
    }
    Some(ctx.load_texture(name, square, egui::TextureOptions::LINEAR))
}
