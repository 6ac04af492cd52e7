//! Panes that show values: as pictures, as ground in three dimensions, as tables.

mod bar;
mod compare;
mod ground;
mod keys;
mod legend;
mod numbers;
mod picture;
mod plot;
mod probe;
mod series;
mod table;
mod tiles;
mod view;

use std::sync::Arc;

use eframe::egui;
use orograph_core::{Texture, Value, ValueType};
use orograph_edit::{
    Beside, Fault, Shown, Wish,
    looks::{self, Colours},
};
use orograph_engine::{Registry, document::Link};

pub use compare::Compare;
pub use ground::Ground;
pub use keys::{has_keyboard, takes};
pub use picture::Picture;

use legend::Legend;
use probe::Probe;

/// How a pane shows its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mode {
    /// As the first look at its type.
    First,
    /// As the picture that a node type makes of it.
    Look(String),
    /// As ground to walk around, with the look on it.
    Ground(Option<String>),
    /// As a plot.
    Plot,
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
    /// The picture of the terrain alone that lines in `ground` lie on.
    bare: Picture,
    plot: plot::Plot,
    content: Content,
}

enum Content {
    Nothing,
    Faults(Vec<Fault>),
    Sight(Sight),
}

/// What is seen.
struct Sight {
    value: Value,
    /// What it is compared with, or the terrain that it lies on.
    beside: Option<Value>,
    compared: bool,
    legend: Option<Legend>,
    style: table::Style,
}

impl Sight {
    fn probe(&self) -> Probe<'_> {
        Probe { value: &self.value, beside: self.beside.as_ref(), compared: self.compared }
    }
}

/// What the user asked of a pane.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Show it in another way.
    Mode(Mode),
    /// Show another output of the same node.
    Output(Link),
    /// Stay with the output, or follow the selection again.
    Pin(bool),
    /// A stroke was drawn, in shares of the picture, x to the right and y down.
    Stroke(Vec<[f64; 2]>),
    /// Strokes near this place are to go; within this share of the picture.
    Erase([f64; 2], f64),
    /// A gesture with the brush ended.
    Lifted,
}

/// What stands to be shown in a pane.
#[derive(Clone, Debug, Default)]
pub struct Offer {
    /// The type of what it shows.
    pub value_type: Option<ValueType>,
    /// The outputs of the node that it shows.
    pub outputs: Vec<Link>,
    /// Lines that are drawn over a picture while a tool edits them.
    pub strokes: Strokes,
}

/// Painted lines: vertices of x, y and height, x and y in shares of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    /// Those that the brush adds to and the eraser takes from.
    pub lines: Vec<Vec<[f64; 3]>>,
    /// Those of other layers.
    pub others: Vec<Vec<[f64; 3]>>,
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
            bare: Picture::default(),
            plot: plot::Plot::default(),
            content: Content::Nothing,
        }
    }

    /// What is to be computed for it, where `beside` is what its picture can show besides.
    #[must_use]
    pub fn wish(&self, registry: &Registry, value_type: Option<ValueType>, beside: Beside) -> Option<Wish> {
        let output = self.output.clone()?;
        let look = match &beside {
            Beside::Against(_) => Some(looks::DIFFERENCE.to_owned()),
            _ => self.look(registry, value_type?),
        };
        Some(Wish { name: self.name.clone(), output, look, beside, overrides: Vec::new() })
    }

    /// Whether it shows its value against that of the other pane.
    #[must_use]
    pub fn compares(&self) -> bool {
        matches!(&self.mode, Mode::Look(id) | Mode::Ground(Some(id)) if id == looks::DIFFERENCE)
    }

    /// Whether its picture is better drawn over terrain.
    #[must_use]
    pub fn draws_over(&self, registry: &Registry, value_type: ValueType) -> bool {
        let look = self.look(registry, value_type).and_then(|look| registry.get(&look));
        value_type == ValueType::Features
            || look.is_some_and(|look| looks::ground_port(look.spec()).is_some())
    }

    fn look(&self, registry: &Registry, value_type: ValueType) -> Option<String> {
        if value_type == ValueType::Table {
            // Tables are read and plotted here.
            return None;
        }
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
            Ok(Shown { value, picture, beside, ground, scale }) => {
                let texture = picture.as_ref().and_then(texture_of).or_else(|| texture_of(&value));
                self.picture.show(ctx, &self.name, texture);
                let compared = scale.as_ref().is_some_and(|scale| scale.colours == Colours::Diverging);
                let (terrain, features) = match (&value, &beside) {
                    (Value::Heightfield(terrain), _) => (Some(terrain), None),
                    (Value::Features(features), Some(Value::Heightfield(terrain))) => {
                        (Some(terrain), Some(features))
                    }
                    (_, Some(Value::Heightfield(terrain))) => (Some(terrain), None),
                    _ => (None, None),
                };
                self.ground.show(terrain.map(AsRef::as_ref), features.map(AsRef::as_ref));
                let bare = ground.as_ref().and_then(texture_of).filter(|_| features.is_some());
                self.bare.show(ctx, &format!("{} bare", self.name), bare);
                if let Value::Table(table) = &value {
                    self.plot.renew(table);
                }
                let legend = scale.as_ref().and_then(Legend::new);
                let style = match &value {
                    Value::Table(table) => table::Style::of(table),
                    _ => table::Style::default(),
                };
                self.content = Content::Sight(Sight { value, beside, compared, legend, style });
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
        self.sight().map(|sight| &sight.value)
    }

    fn sight(&self) -> Option<&Sight> {
        match &self.content {
            Content::Sight(sight) => Some(sight),
            _ => None,
        }
    }

    /// Draws what it shows; `strokes` are drawn over a picture while a tool edits them.
    fn content(&mut self, ui: &mut egui::Ui, tool: Tool, strokes: &Strokes) -> Vec<Asked> {
        let mut asked = Vec::new();
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
            Content::Sight(sight) => match (&sight.value, &self.mode) {
                (Value::Table(values), Mode::Plot) => self.plot.ui(ui, &self.name, values),
                (Value::Table(values), _) => table::show(ui, &self.name, values, &sight.style),
                (_, Mode::Ground(_)) if self.ground.has_terrain() => {
                    let texture = self.bare.texture().or_else(|| self.picture.texture());
                    let legend = sight.legend.as_ref().filter(|_| self.bare.texture().is_none());
                    self.ground.ui(ui, &self.name, texture, legend);
                }
                _ if self.picture.texture().is_some() => {
                    let legend = sight.legend.as_ref();
                    asked.extend(self.picture.ui(ui, &self.name, &sight.probe(), legend, tool, strokes));
                }
                (value, _) => {
                    ui.label(words(value));
                }
            },
        }
        asked
    }
}

fn texture_of(value: &Value) -> Option<Arc<Texture>> {
    match value {
        Value::Texture(texture) => Some(texture.clone()),
        _ => None,
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

/// A small picture for a node.
#[must_use]
pub fn thumbnail(ctx: &egui::Context, name: &str, shown: &Shown) -> Option<egui::TextureHandle> {
    const SIZE: usize = 96;
    let texture = match (&shown.picture, &shown.value) {
        (Some(Value::Texture(texture)), _) | (None, Value::Texture(texture)) => texture,
        _ => return None,
    };
    let all = [texture.rows(), texture.cols()];
    let image = tiles::sampled(texture, [0, 0], all, tiles::step(texture, SIZE));
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
