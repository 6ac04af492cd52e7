//! Pages of help: a node's, from its spec; the keys.

use eframe::egui;
use orograph_core::{Arity, NodeSpec, ParamKind};

use super::command::ENTRIES;

/// An open page.
pub(super) struct Page {
    title: String,
    content: Content,
}

enum Content {
    Node(Box<NodeSpec>),
    Keys,
}

impl Page {
    pub(super) fn node(spec: NodeSpec) -> Self {
        Self { title: spec.id.to_string(), content: Content::Node(Box::new(spec)) }
    }

    pub(super) fn keys() -> Self {
        Self { title: "Keys".into(), content: Content::Keys }
    }

    /// Draws the page; false once it was closed.
    pub(super) fn show(&self, ctx: &egui::Context) -> bool {
        let mut open = true;
        // Beside the menus, which lie at the top left.
        let middle = ctx.content_rect().center();
        let window = egui::Window::new(&self.title)
            .id("help".into())
            .open(&mut open)
            .pivot(egui::Align2::CENTER_CENTER)
            .default_pos(middle)
            .default_width(520.0)
            .default_height(ctx.content_rect().height() * 0.7);
        window.vscroll(true).show(ctx, |ui| match &self.content {
            Content::Node(spec) => node(ui, spec),
            Content::Keys => keys(ui),
        });
        open
    }
}

fn keys(ui: &mut egui::Ui) {
    egui::Grid::new("keys").striped(true).show(ui, |ui| {
        for entry in ENTRIES.iter().filter(|entry| !entry.label.is_empty()) {
            ui.label(entry.label);
            let key = entry.told().map(|key| ui.ctx().format_shortcut(&key));
            ui.monospace(key.unwrap_or_default());
            ui.end_row();
        }
    });
    ui.separator();
    ui.label("Drag from a port to wire it; let go over empty space to search for what fits.");
    ui.label("Drag over empty space to select; hold Ctrl to add, Shift to select wires.");
    ui.label("Click a wire twice to bend it there; drag the bend, or click it twice to take it away.");
    ui.label("Drag with the middle button to move about; turn the wheel to enlarge.");
}

fn node(ui: &mut egui::Ui, spec: &NodeSpec) {
    ui.weak(format!("version {}", spec.version));
    ui.label(spec.doc.as_ref());
    for (title, ports) in [("Inputs", &spec.inputs), ("Outputs", &spec.outputs)] {
        if ports.is_empty() {
            continue;
        }
        ui.add_space(8.0);
        ui.strong(title);
        for port in ports {
            let arity = match port.arity {
                Arity::One => "",
                Arity::Optional => ", optional",
                Arity::Many => ", any number",
            };
            ui.label(format!("{} ({}{arity}): {}", port.name, port.value_type, port.doc));
        }
    }
    if !spec.params.is_empty() {
        ui.add_space(8.0);
        ui.strong("Settings");
    }
    for param in &spec.params {
        let unit = match param.unit.symbol() {
            "1" => String::new(),
            symbol => format!(" {symbol}"),
        };
        let limits = match &param.kind {
            ParamKind::Number { range: (low, high), .. } => format!(" (from {low} to {high}{unit})"),
            ParamKind::Integer { range: (low, high), .. } => format!(" (from {low} to {high}{unit})"),
            _ => String::new(),
        };
        ui.label(format!("{}{limits}: {}", param.name, param.doc));
        if let ParamKind::Choice { options } = &param.kind {
            for option in options {
                ui.label(format!("    {}: {}", option.name, option.doc));
            }
        }
    }
}
