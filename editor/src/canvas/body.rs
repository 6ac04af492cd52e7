//! What a node looks like: title, ports, picture, state.

use eframe::egui::{
    self, Color32, Rect, RichText, pos2,
    text::{LayoutJob, TextFormat, TextWrapping},
    vec2,
};
use egui_graph::{FramedResponse, NodeCtx};
use orograph_edit::Badge;

use super::NodeView;
use crate::theme;

/// Width of a node.
pub(super) const WIDTH: f32 = 190.0;
const THUMBNAIL: f32 = 96.0;
const GAP: f32 = 3.0;

/// Height of the title and of a row of ports, the same for all nodes, so that they keep their size from afar.
const TITLE: f32 = 38.0;
const ROW: f32 = 18.0;

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

/// Size of the name of a node that is seen from afar.
const NAME: f32 = 30.0;

/// A node too small to be read: its block, its ports, and its name in large letters.
///
/// Placed by hand: a graph of hundreds of nodes is seen like this, and every widget in them would cost.
pub(super) fn from_afar(ctx: NodeCtx<'_>, node: &NodeView, height: f32) -> FramedResponse<Body> {
    let frame = egui_graph::node::default_frame(ctx.style(), ctx.interaction());
    ctx.framed_with(frame.shadow(egui::Shadow::NONE), |ui, sockets| {
        let (_, rect) = ui.allocate_space(vec2(WIDTH - 20.0, height));
        let below =
            |top: f32, height: f32| Rect::from_min_size(pos2(rect.left(), top), vec2(rect.width(), height));
        let title = below(rect.top(), TITLE);
        ui.painter().rect_filled(title, 3.0, fill(ui, node));
        let mut top = title.bottom() + GAP;
        for row in 0..node.inputs.len().max(node.outputs.len()) {
            if row < node.inputs.len() {
                sockets.input(row, below(top, ROW));
            }
            if row < node.outputs.len() {
                sockets.output(row, below(top, ROW));
            }
            top += ROW + GAP;
        }
        if let Some(picture) = node.thumbnail {
            let middle = pos2(rect.center().x, top + THUMBNAIL / 2.0);
            let place = Rect::from_center_size(middle, vec2(THUMBNAIL, THUMBNAIL));
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(picture, place, whole, Color32::WHITE);
            top += THUMBNAIL + GAP;
        }
        if node.fault.is_some() || matches!(node.badge, Some(Badge::Failed(_))) {
            ui.painter().rect_filled(rect.with_min_y(top.min(rect.bottom())), 2.0, theme::FAULT);
        }
        // As large as can still be read, over whatever stands below.
        let colour = ui.visuals().strong_text_color();
        let text = TextFormat::simple(egui::FontId::proportional(NAME), colour);
        let mut job = LayoutJob::single_section(node.name.clone(), text);
        job.wrap = TextWrapping::truncate_at_width(rect.width());
        let name = ui.fonts_mut(|fonts| fonts.layout_job(job));
        ui.painter().galley(title.left_top() + vec2(4.0, 0.0), name, colour);
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

fn fill(ui: &egui::Ui, node: &NodeView) -> Color32 {
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
