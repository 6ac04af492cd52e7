//! What a node looks like: title, ports, picture, state.

use eframe::egui::{self, Color32, Rect, RichText, pos2, vec2};
use egui_graph::{FramedResponse, NodeCtx};
use orograph_edit::Badge;

use super::{NodeView, afar};
use crate::theme;

/// Width of a node.
pub(super) const WIDTH: f32 = 190.0;
pub(super) const THUMBNAIL: f32 = 96.0;
pub(super) const GAP: f32 = 3.0;

/// Height of the title and of a row of ports, the same for all nodes, so that they keep their size from afar.
pub(super) const TITLE: f32 = 38.0;
pub(super) const ROW: f32 = 18.0;

/// How large a node can become, but for words about faults.
pub(super) fn most(node: &NodeView) -> egui::Vec2 {
    const EDGES: f32 = 20.0;
    const STATE: f32 = 18.0;
    let rows = node.inputs.len().max(node.outputs.len()) as f32;
    let picture = if node.outputs.is_empty() { 0.0 } else { THUMBNAIL + GAP };
    let comment = if node.comment.is_empty() { 0.0 } else { 2.0 * STATE };
    vec2(WIDTH, EDGES + TITLE + rows * (ROW + GAP) + picture + comment + STATE)
}

/// How a node was drawn.
pub(super) enum Body {
    /// With everything in it, which is this high.
    Near(f32),
    /// As a coloured block.
    Afar,
}

/// A node too small to be read: its block, its ports, and its name in large letters.
pub(super) fn from_afar(ctx: NodeCtx<'_>, node: &NodeView, height: f32) -> FramedResponse<Body> {
    let interaction = ctx.interaction();
    let frame = afar::frame(ctx.style(), interaction);
    ctx.framed_with(frame, |ui, sockets| {
        let (_, rect) = ui.allocate_space(vec2(WIDTH - 20.0, height));
        let mut top = rect.top() + TITLE + GAP;
        for row in 0..node.inputs.len().max(node.outputs.len()) {
            let place = Rect::from_min_size(pos2(rect.left(), top), vec2(rect.width(), ROW));
            if row < node.inputs.len() {
                sockets.input(row, place);
            }
            if row < node.outputs.len() {
                sockets.output(row, place);
            }
            top += ROW + GAP;
        }
        afar::inner(ui, node, rect, interaction.selected);
        Body::Afar
    })
}

/// A node with everything in it.
pub(super) fn show(ctx: NodeCtx<'_>, node: &NodeView) -> FramedResponse<Body> {
    ctx.framed(|ui, sockets| {
        ui.set_width(WIDTH - 20.0);
        ui.spacing_mut().item_spacing.y = GAP;
        title(ui, node);
        let rows = node.inputs.len().max(node.outputs.len());
        for row in 0..rows {
            let (input, output) = (node.inputs.get(row), node.outputs.get(row));
            let at = |there: bool| there.then_some(row);
            sockets.row(ui, at(input.is_some()), at(output.is_some()), |ui| {
                ui.horizontal(|ui| {
                    ui.set_width(WIDTH - 20.0);
                    ui.set_height(ROW);
                    if let Some(port) = input {
                        ui.add(egui::Label::new(RichText::new(&port.name).small()).selectable(false));
                    }
                    if let Some(port) = output {
                        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                            ui.add(egui::Label::new(RichText::new(&port.name).small()).selectable(false));
                        });
                    }
                });
            });
        }
        thumbnail(ui, node);
        if !node.comment.is_empty() {
            ui.add(
                egui::Label::new(RichText::new(&node.comment).italics().weak().small())
                    .selectable(false)
                    .wrap(),
            );
        }
        state(ui, node);
        Body::Near(ui.min_rect().height())
    })
}

fn thumbnail(ui: &mut egui::Ui, node: &NodeView) {
    if let Some(picture) = node.thumbnail {
        ui.vertical_centered(|ui| {
            let picture = egui::load::SizedTexture::new(picture, vec2(THUMBNAIL, THUMBNAIL));
            ui.add(egui::Image::new(picture).alt_text(format!("picture of {}", node.name)));
        });
    }
}

pub(super) fn fill(ui: &egui::Ui, node: &NodeView) -> Color32 {
    let dark = ui.visuals().dark_mode;
    let fill = if node.unknown { Color32::from_gray(90) } else { theme::family(&node.family, dark) };
    if node.bypass { fill.gamma_multiply(0.35) } else { fill }
}

fn title(ui: &mut egui::Ui, node: &NodeView) {
    let frame = egui::Frame::new()
        .fill(fill(ui, node))
        .corner_radius(3.0)
        .inner_margin(egui::Margin::symmetric(6, 2));
    let response = frame.show(ui, |ui| {
        ui.set_width(WIDTH - 32.0);
        ui.set_height(TITLE - 4.0);
        let text = RichText::new(&node.name).strong();
        let text = if node.bypass { text.strikethrough() } else { text };
        ui.add(egui::Label::new(text).selectable(false).truncate());
        // Weak text would drown in the colour.
        let kind = RichText::new(&node.kind).small().color(ui.visuals().strong_text_color());
        ui.add(egui::Label::new(kind).selectable(false).truncate());
    });
    response.response.on_hover_text(&node.summary);
}

fn state(ui: &mut egui::Ui, node: &NodeView) {
    let small = |text: String| egui::Label::new(RichText::new(text).small().weak()).selectable(false);
    if let Some(fault) = &node.fault {
        let text = RichText::new(fault).small().color(theme::FAULT);
        ui.add(egui::Label::new(text).selectable(false).wrap());
        return;
    }
    match &node.badge {
        Some(Badge::Running(done)) => {
            ui.add(egui::ProgressBar::new(*done as f32).desired_height(6.0));
        }
        Some(Badge::Done { how, micros, bytes, warnings }) => {
            ui.horizontal(|ui| {
                let time = if *how == "computed" { format!(" {}", duration(*micros)) } else { String::new() };
                ui.add(small(format!("{how}{time} · {}", size(*bytes))));
                if !warnings.is_empty() {
                    let mark = RichText::new("!").small().strong().color(theme::WARNING);
                    ui.add(egui::Label::new(mark).selectable(false)).on_hover_text(warnings.join("\n"));
                }
            });
        }
        Some(Badge::Failed(fault)) => {
            let text = RichText::new(&fault.message).small().color(theme::FAULT);
            let response = ui.add(egui::Label::new(text).selectable(false).wrap());
            if let Some(help) = &fault.help {
                response.on_hover_text(help);
            }
        }
        None => {}
    }
}

fn duration(micros: u64) -> String {
    match micros {
        0..1_000 => format!("{micros} µs"),
        1_000..1_000_000 => format!("{:.1} ms", micros as f64 / 1e3),
        _ => format!("{:.2} s", micros as f64 / 1e6),
    }
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}
