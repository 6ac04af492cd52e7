//! Nodes too small to be read. Hundreds of them are seen at once, and a widget for each would cost more than a frame
//! may take: those that the pointer could reach are widgets, all others are painted as the block that such a widget is.

use std::collections::HashSet;

use eframe::egui::{
    self, Color32, FontId, Pos2, Rect, Stroke, StrokeKind, Vec2,
    emath::TSTransform,
    pos2,
    text::{LayoutJob, TextFormat, TextWrapping},
    vec2,
};
use egui_graph::{
    NodeId,
    node::{NodeInteraction, default_frame},
};
use orograph_edit::Badge;

use super::{
    NodeView,
    body::{self, GAP, ROW, THUMBNAIL, TITLE},
};
use crate::theme;

/// Below this scale nobody reads what stands in a node.
pub(super) const FAR: f32 = 0.35;

/// Size of the name of a node that is seen from afar.
const NAME: f32 = 30.0;

/// How far from the pointer, in the window, a node still is a widget: farther than it moves between two frames of a
/// hand that is about to press.
const REACH: f32 = 48.0;

/// A node or a wire that is only painted, because it is seen from afar and the pointer cannot reach it.
#[derive(Default)]
pub(super) struct Afar {
    /// What the pointer reaches, in the graph, when nodes are seen from afar.
    reach: Option<Rect>,
    /// A button is down, or was let go in this frame.
    held: bool,
    /// The pointer was pressed beside all nodes, so that it spans a box.
    boxes: bool,
    /// That box.
    spanned: Option<Rect>,
    /// The nodes that were widgets in the last frame.
    widgets: HashSet<NodeId>,
}

/// A node to be painted.
pub(super) struct Block {
    pub(super) rect: Rect,
    pub(super) selected: bool,
}

impl Afar {
    /// Looks where the pointer is, before the nodes of a frame are shown.
    pub(super) fn look(&mut self, ctx: &egui::Context, to_window: TSTransform, nodes: &[(Rect, Color32)]) {
        let pointer = ctx.input(|input| input.pointer.clone());
        let place = |pos: Pos2| to_window.inverse() * pos;
        let around =
            |pos: Pos2| Rect::from_center_size(place(pos), Vec2::splat(2.0 * REACH / to_window.scaling));
        let is_far = to_window.scaling < FAR;
        self.reach = is_far.then(|| pointer.latest_pos().map_or(Rect::NOTHING, around));
        self.held = pointer.any_down() || pointer.any_released();
        if pointer.primary_pressed() {
            let origin = pointer.press_origin().map(place);
            self.boxes = origin.is_some_and(|origin| !nodes.iter().any(|(rect, _)| rect.contains(origin)));
        }
        let box_of = |(from, to)| Rect::from_two_pos(place(from), place(to));
        let down = self.boxes && pointer.primary_down();
        self.spanned = pointer.press_origin().zip(pointer.latest_pos()).filter(|_| down).map(box_of);
    }

    /// Whether a node is only painted. What is a widget when a button goes down stays one until it is let go.
    pub(super) fn is_paint(&mut self, node: NodeId, rect: Rect) -> bool {
        let Some(reach) = self.reach else { return false };
        if reach.intersects(rect) || (self.held && self.widgets.contains(&node)) {
            self.widgets.insert(node);
            return false;
        }
        self.widgets.remove(&node);
        true
    }

    /// Whether a wire that runs along `points` is only painted.
    pub(super) fn is_paint_wire(&self, points: &[Pos2]) -> bool {
        self.reach.is_some_and(|reach| self.spanned.is_none() && !reach.intersects(Rect::from_points(points)))
    }

    /// What the pointer spans is not a box after all.
    pub(super) fn no_box(&mut self) {
        self.spanned = None;
    }

    /// Paints a node as its widget would look.
    pub(super) fn paint(&self, ui: &egui::Ui, node: &NodeView, block: &Block) {
        let interaction = NodeInteraction {
            selected: block.selected,
            in_selection_rect: self.spanned.is_some_and(|spanned| spanned.intersects(block.rect)),
            hovered: false,
        };
        let frame = frame(ui.style(), interaction);
        let inside = block.rect - frame.total_margin();
        ui.painter().add(frame.paint(inside));
        inner(ui, node, inside, block.selected);
    }
}

/// The edge of a node: without a shadow, which nobody sees.
pub(super) fn frame(style: &egui::Style, interaction: NodeInteraction) -> egui::Frame {
    default_frame(style, interaction).shadow(egui::Shadow::NONE)
}

/// What stands in a node: its colour, its picture, whether something is wrong, and its name in large letters.
pub(super) fn inner(ui: &egui::Ui, node: &NodeView, rect: Rect, selected: bool) {
    let painter = ui.painter();
    // The edge of a node is thinner than a pixel by now.
    let scale = ui.ctx().layer_transform_to_global(ui.layer_id()).map_or(1.0, |to_window| to_window.scaling);
    let (width, colour) = match selected {
        true => (1.5, ui.visuals().selection.stroke.color),
        false => (1.0, ui.visuals().widgets.noninteractive.bg_stroke.color),
    };
    painter.rect_stroke(rect, 0.0, Stroke::new(width / scale, colour), StrokeKind::Outside);
    let title = rect.with_max_y(rect.top() + TITLE);
    painter.rect_filled(title, 3.0, body::fill(ui, node));
    let rows = node.inputs.len().max(node.outputs.len()) as f32;
    let mut top = title.bottom() + GAP + rows * (ROW + GAP);
    if let Some(picture) = node.thumbnail {
        let middle = pos2(rect.center().x, top + THUMBNAIL / 2.0);
        let place = Rect::from_center_size(middle, vec2(THUMBNAIL, THUMBNAIL));
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(picture, place, whole, Color32::WHITE);
        top += THUMBNAIL + GAP;
    }
    if node.fault.is_some() || matches!(node.badge, Some(Badge::Failed(_))) {
        painter.rect_filled(rect.with_min_y(top.min(rect.bottom())), 2.0, theme::FAULT);
    }
    // As large as can still be read, over whatever stands below.
    let colour = ui.visuals().strong_text_color();
    let text = TextFormat::simple(FontId::proportional(NAME), colour);
    let mut job = LayoutJob::single_section(node.name.clone(), text);
    job.wrap = TextWrapping::truncate_at_width(rect.width());
    let name = ui.fonts_mut(|fonts| fonts.layout_job(job));
    painter.galley(title.left_top() + vec2(4.0, 0.0), name, colour);
}
