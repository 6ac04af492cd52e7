//! The inspector: a node's settings, drawn from its spec alone.

mod colour;
mod curve;
mod param;
mod slide;

use std::collections::HashMap;

use eframe::egui::{self, RichText};
use orograph_core::{ParamKind, ParamValue};
use orograph_edit::{Interface, Kind, Offered};
use orograph_engine::{
    Document,
    compile::{lifted, param_value},
    document::{Link, Node},
};

use crate::theme;

/// What the user asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Another value for a parameter; part of a gesture while the pointer or the keyboard still holds it.
    Set(Link, ParamValue),
    /// The default again.
    Reset(Link),
    /// The parameter as one of the whole graph.
    Expose(Link),
    /// An exposed parameter no longer exposed.
    Hide(String),
    /// Pictures for several values of this parameter.
    Vary(Link),
    /// Another name for the node.
    Rename(String, String),
    /// Another comment.
    Comment(String, String),
    /// A bypass, or its end.
    Bypass(String),
    /// A file for this parameter, from the dialog; to be written when the flag says so.
    File(Link, bool),
    /// The help page of a node.
    Help(String),
    /// Other words about the graph.
    Doc(String),
    /// An output as a named one of the graph.
    AddOutput(Link),
    /// A named output no longer.
    RemoveOutput(String),
    /// A gesture ended.
    Done,
}

/// What the inspector remembers between frames.
#[derive(Default)]
pub struct Inspector {
    /// Values that were refused, and why.
    refused: HashMap<Link, Refusal>,
    name: Option<(String, String)>,
    /// Why the last name was refused.
    pub name_refused: Option<String>,
}

struct Refusal {
    /// The value in the document when it was refused: when that changes, the refusal is over.
    value: ParamValue,
    why: String,
}

impl Inspector {
    /// Draws the settings of a node.
    pub fn node(
        &mut self,
        ui: &mut egui::Ui,
        name: &str,
        node: &Node,
        interface: &Interface,
        exposed: &[(String, Link)],
    ) -> Vec<Ask> {
        let mut asks = Vec::new();
        self.head(ui, name, node, interface, &mut asks);
        let node = match &interface.kind {
            Kind::Type(node_type) => match lifted(node, node_type) {
                Ok(node) => node,
                Err(error) => {
                    ui.colored_label(theme::FAULT, error.to_string());
                    return asks;
                }
            },
            _ => node.clone(),
        };
        egui::ScrollArea::vertical().id_salt("settings").auto_shrink([false, false]).show(ui, |ui| {
            if let Kind::Unknown(reason) = &interface.kind {
                ui.colored_label(theme::WARNING, reason);
                ui.label("It is kept as it is, and saved back unchanged.");
                for (param, value) in &node.params {
                    ui.monospace(format!("{param}: {}", value.to_ron()));
                }
            }
            for offered in &interface.params {
                self.setting(ui, name, &node, offered, exposed, &mut asks);
            }
            if !interface.outputs.is_empty() {
                ui.separator();
                ui.label(RichText::new("Outputs").strong());
            }
            for output in &interface.outputs {
                ui.horizontal(|ui| {
                    let kind = output.value_type.map_or_else(String::new, |kind| format!(" — {kind}"));
                    ui.label(format!("{}{kind}", output.name)).on_hover_text(&output.doc);
                    let label = format!("name output {}", output.name);
                    if named(ui.small_button("name it"), &label).clicked() {
                        asks.push(Ask::AddOutput(Link::new(name, &output.name)));
                    }
                });
            }
        });
        asks
    }

    fn head(
        &mut self,
        ui: &mut egui::Ui,
        name: &str,
        node: &Node,
        interface: &Interface,
        asks: &mut Vec<Ask>,
    ) {
        ui.horizontal(|ui| {
            if self.name.as_ref().is_none_or(|(of, _)| of != name) {
                self.name = Some((name.to_owned(), name.to_owned()));
                self.name_refused = None;
            }
            let Some((_, text)) = &mut self.name else { return };
            let response =
                named(ui.add(egui::TextEdit::singleline(text).desired_width(150.0)), "name of the node");
            if response.lost_focus() && text != name {
                asks.push(Ask::Rename(name.to_owned(), text.clone()));
            }
            if named(ui.small_button("?"), "help on this node").clicked() {
                asks.push(Ask::Help(name.to_owned()));
            }
            let mut bypass = node.bypass;
            if ui.checkbox(&mut bypass, "bypass").on_hover_text("Hand the inputs on untouched").changed() {
                asks.push(Ask::Bypass(name.to_owned()));
            }
        });
        if let Some(why) = &self.name_refused {
            ui.colored_label(theme::FAULT, why);
        }
        if let Some(spec) = interface.spec() {
            ui.weak(format!("{} · version {}", spec.id, spec.version));
        }
        ui.label(interface.summary());
        let mut comment = node.comment.clone();
        let edit = egui::TextEdit::multiline(&mut comment).desired_rows(1).hint_text("Why it is there");
        let response = named(ui.add(edit.desired_width(f32::INFINITY)), "comment");
        if response.changed() {
            asks.push(Ask::Comment(name.to_owned(), comment));
        }
        if response.lost_focus() {
            asks.push(Ask::Done);
        }
        ui.separator();
    }

    fn setting(
        &mut self,
        ui: &mut egui::Ui,
        name: &str,
        node: &Node,
        offered: &Offered,
        exposed: &[(String, Link)],
        asks: &mut Vec<Ask>,
    ) {
        let link = Link::new(name, &offered.name);
        let spec = &offered.spec;
        let given = node.params.get(&offered.name);
        let typed = given.map(|literal| param_value(literal, spec));
        let value = match &typed {
            Some(Ok(value)) => value.clone(),
            _ => spec.default.clone(),
        };
        let label = offered.name.replace('_', " ");
        ui.push_id(&offered.name, |ui| {
            ui.horizontal(|ui| {
                let text =
                    if given.is_some() { RichText::new(&label).strong() } else { RichText::new(&label) };
                let public = exposed.iter().find(|(_, param)| *param == link).map(|(public, _)| public);
                let text = if public.is_some() { text.underline() } else { text };
                let response = ui.add(egui::Label::new(text).sense(egui::Sense::click())).on_hover_ui(|ui| {
                    ui.set_max_width(420.0);
                    ui.label(spec.doc.as_ref());
                    ui.weak(limits(&spec.kind, spec.unit.symbol()));
                });
                response.context_menu(|ui| {
                    if ui.button("Reset to default").clicked() {
                        asks.push(Ask::Reset(link.clone()));
                    }
                    match public {
                        None if ui.button("Expose as a parameter of the graph").clicked() => {
                            asks.push(Ask::Expose(link.clone()));
                        }
                        Some(public) if ui.button("Do not expose").clicked() => {
                            asks.push(Ask::Hide(public.clone()));
                        }
                        _ => {}
                    }
                    if is_varied(&spec.kind) && ui.button("Show variations").clicked() {
                        asks.push(Ask::Vary(link.clone()));
                    }
                });
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if given.is_some() {
                        let button = ui.small_button("↺").on_hover_text("Reset to default");
                        if named(button, &format!("reset {}", offered.name)).clicked() {
                            asks.push(Ask::Reset(link.clone()));
                        }
                    }
                    let text = if public.is_some() { "●" } else { "○" };
                    let button = ui.small_button(text).on_hover_text("Expose as a parameter of the graph");
                    if named(button, &format!("expose {}", offered.name)).clicked() {
                        asks.push(match public {
                            Some(public) => Ask::Hide(public.clone()),
                            None => Ask::Expose(link.clone()),
                        });
                    }
                });
            });
            let answer = param::edit(ui, &label, spec, &value);
            if let Some(file) = answer.file {
                asks.push(Ask::File(link.clone(), file));
            }
            if let Some(next) = answer.value {
                match spec.check(&next) {
                    Ok(()) => {
                        self.refused.remove(&link);
                        asks.push(Ask::Set(link.clone(), next));
                    }
                    // Refused, not bent into the range: the user sees why.
                    Err(error) => {
                        let why = match error.hint() {
                            Some(hint) => format!("{error}: {hint}"),
                            None => error.to_string(),
                        };
                        self.refused.insert(link.clone(), Refusal { value: value.clone(), why });
                    }
                }
            }
            if answer.done {
                asks.push(Ask::Done);
            }
            if self.refused.get(&link).is_some_and(|refusal| refusal.value != value) {
                self.refused.remove(&link);
            }
            if let Some(refusal) = self.refused.get(&link) {
                ui.colored_label(theme::FAULT, &refusal.why);
            }
            if let Some(Err((message, help))) = &typed {
                ui.colored_label(theme::FAULT, message);
                if let Some(help) = help {
                    ui.label(help);
                }
            }
        });
        ui.add_space(4.0);
    }

    /// Draws what the graph as a whole says, when no node is chosen.
    pub fn graph(&mut self, ui: &mut egui::Ui, document: &Document) -> Vec<Ask> {
        let mut asks = Vec::new();
        ui.strong("The graph");
        let mut doc = document.doc.clone();
        let edit =
            egui::TextEdit::multiline(&mut doc).hint_text("What it shows").desired_width(f32::INFINITY);
        let response = named(ui.add(edit), "about the graph");
        if response.changed() {
            asks.push(Ask::Doc(doc));
        }
        if response.lost_focus() {
            asks.push(Ask::Done);
        }
        let section = |ui: &mut egui::Ui, title: &str| {
            ui.add_space(6.0);
            ui.strong(title);
        };
        section(ui, "Exposed parameters");
        for (name, exposed) in &document.expose {
            ui.horizontal(|ui| {
                ui.label(format!("{name} — {}", exposed.param)).on_hover_text(&exposed.doc);
                if named(ui.small_button("×"), &format!("hide {name}")).clicked() {
                    asks.push(Ask::Hide(name.clone()));
                }
            });
        }
        section(ui, "Outputs");
        for (name, output) in &document.outputs {
            ui.horizontal(|ui| {
                ui.label(format!("{name} — {output}"));
                if named(ui.small_button("×"), &format!("remove output {name}")).clicked() {
                    asks.push(Ask::RemoveOutput(name.clone()));
                }
            });
        }
        asks
    }
}

/// Gives a widget the name by which assistive technology knows it.
pub(crate) fn named(response: egui::Response, label: &str) -> egui::Response {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
    response
}

/// Parameters that a grid of pictures can be made for.
fn is_varied(kind: &ParamKind) -> bool {
    matches!(kind, ParamKind::Number { .. } | ParamKind::Integer { .. } | ParamKind::Choice { .. })
}

fn limits(kind: &ParamKind, unit: &str) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    match kind {
        ParamKind::Number { range: (low, high), .. } => format!("from {low} to {high}{unit}"),
        ParamKind::Integer { range: (low, high), .. } => format!("from {low} to {high}{unit}"),
        ParamKind::InputPath => "a file to read, relative to the graph".into(),
        ParamKind::OutputPath => "a file to write, relative to the output folder".into(),
        _ => String::new(),
    }
}
